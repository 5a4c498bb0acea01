"""turbine_fenicsx: blades on hub and nacelle (hybrid), the same turning, or clamped."""

from __future__ import annotations

import dataclasses
import time

from mpi4py import MPI
from petsc4py import PETSc

import dolfinx
import measure
import numpy as np

from turbine_fenicsx import Coupling, FlexibleBody, Gravity, MultibodySystem, StVenantKirchhoff
from turbine_fenicsx.foundation.rotations import E3
from turbine_fenicsx.meshing import load_msh
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.solver_options import SolverOptions
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.flexible_blades import FlexibleBlades
from turbine_fenicsx.turbine.components.model import assemble
from turbine_fenicsx.turbine.components.nacelle import Nacelle


def build(problem, model, comm):
    """The system of the problem."""
    gravity = Gravity((0.0, -problem.gravity, 0.0))
    if model == "clamped":
        mesh = load_msh(comm, problem.msh)
        material = StVenantKirchhoff(*problem.lame)
        body = FlexibleBody("blades", mesh.mesh, material, problem.density, problem.degree)
        roots = [Coupling(root, body, mesh.facets(root), None) for root in ROOTS]
        return MultibodySystem(comm, [body, *roots, gravity])
    first, shear = problem.lame
    material = {"first_lame": first, "shear_modulus": shear, "density": problem.density}
    case = Case.parse(
        {
            "mesh": {"file": problem.msh},
            "material": {"law": "st_venant_kirchhoff", **material},
        }
    )
    parts = assemble(case, [Nacelle(), FlexibleBlades()], comm).parts
    if model == "turning":
        parts = turning(parts, 1.0)
    return MultibodySystem(comm, [*parts, gravity])


def turning(parts, speed):
    """The same parts with the hub turning about the rotor axis at a speed [rad/s]."""
    hub = parts[1]
    new = dataclasses.replace(hub, angular_velocity=speed * E3)
    found = []
    for part in parts:
        if part is hub:
            part = new
        elif getattr(part, "rigid", None) is hub:
            part = dataclasses.replace(part, rigid=new)
        elif getattr(part, "second", None) is hub:
            part = dataclasses.replace(part, second=new)
        found.append(part)
    return found


def tip_displacements(system, state, points):
    """Displacements of the tips relative to the hub, in its initial axes, shape (3, 3).

    Args:
        system: The system.
        state: A state of it.
        points: Initial positions of the tips.
    """
    (block,) = system.flexible_models
    u = state.u[0].array_r.reshape(-1, 3)
    hub = next((b for b in system.rigid_bodies if b.name == "hub"), None)
    tips = np.zeros((3, 3))
    for k, point in enumerate(points):
        near = (np.inf,)  # of nodes as near as each other the first by position, on any ranks
        if len(u):
            distance = np.round(np.linalg.norm(block.positions - point, axis=1), 6)
            node = np.lexsort((*block.positions.T, distance))[0]
            near = (distance[node], *block.positions[node, ::-1])
        if near == min(system.comm.allgather(near)) and len(u):
            tips[k] = u[node]
            if hub is not None:
                X = block.positions[node]
                phi, *directors = system.coordinates_of(state.q)[hub].reshape(4, 3)
                tips[k] = np.array(directors) @ (X + u[node] - phi) - hub.body_coordinates(X)
    return system.comm.allreduce(tips)


def main():
    problem, args = measure.arguments(
        model=["hybrid", "clamped", "turning"], linear_solver="frozen", tolerance=0.0
    )
    comm = MPI.COMM_WORLD
    tolerance = args.tolerance or problem.tolerance
    system = build(problem, args.model, comm)
    solver = EnergyMomentum(system, options=SolverOptions(args.linear_solver, tolerance))
    state = system.initial_state()
    spare = state.copy()
    set_up = measure.seconds_since_start()

    steps, balances, reports = [], [], []
    for _ in range(problem.steps):
        comm.barrier()
        t0 = time.perf_counter()
        reports.append(solver.advance(state, problem.dt, spare))
        state, spare = spare, state
        comm.barrier()
        t1 = time.perf_counter()
        system.balance(state)
        steps.append(t1 - t0)
        balances.append(time.perf_counter() - t1)
    tips = tip_displacements(system, state, problem.tip_points)
    memory = comm.allreduce(measure.peak_memory())
    if comm.rank == 0:
        measure.write(
            args.result,
            problem,
            set_up=set_up,
            steps=steps,
            iterations=[r.newton_iterations for r in reports],
            krylov=[r.krylov_iterations for r in reports],
            tips=tips,
            memory=memory,
            ranks=comm.size,
            versions={
                **measure.versions("turbine_fenicsx"),
                "dolfinx": dolfinx.__version__,
                "petsc": ".".join(map(str, PETSc.Sys.getVersion())),
            },
            balances=balances,
            residual=max(r.residual for r in reports),
        )
    solver.destroy()


if __name__ == "__main__":
    main()
