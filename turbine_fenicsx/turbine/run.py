"""Running a case: everything from the case to the files, and going on later."""

from __future__ import annotations

import hashlib
import json
import logging
import os
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from mpi4py import MPI

from turbine_fenicsx import __version__, timing
from turbine_fenicsx.checkpoint import Checkpoints, load_newest
from turbine_fenicsx.errors import InputError
from turbine_fenicsx.folder_lock import claimed
from turbine_fenicsx.memory import Memory
from turbine_fenicsx.observers.fields import Fields
from turbine_fenicsx.observers.history import (
    Channel,
    History,
    angle_channel,
    energy_channel,
    numerics_channel,
    work_channel,
)
from turbine_fenicsx.observers.openfast import OpenFastOutput
from turbine_fenicsx.observers.progress import Progress
from turbine_fenicsx.observers.run_log import StepLog, logging_to
from turbine_fenicsx.observers.tips import stress_channel
from turbine_fenicsx.output_folder import read_history
from turbine_fenicsx.parallel import on_rank0
from turbine_fenicsx.simulation import Observer, Simulation
from turbine_fenicsx.step_error import StepError
from turbine_fenicsx.turbine.case import Case, changed
from turbine_fenicsx.turbine.channels import (
    CONVENTIONS,
    BladeSensors,
    TowerSensors,
    openfast_channels,
)
from turbine_fenicsx.turbine.model import PART_NAMES, Turbine, build_turbine, solver_options
from turbine_fenicsx.turbine.refusal import refuse_run
from turbine_fenicsx.turbine.summary import Statistics, summary, table

log = logging.getLogger(__name__)

FREE = ("title", "time", "solver", "output")
"""Parts of a case that may change when a run goes on."""


def channels(
    turbine: Turbine, sensors: Iterable[BladeSensors | TowerSensors], stress: bool
) -> list[Channel]:
    """Columns of ``history.csv`` from left to right."""
    system = turbine.system
    found = [energy_channel(), angle_channel(system)]
    for sensor in sensors:
        found += sensor.history_channels()
    if system.flexible_bodies and stress:
        found.append(stress_channel(system))
    return [*found, work_channel(system), numerics_channel()]


def run_case(
    case: Case,
    out: str | os.PathLike[str],
    comm: MPI.Intracomm,
    progress: str = "auto",
    observers: Iterable[Observer] = (),
    stop: Callable[[], bool] | None = None,
    resume: bool = False,
    force: bool = False,
) -> dict[str, Any]:
    """Run a case and write everything into a folder.

    Written are ``case.json``, ``history.csv``, ``history.out``, ``fields.xdmf``, ``run.log``,
    ``summary.json`` and checkpoints.

    Args:
        case: The case.
        out: Output folder, created if it does not exist.
        comm: Communicator.
        progress: "auto", "bar", "log" or "none".
        observers: More observers.
        stop: Called after each step; where it returns True, the run ends with a checkpoint.
        resume: Whether to go on from the last checkpoint in the folder.
        force: Whether to go on even if the memory of the machine seems too small.

    Returns:
        The summary, on every rank.

    Raises:
        InputError: if the folder cannot be written, the case cannot be built or is too large for
            the memory of the machine, or the checkpoint belongs to something else.
        OSError: if a file cannot be written later on; all checkpoints are intact.
        StepFailure: if a step does not converge at the smallest size.
    """
    if not force:
        refuse_run(case, comm)
    with claimed(comm, out) as folder, logging_to(comm, folder / "run.log", append=resume):
        log.info("%s %s, %d ranks", "restart" if resume else "run", __version__, comm.size)
        turbine = build_turbine(case, comm)
        labels = on_rank0(comm, lambda: _labels(case))
        memory = None
        if resume:
            memory = load_newest(folder / "checkpoints", turbine.system, _must_equal(labels, out))
        try:
            simulation, statistics = _prepare(
                case, turbine, folder, comm, memory, labels, progress, observers, stop
            )
        except OSError as error:
            raise InputError(f"cannot write to {str(out)!r}: {error.strerror or error}") from None
        timing.start()
        start = time.perf_counter()
        simulation.run(memory)
        seconds = time.perf_counter() - start
        result = summary(turbine, statistics, seconds, simulation)
        result["interrupted"] = simulation.stopped
        text = json.dumps(result, indent=2) + "\n"
        on_rank0(comm, lambda: (folder / "summary.json").write_text(text, encoding="utf-8"))
        log.info("end\n%s", table(result))
    return result


def restart_case(
    out: str | os.PathLike[str],
    comm: MPI.Intracomm,
    overrides: Iterable[str] = (),
    progress: str = "auto",
    stop: Callable[[], bool] | None = None,
    force: bool = False,
) -> tuple[Case, dict[str, Any]]:
    """Go on with a run from its last checkpoint.

    Args:
        out: Output folder of the run.
        comm: Communicator; the number of ranks may differ.
        overrides: Changes such as ``"time.end=24"``, of the tables in `FREE` only.
        progress: As in `run_case`.
        stop: As in `run_case`.
        force: As in `run_case`.

    Returns:
        The case and the summary.

    Raises:
        InputError: if there is no run to go on with, or a key may not change.
        OSError: as in `run_case`.
        StepFailure: as in `run_case`.
    """
    case = on_rank0(comm, lambda: _changed_case(Path(out), list(overrides)))
    return case, run_case(case, out, comm, progress, stop=stop, resume=True, force=force)


def _prepare(
    case: Case,
    turbine: Turbine,
    folder: Path,
    comm: MPI.Intracomm,
    memory: Memory | None,
    labels: dict[str, str],
    progress: str,
    observers: Iterable[Observer],
    stop: Callable[[], bool] | None,
) -> tuple[Simulation, Statistics]:
    """Open all files and make the simulation."""
    end, every, system = case.time.end, case.output.fields_every, turbine.system
    kept = None if memory is None else float(memory.numbers["state.time"])
    checkpoints = Checkpoints(
        system,
        folder / "checkpoints",
        labels,
        case.output.checkpoint_every,
        case.output.checkpoint_wall_time,
    )
    if memory is None:
        checkpoints.clear()
    data = case.model_dump(mode="json")
    if case.mesh.file:
        data["mesh"]["file"] = os.path.abspath(case.mesh.file)
    text = json.dumps(data, indent=2) + "\n"
    on_rank0(comm, lambda: _replace(folder / "case.json", text))
    statistics = Statistics()
    sensors = (BladeSensors(case, turbine), TowerSensors(case, turbine))
    history = folder / "history.csv"
    stress = every > 0.0
    if memory is not None:  # the columns stay
        stress = on_rank0(comm, lambda: "max_stress_[Pa]" in read_history(history).columns)
    watching: list[Observer] = [
        statistics,
        History(comm, history, channels(turbine, sensors, stress), kept),
        OpenFastOutput(
            comm,
            folder / "history.out",
            openfast_channels(turbine, *sensors),
            case.title,
            CONVENTIONS,
            kept,
        ),
    ]
    if every > 0.0:
        fields = folder / "fields.xdmf"
        parts = turbine.surfaces, turbine.parts, PART_NAMES
        watching.append(Fields(system, fields, every, end, *parts, keep_until=kept))
    watching += [Progress(comm, end, progress), StepLog(), *observers]
    if memory is not None:
        statistics.take_in(on_rank0(comm, lambda: read_history(history)))
    simulation = Simulation(
        system,
        case.time.step,
        end,
        watching,
        solver_options(case),
        step_error=_step_error(case, comm),
        checkpoints=checkpoints,
        stop=stop,
    )
    return simulation, statistics


def _step_error(case: Case, comm: MPI.Intracomm) -> StepError | None:
    """The error estimate that steps follow, if the case asks for it."""
    angle, displacement = case.time.angle_tolerance, case.time.displacement_tolerance
    if angle is None and displacement is None:
        return None
    return StepError(comm, angle, displacement)


def _replace(path: Path, text: str) -> None:
    """Write a file so that it is complete at any moment."""
    temporary = path.with_name(f"{path.name}.tmp")
    temporary.write_text(text, encoding="utf-8")
    os.replace(temporary, path)


def _labels(case: Case) -> dict[str, str]:
    """What a checkpoint and the run that reads it must agree in."""
    tables = case.model_dump(mode="json", exclude=set(FREE))
    mesh = tables["mesh"].pop("file")
    return {
        "version of turbine_fenicsx": __version__,
        "case": hashlib.sha256(json.dumps(tables, sort_keys=True).encode()).hexdigest()[:16],
        "mesh": hashlib.sha256(Path(mesh).read_bytes()).hexdigest()[:16] if mesh else "built in",
    }


def _must_equal(
    labels: dict[str, str], out: str | os.PathLike[str]
) -> Callable[[dict[str, str]], None]:
    """Compares the labels of a checkpoint with these."""

    def check(found: dict[str, str]) -> None:
        for name, mine in labels.items():
            if found.get(name) != mine:
                raise InputError(
                    f"cannot go on with {os.fspath(out)!r}: the {name} has changed, it was "
                    f"{found.get(name)} and is {mine}"
                )

    return check


def _changed_case(folder: Path, overrides: list[str]) -> Case:
    """The case of an output folder with changes."""
    try:
        data = json.loads((folder / "case.json").read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"there is no run in {str(folder)!r} to go on with") from None
    except (OSError, ValueError) as error:
        raise InputError(f"cannot read {str(folder / 'case.json')!r}: {error}") from None
    old, new = Case.parse(data), changed(data, overrides)
    for name in type(old).model_fields:
        mine, theirs = getattr(new, name), getattr(old, name)
        if name not in FREE and mine != theirs:
            keys = [k for k in type(mine).model_fields if getattr(mine, k) != getattr(theirs, k)]
            raise InputError(
                f"{name}.{keys[0]} cannot change when a run goes on; only {', '.join(FREE)} can"
            )
    return new
