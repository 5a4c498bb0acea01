"""A run or a mesh that the machine cannot hold is refused before anything is built."""

from __future__ import annotations

from mpi4py import MPI

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.machine import machine_memory
from turbine_fenicsx.meshing.size import MeshSize
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.estimate import (
    estimate,
    estimate_modes_memory,
    in_bytes,
    mesh_memory,
)
from turbine_fenicsx.turbine.rotor_plan import plan_rotor

WAY_OUT = "--force continues anyway"


def size_of_blades(case: Case, comm: MPI.Intracomm) -> MeshSize | None:
    """Size of the built-in mesh of a case; None without one, or with a mesh file. Collective."""
    if case.turbine.model == "rigid" or case.mesh.file:
        return None
    return plan_rotor(case, comm).blades.size


def refuse_run(case: Case, comm: MPI.Intracomm) -> None:
    """Refuse a run that needs more memory than there is. Collective.

    The mesh of a file counts only once it is read, so `check` says what it needs, and not this;
    what components of a user's own add is not counted.

    Raises:
        InputError: on all ranks, if the memory is too small.
    """
    available = machine_memory(comm)
    found = estimate(case, size_of_blades(case, comm), comm.size, available)
    if sentence := found.describe_shortage(available):
        raise InputError(f"{sentence}; {WAY_OUT}")


def refuse_modes(case: Case, comm: MPI.Intracomm, count: int) -> None:
    """Refuse modes that need more memory than there is. Collective.

    Raises:
        InputError: on all ranks, if the memory is too small.
    """
    needed = estimate_modes_memory(case, size_of_blades(case, comm), comm.size, count)
    available = machine_memory(comm)
    if needed > available:
        raise InputError(
            f"{count} modes need about {in_bytes(needed)} of memory, this machine has "
            f"{in_bytes(available)}; {WAY_OUT}"
        )


def refuse_mesh(case: Case, comm: MPI.Intracomm) -> None:
    """Refuse to make a mesh that does not fit into the memory. Collective.

    Raises:
        InputError: on all ranks, if the memory is too small.
    """
    size = plan_rotor(case, comm).blades.size
    available = machine_memory(comm)
    if mesh_memory(size) <= available:
        return
    raise InputError(
        f"a mesh of {size.cells} cells needs about {in_bytes(mesh_memory(size))} of memory, this "
        f"machine has {in_bytes(available)}; {WAY_OUT}"
    )
