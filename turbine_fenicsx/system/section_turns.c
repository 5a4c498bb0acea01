/* Rotations and spins of sections, and the rows of their loads; see section_turns.py. */

static void normalise(double a[3])
{
  const double length = sqrt(dot(a, a));
  for (int i = 0; i < 3; i++)
    a[i] /= length;
}

/* Eigenvectors of the symmetric S, columns of V, by Jacobi's rotations; S becomes diagonal. */
static void find_eigenvectors(double S[3][3], double V[3][3])
{
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      V[i][j] = i == j;
  for (int sweep = 0; sweep < 12; sweep++) {
    const double left = S[0][1] * S[0][1] + S[0][2] * S[0][2] + S[1][2] * S[1][2];
    const double size = S[0][0] * S[0][0] + S[1][1] * S[1][1] + S[2][2] * S[2][2];
    if (left <= 1e-36 * size)
      return;
    for (int p = 0; p < 2; p++)
      for (int q = p + 1; q < 3; q++) {
        if (S[p][q] == 0.0)
          continue;
        const double theta = 0.5 * (S[q][q] - S[p][p]) / S[p][q];
        const double t = copysign(1.0, theta) / (fabs(theta) + sqrt(theta * theta + 1.0));
        const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
        for (int i = 0; i < 3; i++) {
          const double x = S[i][p], y = S[i][q];
          S[i][p] = c * x - s * y;
          S[i][q] = s * x + c * y;
        }
        for (int i = 0; i < 3; i++) {
          const double x = S[p][i], y = S[q][i], v = V[i][p], w = V[i][q];
          S[p][i] = c * x - s * y;
          S[q][i] = s * x + c * y;
          V[i][p] = c * v - s * w;
          V[i][q] = s * v + c * w;
        }
      }
  }
}

/* The rotation nearest to B. Sections are nearly flat: the least axis follows from the others. */
static void find_rotation(const double B[3][3], double A[3][3])
{
  double S[3][3], V[3][3], u[3][3], v[3][3];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      S[i][j] = B[0][i] * B[0][j] + B[1][i] * B[1][j] + B[2][i] * B[2][j];
  find_eigenvectors(S, V);
  int least = S[1][1] < S[0][0] ? 1 : 0;
  least = S[2][2] < S[least][least] ? 2 : least;
  int first = (least + 1) % 3, second = (least + 2) % 3;
  if (S[second][second] > S[first][first]) {
    const int k = first;
    first = second;
    second = k;
  }
  for (int i = 0; i < 3; i++) {
    v[0][i] = V[i][first];
    v[1][i] = V[i][second];
  }
  cross(v[0], v[1], v[2]);
  for (int k = 0; k < 2; k++)
    for (int i = 0; i < 3; i++)
      u[k][i] = dot(B[i], v[k]);
  normalise(u[0]);
  const double along = dot(u[0], u[1]);
  for (int i = 0; i < 3; i++)
    u[1][i] -= along * u[0][i];
  normalise(u[1]);
  cross(u[0], u[1], u[2]);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      A[i][j] = u[0][i] * v[0][j] + u[1][i] * v[1][j] + u[2][i] * v[2][j];
}

static void invert(const double J[3][3], double inverse[9])
{
  double rows[3][3];
  for (int i = 0; i < 3; i++)
    cross(J[(i + 1) % 3], J[(i + 2) % 3], rows[i]);
  const double det = dot(J[0], rows[0]);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      inverse[3 * i + j] = rows[j][i] / det;
}

/* omega = J^-1 sum_j a_j x rate_j; sums hold a_j and rate_j in the rows 1 to 3. */
static void find_spin(const double J[3][3], const double a[3][3], const double *sums,
                      double *inverse, double *spin)
{
  double w[3] = {0.0, 0.0, 0.0};
  invert(J, inverse);
  for (int j = 0; j < 3; j++) {
    double c[3];
    cross(a[j], sums + 6 * (1 + j) + 3, c);
    for (int i = 0; i < 3; i++)
      w[i] += c[i];
  }
  for (int i = 0; i < 3; i++)
    spin[i] = dot(inverse + 3 * i, w);
}

static void find_spins(int n, const double *sums, double *inverses, double *spins)
{
  for (int k = 0; k < n; k++, sums += 24, inverses += 9, spins += 3) {
    double r[3][3], J[3][3], trace = 0.0;
    for (int j = 0; j < 3; j++) {
      for (int i = 0; i < 3; i++)
        r[j][i] = sums[6 * (1 + j) + i];
      trace += dot(r[j], r[j]);
    }
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        J[i][j] = (i == j ? trace : 0.0) - r[0][i] * r[0][j] - r[1][i] * r[1][j]
                  - r[2][i] * r[2][j];
    find_spin(J, r, sums, inverses, spins);
  }
}

static void find_turns(int n, const double *sums, double *rotations, double *inverses, double *spins)
{
  for (int k = 0; k < n; k++, sums += 24, rotations += 9, inverses += 9, spins += 3) {
    double B[3][3], A[3][3], J[3][3];
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        B[i][j] = sums[6 * (1 + j) + i];
    find_rotation(B, A);
    /* J = tr(A^T B) 1 - B A^T */
    double trace = 0.0;
    for (int i = 0; i < 3; i++)
      trace += dot(A[i], B[i]);
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) {
        J[i][j] = (i == j ? trace : 0.0) - dot(B[i], A[j]);
        rotations[3 * i + j] = A[i][j];
      }
    double columns[3][3];
    for (int j = 0; j < 3; j++)
      for (int i = 0; i < 3; i++)
        columns[j][i] = A[i][j];
    find_spin(J, columns, sums, inverses, spins);
  }
}

static void find_rows(int n, const double *forces, const double *moments, const double *rotations,
               const double *inverses, double *rows)
{
  for (int k = 0; k < n; k++, forces += 3, moments += 3, rotations += 9, inverses += 9) {
    double turn[3];
    for (int i = 0; i < 3; i++) {
      turn[i] = dot(inverses + 3 * i, moments);
      *rows++ = forces[i];
    }
    /* (J^-1 M) x A_j */
    for (int j = 0; j < 3; j++, rows += 3) {
      const double a[3] = {rotations[j], rotations[3 + j], rotations[6 + j]};
      cross(turn, a, rows);
    }
  }
}
