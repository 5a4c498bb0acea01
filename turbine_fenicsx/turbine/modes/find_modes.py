"""The modes of a case: everything from the case to the files."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from mpi4py import MPI

from turbine_fenicsx.analysis.campbell import ModeFollower
from turbine_fenicsx.analysis.damped_modes import damped_modes
from turbine_fenicsx.analysis.linear_system import count_degrees_of_freedom
from turbine_fenicsx.analysis.mode import Modes
from turbine_fenicsx.analysis.modes import modes
from turbine_fenicsx.analysis.slepc import import_slepc
from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.interrupts import end_immediately_alone
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.linear_solvers.memory import check_memory
from turbine_fenicsx.records.conventions import BLADES
from turbine_fenicsx.records.folder_lock import lock_folder
from turbine_fenicsx.records.output_folder import (
    keep_results,
)
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.brakes import Brakes
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.turbine.components.model import build_turbine, list_components
from turbine_fenicsx.turbine.components.nacelle import ROTOR, YAW
from turbine_fenicsx.turbine.modes.mode_files import ModeTable, Place
from turbine_fenicsx.turbine.modes.mode_series import Found, find_series, free_modes, write_series
from turbine_fenicsx.turbine.run.start import list_held, turn_blades

log = logging.getLogger(__name__)

COUNT = 12
"""Number of modes if nobody says how many."""

ADDITIONAL_MODES = 2
"""Number of additional modes: three equal blades have three equal modes, and which of them are
found depends on round-off."""


MIN_SPEED, MAX_SPEED = 1e-6, 1e3
"""Speeds of a rotor that turns [rad/s]."""


@dataclass(frozen=True)
class ModesWanted:
    """Which modes of a case are wanted.

    Args:
        count: Number of modes; None for 12, or all if the turbine has fewer.
        speeds: Speeds of the rotor [rad/s]; 0 is standstill. The weight counts only if all are 0.
        locked: Names of joint coordinates that a brake holds.

    Raises:
        InputError: for a speed that is neither 0 nor one of a rotor.
    """

    count: int | None = None
    speeds: tuple[float, ...] = (0.0,)
    locked: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for speed in self.speeds:
            if speed and not MIN_SPEED <= abs(speed) <= MAX_SPEED:
                raise InputError(
                    f"a rotor speed of {speed:.4g} rad/s: expected 0, or {MIN_SPEED:g} to "
                    f"{MAX_SPEED:g} rad/s"
                )


def find_modes(
    case: Case,
    out: str | os.PathLike[str] | None,
    comm: MPI.Intracomm,
    wanted: ModesWanted = ModesWanted(),
    *,
    force: bool = False,
    overwrite: bool = False,
    found: Callable[[ModeTable], bool] = lambda _: False,
) -> tuple[list[ModeTable], list[str]]:
    """Find the modes of a case and write them into a folder.

    Written are ``modes.csv``, ``modes.xdmf`` (of several speeds the shapes at the last one),
    ``campbell.csv`` for several speeds, and ``case.json``. Of several speeds, the k-th mode at each
    is the k-th at the first one, followed by its shape.

    On one rank a signal ends the work at hand, see
    `turbine_fenicsx.foundation.interrupts.catch_signals`; the speeds before it are written.

    Args:
        case: The case.
        out: Output folder, created if it does not exist; None writes nothing.
        comm: Communicator.
        wanted: Which modes.
        force: Whether to continue even if the memory of the machine seems too small.
        overwrite: Whether earlier results in the folder may be replaced.
        found: Called after each speed; where it returns True on any rank, no more are looked at.

    Returns:
        The modes at each speed, and the names of the files.

    Raises:
        InputError: if the folder cannot be written or holds earlier results, the case cannot be
            built or is too large for the memory of the machine, there are no such modes, or
            slepc4py is missing.
        FileError: if a file cannot be written.
        StepFailure: if there is no equilibrium, or the modes are not found.
        KeyboardInterrupt: if a signal came before the modes at the first speed were found.
    """
    import_slepc()
    if out is None:
        return _find(case, None, comm, wanted, found, force)
    with lock_folder(comm, out) as folder:
        on_rank0(comm, lambda: keep_results(folder, "modes", overwrite))
        return _find(case, folder, comm, wanted, found, force)


def _find(
    case: Case,
    folder: Path | None,
    comm: MPI.Intracomm,
    wanted: ModesWanted,
    found: Callable[[ModeTable], bool],
    force: bool,
) -> tuple[list[ModeTable], list[str]]:
    """Find the modes, and write them into a folder that is locked."""
    case = _leave_out_wind_and_control(case, comm)
    turning = any(wanted.speeds)
    if turning and ROTOR in wanted.locked:
        raise InputError(f"a brake on {ROTOR!r} leaves it no speed: lock it, or let it turn")
    if case.turbine.azimuth and ROTOR in wanted.locked:
        raise InputError(f"a brake on {ROTOR!r} holds it at turbine.azimuth = 0 only")
    if turning:
        case = case.model_copy(update={"loads": case.loads.model_copy(update={"gravity": 0.0})})
    locked = dict.fromkeys(wanted.locked, lambda: 0.0)
    with end_immediately_alone(comm):
        turbine = build_turbine(case, comm, [*list_components(case), Brakes(locked)])
    if not force:
        check_memory(turbine.system, "frozen", shared=False)  # the modes' own factor is like it
    free = count_degrees_of_freedom(turbine.system)
    count = wanted.count or min(COUNT, free)
    more = min(ADDITIONAL_MODES, max(free - count, 0))
    at_each_speed = _find_turning if turning else _find_at_rest
    finders = [
        partial(at_each_speed, turbine, wanted, count + more, speed) for speed in wanted.speeds
    ]
    tables, last = find_series(turbine, finders, count, found)
    files = [] if folder is None else write_series(case, turbine, folder, tables, last)
    free_modes(last)
    return tables, files


def _leave_out_wind_and_control(case: Case, comm: MPI.Intracomm) -> Case:
    """The case without what modes do not know, with a note of what that is."""
    there = {
        "wind": case.wind.blows,
        "control": case.control.kind != "none",
        "event": bool(case.event),
    }
    left_out = [name for name, found in there.items() if found]
    if not left_out:
        return case
    if comm.rank == 0:
        tables = " and ".join(f"[{name}]" for name in left_out)
        log.warning("modes are those without wind and controller: %s left out", tables)
    new = {name: type(getattr(case, name))() for name in left_out}
    return case.model_copy(update=new)


def _find_at_rest(
    turbine: Turbine, wanted: ModesWanted, count: int, speed: float, before: Modes | None
) -> Found:
    """The modes about the equilibrium, with what dampens them."""
    system = turbine.system
    start = _make_initial_state(turbine)
    state = equilibrium(system, state=start, held=_list_held(turbine, wanted))
    start.destroy()
    damped = any(force.kind == "dissipative" for force in system.motion_forces) or any(
        model.is_viscous for model in system.flexible_models
    )
    return Found((damped_modes if damped else modes)(system, state, count), Place(speed))


def _find_turning(
    turbine: Turbine, wanted: ModesWanted, count: int, speed: float, before: Modes | None
) -> Found:
    """The modes at a speed, in the order of those before."""
    carried = turbine.case.tower.flexible or YAW not in wanted.locked
    blades = len(BLADES) if carried else None
    start = _make_initial_state(turbine)
    try:
        held = [name for name in _list_held(turbine, wanted) if name != ROTOR]
        follower = ModeFollower(turbine.system, ROTOR, count, blades, start, held)
        if before is None:
            return Found(follower.start(speed), Place(speed))
        return Found(follower.continue_at(before, speed), Place(speed))
    finally:
        start.destroy()


def _list_held(turbine: Turbine, wanted: ModesWanted) -> list[str]:
    """Joint coordinates that no brake holds, nor anything else."""
    return [name for name in list_held(turbine.case, turbine.system) if name not in wanted.locked]


def _make_initial_state(turbine: Turbine) -> State:
    """The initial state, rotor and blades turned to where they start. Collective."""
    system = turbine.system
    state = system.initial_state()
    turn_blades(turbine.case, system, state)
    turning_frame(system, ROTOR, 0.0, state).turn(state, turbine.case.turbine.azimuth)
    return state
