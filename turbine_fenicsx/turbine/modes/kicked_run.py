"""The decay of one mode in steady wind: its eigenvalue, a run that is kicked, and who takes part.

Two runs begin in the same steady state, one of them with velocities along the mode. The difference
of what the mode's filter sees in them is fitted. The energy-momentum scheme is the midpoint rule
for small motions, so that what its steps do is undone. Numerical dissipation is left in.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.analysis.air_modes import AirProblem
from turbine_fenicsx.analysis.decay_fit import fit_decay
from turbine_fenicsx.analysis.modal_filter import ModalFilter
from turbine_fenicsx.analysis.mode import Mode
from turbine_fenicsx.analysis.slepc import import_slepc
from turbine_fenicsx.foundation.errors import InputError, StepFailure
from turbine_fenicsx.foundation.interrupts import end_immediately_alone
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.conventions import BLADES
from turbine_fenicsx.records.folder_lock import lock_folder
from turbine_fenicsx.records.output_folder import keep_results
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.case.aero_blade import load_aero_blade
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.generator import SteadyTorque
from turbine_fenicsx.turbine.components.nacelle import ROTOR
from turbine_fenicsx.turbine.components.rotor_air import RotorLoads
from turbine_fenicsx.turbine.modes.damping_files import Damping, write_damping
from turbine_fenicsx.turbine.modes.mode_series import Found, free_modes
from turbine_fenicsx.turbine.modes.symmetric_turbine import SymmetricTurbine, make_symmetric
from turbine_fenicsx.turbine.modes.wind_modes import (
    WindFinder,
    WindModesWanted,
    look_up,
    say_what_is_left_out,
)
from turbine_fenicsx.turbine.run.run import make_stepper
from turbine_fenicsx.turbine.steady.operating_states import make_schedule

KICK = 0.1
"""Largest velocity of a section in a kick, if nobody says so [m/s]."""

CYCLES = 8.0
"""Vibrations of a run, if nobody says how many."""

FADED, GROWN = 8.0, 3.0
"""A run ends when the motion has fallen, or grown, by exp of these."""

WHIRLS = 0.9
"""Least part of the rotor's modal mass that goes round one way in a mode that whirls."""

FEWEST = 20
"""Minimum number of steps of a run."""

MOST_STEPS = 200000
"""Maximum number of steps of a run."""


@dataclass(frozen=True)
class DampingWanted:
    """Which mode is kicked.

    Args:
        modes: The wind, one, and how modes are found there; the air moves as in runs.
        mode: Its number, from 1 on, or its name.
        kick: Largest velocity of a section [m/s].
        cycles: Maximum number of vibrations of a run.
    """

    modes: WindModesWanted
    mode: str
    kick: float = KICK
    cycles: float = CYCLES


def find_damping(
    case: Case,
    out: str | os.PathLike[str] | None,
    comm: MPI.Intracomm,
    wanted: DampingWanted,
    *,
    overwrite: bool = False,
    found: Callable[[str], None] = lambda _: None,
) -> tuple[Damping, list[str]]:
    """Find the damping of one mode three ways. Collective.

    The turbine is that of `find_wind_modes`, free against a constant torque, and the runs have step
    and scheme of the case.

    Args:
        out: Folder for the results; None for none.
        overwrite: Whether earlier modes there are replaced.
        found: Called with a sentence on what comes next.

    Returns:
        The damping, and the names of the files.

    Raises:
        InputError: as `find_wind_modes`, or if there is no such mode.
        FileError: if a file cannot be written.
        StepFailure: if there is no steady state, or a run fails.
    """
    import_slepc()
    modes = wanted.modes
    with lock_folder(comm, out) if out is not None else nullcontext() as folder:
        if folder is not None:
            on_rank0(comm, lambda: keep_results(folder, "dampings", overwrite))
        plan = on_rank0(comm, lambda: make_schedule(case, modes.schedule, modes.keep_power))
        say_what_is_left_out(case, comm, False)
        with end_immediately_alone(comm):
            torque = SteadyTorque()
            rotor = SymmetricTurbine(
                make_symmetric(case), comm, modes.locked, modes.amplitude, [torque]
            )
            finder = WindFinder(rotor, partial(look_up, rotor, plan), modes)
            here = finder.find(modes.winds[0], None)
            finder.destroy()
            if here is None or here.names is None:
                raise StepFailure("there are no modes without a steady state")
            try:
                mode, name = _choose(here, wanted.mode)
                power = float(RotorLoads(rotor.turbine).evaluate(here.modes.state).moment[0])
                torque.value = -power
                damping = _find(case, rotor, wanted, here, mode, name, found)
            finally:
                free_modes(here.modes)
        files = [] if folder is None else write_damping(case, folder, damping, comm)
    return damping, files


def _choose(here: Found, wanted: str) -> tuple[Mode, str]:
    """A mode by its number or its name, and its name."""
    titles = list(here.names or ())
    if wanted in titles:
        number = titles.index(wanted)
    elif wanted.isdecimal() and 1 <= int(wanted) <= len(titles):
        number = int(wanted) - 1
    else:
        known = "; ".join(f"{k} {name}" for k, name in enumerate(titles, start=1))
        raise InputError(f"--mode {wanted}: no such mode at {here.place.wind:g} m/s, but {known}")
    return here.modes.modes[number], titles[number]


def _find(
    case: Case,
    rotor: SymmetricTurbine,
    wanted: DampingWanted,
    here: Found,
    mode: Mode,
    name: str,
    found: Callable[[str], None],
) -> Damping:
    """Kick a mode, and look where its damping comes from."""
    system, state, s = rotor.turbine.system, here.modes.state, mode.eigenvalue
    problem = AirProblem(system, ROTOR, here.place.speed, state, len(BLADES))
    try:
        work, meter = problem.find_work(mode), problem.make_filter(mode)
        h, end = case.time.step, _find_end(s, wanted.cycles)
        steps = max(int(np.ceil(end / h)), FEWEST)
        if steps > MOST_STEPS:
            raise InputError(
                f"time.step = {h:g} s: a run of {end:.3g} s takes {steps} steps, at most "
                f"{MOST_STEPS} are allowed"
            )
        found(f"{name}: two runs of {steps * h:.3g} s, without a kick and with one")
        kick = wanted.kick / _find_speed(system, state, mode)
        rows = [
            _run(case, system, meter, _kick(state, mode, size), h, steps * h)
            for size in (0.0, kick)
        ]
    finally:
        problem.destroy()
    if len(rows[0]) != len(rows[1]):
        raise StepFailure("the runs with and without a kick have different steps")
    q = rows[1][:, 1] - rows[0][:, 1]
    undo = None if case.turbine.numerical_dissipation else h
    shift = _find_shift(mode, here.place.speed)
    decay = fit_decay(rows[0][:, 0].real, q, s, undo, shift)
    blade = on_rank0(system.comm, lambda: load_aero_blade(rotor.case))
    return Damping(name, here.place, s, decay, work, blade.radius, blade.parts)


def _find_end(s: complex, cycles: float) -> float:
    """How long a run takes [s]."""
    rate = max(-s.real / FADED, s.real / GROWN)
    return 1.0 / max(s.imag / (2.0 * np.pi * cycles), rate)


def _find_shift(mode: Mode, speed: float) -> float:
    """Shift of the frequency of a mode that whirls to that seen from the rotor [rad/s]."""
    if mode.whirl is None:
        return 0.0
    ways = ((mode.whirl.backward, speed), (mode.whirl.forward, -speed))
    return next((shift for part, shift in ways if part >= WHIRLS), 0.0)


def _find_speed(system: MultibodySystem, state: State, mode: Mode) -> float:
    """Largest velocity of a section in a kick by the real part of the mode. Collective."""
    return max(
        float(np.max(np.linalg.norm(loads.find_motion(u.array_r, v.array_r).velocity, axis=1)))
        for model, u, v in zip(system.flexible_models, state.u, mode.real.u, strict=True)
        for loads in model.section_loads
    )


def _kick(state: State, mode: Mode, size: float) -> State:
    """A state with velocities along the real part of a mode, a copy. Collective."""
    kicked = state.copy()
    for v, shape in zip(kicked.v, mode.real.u, strict=True):
        v.axpy(size, shape)
    kicked.q_dot = kicked.q_dot + size * mode.real.q
    kicked.joint_rates = kicked.joint_rates + size * mode.real.joint_coordinates
    return kicked


def _run(
    case: Case, system: MultibodySystem, meter: ModalFilter, start: State, h: float, end: float
) -> Array:
    """Times and q of a run from a state, which is freed, shape (n, 2). Collective."""
    watch = _Watch(meter)
    simulation = Simulation(
        system, h, end, observers=[watch], start=start, stepper=make_stepper(case, system)
    )
    simulation.run()
    start.destroy()
    return np.array(watch.rows)


class _Watch:
    """An observer of q."""

    def __init__(self, meter: ModalFilter) -> None:
        self._meter, self.rows = meter, list[tuple[float, complex]]()

    def start(self, snapshot: Snapshot, resumed: bool) -> None:
        """See the first state."""
        self.observe(snapshot)

    def observe(self, snapshot: Snapshot) -> None:
        """See a state."""
        self.rows.append((snapshot.state.time, self._meter.measure(snapshot.state)))

    def finish(self) -> None:
        """Nothing has to be closed."""
