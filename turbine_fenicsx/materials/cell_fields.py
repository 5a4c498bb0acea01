"""Densities and moduli that differ from cell to cell."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, TypeGuard

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
from dolfinx import fem
from dolfinx.mesh import Mesh

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import raise_together
from turbine_fenicsx.foundation.types import Array

Scalar: TypeAlias = float | fem.Function
"""A density or a parameter of a material: a number, or what `cell_field` returns."""


def cell_field(
    mesh: Mesh, values: npt.ArrayLike | Callable[[Array], npt.ArrayLike]
) -> fem.Function:
    """A cellwise constant field, for densities and for the parameters of materials.

    Args:
        mesh: The mesh.
        values: One value for each cell that this rank owns, shape (cells,), or a row of n values,
            shape (cells, n); or a function of the midpoints of cells, shape (cells, 3) [m], that
            returns these.

    Returns:
        DOLFINx function of degree 0, a scalar or a vector of n components.

    Raises:
        ModelError: for another number of values, rows of different lengths on different ranks, or
            values that are not finite, on all ranks.

    Note:
        Collective.
    """
    midpoints = fem.Function(_compat.cellwise_space(mesh, (3,)))
    n, error = mesh.topology.index_map(mesh.topology.dim).size_local, None
    given = np.empty(0)
    try:
        if callable(values):
            midpoints.interpolate(lambda x: x)
            nodes = _compat.dofs_of_cells(midpoints.function_space)[:n, 0]
            values = values(midpoints.x.array.reshape(-1, 3)[nodes])
        given = np.asarray(values, dtype=float)
        if given.ndim not in (1, 2) or len(given) != n:
            raise ModelError(
                f"a cell field needs a value for each of the {n} cells of this rank, shape "
                f"({n},), got shape {given.shape}"
            )
        if not np.all(np.isfinite(given)):
            raise ModelError("values of a cell field must be finite, but some are not")
    except Exception as problem:  # the other ranks must hear of it, whatever it is
        error = problem
    raise_together(mesh.comm, error)
    shapes = set(mesh.comm.allgather(given.shape[1:]))
    if len(shapes) > 1:
        raise ModelError(f"rows of a cell field differ in length between ranks: {sorted(shapes)}")
    field = fem.Function(_compat.cellwise_space(mesh, given.shape[1:]))
    dofs = _compat.dofs_of_cells(field.function_space)[:n, 0]
    field.x.array.reshape(-1, *given.shape[1:])[dofs] = given
    field.x.scatter_forward()
    return field


def is_field(value: Any) -> TypeGuard[fem.Function]:
    """Whether a value is a DOLFINx function, and no number."""
    return isinstance(value, fem.Function)


def parameters_on(mesh: Mesh, name: str) -> Callable[[Any], Any]:
    """Function that turns numbers, arrays or cell fields into UFL coefficients on a mesh.

    It raises a ModelError for a field that belongs to the mesh of another body.
    """

    def parameter(value: Any) -> Any:
        if not is_field(value):
            return fem.Constant(mesh, np.array(value, dtype=PETSc.ScalarType, order="C"))
        if value.function_space.mesh is not mesh:
            raise ModelError(f"a cell field of {name!r} was made for the mesh of another body")
        return value

    return parameter


def check_cells(
    message: str, condition: Callable[..., npt.NDArray[np.bool_]], **values: Any
) -> None:
    """Check numbers, or fields in all cells.

    Args:
        message: Start of the message for values that do not fulfil the condition; {name} stands
            for the value of that name.
        condition: Function of the values that returns whether they are valid.
        values: Numbers or cell fields, in the order of the arguments of ``condition``.
    """
    arrays = [_take_numbers(name, value) for name, value in values.items()]
    comms = [value.function_space.mesh.comm for value in values.values() if is_field(value)]
    holds = bool(np.all(condition(*arrays)))
    if comms:
        holds = comms[0].allreduce(holds, op=MPI.LAND)
    if not holds:
        texts = {name: _describe_values(value) for name, value in values.items()}
        raise ModelError(message.format(**texts))


def map_cells(function: Callable[..., Array], *values: Scalar) -> list[fem.Function]:
    """A function of numbers, or of cell fields cell by cell.

    Args:
        function: Takes numbers and returns an array of shape (m,).
        values: Numbers or cell fields, at least one of them a field.

    Returns:
        A cell field for each of the m results.
    """
    mesh = next(value.function_space.mesh for value in values if is_field(value))
    table = np.column_stack(np.broadcast_arrays(*(_take_numbers("value", v) for v in values)))
    distinct, inverse = np.unique(table, axis=0, return_inverse=True)
    results, error = np.zeros((0, 0)), None
    try:
        results = np.array([function(*row) for row in distinct])
    except Exception as problem:  # the other ranks must hear of it
        error = problem
    raise_together(mesh.comm, error)
    n = mesh.topology.index_map(mesh.topology.dim).size_local
    width = mesh.comm.allreduce(results.shape[-1] if n else 0, op=MPI.MAX)
    per_cell = results[inverse.ravel()] if n else np.zeros((0, width))
    return [cell_field(mesh, per_cell[:, k]) for k in range(width)]


def _take_numbers(name: str, value: Any) -> Array:
    """The number, or the values in the cells of this rank."""
    words = name.replace("_", " ")
    if is_field(value):
        space = value.function_space
        dofs = _compat.dofs_of_cells(space)
        if value.ufl_shape != () or dofs.shape[1] != 1:
            raise ModelError(f"{words} must be constant in each cell, as cell_field() makes it")
        owned = space.mesh.topology.index_map(space.mesh.topology.dim).size_local
        return np.asarray(value.x.array[dofs[:owned, 0]])
    try:
        number = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        number = np.full(1, np.nan)
    if number.shape != ():
        got = f"an array of shape {np.shape(value)}" if np.shape(value) else repr(value)
        raise ModelError(
            f"{words} must be a number, or a field made by cell_field(mesh, values), got {got}"
        )
    return number


def _describe_values(value: Any) -> str:
    """A number, or the range of a field, for messages. Collective for fields."""
    if not is_field(value):
        return f"{value:g}"
    comm, x = value.function_space.mesh.comm, value.x.array
    least = comm.allreduce(float(np.min(x, initial=np.inf)), op=MPI.MIN)
    largest = comm.allreduce(float(np.max(x, initial=-np.inf)), op=MPI.MAX)
    return f"{least:g} to {largest:g}"
