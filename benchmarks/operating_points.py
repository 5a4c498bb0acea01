"""Operating points of a turbine as load paths of its blade: air, centrifugal force and weight.

The air is that of blade-element momentum theory at a steady wind speed. With the centrifugal force
of the rotor's speed it grows until t = 1 s; then the weight turns around the blade. Axes of the
blade are those of its mesh: along the span, to the leading edge, to the suction side.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from turbine_fenicsx import BodyForce, LoadPath, Ramp, Table
from turbine_fenicsx.reduction.smooth_loads import LineLoads
from turbine_fenicsx.reduction.static_body import StaticBody
from turbine_fenicsx.wind.rotor import (
    Operation,
    Rotor,
    find_performance,
    find_pitch,
    find_section_loads,
)
from turbine_fenicsx.wind.windio_blade import make_aero_blade

GRAVITY = 9.81
STEEPEST = np.radians(30.0)


@dataclass(frozen=True)
class Point:
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

    def __str__(self):
        """Its name."""
        return f"{self.wind:g} m/s, {self.air:g} of the air"


TRAINING = tuple(
    Point(wind, air) for wind in (6.0, 10.0, 15.0, 25.0) for air in (1.0, 1.5) if wind * air != 9.0
)
UNSEEN = (
    Point(8.0, azimuths=(45.0,)),
    Point(11.5, azimuths=(135.0,)),
    Point(20.0, azimuths=(225.0,), shear=0.2),
    Point(10.5, 1.4, azimuths=(315.0,)),
    Point(13.0, 0.4, azimuths=(60.0,)),
)
LAST = (
    Point(7.0, 1.2, azimuths=(30.0,)),
    Point(9.5, azimuths=(120.0,)),
    Point(12.0, 1.3, azimuths=(210.0,)),
    Point(17.0, 0.7, azimuths=(300.0,)),
    Point(22.0, 1.2, azimuths=(75.0,)),
)
"""Looked at only after all choices had been made."""


class Operations:
    """Makes load paths for a blade of a windIO file.

    Args:
        solid: The clamped blade.
        turbine: The file.
    """

    def __init__(self, solid, turbine):
        self._turbine, self._body = turbine, solid.body
        still = StaticBody(solid.system(), solid.body, solid.body)
        self.lines = LineLoads(still)
        self._root = still.gather(still.model.positions)[:, 0].min()
        still.destroy()

    @cached_property
    def _rotor(self):
        hub = self._turbine.hub.radius
        tip = hub + self.lines.axis.length
        radius = np.linspace(hub + 0.005 * tip, 0.995 * tip, 60)
        return Rotor(make_aero_blade(self._turbine, radius))

    def run(self, point):
        """How the rotor runs."""
        control, rotor = self._turbine.control, self._rotor
        best = control.tip_speed_ratio * point.wind / rotor.tip_distance
        speed = float(np.clip(best, control.least_speed, control.rated_speed))
        fine = control.fine_pitch or 0.0
        operation = Operation(point.wind, speed, fine, shear=point.shear)
        power = control.rated_power / 0.95
        if find_performance(rotor, operation, 1).power <= power:
            return operation
        pitch = find_pitch(rotor, operation, power, (fine, STEEPEST), accuracy=1e-4)
        return Operation(point.wind, speed, pitch, shear=point.shear)

    def path(self, point):
        """Its load path."""
        operation, grow = self.run(point), Ramp(1.0, 1.0)
        s, c = np.sin(operation.pitch), np.cos(operation.pitch)
        normal, way = np.array([0.0, -s, c]), np.array([0.0, c, s])
        centrifugal = np.diag([1.0, 1.0, 1.0]) - np.outer(normal, normal)
        origin = np.array([self._root - self._turbine.hub.radius, 0.0, 0.0])

        def turn(X):
            return operation.rotor_speed**2 * (X - origin) @ centrifugal

        air = self._blow(point, operation, normal, way)
        forces = [
            BodyForce("air", self._body, field=air, function=grow),
            BodyForce("centrifugal", self._body, field=turn, function=grow),
        ]
        times = 2.0 + np.arange(len(point.azimuths))
        for name, g, wave in (
            ("span", np.array([-1.0, 0.0, 0.0]), np.cos),
            ("way", way, np.sin),
        ):
            values = np.concatenate([[0.0], wave(np.radians(point.azimuths))])
            table = Table(tuple(np.concatenate([[1.0], times])), tuple(values))
            forces.append(
                BodyForce(
                    f"weight, {name}",
                    self._body,
                    field=lambda X, g=g: np.broadcast_to(GRAVITY * g, X.shape),
                    function=table,
                )
            )
        return LoadPath(str(point), forces, (0.5, 1.0, *times))

    def _blow(self, point, operation, normal, way):
        """The field of the air."""
        blade, lines = self._rotor.blade, self.lines
        loads = find_section_loads(self._rotor, operation, np.zeros(1))
        f = loads.normal[0][:, None] * normal + loads.tangential[0][:, None] * way
        chord = np.column_stack([0.0 * blade.twist, np.cos(blade.twist), -np.sin(blade.twist)])
        lever = (np.asarray(blade.reference) - blade.aerodynamic_centre) * blade.chord
        at = chord * lever[:, None]
        at[:, 0] += blade.radius - self._turbine.hub.radius + self._root
        if blade.prebend is not None:
            at[:, 2] += blade.prebend
        along = lines.axis.axes[:, 2]
        moment = loads.moment[0] * along[0] + np.cross(lines.axis.arms(at), f) @ along
        place = lines.axis.span(at)

        def profile(values):
            return lambda s: point.air * np.interp(s, place, values)

        parts = [lines.field(profile(f[:, k]), np.eye(3)[k], 0.0) for k in range(3)]
        parts.append(lines.field(profile(moment), np.zeros(3), 1.0))
        return lambda X: sum(part(X) for part in parts)
