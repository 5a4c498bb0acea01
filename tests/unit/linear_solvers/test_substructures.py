"""Claims about factors that the ranks hold apart and join at their interface."""

from petsc4py import PETSc

import numpy as np
import pytest
from dolfinx.mesh import CellType, create_box
from test_factor import error_of_solution, take_values

from turbine_fenicsx import StepTimes, StVenantKirchhoff
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.linear_solvers import shared, symmetric
from turbine_fenicsx.linear_solvers.substructures import Substructures, find_shared_nodes
from turbine_fenicsx.linear_solvers.symmetric import SymmetricFactor
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep

pytestmark = pytest.mark.parallel


def stiffness(comm, layers=32, width=2, length=8.0):
    """Tangent of a free bar, symmetric positive definite, its nodes and which of them are shared.

    On one rank these are those of a section in the middle.
    """
    corners = [np.zeros(3), np.array([1.0, 1.0, length])]
    mesh = create_box(comm, corners, [width, width, layers], cell_type=CellType.hexahedron)
    block = FlexibleModel(FlexibleBody("bar", mesh, StVenantKirchhoff(1e9, 1e9), 1e3))
    step, rest = FlexibleStep(block), block.new_vector()
    step.start_step(rest, rest, StepTimes.from_start(0.0, 0.02), np.zeros(3))
    step.assemble_tangent(rest)
    X, in_S = block.positions, find_shared_nodes(block)
    if comm.size == 1:
        in_S = np.abs(X[:, 2] - 0.5 * length) < 1e-9
    return step.tangent, X, in_S


@pytest.mark.parametrize("package", ["cholmod", "mumps"])
@pytest.mark.parametrize("slab", [1, 4, 1000])
def test_joined_factors_solve_whatever_the_slab(comm, monkeypatch, slab, package):
    monkeypatch.setattr(shared, "SLAB", slab)
    if package == "mumps":
        monkeypatch.setattr(symmetric, "has_cholmod", lambda: False)
    A, X, in_S = stiffness(comm)
    own = A.copy()
    factor = Substructures(own, X, in_S, "test_")
    for shift in (0.0, 1e3):  # follows new values of the matrix
        A.shift(shift)
        take_values(own, A)
        factor.update()
        # relative errors of NEGLIGIBLE; without the part beyond the slab it is 0.1 and more
        assert error_of_solution(factor, A) < 10.0 * shared.NEGLIGIBLE
    assert factor.iterations == 2
    factor.destroy()


def test_nothing_is_lost_but_what_is_negligible(comm, monkeypatch):
    monkeypatch.setattr(shared, "NEGLIGIBLE", 0.0)
    A, X, in_S = stiffness(comm)
    own = A.copy()
    factor = Substructures(own, X, in_S, "test_")
    factor.update()
    assert error_of_solution(factor, A) < 1e-6  # that of W in single precision
    factor.destroy()


def test_far_from_the_interface_only_few_solutions_are_needed(comm, monkeypatch):
    """Saint-Venant: far fewer solutions with the large factor than columns of W."""
    solved = []
    original = SymmetricFactor.solve_many

    def counting(self, B):
        solved.append(B.shape)
        return original(self, B)

    monkeypatch.setattr(SymmetricFactor, "solve_many", counting)
    A, X, in_S = stiffness(comm, layers=96, width=3, length=48.0)
    own = A.copy()
    factor = Substructures(own, X, in_S, "test_")
    factor.update()
    near = solved[::2]
    far = solved[1::2]
    assert far and all(b[1] <= a[1] // 2 for a, b in zip(near, far, strict=True))
    factor.destroy()


def test_halves_share_a_factor(comm):
    """On one rank the section in the middle leaves two halves, a motion apart."""
    A, X, in_S = stiffness(comm)
    own = A.copy()
    factor = Substructures(own, X, in_S, "test_")
    factor.update()
    factors, parts = factor.factors
    assert (factors, parts) == (1, 2) if comm.size == 1 else factors <= parts == comm.size
    assert error_of_solution(factor, A) < 10.0 * shared.NEGLIGIBLE
    B = np.random.default_rng(comm.rank).normal(size=(A.getLocalSize()[0], 4))
    X = factor.solve_many(B)
    x, b = A.createVecs()
    for k in range(4):
        x.array[:] = X[:, k]
        A.mult(x, b)
        b.array[:] -= B[:, k]
        assert b.norm() < 1e-3 * comm.allreduce(np.sum(B[:, k] ** 2)) ** 0.5
    factor.destroy()


def test_where_there_is_no_factor_solutions_are_not_finite_on_all_ranks(comm):
    A, X, in_S = stiffness(comm)
    own = A.copy()
    factor = Substructures(own, X, in_S, "test_")
    diagonal = A.getDiagonal()
    if comm.rank == comm.size - 1:  # one rank alone
        diagonal.array[:] = np.nan
    A.setDiagonal(diagonal)
    take_values(own, A)
    factor.update()
    assert not np.any(np.isfinite(factor.solve_many(np.ones((A.getLocalSize()[0], 1)))))
    factor.destroy()


def test_what_fails_on_one_rank_is_raised_on_all(comm, monkeypatch):
    A, X, in_S = stiffness(comm)
    factor = Substructures(A.copy(), X, in_S, "test_")

    def run_out_of_memory(self):
        raise MemoryError("no room for the factor")

    if comm.rank == comm.size - 1:
        monkeypatch.setattr(shared.CongruentParts, "factorise", run_out_of_memory)
    with pytest.raises(MemoryError, match="no room for the factor"):
        factor.update()
    factor.destroy()


def test_ranks_that_do_not_meet(comm):
    """Nothing couples them, as where each rank has a blade of its own."""
    A = PETSc.Mat().createAIJ((6 * comm.size, 6 * comm.size), nnz=1, comm=comm)
    for i in range(*A.getOwnershipRange()):
        A[i, i] = 2.0 + i
    A.assemble()
    X, in_S = np.arange(6.0).reshape(2, 3), np.zeros(2, bool)
    own = A.copy()
    factor = Substructures(own, X, in_S, "test_")
    assert factor.pays_off()
    factor.update()
    assert error_of_solution(factor, A) < 1e-14
    factor.destroy()


def test_shared_nodes_take_the_ranks_apart(comm):
    """Without them no entry of the matrix couples two ranks."""
    A, _, in_S = stiffness(comm)
    first, last = A.getOwnershipRange()
    others = comm.allgather(first + np.flatnonzero(np.repeat(~in_S, 3)))
    indptr, columns, _ = A.getValuesCSR()
    rows = np.repeat(np.arange(last - first), np.diff(indptr))
    met = columns[~np.repeat(in_S, 3)[rows]]
    assert not np.any(np.isin(met, np.concatenate([[], *others[: comm.rank]])))
    assert not np.any(np.isin(met, np.concatenate([[], *others[comm.rank + 1 :]])))
    assert comm.size == 1 or 0 < comm.allreduce(np.count_nonzero(in_S)) < 50 * comm.size


def test_worthwhile_for_slender_bodies_only(comm):
    bar, X, in_S = stiffness(comm)

    def pays_off(shared):
        return Substructures(bar, X, shared, "test_").pays_off()

    everything = np.ones(in_S.size, bool)
    assert pays_off(in_S) == (comm.size > 1)  # a bar in one piece
    assert not pays_off(everything)
    everything[::2] = False
    assert not pays_off(everything)
