
/* Damage of plies by their histories of stress; see ply_damage.py. */
#include <stdlib.h>

typedef struct {
  double tension, tension_slope; /* a cycle of mean M and amplitude A lasts (d/A)^m times, */
  double compression, compression_slope; /* d = min(a_t - b_t M, a_c + b_c M) */
  double exponent;               /* m; 0 if the stress does not count */
} Life;

/* One over the strengths of a ply; 0 for those that are not known. */
typedef struct {
  double tension[2], compression[2], shear;
} Strength;

static double find_margin(const Life *life, double mean)
{
  const double up = life->tension - life->tension_slope * mean;
  const double down = life->compression + life->compression_slope * mean;
  return up < down ? up : down;
}

/* Damage of one cycle from x to y; 1 if it reaches a strength. */
static double find_damage(const Life *life, double x, double y)
{
  const double margin = find_margin(life, 0.5 * (x + y)), amplitude = 0.5 * fabs(y - x);
  return amplitude < margin ? pow(amplitude / margin, life->exponent) : 1.0;
}

/* Stress at which a history turns; the first and the last one are such, equal ones count once. */
static int find_reversals(int m, const double *s, double *found)
{
  int n = 0;
  for (int k = 0; k < m; k++) {
    if (n > 0 && s[k] == found[n - 1])
      continue;
    if (n > 1 && (s[k] > found[n - 1]) == (found[n - 1] > found[n - 2]))
      n--;
    found[n++] = s[k];
  }
  return n;
}

/* Rainflow count of ASTM E1049-85, section 5.4.4. Returns the damage, half cycles as one half. */
static double count_damage(const Life *life, int m, const double *s, double *stack, double *cycles)
{
  const int n = find_reversals(m, s, stack);
  double damage = 0.0, count = 0.0;
  int top = 0, first = 0; /* the stack overwrites what was read of it */
  for (int k = 0; k < n; k++) {
    stack[top++] = stack[k];
    while (top - first >= 3) {
      const double *p = stack + top;
      if (fabs(p[-1] - p[-2]) < fabs(p[-2] - p[-3]))
        break;
      const int whole = top - first > 3;
      damage += (whole ? 1.0 : 0.5) * find_damage(life, p[-3], p[-2]);
      count += whole ? 1.0 : 0.5;
      if (whole) {
        stack[top - 3] = stack[top - 1];
        top -= 2;
      } else
        first++;
    }
  }
  for (int k = first; k + 1 < top; k++) {
    damage += 0.5 * find_damage(life, stack[k], stack[k + 1]);
    count += 0.5;
  }
  *cycles = count;
  return damage;
}

/* No less than the damage of a history of m numbers between two limits. */
static double bound_damage(const Life *life, int m, double low, double high)
{
  const double up = life->tension - life->tension_slope * high;
  const double down = life->compression + life->compression_slope * low;
  const double margin = up < down ? up : down;
  const double amplitude = 0.5 * (high - low);
  return 0.5 * m * (amplitude < margin ? pow(amplitude / margin, life->exponent) : 1.0);
}

/* Exertion of Tsai and Hill, with the sign of the stress that comes nearest to its strength. */
static void find_exertion(int m, const double *s, const Strength *r, double *out)
{
  double largest[3] = {0.0, 0.0, 0.0};
  for (int k = 0; k < m; k++) {
    const double x = s[k], y = s[m + k], t = s[2 * m + k] * r->shear;
    const double X = x < 0.0 ? r->compression[0] : r->tension[0];
    const double Y = y < 0.0 ? r->compression[1] : r->tension[1];
    const double a = x * X, b = y * Y, both = Y > 0.0 ? a * y * X : 0.0;
    const double square = a * a - both + b * b + t * t;
    const double shares[3] = {fabs(a), fabs(b), fabs(t)};
    for (int i = 0; i < 3; i++)
      largest[i] = shares[i] > largest[i] ? shares[i] : largest[i];
    out[k] = square > 0.0 ? sqrt(square) : 0.0;
  }
  int i = largest[1] > largest[0] ? 1 : 0;
  i = largest[2] > largest[i] ? 2 : i;
  for (int k = 0; k < m; k++)
    out[k] = s[i * m + k] < 0.0 ? -out[k] : out[k];
}

/* Damage and numbers of cycles of n plies by stresses along and across the fibre, of shear, and by
   exertion. What is surely less than `least` is left out: it has -1 cycles. 1 without memory. */
static int find_ply_damage(int n, int m, const double *stress, const Strength *strength,
                           const Life *life, double least, double *damage, double *cycles,
                           double *range)
{
  double *work = malloc(2 * (size_t)m * sizeof(double));
  if (work == NULL)
    return 1;
  double *exertion = work, *stack = work + m;
  for (int j = 0; j < n; j++, stress += 3 * (size_t)m, strength++) {
    for (int i = 0; i < 4; i++, life++, damage++, cycles++, range++) {
      *damage = *cycles = *range = 0.0;
      if (life->exponent == 0.0)
        continue;
      const double *s = i < 3 ? stress + i * (size_t)m : exertion;
      if (i == 3)
        find_exertion(m, stress, strength, exertion);
      double low = s[0], high = s[0];
      for (int k = 1; k < m; k++) {
        low = s[k] < low ? s[k] : low;
        high = s[k] > high ? s[k] : high;
      }
      *range = high - low;
      if (bound_damage(life, m, low, high) < least)
        *cycles = -1.0;
      else
        *damage = count_damage(life, m, s, stack, cycles);
    }
  }
  free(work);
  return 0;
}
