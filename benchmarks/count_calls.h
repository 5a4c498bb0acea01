/* The calls with numbers of items, which MPI 4 has twice: for ints, and with _c for larger ones.

   N is the type of a number of items, D that of a place among them; M(Send) is the name of a
   function, P(Send) that of the one which does the work, TO_NEIGHBOURS one of each kind. */

/* Sends. */
#define SEND(name)                                                                              \
    int M(name)(const void *b, N n, MPI_Datatype t, int to, int tag, MPI_Comm c)                \
    { MESSAGE(size_of(n, t)); return P(name)(b, n, t, to, tag, c); }
#define ISEND(name)                                                                             \
    int M(name)(const void *b, N n, MPI_Datatype t, int to, int tag, MPI_Comm c,                \
                   MPI_Request *r)                                                              \
    { MESSAGE(size_of(n, t)); return P(name)(b, n, t, to, tag, c, r); }
#define SEND_INIT(name)                                                                         \
    int M(name)(const void *b, N n, MPI_Datatype t, int to, int tag, MPI_Comm c,                \
                   MPI_Request *r)                                                              \
    { int e = P(name)(b, n, t, to, tag, c, r); remember(*r, size_of(n, t)); return e; }

SEND(Send) SEND(Ssend) SEND(Rsend) SEND(Bsend)
ISEND(Isend) ISEND(Issend) ISEND(Irsend) ISEND(Ibsend)
SEND_INIT(Send_init) SEND_INIT(Ssend_init) SEND_INIT(Rsend_init) SEND_INIT(Bsend_init)

int M(Sendrecv)(const void *b, N n, MPI_Datatype t, int to, int tag, void *b2, N n2,
                MPI_Datatype t2, int from, int tag2, MPI_Comm c, MPI_Status *s)
{
    MESSAGE(size_of(n, t));
    return P(Sendrecv)(b, n, t, to, tag, b2, n2, t2, from, tag2, c, s);
}

/* Neighbourhoods. */
static void TO_NEIGHBOURS(const N n[], MPI_Datatype t, MPI_Comm c)
{
    for (int k = degree(c); k-- > 0;)
        if (n[k] > 0) MESSAGE(size_of(n[k], t));
}

int M(Neighbor_alltoallv)(const void *b, const N n[], const D d[], MPI_Datatype t, void *b2,
                           const N n2[], const D d2[], MPI_Datatype t2, MPI_Comm c)
{
    TO_NEIGHBOURS(n, t, c);
    return P(Neighbor_alltoallv)(b, n, d, t, b2, n2, d2, t2, c);
}
int M(Ineighbor_alltoallv)(const void *b, const N n[], const D d[], MPI_Datatype t, void *b2,
                            const N n2[], const D d2[], MPI_Datatype t2, MPI_Comm c,
                            MPI_Request *r)
{
    TO_NEIGHBOURS(n, t, c);
    return P(Ineighbor_alltoallv)(b, n, d, t, b2, n2, d2, t2, c, r);
}
int M(Neighbor_alltoall)(const void *b, N n, MPI_Datatype t, void *b2, N n2, MPI_Datatype t2,
                          MPI_Comm c)
{
    for (int k = degree(c); k-- > 0;) MESSAGE(size_of(n, t));
    return P(Neighbor_alltoall)(b, n, t, b2, n2, t2, c);
}

/* Collective operations. */
int M(Bcast)(void *b, N n, MPI_Datatype t, int root, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return P(Bcast)(b, n, t, root, c); }
int M(Allreduce)(const void *b, void *x, N n, MPI_Datatype t, MPI_Op o, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return P(Allreduce)(b, x, n, t, o, c); }
int M(Iallreduce)(const void *b, void *x, N n, MPI_Datatype t, MPI_Op o, MPI_Comm c,
                   MPI_Request *r)
{ COLLECTIVE(size_of(n, t)); return P(Iallreduce)(b, x, n, t, o, c, r); }
int M(Reduce)(const void *b, void *x, N n, MPI_Datatype t, MPI_Op o, int root, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return P(Reduce)(b, x, n, t, o, root, c); }
int M(Scan)(const void *b, void *x, N n, MPI_Datatype t, MPI_Op o, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return P(Scan)(b, x, n, t, o, c); }
int M(Exscan)(const void *b, void *x, N n, MPI_Datatype t, MPI_Op o, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return P(Exscan)(b, x, n, t, o, c); }
int M(Gather)(const void *b, N n, MPI_Datatype t, void *x, N m, MPI_Datatype u, int root,
               MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return P(Gather)(b, n, t, x, m, u, root, c); }
int M(Gatherv)(const void *b, N n, MPI_Datatype t, void *x, const N m[], const D d[],
                MPI_Datatype u, int root, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return P(Gatherv)(b, n, t, x, m, d, u, root, c); }
int M(Allgather)(const void *b, N n, MPI_Datatype t, void *x, N m, MPI_Datatype u, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return P(Allgather)(b, n, t, x, m, u, c); }
int M(Allgatherv)(const void *b, N n, MPI_Datatype t, void *x, const N m[], const D d[],
                   MPI_Datatype u, MPI_Comm c)
{ COLLECTIVE(size_of(n, t)); return P(Allgatherv)(b, n, t, x, m, d, u, c); }
int M(Scatter)(const void *b, N n, MPI_Datatype t, void *x, N m, MPI_Datatype u, int root,
                MPI_Comm c)
{ COLLECTIVE(size_of(m, u)); return P(Scatter)(b, n, t, x, m, u, root, c); }
int M(Alltoall)(const void *b, N n, MPI_Datatype t, void *x, N m, MPI_Datatype u, MPI_Comm c)
{
    int ranks;
    PMPI_Comm_size(c, &ranks);
    COLLECTIVE(size_of((long long)n * ranks, t));
    return P(Alltoall)(b, n, t, x, m, u, c);
}

#undef SEND
#undef ISEND
#undef SEND_INIT
#undef N
#undef D
#undef M
#undef P
#undef TO_NEIGHBOURS
