"""Claims about factors that the ranks hold apart and join at their interface."""

from petsc4py import PETSc

import numpy as np
import pytest
from dolfinx.mesh import CellType, create_box
from test_factor import error_of_solution, tridiagonal

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.forces import StepTimes
from turbine_fenicsx.linear_solvers import substructures
from turbine_fenicsx.linear_solvers.substructures import (
    Substructures,
    find_interface_rows,
    is_worthwhile,
)
from turbine_fenicsx.materials import StVenantKirchhoff
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep

pytestmark = pytest.mark.skipif(
    not PETSc.Sys.hasExternalPackage("suitesparse"), reason="this PETSc has no CHOLMOD"
)


def stiffness(comm, layers=32, width=2, length=8.0):
    """Tangent of a free bar, symmetric positive definite, and the distances of its rows."""
    corners = [np.zeros(3), np.array([1.0, 1.0, length])]
    mesh = create_box(comm, corners, [width, width, layers], cell_type=CellType.hexahedron)
    block = FlexibleModel(FlexibleBody("bar", mesh, StVenantKirchhoff(1e9, 1e9), 1e3))
    step, rest = FlexibleStep(block), block.new_vector()
    step.begin(rest, rest, StepTimes.from_start(0.0, 0.02), np.zeros(3))
    step.assemble_tangent(rest)
    step.tangent.setOption(PETSc.Mat.Option.SPD, True)
    return step.tangent, np.repeat(block.positions[:, 2], 3)


def interface_of(A, z):
    """Where ranks meet; a section in the middle if there is one rank only."""
    if A.getComm().getSize() > 1:
        return find_interface_rows(A)
    return np.flatnonzero(np.abs(z - 0.5 * z.max()) < 1e-9).astype(np.int32)


@pytest.mark.parametrize("slab", [1, 4, 1000])
def test_joined_factors_solve_whatever_the_slab(comm, monkeypatch, slab):
    monkeypatch.setattr(substructures, "SLAB", slab)
    A, z = stiffness(comm)
    factor = Substructures(A, interface_of(A, z), "test_")
    for shift in (0.0, 1e3):  # follows new values of the matrix
        A.shift(shift)
        factor.update()
        # relative errors of NEGLIGIBLE; without the part beyond the slab it is 0.1 and more
        assert error_of_solution(factor, A) < 10.0 * substructures.NEGLIGIBLE
    assert factor.iterations == 2
    factor.destroy()


def test_nothing_is_lost_but_what_is_negligible(comm, monkeypatch):
    monkeypatch.setattr(substructures, "NEGLIGIBLE", 0.0)
    A, z = stiffness(comm)
    factor = Substructures(A, interface_of(A, z), "test_")
    factor.update()
    assert error_of_solution(factor, A) < 1e-6  # that of W_s in single precision
    factor.destroy()


def test_far_from_the_interface_only_few_solutions_are_needed(comm, monkeypatch):
    """Saint-Venant: far fewer solutions with the large factor than columns of W."""
    solved = []
    original = substructures.DefiniteFactor.solve_many

    def counting(self, B):
        solved.append(B.shape)
        return original(self, B)

    monkeypatch.setattr(substructures.DefiniteFactor, "solve_many", counting)
    if comm.size == 1:  # one rank has both sides of S
        monkeypatch.setattr(substructures, "SLAB", 2 * substructures.SLAB)
    A, z = stiffness(comm, layers=96, width=3, length=48.0)
    factor = Substructures(A, interface_of(A, z), "test_")
    factor.update()
    near, *far = solved
    assert all(shape[1] <= near[1] // 2 for shape in far)
    assert comm.size > 1 or far
    factor.destroy()


def test_a_matrix_without_factor_is_refused_on_all_ranks(comm):
    A, z = stiffness(comm)
    factor = Substructures(A, interface_of(A, z), "test_")
    if comm.rank == comm.size - 1:  # one rank alone
        diagonal = A.getDiagonal()
        diagonal.array[:] = np.nan
    else:
        diagonal = A.getDiagonal()
    A.setDiagonal(diagonal)
    with pytest.raises(np.linalg.LinAlgError):
        factor.update()
    factor.destroy()


def test_ranks_that_do_not_meet(comm):
    """Nothing couples them, as where each rank has a blade of its own."""
    A = PETSc.Mat().createAIJ((6 * comm.size, 6 * comm.size), nnz=1, comm=comm)
    for i in range(*A.getOwnershipRange()):
        A[i, i] = 2.0 + i
    A.assemble()
    assert is_worthwhile(A, find_interface_rows(A))
    factor = Substructures(A, find_interface_rows(A), "test_")
    factor.update()
    assert error_of_solution(factor, A) < 1e-14
    factor.destroy()


def test_interface_rows_are_those_coupled_to_higher_ranks(comm):
    A = tridiagonal(comm, 60, 2.5)
    last = A.getLocalSize()[0] - 1
    expected = [last] if comm.rank < comm.size - 1 else []
    assert find_interface_rows(A).tolist() == expected


def test_worthwhile_for_slender_bodies_only(comm):
    bar, _ = stiffness(comm)
    rows = find_interface_rows(bar)
    assert is_worthwhile(bar, rows)
    everything = np.arange(bar.getLocalSize()[0], dtype=np.int32)
    assert not is_worthwhile(bar, everything)
    assert not is_worthwhile(bar, everything[: everything.size // 2])
