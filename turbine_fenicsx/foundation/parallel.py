"""Work that one rank does for all."""

import pickle
from collections.abc import Callable
from typing import TypeVar

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.types import Array

T = TypeVar("T")


def sum_over_ranks(comm: MPI.Intracomm, values: Array) -> Array:
    """Sum of one array of each rank, on every rank; the array itself if there is only one rank.

    Args:
        values: Contiguous, of the same shape on all ranks.
    """
    if comm.size == 1:
        return values
    total = np.empty_like(values)
    comm.Allreduce(values, total)
    return total


def largest_of_ranks(comm: MPI.Intracomm, value: float) -> float:
    """Largest of one number of each rank, on every rank."""
    if comm.size == 1:
        return value
    largest = np.empty(1)
    comm.Allreduce(np.array([value]), largest, op=MPI.MAX)
    return float(largest[0])


def from_rank0(comm: MPI.Intracomm, values: Array) -> Array:
    """Overwrite an array with that of rank 0, and return it.

    Args:
        values: Contiguous, of the same shape on all ranks.
    """
    if comm.size > 1:
        comm.Bcast(values)
    return values


def on_rank0(comm: MPI.Intracomm, function: Callable[[], T]) -> T:
    """Call a function on rank 0 and hand its result, or its exception, to every rank.

    Without this, an error on rank 0 leaves the other ranks waiting for ever in their next
    collective call.

    Args:
        comm: Communicator of all ranks that make this call.
        function: Function without arguments; its result must be picklable.

    Returns:
        The result of the function, on every rank.

    Note:
        Collective over ``comm``.
    """
    if comm.size == 1:
        return function()
    result: T | None = None
    error: BaseException | None = None
    if comm.rank == 0:
        try:
            result = function()
        except BaseException as raised:  # an interrupt must reach the other ranks too
            error = raised
    answer: T
    answer, remote_error = comm.bcast((result, _make_portable(error)), root=0)
    if error is not None:
        raise error
    if remote_error is not None:
        raise remote_error
    return answer


def raise_together(comm: MPI.Intracomm, error: BaseException | None) -> None:
    """Raise the first error of any rank on every rank.

    Args:
        comm: Communicator of all ranks that make this call.
        error: What went wrong on this rank; None if nothing did.

    Note:
        Collective over ``comm``.
    """
    if comm.size == 1 and error is not None:
        raise error
    if not largest_of_ranks(comm, float(error is not None)):  # a step needs no more
        return
    for rank, found in enumerate(comm.allgather(_make_portable(error))):
        if found is not None:
            raise error if error is not None and rank == comm.rank else found


def _make_portable(error: BaseException | None) -> BaseException | None:
    """Return the exception itself if it survives pickling, else a RuntimeError in its place."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
