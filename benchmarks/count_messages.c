/* Counts what one rank sends: preloaded, it stands between a program and its MPI library.

     mpicc -shared -fPIC -O2 -o count_messages.so count_messages.c -ldl

   tfx_counts holds messages to single ranks, their bytes, collective operations, and the bytes that
   this rank brings to them. A message is a send, or a neighbour of a neighbourhood collective that
   gets anything. Libraries written in Fortran (MUMPS) come by other names. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <mpi.h>

long long tfx_counts[4];

enum { MOST_REQUESTS = 65536 };
static struct { MPI_Request request; long long bytes; } persistent[MOST_REQUESTS];
static int n_persistent, inside; /* a call from Fortran may pass through one in C */

static long long size_of(long long count, MPI_Datatype type)
{
    int size = 0;
    if (count > 0 && type != MPI_DATATYPE_NULL) PMPI_Type_size(type, &size);
    return count * size;
}

static void add(int kind, long long number, long long bytes)
{
    if (inside) return;
    tfx_counts[2 * kind] += number;
    tfx_counts[2 * kind + 1] += bytes;
}

#define MESSAGE(bytes) add(0, 1, bytes)
#define COLLECTIVE(bytes) add(1, 1, bytes)

static void remember(MPI_Request request, long long bytes)
{
    int k = 0;
    while (k < n_persistent && persistent[k].request != request) k++;
    if (k == MOST_REQUESTS) return;
    persistent[k].request = request;
    persistent[k].bytes = bytes;
    if (k == n_persistent) n_persistent++;
}

static void started(MPI_Request request)
{
    for (int k = 0; k < n_persistent; k++)
        if (persistent[k].request == request) { MESSAGE(persistent[k].bytes); return; }
}

static void forget(MPI_Request request)
{
    for (int k = 0; k < n_persistent; k++)
        if (persistent[k].request == request) { persistent[k] = persistent[--n_persistent]; return; }
}

int MPI_Start(MPI_Request *r) { started(*r); return PMPI_Start(r); }
int MPI_Startall(int n, MPI_Request r[])
{
    for (int k = 0; k < n; k++) started(r[k]);
    return PMPI_Startall(n, r);
}
int MPI_Request_free(MPI_Request *r) { forget(*r); return PMPI_Request_free(r); }

static int degree(MPI_Comm c)
{
    int in = 0, out = 0, weighted = 0;
    PMPI_Dist_graph_neighbors_count(c, &in, &out, &weighted);
    return out;
}

int MPI_Barrier(MPI_Comm c) { COLLECTIVE(0); return PMPI_Barrier(c); }
int MPI_Ibarrier(MPI_Comm c, MPI_Request *r) { COLLECTIVE(0); return PMPI_Ibarrier(c, r); }

#define N int
#define D int
#define M(name) MPI_##name
#define P(name) PMPI_##name
#define TO_NEIGHBOURS to_neighbours
#include "count_calls.h"
#if MPI_VERSION >= 4
#define N MPI_Count
#define D MPI_Aint
#define M(name) MPI_##name##_c
#define P(name) PMPI_##name##_c
#define TO_NEIGHBOURS to_neighbours_c
#include "count_calls.h"
#endif

/* Fortran. Its library need not be among those that all see, but the caller's libraries have it. */
static void *find_next(const char *name, void *caller)
{
    Dl_info of_caller;
    void *found = dlsym(RTLD_NEXT, name), *library = 0;
    if (!found && dladdr(caller, &of_caller))
        library = dlopen(of_caller.dli_fname, RTLD_LAZY | RTLD_NOLOAD);
    return library ? dlsym(library, name) : found;
}

#define FORTRAN(name, parameters, arguments, what)                                              \
    void name parameters                                                                        \
    {                                                                                           \
        static void (*next) parameters;                                                         \
        if (!next) *(void **)&next = find_next(#name, __builtin_return_address(0));             \
        what(size_of(*n, PMPI_Type_f2c(*t)));                                                   \
        inside++;                                                                               \
        next arguments;                                                                         \
        inside--;                                                                               \
    }
typedef MPI_Fint F;
FORTRAN(mpi_send_, (void *b, F *n, F *t, F *to, F *tag, F *c, F *e), (b, n, t, to, tag, c, e),
        MESSAGE)
FORTRAN(mpi_isend_, (void *b, F *n, F *t, F *to, F *tag, F *c, F *r, F *e),
        (b, n, t, to, tag, c, r, e), MESSAGE)
FORTRAN(mpi_bcast_, (void *b, F *n, F *t, F *root, F *c, F *e), (b, n, t, root, c, e), COLLECTIVE)
FORTRAN(mpi_allreduce_, (void *b, void *x, F *n, F *t, F *o, F *c, F *e), (b, x, n, t, o, c, e),
        COLLECTIVE)
FORTRAN(mpi_reduce_, (void *b, void *x, F *n, F *t, F *o, F *root, F *c, F *e),
        (b, x, n, t, o, root, c, e), COLLECTIVE)
