"""A FEniCSx script as its users write it: clamped blades, implicit midpoint rule, SNES and MUMPS.

The rule M (du - dt v) + dt^2/2 (f(u + du/2) - M g) = 0 is second order as all the others here, and
its tangent is symmetric, so that a Cholesky factorisation is allowed. `METHODS` are the ways to
solve with it, from what everyone does first to what an expert tunes; nothing but PETSc options
differs. The variable PETSC_OPTIONS may hold more of them.
"""

from __future__ import annotations

import time

from mpi4py import MPI
from petsc4py import PETSc

import dolfinx
import measure
import numpy as np
import ufl
from dolfinx import fem

from turbine_fenicsx import _compat  # hides the differences between DOLFINx releases, no more
from turbine_fenicsx.meshing import load_msh

DIRECT = {"ksp_type": "preonly", "pc_factor_mat_solver_type": "mumps"}
KRYLOV = {"ksp_type": "cg", "ksp_rtol": 1e-5, "pc_type": "cholesky"}
LAG_FACTOR = {"snes_lag_preconditioner": -2, "snes_lag_preconditioner_persists": True}
LAG_TANGENT = {"snes_lag_jacobian": -2, "snes_lag_jacobian_persists": True}
METHODS = {
    # full Newton, a factorisation in each iteration
    "lu": {**DIRECT, "pc_type": "lu"},
    "cholesky": {**DIRECT, "pc_type": "cholesky"},
    # the tangent assembled in each iteration, one factor of the run as preconditioner of CG
    "lagged": {**DIRECT, **KRYLOV, **LAG_FACTOR},
    # tangent and factor of the first step for ever (chord iteration)
    "chord": {**DIRECT, "pc_type": "cholesky", **LAG_TANGENT},
}


class Blades:
    """Forms, vectors and solver."""

    def __init__(self, problem, comm, options):
        mesh = load_msh(comm, problem.msh)
        domain = mesh.mesh
        self.V = V = _compat.vector_space(domain, problem.degree)
        self.u, self.du, self.dt_v = (fem.Function(V) for _ in range(3))
        w, delta = ufl.TestFunction(V), ufl.TrialFunction(V)
        lam, mu = (fem.Constant(domain, PETSc.ScalarType(x)) for x in problem.lame)
        rho = fem.Constant(domain, PETSc.ScalarType(problem.density))
        h = fem.Constant(domain, PETSc.ScalarType(0.5 * problem.dt**2))
        g = fem.Constant(domain, np.array([0.0, -problem.gravity, 0.0], dtype=PETSc.ScalarType))
        points = {"quadrature_degree": 2 * problem.degree + 1}  # 2 x 2 x 2 or 3 x 3 x 3 of Gauss
        dx = ufl.dx(domain=domain, metadata=points)

        F = ufl.Identity(3) + ufl.grad(self.u + 0.5 * self.du)
        E = 0.5 * (F.T * F - ufl.Identity(3))
        S = lam * ufl.tr(E) * ufl.Identity(3) + 2.0 * mu * E
        R = rho * ufl.dot(self.du - self.dt_v - h * g, w) * dx
        R += h * ufl.inner(F * S, ufl.grad(w)) * dx
        self.residual_form = _compat.compile_form(R)
        self.tangent_form = _compat.compile_form(ufl.derivative(R, self.du, delta))

        roots = [mesh.facets(f"root_{k}") for k in (1, 2, 3)]
        nodes = fem.locate_dofs_topological(V, 2, np.sort(np.concatenate(roots)))
        self.n_owned = 3 * V.dofmap.index_map.size_local
        self.clamped = (3 * nodes[:, None] + np.arange(3)).ravel()
        self.clamped = self.clamped[self.clamped < self.n_owned].astype(np.int32)
        self.clamped_rows = self.clamped + 3 * V.dofmap.index_map.local_range[0]

        index_map = V.dofmap.index_map
        self.work = PETSc.Vec().createGhost(
            index_map.ghosts.astype(PETSc.IntType),
            size=(self.n_owned, 3 * index_map.size_global),
            bsize=3,
            comm=comm,
        )
        self.R = PETSc.Vec().createMPI((self.n_owned, 3 * index_map.size_global), comm=comm)
        self.x = self.R.duplicate()
        self.terms = self._size_of_terms(rho, w, dx, problem)
        self.tolerance = problem.tolerance
        self.A = _compat.create_matrix(self.tangent_form)
        self.A.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self.A.setOption(PETSc.Mat.Option.SPD, options["pc_type"] == "cholesky")

        self.snes = PETSc.SNES().create(comm)
        self.snes.setFunction(self.residual, self.R)
        self.snes.setJacobian(self.tangent, self.A)
        self.snes.setConvergenceTest(self.converged)
        database = PETSc.Options()
        for key, value in {"snes_linesearch_type": "basic", **options}.items():
            if key not in database:
                database[key] = value
        self.snes.setFromOptions()

    def residual(self, snes, x, R):
        self.du.x.array[: self.n_owned] = x.array_r
        self.du.x.scatter_forward()
        _compat.assemble_vector(self.work, self.residual_form)
        R.array[:] = self.work.array_r
        R.array[self.clamped] = x.array_r[self.clamped]

    def tangent(self, snes, x, A, P):
        _compat.assemble_matrix(A, self.tangent_form)
        A.zeroRowsColumns(self.clamped_rows, 1.0)

    def converged(self, snes, iteration, norms):
        """The criterion of turbine_fenicsx: residual against the inertia and gravity terms."""
        du, dt_v = np.abs(self.du.x.array[: self.n_owned]), np.abs(self.dt_v.x.array)
        mass, weight = self.terms
        squares = self.V.mesh.comm.allreduce(
            np.sum((mass * (du + dt_v[: self.n_owned] + weight)) ** 2)
        )
        if snes.getFunction()[0].norm() <= self.tolerance * np.sqrt(squares):
            return PETSc.SNES.ConvergedReason.CONVERGED_FNORM_RELATIVE
        return PETSc.SNES.ConvergedReason.DIVERGED_MAX_IT if iteration >= 50 else 0

    def step(self, dt):
        """One time step from the state in u and dt_v; returns the Newton and Krylov iterations."""
        self.x.array[:] = self.dt_v.x.array[: self.n_owned]
        self.snes.solve(None, self.x)
        if self.snes.getConvergedReason() < 0:
            raise RuntimeError(f"step did not converge: {self.snes.getConvergedReason()}")
        self.u.x.array[:] += self.du.x.array
        self.dt_v.x.array[:] = 2.0 * self.du.x.array - self.dt_v.x.array
        return self.snes.getIterationNumber(), self.snes.getLinearSolveIterations()

    def tips(self, points):
        """Displacements of the tips at these initial positions, shape (3, 3)."""
        comm = self.V.mesh.comm
        X = self.V.tabulate_dof_coordinates()[: self.n_owned // 3]
        found = np.zeros((3, 3))
        for k, point in enumerate(points):
            distance = np.linalg.norm(X - point, axis=1)
            near = (float(distance.min(initial=np.inf)), comm.rank)
            if comm.allreduce(near, op=MPI.MINLOC)[1] == comm.rank:
                node = int(np.argmin(distance))
                found[k] = self.u.x.array[3 * node : 3 * node + 3]
        return comm.allreduce(found)

    def _size_of_terms(self, rho, w, dx, problem):
        """Nodal masses of the owned unknowns and dt^2/2 times gravity."""
        one = fem.Constant(self.V.mesh, np.ones(3, dtype=PETSc.ScalarType))
        _compat.assemble_vector(self.work, _compat.compile_form(rho * ufl.dot(one, w) * dx))
        return self.work.array_r.copy(), 0.5 * problem.dt**2 * problem.gravity


def main():
    problem, args = measure.arguments(method=list(METHODS))
    comm = MPI.COMM_WORLD
    blades = Blades(problem, comm, METHODS[args.method])
    set_up = measure.seconds_since_start()
    steps, newton, krylov = [], [], []
    for _ in range(problem.steps):
        comm.barrier()
        t0 = time.perf_counter()
        iterations = blades.step(problem.dt)
        comm.barrier()
        steps.append(time.perf_counter() - t0)
        newton.append(iterations[0])
        krylov.append(iterations[1])
    tips = blades.tips(problem.tip_points)
    memory = comm.allreduce(measure.peak_memory())
    if comm.rank == 0:
        measure.write(
            args.result,
            problem,
            set_up=set_up,
            steps=steps,
            iterations=newton,
            tips=tips,
            memory=memory,
            ranks=comm.size,
            versions={
                **measure.versions(),
                "dolfinx": dolfinx.__version__,
                "petsc": ".".join(map(str, PETSc.Sys.getVersion())),
            },
            krylov=krylov,
        )


if __name__ == "__main__":
    main()
