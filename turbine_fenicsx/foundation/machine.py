"""Memory of the machines that a run uses."""

from __future__ import annotations

import ctypes
import os
import resource
from pathlib import Path

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.parallel import sum_over_ranks

_LIMITS = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")


def machine_memory(comm: MPI.Intracomm) -> float:
    """Memory that all ranks together may use, summed over the machines they run on [B]. Collective.

    A container's limit counts, and that of `ulimit -v` for each rank.
    """
    here = comm.Split_type(MPI.COMM_TYPE_SHARED)
    mine = _memory_here() if here.rank == 0 else 0.0
    here.Free()
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    own = float(limit) if limit != resource.RLIM_INFINITY else float("inf")
    machines, limits = sum_over_ranks(comm, np.array([mine, min(own, 1e18)]))
    return float(min(machines, limits))


def trim_heap() -> None:
    """Give what was freed back to the system, before something large comes that fits in no gap.

    SuperLU_DIST, which comes with PETSc, makes glibc keep everything. Other C libraries than
    glibc have no such function.
    """
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


def _memory_here() -> float:
    """Memory of this machine, or what its container leaves of it [B]."""
    found = [float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")]
    for name in _LIMITS:
        try:
            found.append(float(Path(name).read_text(encoding="ascii")))
        except (OSError, ValueError):  # no container, or "max"
            continue
    return min(found)
