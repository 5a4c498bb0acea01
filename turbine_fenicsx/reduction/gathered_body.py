"""A body on a mesh as matrices of all its nodes, gathered on rank 0."""

from __future__ import annotations

from dataclasses import dataclass

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import ufl
from scipy import sparse

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.flexible_model import FlexibleModel


@dataclass(frozen=True, eq=False)
class WholeBody:
    """Positions and matrices of all nodes, in the order of their global numbers.

    Args:
        positions: X, shape (N, 3) [m], on all ranks.
        mass: int rho N_a N_b dV on rank 0, shape (N, N) [kg].
        stiffness: K at rest on rank 0, shape (3 N, 3 N) [N/m].
        laplacian: int grad N_a . grad N_b dV on rank 0, shape (N, N) [m]; None if not wanted.
    """

    positions: Array
    mass: sparse.csr_matrix
    stiffness: sparse.csr_matrix
    laplacian: sparse.csr_matrix | None


def gather_body(model: FlexibleModel, with_laplacian: bool) -> WholeBody:
    """Gather a body. Collective."""
    u, K = model.new_vector(), model.new_stiffness()
    model.assemble_stiffness(u, 0.0, K)
    M = model.mass_matrix()
    stiffness, mass = _gather(model.comm, K), _gather(model.comm, M)[::3, ::3]
    laplacian = None
    if with_laplacian:
        w, delta = ufl.TestFunction(model.space), ufl.TrialFunction(model.space)
        form = _compat.compile_form(ufl.inner(ufl.grad(w), ufl.grad(delta)) * model.dx_mass)
        L = _compat.create_matrix(form)
        _compat.assemble_matrix(L, form)
        laplacian = sparse.csr_matrix(_gather(model.comm, L)[::3, ::3])
        L.destroy()
    for thing in (u, K, M):
        thing.destroy()
    positions = np.concatenate(model.comm.allgather(model.positions))
    return WholeBody(positions, sparse.csr_matrix(mass), stiffness, laplacian)


def _gather(comm: MPI.Intracomm, matrix: PETSc.Mat) -> sparse.csr_matrix:
    """A matrix on rank 0; without rows on the others."""
    starts, columns, values = matrix.getValuesCSR()
    n = matrix.getSize()[1]
    own = sparse.csr_matrix((values, columns, starts), (len(starts) - 1, n))
    parts = comm.gather(own)
    return sparse.vstack(parts, "csr") if parts else sparse.csr_matrix((0, n))
