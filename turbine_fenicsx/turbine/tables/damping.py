"""Structural damping of blades and tower: ratios of named modes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import hypot, pi
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from turbine_fenicsx.case.quantities import AngularSpeed, Seconds, Unit, to_si
from turbine_fenicsx.case.rules import Beside, Only, With
from turbine_fenicsx.case.schema import Also
from turbine_fenicsx.case.section import NotNegative, Section
from turbine_fenicsx.foundation.plausible import Plausible
from turbine_fenicsx.foundation.text_files import quote

MAX_RATIO = 0.3
"""Largest damping ratio of a mode: beyond, it is a mistake of the unit."""

MAX_SPEED = 20.0 * pi
"""Largest speed of a rotor at which blades are damped, 600 rpm [rad/s]."""

DEFAULT_MODES = {"blade": ("flap_1", "edge_1"), "tower": ("fore_aft_1", "fore_aft_2")}
"""Modes for which a single ratio counts, by table."""

_WITH_RATIOS = Beside("stiffness_time"), With("flap_1", "edge_1", "flap_2", "edge_2")

_OF_BEAMS = Only("blade.model", "beam")

Time = Annotated[Seconds, NotNegative, Plausible(1e-6, 1.0)]

MAX_NAMED = 2
"""Number of modes that stiffness and mass together can meet."""


def to_ratio(value: Any) -> float:
    """A damping ratio, a part of the critical damping.

    Args:
        value: A number, ``"0.5 %"``, or a logarithmic decrement: ``"3 % logdec"``.

    Raises:
        ValueError: if it is none, or out of range.
    """
    text = value.strip() if isinstance(value, str) else value
    try:
        decrement = isinstance(text, str) and text.endswith("logdec")
        if decrement:
            text = text.removesuffix("logdec").strip()
        hundredth = isinstance(text, str) and text.endswith("%")
        if hundredth:
            text = text.removesuffix("%").strip()
        ratio = to_si(text, "") * (0.01 if hundredth else 1.0)
        if decrement:
            ratio /= hypot(2.0 * pi, ratio)
    except ValueError:
        ratio = -1.0
    if not 0.0 <= ratio <= MAX_RATIO:
        raise ValueError(
            f'expected a damping ratio from 0 to {MAX_RATIO:g}, for example "0.5 %" or "3 % logdec"'
        )
    return ratio


Ratio = Annotated[float, BeforeValidator(to_ratio), Unit("")]


class DampingCase(Section):
    """Common keys of the damping of blades and tower."""

    stiffness_time: Annotated[Seconds | None, NotNegative, Plausible(1e-6, 1.0)] = None
    """Factor of the stiffness in the damping matrix, in place of ratios: ``mu`` of windIO and
    BeamDyn."""

    @property
    def ratios(self) -> dict[str, float]:
        """Ratios of the named modes."""
        values = {name: getattr(self, name) for name in type(self).model_fields}
        skip = {"stiffness_time", "mu", "speed"}
        return {name: x for name, x in values.items() if name not in skip and x is not None}

    @property
    def may_not_fit(self) -> bool:
        """Whether there are two ratios that stiffness and mass can perhaps not meet together."""
        return len(set(self.ratios.values())) > 1

    @property
    def acts(self) -> bool:
        """Whether something is damped."""
        return bool(self.stiffness_time) or any(self.ratios.values())

    def describe(self) -> str:
        """The damping in words; empty if there is none."""
        if self.stiffness_time:
            return f"in proportion to the stiffness, {self.stiffness_time:g} s"
        if not self.acts:
            return ""
        ratios = self.ratios
        if self.may_not_fit:
            return ", ".join(f"{100.0 * x:.3g} % of {name}" for name, x in ratios.items())
        others = ", others in proportion to their frequencies" if len(ratios) == 1 else ""
        return f"{100.0 * max(ratios.values()):.3g} % of {' and '.join(ratios)}{others}"


class BladeDampingCase(DampingCase):
    """Damping ratios of one or two modes of a blade that is clamped at its root.

    Stiffness and mass dampen in such proportions that these modes have the ratios; others have
    more where their frequencies are higher. One value in place of the table counts for ``flap_1``
    and ``edge_1``.
    """

    flap_1: Ratio | None = None
    """Ratio of the first flapwise mode, or its logarithmic decrement: ``"3 % logdec"``."""
    flap_2: Ratio | None = None
    """Ratio of the second flapwise mode."""
    edge_1: Ratio | None = None
    """Ratio of the first edgewise mode."""
    edge_2: Ratio | None = None
    """Ratio of the second edgewise mode."""
    mu: Annotated[tuple[Time, Time, Time, Time, Time, Time] | None, _OF_BEAMS] = None
    """Factors of the stiffness in the damping matrix of beams by strain: shear along x and y,
    stretch, bending about x and y, torsion; ``mu`` of windIO and BeamDyn."""
    speed: Annotated[AngularSpeed, Field(ge=0.0, le=MAX_SPEED), *_WITH_RATIOS] = 0.0
    """Speed of the rotor at which the blade has these ratios; a rotor that turns is stiffer, and
    damped less."""

    def describe(self) -> str:
        """The damping in words, with the speed at which it holds."""
        if self.mu is not None and any(self.mu):
            return f"in proportion to the stiffness, {', '.join(f'{t:g}' for t in self.mu)} s"
        text = super().describe()
        at_speed = bool(text and self.ratios and self.speed)
        return f"{text}, at {self.speed * 30.0 / pi:.4g} rpm" if at_speed else text


class TowerDampingCase(DampingCase):
    """Damping ratios of one or two modes of the tower, which carries nacelle and rotor.

    As for blades; nacelle and rotor count as one rigid body. One value in place of the table counts
    for ``fore_aft_1`` and ``fore_aft_2``.
    """

    fore_aft_1: Ratio | None = None
    """Ratio of the first mode fore and aft."""
    fore_aft_2: Ratio | None = None
    """Ratio of the second mode fore and aft."""
    side_side_1: Ratio | None = None
    """Ratio of the first mode to the sides."""
    side_side_2: Ratio | None = None
    """Ratio of the second mode to the sides."""


def _spread(*names: str) -> Callable[[Any], Any]:
    """A function that makes a table with some modes of one ratio."""

    def make(value: Any) -> Any:
        if isinstance(value, Mapping | Section):
            return value
        return dict.fromkeys(names, to_ratio(value))

    return make


_RATIO = Also("number", "string")
BladeDamping = Annotated[
    BladeDampingCase, BeforeValidator(_spread(*DEFAULT_MODES["blade"])), _RATIO
]
TowerDamping = Annotated[
    TowerDampingCase, BeforeValidator(_spread(*DEFAULT_MODES["tower"])), _RATIO
]


def check_damping(key: str, damping: DampingCase) -> str:
    """A sentence if the ratios do not go together.

    Args:
        key: Of the table, for example "blade.damping".
        damping: The table.
    """
    named = list(damping.ratios)
    others = [*named, *(["stiffness_time"] if damping.stiffness_time is not None else [])]
    if getattr(damping, "mu", None) is not None and others:
        return f"{key}.mu: expected none beside {others[0]}"
    if named and damping.stiffness_time is not None:
        return f"{key}.stiffness_time = {damping.stiffness_time:g}: expected none beside {named[0]}"
    if len(named) > MAX_NAMED:
        return (
            f"{key}: expected ratios of at most {MAX_NAMED} modes, which stiffness and mass can "
            f"meet, got {quote(named)}"
        )
    return ""
