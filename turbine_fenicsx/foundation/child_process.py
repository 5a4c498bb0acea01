"""Environment of processes that run what may crash, apart from MPI."""

from __future__ import annotations

import os

_OF_MPI = ("OMPI_", "PMIX_", "PRTE_", "PMI_", "MPI_", "MPICH_", "HYDRA_", "HYDI_", "I_MPI_")


def environment_without_mpi() -> dict[str, str]:
    """Variables of this process without those by which a launcher tells ranks of one another."""
    return {name: x for name, x in os.environ.items() if not name.startswith(_OF_MPI)}
