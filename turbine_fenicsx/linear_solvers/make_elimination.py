"""The elimination that a kind of body has."""

from __future__ import annotations

from collections.abc import Callable

from petsc4py import PETSc

from turbine_fenicsx.linear_solvers.body_elimination import BodyElimination
from turbine_fenicsx.linear_solvers.dense_elimination import DenseElimination
from turbine_fenicsx.linear_solvers.factor import FreeSolver
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.coupling_block import CouplingBlock


def make_elimination(
    model: BodyModel,
    tangent: PETSc.Mat,
    coupling: CouplingBlock,
    make_solver: Callable[[PETSc.Mat, PETSc.IS], FreeSolver],
) -> BodyElimination | DenseElimination:
    """The elimination of a body from its tangent, dense if the tangent is.

    Args:
        make_solver: Makes the solver for A_II of a sparse tangent from the matrix and its free
            nodes.
    """
    if "dense" in tangent.getType():
        return DenseElimination(model, tangent, coupling)
    return BodyElimination(model, tangent, coupling, make_solver)
