"""Running a case: everything from the case to the files in the output folder."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from mpi4py import MPI

from turbine_fenicsx import timing
from turbine_fenicsx.errors import InputError
from turbine_fenicsx.observers.fields import Fields
from turbine_fenicsx.observers.history import (
    Channel,
    History,
    angle_channel,
    energy_channel,
    numerics_channel,
)
from turbine_fenicsx.observers.progress import Progress
from turbine_fenicsx.observers.tips import stress_channel, tip_channel
from turbine_fenicsx.parallel import on_rank0
from turbine_fenicsx.simulation import Observer, Simulation
from turbine_fenicsx.turbine.case import Case
from turbine_fenicsx.turbine.model import Turbine, build_turbine, solver_options
from turbine_fenicsx.turbine.summary import Statistics, summary


def channels(case: Case, turbine: Turbine) -> list[Channel]:
    """Columns of ``history.csv`` from left to right."""
    system = turbine.system
    found = [energy_channel(), angle_channel(system), tip_channel(system, list(turbine.tips))]
    if system.flexible_bodies and case.output.fields_every > 0.0:
        found.append(stress_channel(system))
    return [*found, numerics_channel()]


def run_case(
    case: Case,
    out: str | os.PathLike[str],
    comm: MPI.Intracomm,
    progress: str = "auto",
    observers: Iterable[Observer] = (),
) -> dict[str, Any]:
    """Run a case and write ``history.csv``, ``fields.xdmf`` and ``summary.json``.

    Args:
        case: The case.
        out: Output folder, created if it does not exist.
        comm: Communicator.
        progress: "auto", "bar", "log" or "none".
        observers: More observers.

    Returns:
        The summary, on every rank.

    Raises:
        InputError: if the folder cannot be written or the case cannot be built.
        StepFailure: if a step does not converge at the smallest size.
    """
    folder = Path(out)
    try:
        on_rank0(comm, lambda: folder.mkdir(parents=True, exist_ok=True))
    except OSError as error:
        raise InputError(f"cannot write to {str(out)!r}: {error.strerror}") from None
    turbine = build_turbine(case, comm)
    end, every = case.time.end, case.output.fields_every
    statistics = Statistics()
    try:
        watching: list[Observer] = [
            statistics,
            History(comm, folder / "history.csv", channels(case, turbine)),
        ]
        if every > 0.0:
            fields = folder / "fields.xdmf"
            watching.append(
                Fields(turbine.system, fields, every, end, turbine.surfaces, turbine.parts)
            )
    except OSError as error:
        raise InputError(f"cannot write to {str(out)!r}: {error.strerror or error}") from None
    watching += [Progress(comm, end, progress), *observers]
    simulation = Simulation(turbine.system, case.time.step, end, watching, solver_options(case))
    timing.start()
    start = time.perf_counter()
    simulation.run()
    seconds = time.perf_counter() - start
    result = summary(turbine, statistics, seconds, simulation.halvings)
    text = json.dumps(result, indent=2) + "\n"
    on_rank0(comm, lambda: (folder / "summary.json").write_text(text, encoding="utf-8"))
    return result
