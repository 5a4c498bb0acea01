/* Velocities between the points of a turbulence field; see compiled_turbulence.py. */

typedef struct {
  const float *floats;
  const short *integers; /* in place of them, if not NULL */
  int planes, heights, widths, periodic;
  double dt, speed, lead, bottom, rise, left, step;
  const double *slope, *intercept;
} Field;

/* Interval that holds a place, of intervals 0 to last; 0 for what is no number. */
static int find_interval(double place, int last)
{
  if (!(place > 0.0))
    return 0;
  return place < last ? (int)place : last;
}

static double clip(double place, double last)
{
  return place < 0.0 ? 0.0 : place > last ? last : place;
}

/* Velocities at n places, linear between the points; 1 where the field is over. */
static int find_velocities(const Field *f, int n, const double *place, double time, double *out)
{
  const double planes = f->planes;
  for (int k = 0; k < n; k++, place += 3, out += 3) {
    double s = (time + f->lead - place[0] / f->speed) / f->dt;
    if (f->periodic) {
      s = fmod(s, planes);
      s = s < 0.0 ? s + planes : s;
    } else if (s < 0.0 || s > planes - 1.0)
      return 1;
    const double up = clip((place[2] - f->bottom) / f->rise, f->heights - 1.0);
    const double across = clip((place[1] - f->left) / f->step, f->widths - 1.0);
    const int i = find_interval(s, f->planes - 1);
    const int after = i + 1 < f->planes ? i + 1 : f->periodic ? 0 : i;
    const int h = find_interval(up, f->heights - 2), w = find_interval(across, f->widths - 2);
    const int plane[2] = {i, after};
    const double along[2] = {1.0 - (s - i), s - i}, high[2] = {1.0 - (up - h), up - h};
    const double wide[2] = {1.0 - (across - w), across - w};
    double sum[3] = {0.0, 0.0, 0.0};
    for (int a = 0; a < 2; a++)
      for (int b = 0; b < 2; b++)
        for (int c = 0; c < 2; c++) {
          const double weight = along[a] * high[b] * wide[c];
          const size_t row = ((size_t)plane[a] * f->heights + h + b) * f->widths + w + c;
          for (int j = 0; j < 3; j++)
            sum[j] += weight * (f->integers ? f->integers[3 * row + j] : f->floats[3 * row + j]);
        }
    const double near_ground = f->bottom > 0.0 ? clip(place[2] / f->bottom, 1.0) : 1.0;
    for (int j = 0; j < 3; j++)
      out[j] = near_ground * (sum[j] - f->intercept[j]) / f->slope[j];
  }
  return 0;
}
