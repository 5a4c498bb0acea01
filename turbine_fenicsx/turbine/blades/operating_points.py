"""Operating points of a turbine as load paths of its blade: air, centrifugal force and weight.

The air is that of blade-element momentum theory at a steady wind speed. With the centrifugal force
of the rotor's speed it grows until t = 1 s; then the weight turns around the blade. Axes of the
blade are those of its mesh: along the span from the rotor centre, to the leading edge, to the
suction side.

Loads act on the skin as in a run, so that thin walls are bent by them as they are there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.forces.body_force import BodyForce
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.section_loads import SectionLoads, SectionMotion
from turbine_fenicsx.forces.time_functions import Ramp, Table
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.reduction.load_path import LoadPath
from turbine_fenicsx.system.find_stations import find_stations
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.wind.aero_blade import AeroBlade
from turbine_fenicsx.wind.rotor import (
    Operation,
    Rotor,
    find_performance,
    find_pitch,
    find_section_loads,
)

SUBDIVISIONS = 20
"""Number of intervals between two stations in which loads are summed up."""


@dataclass(eq=False)
class GrowingAir:
    """A `LineLoad` on stations: line loads, shared out between the two stations beside them.

    Args:
        stations: Distances of the stations along the span, shape (n,) [m].
        along: Distances at which the loads are known, rising, shape (m,) [m].
        places: Where they act, shape (m, 3) [m].
        forces: Forces for each length, shape (m, 3) [N/m].
        moments: Moments for each length about the places, shape (m, 3) [N].
        function: Factor as a function of time [s].
    """

    stations: Array
    along: Array
    places: Array
    forces: Array
    moments: Array
    function: Callable[[float], float]
    _summed: tuple[Array, Array] | None = field(default=None, init=False)

    def start_step(self, times: StepTimes) -> None:
        """Nothing changes with steps."""

    def loads(self, motion: SectionMotion, time: float) -> tuple[Array, Array]:
        """The loads at a time; see `LineLoad.loads`."""
        if self._summed is None:
            self._summed = self._sum_up(motion.initial)
        factor = self.function(time)
        return factor * self._summed[0], factor * self._summed[1]

    def accept(self, motion: SectionMotion, times: StepTimes) -> None:
        """Nothing moves on."""

    def save(self) -> RestartData:
        """Nothing is kept."""
        return RestartData()

    def restore(self, data: RestartData) -> None:
        """Nothing was kept."""

    def _sum_up(self, centres: Array) -> tuple[Array, Array]:
        """Forces on the stations, and moments about their centres."""
        s, ends = self.stations, self.along[[0, -1]]
        knots = np.concatenate([[ends[0]], s[(s > ends[0]) & (s < ends[1])], [ends[1]]])
        part = (np.arange(SUBDIVISIONS) + 0.5) / SUBDIVISIONS
        middles = (knots[:-1, None] + np.diff(knots)[:, None] * part).ravel()
        lengths = np.repeat(np.diff(knots) / SUBDIVISIONS, SUBDIVISIONS)
        x, f, m = (self._interpolate(y, middles) for y in (self.places, self.forces, self.moments))
        # hat functions of the stations, constant beyond the ends
        hats = np.array([np.interp(middles, s, e) for e in np.eye(len(s))]) * lengths
        F = hats @ f
        return F, hats @ (m + np.cross(x, f)) - np.cross(centres, F)

    def _interpolate(self, values: Array, places: Array) -> Array:
        """Values at distances along the span, shape (k, 3)."""
        return np.stack([np.interp(places, self.along, column) for column in values.T], axis=1)


GRAVITY = 9.81
STEEPEST = np.radians(30.0)
"""Largest pitch [rad]."""

MAX_STATIONS = 60
"""Maximum number of stations on which the air acts."""

EFFICIENCY = 0.95
"""Electrical power over that of the rotor."""


@dataclass(frozen=True)
class RatedOperation:
    """How a turbine is run in steady wind.

    Args:
        least_speed: Smallest speed of the rotor [rad/s].
        rated_speed: Rated speed [rad/s].
        rated_power: Rated electrical power [W].
        tip_speed_ratio: The best one below rated speed [-].
        fine_pitch: Pitch below rated power [rad].
    """

    least_speed: float
    rated_speed: float
    rated_power: float
    tip_speed_ratio: float
    fine_pitch: float = 0.0

    def find_speed(self, rotor: Rotor, wind: float) -> tuple[float, bool]:
        """Speed of the rotor in a wind [rad/s], and whether it has the best tip-speed ratio."""
        best = self.tip_speed_ratio * wind / rotor.tip_distance
        speed = float(np.clip(best, self.least_speed, self.rated_speed))
        return speed, speed == best

    def find(self, rotor: Rotor, wind: float, shear: float = 0.0) -> Operation:
        """Speed and pitch of a rotor in a wind.

        Args:
            rotor: The rotor.
            wind: Wind speed [m/s].
            shear: Exponent of the wind over height.
        """
        speed, _ = self.find_speed(rotor, wind)
        operation = Operation(wind, speed, self.fine_pitch, shear=shear)
        power = self.rated_power / EFFICIENCY
        if find_performance(rotor, operation, 1).power <= power:
            return operation
        steepest = max(STEEPEST, self.fine_pitch + STEEPEST)
        pitch = find_pitch(rotor, operation, power, (self.fine_pitch, steepest), accuracy=1e-4)
        return Operation(wind, speed, pitch, shear=shear)


@dataclass(frozen=True)
class OperatingPoint:
    """An operating point.

    Args:
        wind: Wind speed [m/s].
        air: Factor of the loads of the air.
        azimuths: Where the weight acts, one after the other [deg].
        shear: Exponent of the wind over height.
    """

    wind: float
    air: float = 1.0
    azimuths: tuple[float, ...] = (0.0, 90.0, 180.0, 270.0)
    shear: float = 0.0

    def __str__(self) -> str:
        """Its name."""
        factor = "" if self.air == 1.0 else f", {self.air:g} times its loads"
        return f"wind of {self.wind:g} m/s{factor}"


TRAINING = (
    *(
        OperatingPoint(wind, air)
        for wind in (6.0, 10.0, 15.0, 25.0)
        for air in (1.0, 1.5)
        if wind * air != 9.0
    ),
    OperatingPoint(10.0, -0.6),
)
"""Points that a basis is made of; in the last one blades bend upwind, as in a stop."""

UNSEEN = (
    OperatingPoint(8.0, azimuths=(45.0,)),
    OperatingPoint(11.5, azimuths=(135.0,)),
    OperatingPoint(20.0, azimuths=(225.0,), shear=0.2),
    OperatingPoint(10.5, 1.4, azimuths=(315.0,)),
    OperatingPoint(13.0, 0.4, azimuths=(60.0,)),
)
"""Others, which a basis is judged by."""


class OperatingLoads:
    """Makes load paths of a blade at operating points.

    Args:
        system: A system with the blade alone, held at its root.
        body: The blade, on a mesh in its own axes from the rotor centre.
        skin: Facets of its skin, on which the air acts, indices local to this rank.
        blade: Its aerodynamics.
        rated: How the turbine is run.

    Note:
        Collective.
    """

    def __init__(
        self,
        system: MultibodySystem,
        body: FlexibleBody,
        skin: npt.NDArray[np.int32],
        blade: AeroBlade,
        rated: RatedOperation,
    ) -> None:
        self._body, self._blade, self._rated = body, blade, rated
        index = system.flexible_bodies.index(body)
        self._line = find_stations(system.flexible_models[index].full, skin, MAX_STATIONS)

    @cached_property
    def rotor(self) -> Rotor:
        """The rotor of such blades, without cone and tilt."""
        return Rotor(self._blade)

    def find_operation(self, point: OperatingPoint) -> Operation:
        """Speed and pitch of the rotor at an operating point."""
        return self._rated.find(self.rotor, point.wind, point.shear)

    def list_paths(self, points: Sequence[OperatingPoint]) -> list[LoadPath]:
        """Load paths of some operating points."""
        return [self.make_path(point) for point in points]

    def make_path(self, point: OperatingPoint) -> LoadPath:
        """The load path of an operating point: air and rotation grow, then the weight turns."""
        operation, grow = self.find_operation(point), Ramp(1.0, 1.0)
        s, c = np.sin(operation.pitch), np.cos(operation.pitch)
        normal, way = np.array([0.0, -s, c]), np.array([0.0, c, s])
        outwards = operation.rotor_speed**2 * (np.eye(3) - np.outer(normal, normal))
        forces = [
            SectionLoads(
                "air", self._body, [self._line], self._blow(point, operation, normal, way, grow)
            ),
            BodyForce("centrifugal", self._body, field=lambda X: X @ outwards, function=grow),
        ]
        times = 2.0 + np.arange(len(point.azimuths))
        for name, g, wave in (
            ("span", np.array([-1.0, 0.0, 0.0]), np.cos),
            ("way", way, np.sin),
        ):
            values = np.concatenate([[0.0], wave(np.radians(point.azimuths))])
            table = Table(tuple(np.concatenate([[1.0], times])), tuple(values))
            field = _make_constant(GRAVITY * g)
            forces.append(BodyForce(f"weight, {name}", self._body, field=field, function=table))
        return LoadPath(str(point), forces, (0.5, 1.0, *times))

    def _blow(
        self,
        point: OperatingPoint,
        operation: Operation,
        normal: Array,
        way: Array,
        grow: Callable[[float], float],
    ) -> GrowingAir:
        """The air at an operating point."""
        blade = self._blade
        loads = find_section_loads(self.rotor, operation, np.zeros(1))
        f = loads.normal[0][:, None] * normal + loads.tangential[0][:, None] * way
        chord = np.column_stack([0.0 * blade.twist, np.cos(blade.twist), -np.sin(blade.twist)])
        lever = (np.asarray(blade.reference) - blade.aerodynamic_centre) * blade.chord
        at = chord * lever[:, None]
        at[:, 0] += blade.radius
        if blade.prebend is not None:
            at[:, 2] += blade.prebend
        moment = loads.moment[0][:, None] * np.array([1.0, 0.0, 0.0])
        stations = np.asarray(self._line.stations, dtype=float)
        blown = point.air * f, point.air * moment
        return GrowingAir(stations, blade.radius, at, *blown, grow)


def _make_constant(vector: Array) -> Callable[[Array], Array]:
    """A field with the same vector at all points."""
    return lambda X: np.broadcast_to(vector, X.shape)
