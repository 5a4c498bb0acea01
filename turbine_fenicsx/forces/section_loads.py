"""Forces and moments on the sections of a slender flexible body, from whatever knows them.

A `LineLoad` sees how each section moves and answers with a force and a moment: aerodynamics, an
actuator, measured loads. It knows nothing of meshes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.argument_checks import (
    check_array,
    check_directions,
    check_methods,
    check_vectors,
)
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array


class SectionMotion(NamedTuple):
    """How n sections move; in an energy-momentum step, in its middle.

    Attributes:
        position: Centres, weighted by the surface around each station, shape (n, 3) [m].
        axes: Rotation of each section from the initial configuration, shape (n, 3, 3).
        velocity: Velocities of the centres, shape (n, 3) [m/s].
        angular_velocity: Shape (n, 3) [rad/s].
        initial: Centres in the initial configuration, shape (n, 3) [m].
    """

    position: Array
    axes: Array
    velocity: Array
    angular_velocity: Array
    initial: Array


@runtime_checkable
class LineLoad(Protocol):
    """Loads on the sections of a body. All ranks call it with the same numbers."""

    def start_step(self, times: StepTimes) -> None:
        """A step, or another attempt at one, begins; at rest its length is infinite."""

    def loads(self, motion: SectionMotion, time: float) -> tuple[Array, Array]:
        """Loads, as a function of motion and time that changes nothing.

        Args:
            motion: How the sections move.
            time: Time [s].

        Returns:
            Forces [N] on the centres of the sections and moments [N m] about these, each of shape
            (n, 3).
        """

    def accept(self, motion: SectionMotion, times: StepTimes) -> None:
        """A step was accepted, with this motion in its middle: wakes and the like move on."""

    def save(self) -> RestartData:
        """State that later loads depend on, apart from the motion."""

    def restore(self, data: RestartData) -> None:
        """Restore saved loads; without any, start from scratch."""


@runtime_checkable
class SlopedLoad(LineLoad, Protocol):
    """Loads that know their derivatives, which are else found by differences."""

    def find_slopes(self, motion: SectionMotion, times: StepTimes) -> Array:
        """Derivatives by an increment of a step, nearly: Newton's method alone takes them.

        An increment moves a section by its half in the middle of the step, where loads act, and
        changes its velocities there by itself over dt.

        Args:
            motion: How the sections move in the middle of the step.

        Returns:
            Derivatives of force and moment on each section by its translation and rotation, shape
            (n, 6, 6). Loads on other sections are left out.
        """


@dataclass(frozen=True, eq=False)
class StationLine:
    """Stations along a slender part of a body.

    Args:
        facets: Facets of its skin, indices local to this rank (ghosts allowed).
        origin: A point of the axis in the initial configuration [m], shape (3,).
        axis: Its direction.
        stations: Distances along the axis from the origin, rising, shape (n,) [m].
        copy: Number of the copy of a reduced body whose skin it is, see `ReducedBody`; the facets
            are those of its mesh, origin and axis count where the copy stands.
    """

    facets: npt.NDArray[np.int32]
    _: KW_ONLY
    origin: npt.ArrayLike
    axis: npt.ArrayLike
    stations: npt.ArrayLike
    copy: int = 0

    @property
    def size(self) -> int:
        """Number of stations."""
        return np.size(self.stations)

    def distances(self, points: Array) -> Array:
        """Distances of points along the axis [m], shape (m,) for points of shape (m, 3)."""
        axis = np.asarray(self.axis, dtype=float)
        found: Array = (points - np.asarray(self.origin, dtype=float)) @ axis
        return found / np.linalg.norm(axis)


@dataclass(frozen=True, eq=False)
class SectionLoads:
    """Loads on stations along the skin of a flexible body.

    Each point of the skin belongs to the two stations beside it, in parts that are linear along the
    axis; beyond the ends, to the first or last alone. The sections move as the skin around them
    does in the mean, by weighted least squares, and the forces on the skin are the transpose of
    that. Their resultants, moments and power are those of the loads to round-off.

    Args:
        name: Name under which their work is reported.
        flexible: The body.
        lines: Where the stations are; the source counts them line after line.
        source: What knows the loads.

    Raises:
        ModelError: for stations that do not rise, an axis without a direction, or a copy that the
            body does not have.
        TypeError: if the source is not a `LineLoad`.
    """

    name: str
    flexible: DeformableBody
    lines: Sequence[StationLine]
    source: LineLoad

    def __post_init__(self) -> None:
        what = f"stations of {self.name!r}"
        for line in self.lines:
            check_vectors(self.name, origin=line.origin)
            check_directions(self.name, axis=line.axis)
            values = check_array(what, line.stations, (line.size,), "a list of numbers")
            if line.size < 1 or not np.all(np.diff(values) > 0.0):
                raise ModelError(
                    f"{what} must be one or more rising distances, got {line.stations!r}"
                )
            copies = len(self.flexible.placements)
            if isinstance(line.copy, bool) or line.copy not in range(copies):
                raise ModelError(
                    f"copy of {self.name!r} must be one of the {copies} copies of "
                    f"{self.flexible.name!r}, counted from 0, got {line.copy!r}"
                )
        if not self.lines:
            raise ModelError(f"{self.name!r} needs a line of stations or more")
        methods = ("start_step", "loads", "accept", "save", "restore")
        check_methods(f"source of {self.name!r}", self.source, methods)
