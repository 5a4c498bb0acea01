"""Running a case: integrator, time series, all files, and resuming it later."""

from __future__ import annotations

import json
import logging
import os
import time
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from mpi4py import MPI

from turbine_fenicsx._version import __version__
from turbine_fenicsx.bodies.beam_basis import BeamBasis
from turbine_fenicsx.bodies.reduced_body import ReducedBody
from turbine_fenicsx.foundation import timing
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.foundation.interrupts import end_immediately_alone
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.linear_solvers.memory import check_memory
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import MOTION
from turbine_fenicsx.records.folder_lock import lock_folder
from turbine_fenicsx.records.openfast_binary import write_openfast_binary
from turbine_fenicsx.records.output_folder import (
    holds_run,
    make_target_folder,
    read_history,
    refuse_others,
    remove_results,
)
from turbine_fenicsx.records.statistics import write_statistics
from turbine_fenicsx.records.vtkhdf_layout import need_h5py
from turbine_fenicsx.records.worst_ply import WorstPly, find_worst_ply
from turbine_fenicsx.reduction.basis_file import write_basis
from turbine_fenicsx.simulation.checkpoint import Checkpoints
from turbine_fenicsx.simulation.energy_check import judge_energy
from turbine_fenicsx.simulation.observer import Observer
from turbine_fenicsx.simulation.observers.history import (
    History,
    angle_channel,
    energy_channel,
    numerics_channel,
    read_columns,
    work_channel,
)
from turbine_fenicsx.simulation.observers.openfast import OpenFastOutput, read_out_columns
from turbine_fenicsx.simulation.observers.progress import Progress
from turbine_fenicsx.simulation.observers.reduced_motion import ReducedMotion
from turbine_fenicsx.simulation.observers.run_log import StepLog, log_to_file
from turbine_fenicsx.simulation.observers.tips import stress_channel
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.simulation.step_error import StepError
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.generalised_alpha import GeneralisedAlpha
from turbine_fenicsx.time_stepping.solver_options import SolverOptions
from turbine_fenicsx.time_stepping.stepper import Stepper
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.component import Channels, Component, Turbine
from turbine_fenicsx.turbine.components.interface_loads import interface_channels
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.components.openfast_channel import choose_channels, choose_columns
from turbine_fenicsx.turbine.run.resume import change_case, fix_duration, label_case, write_case
from turbine_fenicsx.turbine.run.start import make_start
from turbine_fenicsx.turbine.run.summary import Statistics, format_table, summarise
from turbine_fenicsx.turbine.run.turbine_fields import make_fields

CONVENTIONS = (
    "Azimuth is 0 when blade 1 points up (AzimB1Up = 0); RotSpeed is the mean of the step that "
    "ends at the time of the row, loads are those of the last two"
)
"""Line in the head of ``history.out``."""


def turbine_channels(turbine: Turbine, stepper: Stepper, stress: bool) -> Channels:
    """All columns of both time series from left to right. Collective.

    Args:
        stress: Whether the largest stress has a column, if anything is flexible.
    """
    system = turbine.system
    found = [component.channels(turbine) for component in turbine.components]
    found.insert(1, interface_channels(turbine))  # after those of the nacelle
    return Channels(
        history=[
            energy_channel(),
            angle_channel(system),
            *(channel for each in found for channel in each.history),
            *([stress_channel(system)] if stress and system.flexible_bodies else []),
            work_channel(stepper),
            numerics_channel(),
        ],
        openfast=[channel for each in found for channel in each.openfast],
    )


def make_stepper(case: Case, system: MultibodySystem) -> Stepper:
    """Integrator of the turbine of a case. Collective."""
    options = SolverOptions(
        linear_solver=case.solver.linear_solver,
        tolerance=case.solver.tolerance,
        max_iterations=case.solver.max_iterations,
    )
    if case.time.scheme == "generalised_alpha":
        return GeneralisedAlpha(system, case.time.spectral_radius, options)
    return EnergyMomentum(
        system,
        numerical_dissipation=case.turbine.numerical_dissipation,
        angle_form=case.turbine.angle_form,
        options=options,
    )


log = logging.getLogger(__name__)


def run_case(
    case: Case,
    out: str | os.PathLike[str],
    comm: MPI.Intracomm,
    progress: str = "auto",
    observers: Iterable[Observer] = (),
    stop: Callable[[], bool] | None = None,
    resume: bool = False,
    force: bool = False,
    overwrite: bool = False,
    components: Iterable[Component] | None = None,
) -> dict[str, Any]:
    """Run a case and write everything into a folder.

    Written are ``case.json``, ``history.csv``, ``history.out``, the fields, ``run.log``,
    ``summary.json`` and checkpoints.

    Args:
        case: The case.
        out: Output folder, created if it does not exist.
        comm: Communicator.
        progress: "auto", "bar", "log" or "none".
        observers: More observers.
        stop: Called after each step; where it returns True, the run ends with a checkpoint.
        resume: Whether to resume from the last checkpoint in the folder.
        force: Whether to continue even if the memory of the machine seems too small.
        overwrite: Whether the results of an earlier run in the folder may be replaced.
        components: What the turbine is made of from the ground up; `list_components` if None.

    Returns:
        The summary, on every rank.

    Raises:
        InputError: if the folder cannot be written or holds an earlier run, the case cannot be
            built or is too large for the memory of the machine, or the checkpoint belongs to
            something else.
        FileError: if a file cannot be written; all checkpoints are intact.
        StepFailure: if a step does not converge at the smallest size.
        KeyboardInterrupt: if a signal came before the first step, on one rank.
    """
    with ExitStack() as open_folder:
        folder = open_folder.enter_context(lock_folder(comm, out))
        if not (resume or overwrite):
            on_rank0(comm, lambda: _refuse_to_overwrite(folder))
        open_folder.enter_context(log_to_file(comm, folder / "run.log", append=resume))
        log.info("%s %s, %d ranks", "restart" if resume else "run", __version__, comm.size)
        if case.output.format == "vtkhdf":
            on_rank0(comm, need_h5py)
        case = fix_duration(case)  # a resumed run that ends later has the same wind
        turbine = build_turbine(case, comm, components)
        if not force:
            undeformed = case.time.start == "undeformed"  # else the start needs factors
            solver = case.solver.linear_solver if undeformed else "lu"
            check_memory(turbine.system, solver, shared=undeformed)
        watching: list[Observer] = [Progress(comm, case.time.end, progress), StepLog(), *observers]
        return _run(case, turbine, folder, resume, watching, stop)


def restart_case(
    out: str | os.PathLike[str],
    comm: MPI.Intracomm,
    overrides: Iterable[str] = (),
    progress: str = "auto",
    stop: Callable[[], bool] | None = None,
    force: bool = False,
    observers: Iterable[Observer] = (),
    components: Iterable[Component] | None = None,
) -> tuple[Case, dict[str, Any]]:
    """Resume a run from its last checkpoint.

    Args:
        out: Output folder of the run.
        comm: Communicator; the number of ranks may differ.
        overrides: Changes such as ``"time.end=24"``, of the tables in `FREE` only.
        progress: As in `run_case`.
        stop: As in `run_case`.
        force: As in `run_case`.
        observers: As in `run_case`; those of the run.
        components: As in `run_case`; those of the run.

    Returns:
        The case and the summary.

    Raises:
        InputError: if there is no run to resume, or a key may not change.
        FileError: as in `run_case`.
        StepFailure: as in `run_case`.
    """
    case = on_rank0(comm, lambda: change_case(Path(out), list(overrides)))
    result = run_case(
        case,
        out,
        comm,
        progress,
        observers,
        stop,
        resume=True,
        force=force,
        components=components,
    )
    return case, result


def _run(
    case: Case,
    turbine: Turbine,
    folder: Path,
    resume: bool,
    watching: list[Observer],
    stop: Callable[[], bool] | None,
) -> dict[str, Any]:
    """Run a turbine in a folder that is locked; the summary."""
    comm, statistics = turbine.comm, Statistics()
    checkpoints = _make_checkpoints(case, turbine, folder)
    stepper = make_stepper(case, turbine.system)
    with end_immediately_alone(comm):  # it may take minutes, and no file is written yet
        first = None if resume else make_start(case, turbine.system)
    own = [each for c in turbine.components for each in c.observers(turbine, folder)]
    simulation = Simulation(
        turbine.system,
        case.time.step,
        case.time.end,
        [statistics, *own, *_make_outputs(case, turbine, stepper, folder, resume), *watching],
        stepper,
        step_error=_make_step_error(case, comm),
        checkpoints=checkpoints,
        stop=stop,
        start=first,
    )
    data = checkpoints.load(simulation.observers) if resume else None
    if data is None:
        _empty_folder(folder, comm, checkpoints)
    _write_bases(turbine, folder, None if data is None else case)
    write_case(case, folder, comm)
    timing.start()
    start = time.perf_counter()
    simulation.run(data)
    stepper.destroy()  # on all ranks at once
    seconds = time.perf_counter() - start
    result = summarise(turbine, statistics, seconds, simulation)
    result[names.INTERRUPTED] = simulation.stopped
    _write_summary(result, folder, comm)
    on_rank0(comm, lambda: write_statistics(folder, case.output.transient))
    if case.output.binary:
        on_rank0(comm, lambda: write_openfast_binary(folder / "history.out"))
    return result


def _write_bases(turbine: Turbine, folder: Path, resumed: Case | None) -> None:
    """Write the bases of reduced solids, which restarts and later evaluations need.

    Those of beams follow from the case in no time.

    Args:
        resumed: The case of a resumed run, which has taken its bases from the folder unless they
            were missing or damaged.
    """
    taken: tuple[str | None, ...] = ()
    if resumed is not None:
        taken = (resumed.blade.reduction.file, resumed.tower.reduction.file)
    for body in turbine.system.flexible_bodies:
        if not isinstance(body, ReducedBody) or isinstance(body.basis, BeamBasis):
            continue
        path = folder / f"basis_{body.name}.npz"
        if str(path) not in taken:
            on_rank0(turbine.comm, partial(write_basis, path, body.basis))


def _write_summary(result: dict[str, Any], folder: Path, comm: MPI.Intracomm) -> None:
    """Write the summary with warnings of lost energy and failed plies, and its table to the log."""
    worst = on_rank0(comm, lambda: _read_worst_ply(folder / "history.csv"))
    if worst is not None:
        result[names.WORST_PLY] = asdict(worst)
    warnings = [judge_energy(result), worst.warning if worst else ""]
    result[names.WARNINGS] = list(filter(None, warnings))
    text = json.dumps(result, indent=2) + "\n"
    on_rank0(comm, lambda: replace_file(folder / "summary.json", text.encode()))
    log.info("end\n%s", format_table(result))
    for sentence in result[names.WARNINGS]:
        log.info("%s", sentence)


def _read_worst_ply(history: Path) -> WorstPly | None:
    """The largest failure index of a run with failure indices in its history."""
    if not any(name.endswith("_at_[m]") for name in read_columns(history)):
        return None
    return find_worst_ply(read_history(history))


def _refuse_to_overwrite(folder: Path) -> None:
    """Keep earlier results, unless the user wants them replaced."""
    if holds_run(folder):
        raise InputError(
            f"{str(folder)!r} holds the results of a run: `turbine-fenicsx restart` resumes it, "
            "--overwrite replaces it"
        )
    refuse_others(folder, overwrite=False)


def _make_checkpoints(case: Case, turbine: Turbine, folder: Path) -> Checkpoints:
    """Checkpoints of a run, which others can only resume if they agree with it."""
    labels = on_rank0(turbine.comm, lambda: label_case(case))
    labels["list of components"] = turbine.component_names
    output = case.output
    return Checkpoints(
        turbine.system,
        folder / "checkpoints",
        labels,
        output.checkpoint_every,
        output.checkpoint_wall_time,
    )


def _make_outputs(
    case: Case, turbine: Turbine, stepper: Stepper, folder: Path, resume: bool
) -> list[Observer]:
    """Observers that write time series and fields; they open no file yet."""
    comm, every = turbine.comm, case.fields_every
    history, out = folder / "history.csv", folder / "history.out"
    kept = on_rank0(comm, lambda: read_columns(history)) if resume else []
    stress = every > 0.0 or names.MAX_STRESS in kept
    channels = turbine_channels(turbine, stepper, stress)
    columns = on_rank0(comm, lambda: read_out_columns(out)) if resume else []
    openfast = (
        choose_columns(channels.openfast, columns)
        if columns
        else choose_channels(channels.openfast, case.output.channels)
    )
    found: list[Observer] = [
        History(comm, history, channels.history),
        OpenFastOutput(comm, out, openfast, case.title, CONVENTIONS),
    ]
    if case.motion_every > 0.0:
        path, between = folder / MOTION, case.motion_every
        found.append(ReducedMotion(turbine.system, path, between, case.time.end))
    if every > 0.0:
        path = case.output.name_file(folder, "fields")
        found.append(make_fields(turbine, path, every, case.time.end))
    return found


def _empty_folder(folder: Path, comm: MPI.Intracomm, checkpoints: Checkpoints) -> None:
    """Remove the results of an earlier run, if all can be written."""
    for each in (folder, folder / "checkpoints"):
        on_rank0(comm, partial(make_target_folder, each))
    on_rank0(comm, lambda: remove_results(folder))
    checkpoints.clear()


def _make_step_error(case: Case, comm: MPI.Intracomm) -> StepError | None:
    """The error estimate that steps follow, if the case asks for it."""
    angle, displacement = case.time.angle_tolerance, case.time.displacement_tolerance
    if angle is None and displacement is None:
        return None
    return StepError(comm, angle, displacement)
