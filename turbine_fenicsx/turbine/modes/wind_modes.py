"""The modes of a case in steady wind: everything from the case to the files."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Container, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from math import radians

from mpi4py import MPI

import numpy as np
from scipy.optimize import linear_sum_assignment

from turbine_fenicsx.analysis.air_modes import AirModel, AirProblem
from turbine_fenicsx.analysis.campbell import ADDITIONAL_MODES, choose, find_criteria, find_partners
from turbine_fenicsx.analysis.mode import Modes
from turbine_fenicsx.analysis.slepc import import_slepc
from turbine_fenicsx.foundation.errors import ModelError, StepFailure
from turbine_fenicsx.foundation.interrupts import end_immediately_alone
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records.conventions import BLADES
from turbine_fenicsx.records.folder_lock import lock_folder
from turbine_fenicsx.records.output_folder import keep_results
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.nacelle import ROTOR
from turbine_fenicsx.turbine.modes.mode_files import ModeTable, Place
from turbine_fenicsx.turbine.modes.mode_series import Found, find_series, free_modes, write_series
from turbine_fenicsx.turbine.modes.mode_table import ModeRow, describe_modes
from turbine_fenicsx.turbine.modes.symmetric_turbine import (
    SymmetricTurbine,
    list_left_out,
    make_symmetric,
)
from turbine_fenicsx.turbine.steady.controlled_states import ControlledStates, check_controller
from turbine_fenicsx.turbine.steady.operating_states import OperatingState, Schedule, make_schedule
from turbine_fenicsx.wind.aerodynamics import WAKE
from turbine_fenicsx.wind.section_states import SHED, STALL

log = logging.getLogger(__name__)

Look = Callable[..., tuple[OperatingState, State]]
"""Finds the steady state at a speed of wind or rotor, near another one."""

COUNT = 12
"""Number of modes if nobody says how many."""

AMPLITUDE = radians(0.5)
"""Amplitude of the angle of attack for whose vibrations the modes are, if nobody says so [rad]."""

SPEED_MODE = "speed of the rotor"
"""Name of the mode in which the controller keeps the speed."""

LIKE = 0.1
"""Least MAC of a mode in the air with those that it comes from: the one without air, and the one
at the wind before."""


@dataclass(frozen=True)
class WindModesWanted:
    """Which modes of a case in wind are wanted.

    Args:
        winds: Wind speeds that rise [m/s].
        count: Number of modes.
        schedule: As of `find_steady`.
        keep_power: As of `read_schedule`.
        frozen_wake: Whether the wake stays as it is.
        quasi_steady: Whether lift follows without any delay, also in stall.
        locked: Names of joint coordinates that a brake holds.
        amplitude: As of `SymmetricTurbine`.
        speeds: In place of winds, speeds that rise of a rotor that turns freely at the pitch of the
            case: each has a wind without torque [rad/s].
        controlled: Whether the controller of the case sets speed and pitch, and takes part; else
            torque and pitch are constant.
    """

    winds: Sequence[float] = ()
    count: int = COUNT
    schedule: str | None = None
    keep_power: bool = False
    frozen_wake: bool = False
    quasi_steady: bool = False
    locked: tuple[str, ...] = ()
    amplitude: float = AMPLITUDE
    speeds: Sequence[float] = ()
    controlled: bool = False

    def find_air(self, models: Container[str]) -> AirModel:
        """How the air follows if it has some models."""
        instant = (STALL, SHED) if self.quasi_steady else ()
        return AirModel(
            frozen=(WAKE,) if self.frozen_wake and WAKE in models else (),
            instant=tuple(name for name in instant if name in models),
        )


def find_wind_modes(
    case: Case,
    out: str | os.PathLike[str] | None,
    comm: MPI.Intracomm,
    wanted: WindModesWanted,
    *,
    overwrite: bool = False,
    found: Callable[[ModeTable], bool] = lambda _: False,
) -> tuple[list[ModeTable], list[str]]:
    """Find the modes of a case in uniform wind along its shaft, and write them into a folder.

    Files, signals and arguments are those of `find_modes`. Weight, tilt and the rest that changes
    with the azimuth are left out with a warning in the log.

    Returns:
        The modes at each wind speed that has a steady state, and the names of the files.

    Raises:
        InputError: as `find_modes`, or if the case does not say how the turbine is run.
        FileError: if a file cannot be written.
        StepFailure: if there is no steady state at any wind speed.
        KeyboardInterrupt: if a signal came before the modes at the first wind were found.
    """
    import_slepc()
    if wanted.controlled:
        check_controller(case)
    with lock_folder(comm, out) if out is not None else nullcontext() as folder:
        if folder is not None:
            on_rank0(comm, lambda: keep_results(folder, "modes", overwrite))
        plan = None
        if not wanted.speeds and not wanted.controlled:
            plan = on_rank0(comm, lambda: make_schedule(case, wanted.schedule, wanted.keep_power))
        say_what_is_left_out(case, comm, wanted.controlled)
        with end_immediately_alone(comm):
            rotor = SymmetricTurbine(make_symmetric(case), comm, wanted.locked, wanted.amplitude)
        look: Look = partial(rotor.find_free, pitch=float(np.mean(case.pitch.initial)))
        if plan is not None:
            look = partial(look_up, rotor, plan)
        control = ControlledStates(case, rotor) if wanted.controlled else None
        if control is not None:
            look = control.find
        finder = WindFinder(rotor, look, wanted, control)
        finders = [partial(finder.find, place) for place in wanted.speeds or wanted.winds]
        count = wanted.count + wanted.controlled
        tables, last = find_series(rotor.turbine, finders, count, found)
        finder.destroy()
        files = [] if folder is None else write_series(case, rotor.turbine, folder, tables, last)
        free_modes(last)
    return tables, files


def find_flutter(tables: Sequence[ModeTable]) -> list[tuple[float, ModeRow]]:
    """Speeds from which modes grow that decay before, and these modes, by rising speed.

    Args:
        tables: Modes over speeds that rise, with the same numbers.

    Returns:
        Speeds [rad/s], between two places by a straight line, once for each mode.
    """
    found: dict[int, tuple[float, ModeRow]] = {}
    for before, after in pairwise(tables):
        change = after.place.speed - before.place.speed
        for k, (a, b) in enumerate(zip(before.rows, after.rows, strict=True)):
            if a.damping_ratio >= 0.0 > b.damping_ratio:
                part = a.damping_ratio / (a.damping_ratio - b.damping_ratio)
                found.setdefault(k, (before.place.speed + part * change, b))
    return sorted(found.values(), key=lambda pair: pair[0])


def look_up(
    rotor: SymmetricTurbine, plan: Schedule, wind: float, near: State | None = None
) -> tuple[OperatingState, State]:
    """The steady state at a wind speed."""
    operating, (state,) = rotor.find(plan, wind, near)
    return operating, state


def say_what_is_left_out(case: Case, comm: MPI.Intracomm, controlled: bool) -> None:
    """Warn of what modes in wind do not know."""
    left_out = list(list_left_out(case))
    if not controlled and case.control.kind != "none":
        left_out.append("the controller")
    if left_out and comm.rank == 0:
        log.warning(
            "modes in wind are those in uniform wind along the shaft: %s left out",
            ", ".join(left_out),
        )


def _find_share(name: str, row: ModeRow) -> float:
    """Part of a mode that moves as the name of another says, 0 to 1.

    Neighbours of one frequency mix, and MACs alone often exchange them.
    """
    return max((share for way, share in row.ways.items() if way in name), default=0.0)


class WindFinder:
    """Finds modes at one wind speed after the other.

    Modes of the structure are followed from wind to wind and have names. Each becomes a mode in the
    air, one with much of its shape, and of that at the wind before: flap modes are damped so much
    that their shapes mix.
    """

    def __init__(
        self,
        rotor: SymmetricTurbine,
        look: Look,
        wanted: WindModesWanted,
        control: ControlledStates | None = None,
    ) -> None:
        self._rotor, self._look, self._wanted, self._control = rotor, look, wanted, control
        self._still: Modes | None = None

    def find(self, at: float, before: Modes | None) -> Found | None:
        """The modes at a speed of wind or rotor; None with a warning without a steady state."""
        rotor, near = self._rotor, None if before is None else before.state
        try:
            operating, state = self._look(at, near=near)
        except (ModelError, StepFailure) as failure:
            unit = "rad/s" if self._wanted.speeds else "m/s"
            self._warn(f"no modes at {at:.4g} {unit}: {failure}")
            return None
        system, speed, wind = rotor.turbine.system, operating.rotor_speed, operating.wind
        feedback = None if self._control is None else self._control.linearise(operating)
        problem = AirProblem(system, ROTOR, speed, state, len(BLADES), feedback=feedback)
        try:
            still = problem.find_still(self._wanted.count + ADDITIONAL_MODES)
            air = self._wanted.find_air(problem.models)
            found = problem.find(2 * len(still.modes), air)
        finally:
            problem.destroy()
        if self._still is not None:
            still = choose(still, find_partners(system, self._still, still)[0])
            self._still.destroy()
        count = min(self._wanted.count, len(still.modes))
        self._still, rows = describe_modes(rotor.turbine, choose(still, np.arange(count)))
        last = [] if feedback is None else [found.modes[-1]]
        found = replace(found, modes=found.modes[: len(found.modes) - len(last)])
        found, rows_found = describe_modes(rotor.turbine, found)
        criteria = find_criteria(system, self._still, found)
        likeness = criteria.copy()
        if before is not None:
            same = find_criteria(system, before, found)[:count]
            likeness[: len(same)] += same
        weights = likeness + [[_find_share(x.name, y) for y in rows_found] for x in rows]
        _, partners = linear_sum_assignment(np.where(likeness < LIKE, 0.0, -weights))
        for row, mac in zip(rows, likeness[np.arange(count), partners], strict=True):
            if mac < LIKE:
                self._warn(f"{row.name} at {wind:g} m/s has a MAC of {mac:.2f} with what it was")
        place = Place(speed, wind, operating.pitch, bool(self._wanted.speeds))
        found = choose(found, partners)
        found = replace(found, modes=(*found.modes, *last))
        return Found(found, place, [*(row.name for row in rows), *[SPEED_MODE] * len(last)])

    def destroy(self) -> None:
        """Free the modes of the structure."""
        if self._still is not None:
            self._still.destroy()

    def _warn(self, sentence: str) -> None:
        """Log a warning once."""
        if self._rotor.turbine.comm.rank == 0:
            log.warning("%s", sentence)
