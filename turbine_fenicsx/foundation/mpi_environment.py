"""Environment variables of MPI and its launchers."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

_OF_MPI = ("OMPI_", "PMIX_", "PRTE_", "PMI_", "MPI_", "MPICH_", "HYDRA_", "HYDI_", "I_MPI_")

_OF_RANKS = (
    "OMPI_COMM_WORLD_SIZE",
    "PMIX_RANK",
    "PMI_RANK",
    "MPI_LOCALRANKID",
    "SLURM_PROCID",
    "FLUX_TASK_RANK",
    "PALS_RANKID",
)
"""Variables that launchers set for each rank; without any, there is a single process."""

_OF_ONE_RANK = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1"}
"""Open MPI starts no daemon and opens no network; other implementations do not know them."""


def environment_without_mpi() -> dict[str, str]:
    """Variables of this process without those by which a launcher connects ranks."""
    return {name: x for name, x in os.environ.items() if not name.startswith(_OF_MPI)}


@contextmanager
def start_mpi_alone() -> Iterator[None]:
    """Let MPI start in here without what one rank alone does not need.

    A process that no launcher has started needs no daemon for more ranks and no network, which take
    Open MPI 4 a third of a second. Settings of the user stay, and children inherit nothing.
    """
    alone = not any(name in os.environ for name in _OF_RANKS)
    ours = {n: x for n, x in _OF_ONE_RANK.items() if alone and n not in os.environ}
    os.environ.update(ours)
    try:
        yield
    finally:
        for name in ours:
            del os.environ[name]
