"""Where the residual of a step is largest: what to say of a step that fails."""

from __future__ import annotations

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.time_stepping.nested_step import NestedStep


def describe_largest_residual(step: NestedStep, R: PETSc.Vec) -> str:
    """Name the equations whose residual is largest compared with their terms. Collective.

    Returns:
        For example ``"blade_1 near (0.1, 12.3, -4) m"``, equal on all ranks; empty if there is no
        finite residual.
    """
    relative = step.relative_residuals(R)
    if not np.all(np.isfinite(relative)):
        return ""
    bodies = step.system.flexible_models
    largest = int(np.argmax(relative))
    if largest < 2 * len(bodies):
        return _in_body(step, R, largest)
    return _in_rigid_block(step, R, largest - 2 * len(bodies))


def _in_body(step: NestedStep, R: PETSc.Vec, number: int) -> str:
    """The node of a flexible body, or of its couplings, with the largest residual."""
    k, coupled = number % len(step.system.flexible_models), number >= len(step.start.state.u)
    block, coupling = step.system.flexible_models[k], step.system.coupling_blocks[k]
    part = step.split(R)[1 if coupled else 0][k].array_r.reshape(-1, 3)
    nodes = coupling.nodes if coupled else np.arange(block.n_owned)
    sizes = np.linalg.norm(part, axis=1)
    worst = int(np.argmax(sizes)) if sizes.size else -1
    comm = step.system.comm
    mine = (float(sizes[worst]) if sizes.size else -1.0, comm.rank)
    owner = comm.allreduce(mine, op=MPI.MAXLOC)[1]
    name, place, is_point = block.body.name, np.zeros(3), True
    if comm.rank == owner:
        node = nodes[worst]
        place = block.positions[node] + step.start.state.u[k].array_r.reshape(-1, 3)[node]
        is_point = bool(block.is_point[node])
        if coupled:
            slices = zip(coupling.couplings, coupling.slices, strict=True)
            name = next(c.name for c, rows in slices if rows.start <= worst < rows.stop)
    name, place, is_point = comm.bcast((name, place, is_point), root=owner)
    return name if not is_point else f"{name} near ({', '.join(f'{x:.4g}' for x in place)}) m"


def _in_rigid_block(step: NestedStep, R: PETSc.Vec, part: int) -> str:
    """The rigid body or joint with the largest residual."""
    system = step.system
    residual: Array = np.abs(step.on_all_ranks(step.split(R)[2]))
    dq, dT, mu, nu, pi = system.rigid_model.split(residual)
    if part == 0:
        return system.rigid_bodies[int(np.argmax(dq)) // 12].name
    if part == 2:
        row = int(np.argmax(mu))
        owners = [body.name for body in system.rigid_bodies for _ in range(6)]  # directors first
        joints = (name for name, rows in system.joint_rows.items() if row in rows)
        return f"the constraints of {next(joints, None) or owners[row]}"
    of_angles = dT if part == 1 else nu
    if part == 3 and np.max(pi, initial=0.0) > np.max(nu, initial=0.0):
        return f"relation {system.relations[int(np.argmax(pi))].name!r}"
    return f"joint coordinate {system.joint_coordinate_names[int(np.argmax(of_angles))]}"
