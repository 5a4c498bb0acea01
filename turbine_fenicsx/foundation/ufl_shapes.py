"""Shapes of UFL expressions that users return."""

from __future__ import annotations

from typing import Any

import ufl

from turbine_fenicsx.foundation.errors import ModelError

_WORDS = {(): "a scalar", (3,): "a vector of shape (3,)", (3, 3): "a tensor of shape (3, 3)"}


def check_ufl_shape(what: str, found: Any, shape: tuple[int, ...]) -> Any:
    """An expression, or a number, of a given shape: that of a scalar, a vector or a tensor."""
    expression = ufl.as_ufl(found)
    if expression.ufl_shape != shape:
        raise ModelError(
            f"{what} must return {_WORDS[shape]}, got one of shape {expression.ufl_shape}"
        )
    return expression
