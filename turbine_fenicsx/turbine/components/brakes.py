"""Prescribed motions of joint coordinates that keep them where they are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from turbine_fenicsx.joints.prescribed_motion import PrescribedMotion
from turbine_fenicsx.turbine.components.component import Assembly, Component


@dataclass(frozen=True)
class Brakes(Component):
    """Joint coordinates that keep a value.

    Args:
        values: The value of each coordinate by its name, such as ``"yaw"``, as a function of
            nothing that may change between equilibria [rad or m].
    """

    values: Mapping[str, Callable[[], float]]

    def parts(self, assembly: Assembly) -> list[Any]:
        """A prescribed motion for each coordinate that none has already."""
        driven = {p.coordinate for p in assembly.parts if isinstance(p, PrescribedMotion)}
        free = {name: value for name, value in self.values.items() if name not in driven}
        return [PrescribedMotion(name, partial(_keep, value)) for name, value in free.items()]


def _keep(value: Callable[[], float], _: float) -> float:
    """The value at any time."""
    return value()
