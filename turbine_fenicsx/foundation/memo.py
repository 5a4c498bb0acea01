"""The value of a function at the arguments seen last."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar

import numpy as np

Value = TypeVar("Value")


class Memo(Generic[Value]):
    """A function that is not evaluated again for the arguments of the last call.

    Args:
        function: The function. Its arguments are distinguished bit for bit if they are arrays,
            which is faster for small ones than `numpy.array_equal`, else by identity.
    """

    def __init__(self, function: Callable[..., Value]) -> None:
        self._function = function
        self._key: list[Any] = []
        self._value: Value | None = None
        self._objects: tuple[Any, ...] = ()  # kept, so that no other object has their identity

    def __call__(self, *arguments: Any) -> Value:
        """The value."""
        key = [x.tobytes() if isinstance(x, np.ndarray) else id(x) for x in arguments]
        if self._value is None or key != self._key:
            self._value = self._function(*arguments)
            self._key = key
            self._objects = tuple(x for x in arguments if not isinstance(x, np.ndarray))
        return self._value
