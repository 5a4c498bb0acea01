/* Places of sections in a rotor, and the loads on them; see section_air.py. */

typedef struct {
  int sections, angles, columns;
  const double *starts, *widths, *lower, *change; /* of the table of coefficients */
  const int *rows;                                /* first row of each section there */
  const double *chord, *lengths, *area, *middle, *sigma;
  double density, lag, slowest, least, full, none, shares[3], rates[3];
} Air;

static void place(const Air *air, const double *axes, const double *local, const double *position,
                  const double *velocity, const double *omega, const double *centre,
                  const double *shaft, double speed, double *out, double *radius)
{
  const int n = air->sections;
  double *block[10];
  for (int b = 0; b < 10; b++)
    block[b] = out + 3 * (ptrdiff_t)n * b;
  for (int k = 0; k < n; k++, axes += 9, local += 12, position += 3, velocity += 3, omega += 3) {
    double *lever = block[0], *span = block[1], *normal = block[4], *way = block[5];
    double *outward = block[6], *where = block[7], *moves = block[8], *relative = block[9];
    for (int b = 0; b < 4; b++)
      for (int i = 0; i < 3; i++)
        block[b][i] = axes[3 * i] * local[b] + axes[3 * i + 1] * local[4 + b]
                      + axes[3 * i + 2] * local[8 + b];
    double arm[3], turned[3];
    for (int i = 0; i < 3; i++) {
      where[i] = position[i] + lever[i];
      arm[i] = where[i] - centre[i];
    }
    const double along = dot(arm, shaft);
    for (int i = 0; i < 3; i++)
      arm[i] -= along * shaft[i];
    radius[k] = sqrt(dot(arm, arm));
    for (int i = 0; i < 3; i++)
      outward[i] = arm[i] / radius[k];
    cross(shaft, outward, way);
    cross(span, way, normal);
    const double length = sqrt(dot(normal, normal));
    cross(omega, lever, turned);
    for (int i = 0; i < 3; i++) {
      normal[i] /= length;
      moves[i] = velocity[i] + turned[i];
      relative[i] = omega[i] - speed * shaft[i];
    }
    for (int b = 0; b < 10; b++)
      block[b] += 3;
  }
}

/* Interval of the table that holds an angle. */
static int find_interval(const Air *air, double angle)
{
  int low = 0, high = air->angles - 1;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    if (angle >= air->starts[middle])
      low = middle;
    else
      high = middle;
  }
  return low;
}

/* Velocity that shed vorticity induces across the chord. */
static double find_shed_velocity(const Air *air, int k, double forward, double v, double speed,
                                 const double *shed, double duration)
{
  const double x = (air->none - fabs(atan2(v, forward))) / (air->none - air->full);
  const double passed = 2.0 * duration * speed / air->chord[k];
  double delta = 0.0;
  if (x <= 0.0)
    return 0.0;
  for (int i = 0; i < 3; i++) /* z_i - A_i v after the time that has passed */
    delta += (shed[3 * k + i] - air->sigma[k] * air->shares[i] * v) * exp(-passed * air->rates[i]);
  return x < 1.0 ? x * delta : delta;
}

static void load_section(const Air *air, int k, double forward, double up, double rate,
                         const double *attached, const double *shed, double duration,
                         double a[3], double *f_st, double *W, double *v)
{
  const double chord = air->chord[k], speed = sqrt(forward * forward + up * up);
  const double moving = speed > air->slowest ? speed : air->slowest;
  double washed = 0.0, turned = 0.0, turning = 0.0, C[5];
  if (air->area) { /* loads of turning */
    const double flow = speed > air->least ? speed : air->least;
    const double lever = (air->middle[k] + 0.25 * forward / flow) * chord;
    washed = lever * rate;
    turned = air->area[k] * forward * rate;
    turning = -lever * turned;
  }
  *v = up + washed;
  if (air->sigma && shed)
    up += find_shed_velocity(air, k, forward, *v, moving, shed, duration);
  const double angle = atan2(up + washed, forward);
  const int i = find_interval(air, angle);
  const ptrdiff_t row = (ptrdiff_t)(air->rows[k] + i) * air->columns;
  const double weight = (angle - air->starts[i]) / air->widths[i];
  for (int c = 0; c < air->columns; c++)
    C[c] = air->lower[row + c] + weight * air->change[row + c];
  *W = speed;
  *f_st = 1.0;
  double lift = C[0];
  if (air->columns == 5) { /* C_l = C_l,st + (f - f_st)(C_l,inv - C_l,sep) */
    const double tau = air->lag * chord / moving;
    *f_st = C[3];
    if (attached)
      lift += (attached[k] - C[3]) * exp(-duration / tau) * C[4];
  }
  const double flow = sqrt(forward * forward + up * up);
  const double q = 0.5 * air->density * chord * flow;
  a[0] = q * (lift * up - C[1] * forward);
  a[1] = q * (lift * forward + C[1] * up) + air->density * turned;
  a[2] = q * flow * chord * C[2] + air->density * turning;
}

static void find_plane_loads(const Air *air, const double *p, const double *attached,
                             const double *shed, double duration, double *loads, double *f_st,
                             double *W, double *v)
{
  const int n = air->sections;
  for (int k = 0; k < n; k++) {
    double a[3];
    load_section(air, k, p[k], p[n + k], p[2 * n + k], attached, shed, duration, a, f_st + k,
                 W + k, v + k);
    for (int i = 0; i < 3; i++)
      loads[i * n + k] = a[i];
  }
}

static void find_loads(const Air *air, double **places, const double *wind,
                       const double *axial, const double *along, const double *attached,
                       const double *shed, double duration, double *force, double *moment,
                       double *line, double *f_st, double *W, double *v)
{
  const int n = air->sections;
  for (int k = 0; k < n; k++) {
    const double *at[10];
    double V[3], a[3], m[3];
    for (int b = 0; b < 10; b++)
      at[b] = places[b] + 3 * k;
    const double *lever = at[0], *span = at[1], *chordwise = at[2], *suction = at[3];
    const double *normal = at[4], *way = at[5], *relative = at[9];
    for (int i = 0; i < 3; i++)
      V[i] = wind[3 * k + i] - axial[k] * normal[i] - along[k] * way[i];
    load_section(air, k, -dot(V, chordwise), dot(V, suction), dot(relative, span), attached,
                 shed, duration, a, f_st + k, W + k, v + k);
    for (int i = 0; i < 3; i++) {
      line[3 * k + i] = a[0] * chordwise[i] + a[1] * suction[i];
      force[3 * k + i] = air->lengths[k] * line[3 * k + i];
    }
    cross(lever, force + 3 * k, m);
    for (int i = 0; i < 3; i++)
      moment[3 * k + i] = m[i] + air->lengths[k] * a[2] * span[i];
  }
}
