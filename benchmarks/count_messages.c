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

/* Sends. */
#define SEND(name)                                                                              \
    int MPI_##name(const void *b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c)           \
    { MESSAGE(size_of(n, t)); return PMPI_##name(b, n, t, to, tag, c); }
#define ISEND(name)                                                                             \
    int MPI_##name(const void *b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c,           \
                   MPI_Request *r)                                                              \
    { MESSAGE(size_of(n, t)); return PMPI_##name(b, n, t, to, tag, c, r); }
#define SEND_INIT(name)                                                                         \
    int MPI_##name(const void *b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c,           \
                   MPI_Request *r)                                                              \
    { int e = PMPI_##name(b, n, t, to, tag, c, r); remember(*r, size_of(n, t)); return e; }

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

SEND(Send) SEND(Ssend) SEND(Rsend) SEND(Bsend)
ISEND(Isend) ISEND(Issend) ISEND(Irsend) ISEND(Ibsend)
SEND_INIT(Send_init) SEND_INIT(Ssend_init) SEND_INIT(Rsend_init) SEND_INIT(Bsend_init)

int MPI_Start(MPI_Request *r) { started(*r); return PMPI_Start(r); }
int MPI_Startall(int n, MPI_Request r[])
{
    for (int k = 0; k < n; k++) started(r[k]);
    return PMPI_Startall(n, r);
}
int MPI_Request_free(MPI_Request *r) { forget(*r); return PMPI_Request_free(r); }
int MPI_Sendrecv(const void *b, int n, MPI_Datatype t, int to, int tag, void *b2, int n2,
                 MPI_Datatype t2, int from, int tag2, MPI_Comm c, MPI_Status *s)
{
    MESSAGE(size_of(n, t));
    return PMPI_Sendrecv(b, n, t, to, tag, b2, n2, t2, from, tag2, c, s);
}

/* Neighbourhoods. */
static int degree(MPI_Comm c)
{
    int in = 0, out = 0, weighted = 0;
    PMPI_Dist_graph_neighbors_count(c, &in, &out, &weighted);
    return out;
}

static void to_neighbours(const int n[], MPI_Datatype t, MPI_Comm c)
{
    for (int k = degree(c); k-- > 0;)
        if (n[k] > 0) MESSAGE(size_of(n[k], t));
}

int MPI_Neighbor_alltoallv(const void *b, const int n[], const int d[], MPI_Datatype t, void *b2,
                           const int n2[], const int d2[], MPI_Datatype t2, MPI_Comm c)
{
    to_neighbours(n, t, c);
    return PMPI_Neighbor_alltoallv(b, n, d, t, b2, n2, d2, t2, c);
}
int MPI_Ineighbor_alltoallv(const void *b, const int n[], const int d[], MPI_Datatype t, void *b2,
                            const int n2[], const int d2[], MPI_Datatype t2, MPI_Comm c,
                            MPI_Request *r)
{
    to_neighbours(n, t, c);
    return PMPI_Ineighbor_alltoallv(b, n, d, t, b2, n2, d2, t2, c, r);
}
int MPI_Neighbor_alltoall(const void *b, int n, MPI_Datatype t, void *b2, int n2, MPI_Datatype t2,
                          MPI_Comm c)
{
    for (int k = degree(c); k-- > 0;) MESSAGE(size_of(n, t));
    return PMPI_Neighbor_alltoall(b, n, t, b2, n2, t2, c);
}

/* Collective operations. */
int MPI_Barrier(MPI_Comm c) { COLLECTIVE(0); return PMPI_Barrier(c); }
int MPI_Ibarrier(MPI_Comm c, MPI_Request *r) { COLLECTIVE(0); return PMPI_Ibarrier(c, r); }
int MPI_Bcast(void *b, int n, MPI_Datatype t, int root, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return PMPI_Bcast(b, n, t, root, c); }
int MPI_Allreduce(const void *b, void *x, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return PMPI_Allreduce(b, x, n, t, o, c); }
int MPI_Iallreduce(const void *b, void *x, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c,
                   MPI_Request *r)
{ COLLECTIVE(size_of(n, t)); return PMPI_Iallreduce(b, x, n, t, o, c, r); }
int MPI_Reduce(const void *b, void *x, int n, MPI_Datatype t, MPI_Op o, int root, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return PMPI_Reduce(b, x, n, t, o, root, c); }
int MPI_Scan(const void *b, void *x, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return PMPI_Scan(b, x, n, t, o, c); }
int MPI_Exscan(const void *b, void *x, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return PMPI_Exscan(b, x, n, t, o, c); }
int MPI_Gather(const void *b, int n, MPI_Datatype t, void *x, int m, MPI_Datatype u, int root,
               MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return PMPI_Gather(b, n, t, x, m, u, root, c); }
int MPI_Gatherv(const void *b, int n, MPI_Datatype t, void *x, const int m[], const int d[],
                MPI_Datatype u, int root, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return PMPI_Gatherv(b, n, t, x, m, d, u, root, c); }
int MPI_Allgather(const void *b, int n, MPI_Datatype t, void *x, int m, MPI_Datatype u, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return PMPI_Allgather(b, n, t, x, m, u, c); }
int MPI_Allgatherv(const void *b, int n, MPI_Datatype t, void *x, const int m[], const int d[],
                   MPI_Datatype u, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return PMPI_Allgatherv(b, n, t, x, m, d, u, c); }
int MPI_Scatter(const void *b, int n, MPI_Datatype t, void *x, int m, MPI_Datatype u, int root,
                MPI_Comm c)
{ COLLECTIVE(size_of(m, u)); return PMPI_Scatter(b, n, t, x, m, u, root, c); }
int MPI_Alltoall(const void *b, int n, MPI_Datatype t, void *x, int m, MPI_Datatype u, MPI_Comm c)
{
    int ranks;
    PMPI_Comm_size(c, &ranks);
    COLLECTIVE(size_of((long long)n * ranks, t));
    return PMPI_Alltoall(b, n, t, x, m, u, c);
}

/* Fortran. */
#define FORTRAN(name, parameters, arguments, what)                                              \
    void name parameters                                                                        \
    {                                                                                           \
        static void (*next) parameters;                                                         \
        if (!next) *(void **)&next = dlsym(RTLD_NEXT, #name);                                   \
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
