"""Claims about the sparse factors of symmetric matrices."""

from petsc4py import PETSc

import numpy as np
import pytest

from turbine_fenicsx.linear_solvers.factor import SparseFactor
from turbine_fenicsx.linear_solvers.symmetric import SymmetricFactor

pytestmark = pytest.mark.parallel

ACCURACY = 1e-10
"""Condition numbers are some 1e4."""


def tridiagonal(comm, n, diagonal, mine=None, coupled=True):
    """Symmetric matrix with eigenvalues diagonal - 2 cos(k pi/(n + 1)).

    With so many rows of mine on each rank instead of n in all, and ranks coupled or not.
    """
    size = n if mine is None else (mine, None)
    A = PETSc.Mat().createAIJ((size, size), nnz=3, comm=comm)
    start, end = A.getOwnershipRange()
    first, last = (0, A.getSize()[0]) if coupled else (start, end)
    for i in range(start, end):
        A[i, i] = diagonal
        for j in (i - 1, i + 1):
            if first <= j < last:
                A[i, j] = -1.0
    A.assemble()
    return A


def take_values(own, A):
    """Make a matrix that a solver may have destroyed anew, with the values of another one."""
    own.destroy()
    first, last = A.getOwnershipRange()
    rows = PETSc.IS().createStride(last - first, first, 1, comm=A.getComm())
    A.createSubMatrix(rows, rows, submat=own)


def error_of_solution(factor, A):
    x, b = A.createVecs()
    start, end = x.getOwnershipRange()
    x.array[:] = np.sin(1.0 + np.arange(start, end))
    expected = x.copy()
    A.mult(x, b)
    factor.solve(b, x)
    x.axpy(-1.0, expected)
    return x.norm() / expected.norm()


@pytest.mark.parametrize("diagonal", [2.5, 0.7])
def test_solves_whether_positive_definite_or_not(comm, diagonal):
    # 0.7 lies in the middle of the spectrum: L L^T does not exist
    A = tridiagonal(comm, 500, diagonal)
    factor = SymmetricFactor(A, "test_")
    factor.update()
    assert error_of_solution(factor, A) < ACCURACY
    factor.destroy()


def test_follows_a_matrix_that_loses_positive_definiteness(comm):
    A = tridiagonal(comm, 500, 2.5)
    factor = SymmetricFactor(A, "test_")
    for shift in (0.0, -1.8, 1.8):
        A.shift(shift)
        factor.update()
        assert error_of_solution(factor, A) < ACCURACY
    assert factor.iterations >= 3
    factor.destroy()


def test_a_matrix_that_is_not_positive_definite_is_no_news_for_users(capfd):
    """CHOLMOD prints a warning of its own where its supernodes meet a negative pivot."""
    n = 400
    A = PETSc.Mat().createAIJ((n, n), nnz=n, comm=PETSc.COMM_SELF)
    values = np.ones((n, n)) + n * np.eye(n)
    values[n - 1, n - 1] = -1.0
    A.setValues(range(n), range(n), values)
    A.assemble()
    factor = SymmetricFactor(A, "test_quiet_")
    factor.update()
    assert error_of_solution(factor, A) < ACCURACY
    assert factor.count_negative() == 1
    assert capfd.readouterr() == ("", "")
    assert not PETSc.Options("test_quiet_").getAll()
    factor.destroy()
    A.destroy()


@pytest.mark.parametrize("last", [2.5, 0.7, 0.0])
def test_ranks_agree_where_one_of_them_alone_loses_positive_definiteness(comm, last):
    diagonal = last if comm.rank == comm.size - 1 else 2.5
    A = tridiagonal(comm, None, diagonal, mine=200, coupled=False)
    factor = SymmetricFactor(A, "test_")
    factor.update()
    assert error_of_solution(factor, A) < ACCURACY
    factor.destroy()


def test_a_rank_without_rows(comm):
    n = 0 if 0 < comm.rank == comm.size - 1 else 100
    A = tridiagonal(comm, None, 2.5, mine=n)
    factor = SymmetricFactor(A, "test_")
    factor.update()
    assert error_of_solution(factor, A) < ACCURACY
    factor.destroy()


@pytest.mark.parametrize("symmetric", [True, False])
def test_mumps_gets_the_work_space_that_it_finds_it_needs(comm, symmetric):
    """Next to nothing on the diagonal of a grid: nearly all pivots are delayed."""
    w = 40
    A = PETSc.Mat().createAIJ((w * w, w * w), nnz=5, comm=comm)
    for i in range(*A.getOwnershipRange()):
        A[i, i] = 1e-9
        sides = ((i - w, i >= w), (i - 1, i % w), (i + 1, (i + 1) % w), (i + w, i + w < w * w))
        for j in (j for j, there in sides if there):
            A[i, j] = np.sin(2.0 + 1.7 * min(i, j) + 0.3 * max(i, j))
    A.assemble()
    factor = SparseFactor(A, "test_", symmetric)
    for _ in range(2):
        factor.update()
        assert error_of_solution(factor, A) < 1e-6
    factor.destroy()


def test_several_right_hand_sides_of_a_matrix_without_a_factor_give_no_numbers(comm):
    A = tridiagonal(comm, 20, 2.5)
    A.scale(0.0)
    factor = SparseFactor(A, "test_")
    factor.update()
    assert not np.any(np.isfinite(factor.solve_many(np.ones((A.getLocalSize()[0], 3)))))
    factor.destroy()


@pytest.mark.parametrize("given", [{}, {"ksp_type": "cg", "ksp_rtol": 1e-12, "pc_type": "jacobi"}])
def test_several_right_hand_sides_at_once_also_with_a_solver_of_the_users(comm, given):
    A, options = tridiagonal(comm, 50, 2.5), PETSc.Options("test_many_")
    for name, value in given.items():
        options[name] = value
    factor = SparseFactor(A, "test_many_", symmetric=True)
    for name in given:
        options.delValue(name)
    factor.update()
    B = np.sin(np.arange(A.getLocalSize()[0] * 3.0)).reshape(-1, 3)
    X, (x, b) = factor.solve_many(B), A.createVecs()
    for k in range(3):
        x.array[:] = X[:, k]
        A.mult(x, b)
        assert np.allclose(b.array_r, B[:, k], rtol=0, atol=1e-10)
    factor.destroy()
