// A kernel of FFCx by itself: `roofline.py` puts it in the place of KERNEL and runs this twice.
//
// With -DCOUNT numbers count their operations and mark the memory they come from; prints
// operations, and bytes of w, coordinates and A of one cell. Without, prints seconds for a cell, the
// best of some turns over cells one after the other in memory, operations per second of the
// processor at their peak, and bytes per second of a triad, both by the same compiler flags.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <set>
#include <vector>
#define restrict __restrict__

#ifdef COUNT
static long long operations;
static std::set<const void *> touched;
struct Number {
    double x;
    Number(double value = 0.0) : x(value) {}
    Number(const Number &o) : x(o.x) { touched.insert(&o); }
    Number &operator=(const Number &o) { touched.insert(&o); x = o.x; return *this; }
};
#define OPERATOR(o)                                                                             \
    static Number operator o(const Number &a, const Number &b)                                  \
    { operations++; touched.insert(&a); touched.insert(&b); return Number(a.x o b.x); }         \
    static Number &operator o##=(Number &a, const Number &b)                                    \
    { operations++; touched.insert(&a); touched.insert(&b); a.x = a.x o b.x; return a; }
OPERATOR(+) OPERATOR(-) OPERATOR(*) OPERATOR(/)
static Number operator-(const Number &a) { touched.insert(&a); return Number(-a.x); }
#define COMPARISON(o)                                                                           \
    static bool operator o(const Number &a, const Number &b)                                    \
    { touched.insert(&a); touched.insert(&b); return a.x o b.x; }
COMPARISON(<) COMPARISON(<=) COMPARISON(>) COMPARISON(>=) COMPARISON(==) COMPARISON(!=)
#define FUNCTION(f)                                                                             \
    static Number f(const Number &a)                                                            \
    { operations++; touched.insert(&a); return Number(std::f(a.x)); }
FUNCTION(sqrt) FUNCTION(fabs) FUNCTION(exp) FUNCTION(log)
static Number pow(const Number &a, const Number &b)
{ operations++; touched.insert(&a); touched.insert(&b); return Number(std::pow(a.x, b.x)); }
#define double Number
#endif

KERNEL

#undef double
#ifdef COUNT
typedef Number Value;
#else
typedef double Value;
#endif

static double random_number() { return std::rand() / (RAND_MAX + 1.0); }

static double seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

#ifdef COUNT
static long long bytes_of(const std::vector<Value> &v)
{
    long long found = 0;
    for (const Value &x : v) found += 8 * touched.count(&x);
    return found;
}
#endif

#ifndef COUNT
typedef double vector __attribute__((vector_size(LANES * 8)));

/* Seconds of an operation: twelve sums in registers, independent of each other. */
__attribute__((noinline)) static double multiply_and_add(double *use)
{
    const long rounds = 2000000;
    vector s[12] = {}, factor = {}, shift = {};
    factor += 0.999;
    shift += 1e-3;
    double start = seconds();
    for (long i = 0; i < rounds; i++) {
        s[0] = s[0] * factor + shift; s[1] = s[1] * factor + shift;
        s[2] = s[2] * factor + shift; s[3] = s[3] * factor + shift;
        s[4] = s[4] * factor + shift; s[5] = s[5] * factor + shift;
        s[6] = s[6] * factor + shift; s[7] = s[7] * factor + shift;
        s[8] = s[8] * factor + shift; s[9] = s[9] * factor + shift;
        s[10] = s[10] * factor + shift; s[11] = s[11] * factor + shift;
    }
    double each = (seconds() - start) / (24.0 * LANES * rounds);
    for (int k = 0; k < 12; k++) *use += s[k][0];
    return each;
}
#endif

int main(int, char **argv)
{
    enum { W = WIDTH_W, CELLS = 4096, C = 4096 };
    FILE *file = std::fopen(argv[1], "r");
    std::vector<Value> X, w(W), c(C), A(512);
    for (double x; std::fscanf(file, "%lf", &x) == 1;) X.push_back(Value(x));
    std::fclose(file);
    const int entity = 0;
    const uint8_t permutation = 0;
#ifdef COUNT
    for (Value &x : w) x.x = 0.5 + random_number();
    for (Value &x : c) x.x = 1.0;
    operations = 0;
    touched.clear();
    tabulate(A.data(), w.data(), c.data(), X.data(), &entity, &permutation);
    std::printf("%lld %lld %lld %lld\n", operations, bytes_of(w), bytes_of(X), bytes_of(A));
#else
    std::vector<double> all(size_t(W) * CELLS);
    for (double &x : all) x = 0.5 + random_number();
    for (double &x : c) x = 1.0;
    double best = 1e9, peak = 1e9, triad = 1e9;
    for (int turn = 0; turn < 7; turn++) {
        double start = seconds();
        for (int k = 0; k < CELLS; k++)
            tabulate(A.data(), &all[size_t(W) * k], c.data(), X.data(), &entity, &permutation);
        best = std::fmin(best, (seconds() - start) / CELLS);
    }
    double use = 0.0;
    for (int turn = 0; turn < 5; turn++) peak = std::fmin(peak, multiply_and_add(&use));
    const size_t n = 8000000;
    std::vector<double> a(n, 0.0), b(n, 1.0), d(n, 2.0);
    for (int turn = 0; turn < 5; turn++) {
        double start = seconds();
        for (size_t i = 0; i < n; i++) a[i] = b[i] + 3.0 * d[i];
        triad = std::fmin(triad, (seconds() - start) / (24.0 * n));
    }
    use += a[n / 2] + A[0];
    std::fprintf(stderr, "%g\n", use);
    std::printf("%.6e %.6e %.6e\n", best, 1.0 / peak, 1.0 / triad);
#endif
}
