"""A run or a mesh that the machine cannot hold is refused before anything is built."""

from __future__ import annotations

from mpi4py import MPI

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.estimate import estimate, in_bytes, mesh_memory
from turbine_fenicsx.turbine.case.size import MeshSize
from turbine_fenicsx.turbine.machine import machine_memory
from turbine_fenicsx.turbine.rotor_plan import plan_rotor

WAY_OUT = "--force continues anyway"


def size_of_blades(case: Case) -> MeshSize | None:
    """Size of the built-in mesh of a case; None without one, or with a mesh file."""
    if case.turbine.model == "rigid" or case.mesh.file:
        return None
    return plan_rotor(case).size


def refuse_run(case: Case, comm: MPI.Intracomm) -> None:
    """Refuse a run that needs more memory than there is. Collective.

    The mesh of a file counts only once it is read, so `check` says what it needs, and not this.

    Raises:
        InputError: on all ranks, if the memory is too small.
    """
    available = machine_memory(comm)
    if sentence := estimate(case, size_of_blades(case), comm.size).too_large(available):
        raise InputError(f"{sentence}; {WAY_OUT}")


def refuse_mesh(case: Case, comm: MPI.Intracomm) -> None:
    """Refuse to make a mesh that does not fit into the memory. Collective.

    Raises:
        InputError: on all ranks, if the memory is too small.
    """
    size = plan_rotor(case).size
    available = machine_memory(comm)
    if mesh_memory(size) <= available:
        return
    raise InputError(
        f"a mesh of {size.cells} cells needs about {in_bytes(mesh_memory(size))} of memory, this "
        f"machine has {in_bytes(available)}; {WAY_OUT}"
    )
