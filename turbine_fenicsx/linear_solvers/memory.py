"""Memory that matrices and factors of a system need, counted before any of them is made."""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.machine import machine_memory
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.factor import to_petsc
from turbine_fenicsx.linear_solvers.substructures import find_shared_nodes
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.system import MultibodySystem

ENTRY, FACTOR_ENTRY = 12.0, 8.0
"""Bytes of an entry of a matrix, value and column, and of a factor, which keeps blocks."""

BEFORE_FACTOR, BESIDE_FACTOR = 4.4, 2.2
"""Copies of the matrix at most, while it is taken apart and while it is factorised. Measured with
70 000 to 1 260 000 unknowns."""

FACTORS = {"frozen": 1.0, "iterative": 0.0, "lu": 2.0, "monolithic": 2.0}
"""Entries that a linear solver keeps for each entry of L: L L^T one, L U two."""


def check_memory(system: MultibodySystem, linear_solver: str, shared: bool) -> None:
    """Refuse a system that the machines cannot hold. Collective.

    The unknowns and, on one rank, the entries of the matrices are exact. Those of the factors are
    MUMPS's count for the graph of the nodes, which CHOLMOD's factors exceed by up to 15 %. The
    count leaves out what several ranks add at their interfaces.

    Args:
        shared: Whether components of equal size share a factor, as undeformed ones do.
    """
    models = [model.full for model in system.flexible_models if not model.is_small]
    available = machine_memory(system.comm)
    # a row has at least the nodes of one cell; where not even these fit, the graph may not either
    rows = [(m.n_owned, _compat.dofs_of_cells(m.space).shape[1]) for m in models]
    least = np.array([3.0 * sum(n for n, _ in rows), 9.0 * sum(n * width for n, width in rows)])
    unknowns, entries = sum_over_ranks(system.comm, least)
    factor, parts = 0.0, f"at least {entries:.3g} entries of their matrix"
    if BEFORE_FACTOR * ENTRY * entries <= available:
        counts = sum((_count_entries(m, shared) for m in models), np.zeros(2))
        entries, factor = sum_over_ranks(system.comm, counts)
        factor *= FACTORS[linear_solver]
        parts = f"{entries:.3g} entries of their matrix and {factor:.3g} of its factor"
    without = BEFORE_FACTOR * ENTRY * entries
    needed = max(without, BESIDE_FACTOR * ENTRY * entries + FACTOR_ENTRY * factor)
    if needed <= available:
        return
    fits = linear_solver == "frozen" and shared and without <= available
    way_out = f'; solver.linear_solver = "iterative" needs {_in_gigabytes(without)}' if fits else ""
    raise InputError(
        f"{unknowns:.0f} displacements need {_in_gigabytes(needed)} of memory for {parts}, the "
        f"machine has {_in_gigabytes(available)}{way_out}; --force continues anyway"
    )


def _count_entries(model: FlexibleModel, shared: bool) -> Array:
    """Entries of the matrix and of its factor L, of this rank's nodes, shape (2,)."""
    cells, n = _compat.dofs_of_cells(model.space), len(model.local_positions)
    starts = np.arange(0, cells.size + 1, cells.shape[1])
    nodes_of = csr_matrix((np.ones(cells.size), cells.ravel(), starts), (len(cells), n))
    graph = (nodes_of.T @ nodes_of).tocsr()[: model.n_owned]
    own = np.flatnonzero(~find_shared_nodes(model))
    inner = graph[own][:, own]
    component = connected_components(inner, directed=False)[1]
    sizes, found = np.bincount(component), 0.0
    for size, number in zip(*np.unique(sizes, return_counts=True), strict=True):
        part = component == np.flatnonzero(sizes == size)[0]
        found += _count_factor(inner[part][:, part]) * (1 if shared else number)
    return np.array([9.0 * graph.nnz, 9.0 * found])


def _count_factor(graph: csr_matrix) -> float:
    """Entries of the factor L of a symmetric matrix with such a graph."""
    matrix, pc = to_petsc(graph), PETSc.PC().create(PETSc.COMM_SELF)
    pc.setOperators(matrix)
    pc.setType("cholesky")
    pc.setFactorSolverType("mumps")
    pc.setFactorSetUpSolverType()
    factor = pc.getFactorMatrix()
    factor.setMumpsIcntl(23, 1)  # one megabyte: MUMPS analyses, and does not factorise
    pc.setUp()
    found = float(factor.getMumpsInfog(3))
    pc.destroy()
    matrix.destroy()
    return found if found >= 0.0 else -1e6 * found  # MUMPS counts large ones in millions


def _in_gigabytes(size: float) -> str:
    """A size in words."""
    return f"{size / 1e9:.3g} GB"
