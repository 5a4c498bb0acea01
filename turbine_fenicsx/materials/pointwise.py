"""UFL expressions as NumPy arrays, in the middle of some cells and without a compiler.

An expression is written out in scalars, which takes milliseconds for a law. Then each of its nodes
is evaluated once for all values of the coefficients.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from scipy.special import erf
from ufl.algorithms import expand_derivatives
from ufl.algorithms.expand_indices import expand_indices
from ufl.core.expr import Expr
from ufl.corealg.map_dag import map_expr_dag
from ufl.corealg.multifunction import MultiFunction
from ufl.corealg.traversal import unique_post_traversal

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.types import Array, IntArray

_RULES: dict[str, Callable[..., Any]] = {
    "Sum": np.add,
    "Product": np.multiply,
    "Division": np.divide,
    "Power": np.power,
    "Abs": np.abs,
    "Sign": np.sign,
    "Sqrt": np.sqrt,
    "Exp": np.exp,
    "Ln": np.log,
    "Erf": erf,
    **{name.capitalize(): getattr(np, name) for name in ("sin", "cos", "tan")},
    **{name.capitalize(): getattr(np, name) for name in ("sinh", "cosh", "tanh")},
    **{f"A{name}": getattr(np, f"arc{name}") for name in ("sin", "cos", "tan")},
    "Atan2": np.arctan2,
    "MinValue": np.minimum,
    "MaxValue": np.maximum,
    "Conditional": np.where,
    "LT": np.less,
    "LE": np.less_equal,
    "GT": np.greater,
    "GE": np.greater_equal,
    "EQ": np.equal,
    "NE": np.not_equal,
    "AndCondition": np.logical_and,
    "OrCondition": np.logical_or,
    "NotCondition": np.logical_not,
    "Conj": np.conj,
    "Real": np.real,
}
"""NumPy's functions for the operators of UFL by their names."""


class _WithoutVariables(MultiFunction):  # type: ignore[misc]
    """Expressions in place of their variables, which `expand_indices` takes for scalars."""

    expr = MultiFunction.reuse_if_untouched

    def variable(self, _: Any, expression: Any, label: Any) -> Any:
        """The expression itself."""
        return expression


class UnknownExpression(Exception):
    """An operator or a terminal that has no value here, such as a gradient."""


def write_out(expression: Expr) -> Expr:
    """A scalar expression in terms of the entries of its terminals."""
    return expand_indices(map_expr_dag(_WithoutVariables(), expand_derivatives(expression)))


class CellPoints:
    """The same point of some cells, where expressions are evaluated.

    Args:
        cells: Local cells, shape (n,).
        point: The point of the reference cell, shape (3,); its middle if None.

    Attributes:
        points: The points in space, shape (n, 3) [m].
        jacobians: Derivatives of the points with respect to that of the reference cell, shape
            (n, 3, 3).
    """

    def __init__(self, mesh: Any, cells: IntArray, point: Array | None = None) -> None:
        self._cells = np.asarray(cells, dtype=np.int32)
        kind, nodes = _compat.cell_name(mesh), _compat.nodes_of_cells(mesh)[self._cells]
        middle = np.full(3, 0.5 if kind == "hexahedron" else 0.25)
        at = (middle if point is None else point)[None]
        shapes = (_compat.shape_functions(kind, degree, at) for degree in (1, 2))
        self._shapes = {len(N[0]): (N[0], dN[0]) for N, dN in shapes}
        N, dN = self._shapes[nodes.shape[1]]
        X = mesh.geometry.x[nodes]
        self.points: Array = np.einsum("a,nai->ni", N, X)
        self.jacobians: Array = np.einsum("aj,nai->nij", dN, X)

    def evaluate(self, expressions: Sequence[Expr], given: Mapping[Any, Array]) -> Array:
        """Values of scalar expressions.

        Args:
            given: Values of constants that count instead of those they have, shape (samples, ...)
                each.

        Returns:
            Shape (cells, samples, expressions).
        """
        found = []
        known: dict[Any, Any] = {}
        for scalar in expressions:
            for node in unique_post_traversal(scalar):
                if node not in known:
                    known[node] = self._evaluate(node, known, given)
            found.append(known[scalar])
        with_samples = np.zeros((len(self._cells), max(map(len, given.values()), default=1), 1))
        values = [np.asarray(x, dtype=float)[..., None] + with_samples for x in found]
        return np.concatenate(values, axis=-1)

    def _evaluate(self, node: Any, known: Mapping[Any, Any], given: Mapping[Any, Array]) -> Any:
        """Value of a node, an array of shape (cells or 1, samples or 1, ...)."""
        name = type(node).__name__
        if name in _RULES:
            with np.errstate(all="ignore"):
                return _RULES[name](*(known[x] for x in node.ufl_operands))
        if name == "Indexed":
            tensor, index = node.ufl_operands
            return known[tensor][(..., *(int(i) for i in index))]
        if name in ("MultiIndex", "Label"):
            return None
        return self._find_terminal(node, given)

    def _find_terminal(self, node: Any, given: Mapping[Any, Array]) -> Any:
        """Value of a terminal."""
        name = type(node).__name__
        if node in given:
            return given[node][None]
        if isinstance(node, fem.Constant):
            return np.asarray(node.value, dtype=float)[None, None]
        if isinstance(node, fem.Function):
            return self._interpolate(node)[:, None]
        if isinstance(node, ufl.classes.Zero):
            return np.zeros((1, 1, *node.ufl_shape))
        if isinstance(node, ufl.classes.ScalarValue):
            return np.full((1, 1), float(node))
        if name == "Identity":
            return np.eye(3)[None, None]
        if name == "SpatialCoordinate":
            return self.points[:, None]
        if name == "Jacobian":
            return self.jacobians[:, None]
        raise UnknownExpression(name)

    def _interpolate(self, field: fem.Function) -> Array:
        """Values of a field of cells or of Lagrange's functions, shape (cells, ...)."""
        dofs = _compat.dofs_of_cells(field.function_space)[self._cells]
        if dofs.shape[1] != 1 and dofs.shape[1] not in self._shapes:
            raise UnknownExpression(f"a field with {dofs.shape[1]} values in a cell")
        values = field.x.array.reshape(-1, field.function_space.dofmap.bs)[dofs]
        N = self._shapes[dofs.shape[1]][0] if dofs.shape[1] > 1 else np.ones(1)
        found: Array = np.einsum("a,nai->ni", N, values)
        return found.reshape(len(dofs), *field.ufl_shape)
