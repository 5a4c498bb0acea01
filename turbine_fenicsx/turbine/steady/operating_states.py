"""Speed of the rotor and pitch at a wind speed: from a table, or found."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from pathlib import Path
from typing import Protocol

import numpy as np

from turbine_fenicsx.control.rosco_input import read_rosco_input
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.records.steady_tables import WIND, read_steady
from turbine_fenicsx.turbine.blades.blade_basis import find_rated
from turbine_fenicsx.turbine.blades.operating_points import EFFICIENCY, STEEPEST, RatedOperation
from turbine_fenicsx.turbine.case.aero_blade import load_aero_blade
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.wind.rotor import Operation, Rotor, find_performance, find_pitch

RPM, DEGREE = pi / 30.0, pi / 180.0

COLUMNS = {WIND: 1.0, names.ROTOR_SPEED: RPM, names.PITCH: DEGREE}
"""Columns of a schedule, and factors to SI units."""

ROSCO = ".in"
"""End of the name of an input file of ROSCO."""

FROM_RATED = 0.99
"""Part of the largest power of a table from which on its wind is rated or above."""

SLOPE = -0.1 / DEGREE
"""Guess of the derivative of the power by the pitch, over the power [1/rad]."""

SECTORS = 12
"""Azimuths over which loads of stiff blades are averaged."""


@dataclass(frozen=True)
class OperatingState:
    """How a turbine is run in steady wind.

    Args:
        wind: Wind speed [m/s].
        rotor_speed: Of the rotor [rad/s].
        pitch: Of all blades [rad].
        least_pitch: The pitch if power had no limit [rad].
    """

    wind: float
    rotor_speed: float
    pitch: float
    least_pitch: float


class Schedule(Protocol):
    """Speed and pitch over the wind speed."""

    def find_power(self, wind: float) -> float | None:
        """Power of the air that the pitch keeps from above [W]; None where the pitch is given."""

    def at(self, wind: float) -> OperatingState:
        """The operating state of stiff blades at a wind speed; a ModelError if there is none."""

    def find_slope(self, operating: OperatingState) -> float:
        """Derivative of the power of stiff blades by the pitch [W/rad]."""


class TableSchedule:
    """A table of wind speeds, speeds and pitch angles, linear between its rows.

    Args:
        rows: One row per wind speed, which rises, shape (n, 3).
        name: Of the table, for errors.
        powers: Power of the air in each row [W], shape (n,), which the pitch keeps from rated wind
            on, whatever it is in the table; None for the pitch of the table everywhere.
    """

    def __init__(self, rows: Array, name: str, powers: Array | None = None) -> None:
        self._rows, self._name, self._powers = rows, name, powers

    def find_power(self, wind: float) -> float | None:
        """As `Schedule.find_power`."""
        if self._powers is None:
            return None
        power = float(np.interp(wind, self._rows[:, 0], self._powers))
        return power if power >= FROM_RATED * np.max(self._powers) else None

    def at(self, wind: float) -> OperatingState:
        """As `Schedule.at`."""
        V, *columns = self._rows.T
        slack = 1e-9 * V[-1]
        if not V[0] - slack <= wind <= V[-1] + slack:
            raise ModelError(f"{self._name} has no wind of {wind:g} m/s, but {V[0]:g} to {V[-1]:g}")
        speed, pitch = (float(np.interp(wind, V, x)) for x in columns)
        return OperatingState(wind, speed, pitch, pitch if self._powers is None else -0.5 * pi)

    def find_slope(self, operating: OperatingState) -> float:
        """As `Schedule.find_slope`; a guess."""
        return SLOPE * (self.find_power(operating.wind) or 0.0)


class FoundSchedule:
    """The best tip-speed ratio within limits of the speed, and rated power above.

    Where a limit of the speed keeps the best ratio away, the pitch above the fine one is that of
    the largest power.

    Args:
        rotor: The rotor of stiff blades.
        rated: How the turbine is run.
        power: Largest power of the air [W].
        shear: Exponent of the wind over height.
        density: Of the air [kg/m^3].
        least_pitch: Smallest pitch over the wind speed, which limits the thrust: rows of wind speed
            [m/s] and pitch [rad], shape (n, 2); found if there are none.
    """

    def __init__(
        self,
        rotor: Rotor,
        rated: RatedOperation,
        power: float,
        shear: float,
        density: float,
        least_pitch: Array,
    ) -> None:
        self._rotor, self._rated, self._power = rotor, rated, power
        self._air = {"shear": shear, "density": density}
        self._least_pitch = least_pitch

    def find_power(self, wind: float) -> float | None:
        """As `Schedule.find_power`."""
        return self._power

    def at(self, wind: float) -> OperatingState:
        """As `Schedule.at`."""
        rated, rotor = self._rated, self._rotor
        speed, is_best = rated.find_speed(rotor, wind)
        operation = Operation(wind, speed, rated.fine_pitch, **self._air)
        least = pitch = self._find_least_pitch(operation, is_best)
        if self._find_power(operation, pitch) > self._power:
            ends = pitch, pitch + STEEPEST
            pitch = find_pitch(rotor, operation, self._power, ends, SECTORS, accuracy=1e-5)
        return OperatingState(wind, speed, pitch, least)

    def _find_least_pitch(self, operation: Operation, is_best: bool) -> float:
        """The pitch if power had no limit [rad].

        Args:
            is_best: Whether the rotor has the best tip-speed ratio.
        """
        from scipy.optimize import minimize_scalar

        fine = self._rated.fine_pitch
        if len(self._least_pitch):
            return max(fine, float(np.interp(operation.wind_speed, *self._least_pitch.T)))
        if is_best:
            return fine
        found = minimize_scalar(
            lambda x: -self._find_power(operation, x),
            bounds=(fine, fine + 0.3 * STEEPEST),
            method="bounded",
        )
        return float(found.x) if -found.fun > self._find_power(operation, fine) else fine

    def find_slope(self, operating: OperatingState) -> float:
        """As `Schedule.find_slope`."""
        operation = Operation(operating.wind, operating.rotor_speed, **self._air)
        ends = (operating.pitch + x for x in (-0.5 * DEGREE, 0.5 * DEGREE))
        low, high = (self._find_power(operation, x) for x in ends)
        return (high - low) / DEGREE

    def _find_power(self, operation: Operation, pitch: float) -> float:
        """Power of the air at a pitch [W]."""
        return find_performance(self._rotor, replace(operation, pitch=pitch), SECTORS).power


def read_schedule(path: str, keep_power: bool = False) -> TableSchedule:
    """A table of operating states from a CSV file with the columns `COLUMNS`.

    Args:
        keep_power: Whether the pitch keeps the power of the air in a further column from rated
            wind on.

    Raises:
        InputError: if it is something else.
    """
    found = read_steady(path)
    if not COLUMNS.keys() <= found.keys():
        raise InputError(f"the schedule {path!r} needs the columns {', '.join(COLUMNS)}")
    table = np.array([factor * found[name] for name, factor in COLUMNS.items()]).T
    wind, speed, pitch = table.T
    if not np.isfinite(table).all() or np.any(np.diff(wind) <= 0.0) or np.any(speed < 0.0):
        raise InputError(
            f"the schedule {path!r} needs wind speeds that rise, speeds that are not negative, and "
            "finite numbers"
        )
    if np.any(np.abs(pitch) > pi):
        raise InputError(f"the schedule {path!r} has a pitch beyond 180 degrees")
    powers = found.get(names.AERO_POWER) if keep_power else None
    if keep_power and (powers is None or not np.isfinite(powers).all() or np.any(powers <= 0.0)):
        raise InputError(
            f"the schedule {path!r} needs the column {names.AERO_POWER} with positive numbers for "
            "a power that is kept"
        )
    return TableSchedule(table, f"the schedule {path!r}", powers)


def make_schedule(case: Case, file: str | None = None, keep_power: bool = False) -> Schedule:
    """Speed and pitch over the wind speed.

    Args:
        file: Table of speeds and pitch angles (CSV), or input file of ROSCO (``.IN``); by the
            controller of the case if None.
        keep_power: As of `read_schedule`.

    Raises:
        InputError: as `read_schedule` and `find_schedule` do.
    """
    if file is not None and Path(file).suffix.lower() != ROSCO:
        return read_schedule(file, keep_power)
    if keep_power:
        raise InputError("a power is kept of a table (CSV) of speeds, pitch angles and power")
    return find_schedule(case, file)


def find_schedule(case: Case, rosco: str | None = None) -> FoundSchedule:
    """The schedule that a controller leads to: ROSCO, one of kind "pi", or that of a windIO file.

    Args:
        rosco: Input file of ROSCO; that of the case, if it has one, if None.

    Raises:
        InputError: if nothing says how the turbine is run, or a file cannot be read.
    """
    t, rated = case.turbine, find_rated(case)
    rotor = Rotor(
        load_aero_blade(case), precone=-t.precone, tilt=-t.tilt, hub_height=case.hub_height
    )
    rosco, least_pitch = rosco or case.control.input, np.zeros((0, 2))
    if rosco is not None:
        r = read_rosco_input(rosco)
        least_pitch = r.least_pitch
        rated = RatedOperation(
            r.least_speed, r.rated_speed, r.rated_power, r.tip_speed_ratio, r.fine_pitch
        )
    elif case.control.kind == "pi":
        rated = _find_rated_by_law(case, rotor, rated)
    elif rated is not None:
        rated = replace(rated, rated_power=rated.rated_power / find_efficiency(case))
    else:
        raise InputError(
            "the case does not say how the turbine is run: give --schedule FILE, "
            'control.kind = "pi", or a turbine.file with a controller'
        )
    air = case.wind.shear, case.wind.density
    return FoundSchedule(rotor, rated, rated.rated_power, *air, least_pitch)


def find_efficiency(case: Case) -> float:
    """Electrical power over that of the air: of the case, or the usual one where it has none."""
    given = case.drivetrain.efficiency
    return EFFICIENCY if given == 1.0 and case.control.kind != "pi" else given


def _find_rated_by_law(case: Case, rotor: Rotor, file: RatedOperation | None) -> RatedOperation:
    """Limits of the speed and power of a controller of kind "pi".

    Args:
        file: How the file of the turbine runs it; without one the ratio is that of the largest C_P.
    """
    law, pitch, ratio = case.control.torque, case.control.pitch, case.drivetrain.ratio
    return RatedOperation(
        least_speed=law.cut_in_speed / ratio if file is None else file.least_speed,
        rated_speed=pitch.speed / ratio,
        rated_power=law.rated_power,
        tip_speed_ratio=_find_best_ratio(case, rotor) if file is None else file.tip_speed_ratio,
        fine_pitch=pitch.fine,
    )


def _find_best_ratio(case: Case, rotor: Rotor) -> float:
    """The tip-speed ratio of the largest power at the fine pitch."""
    from scipy.optimize import minimize_scalar

    wind, fine = 8.0, case.control.pitch.fine

    def lacking(ratio: float) -> float:
        speed = ratio * wind / rotor.tip_distance
        operation = Operation(wind, speed, fine, density=case.wind.density)
        return -find_performance(rotor, operation, SECTORS).power

    return float(minimize_scalar(lacking, bounds=(3.0, 15.0), method="bounded").x)
