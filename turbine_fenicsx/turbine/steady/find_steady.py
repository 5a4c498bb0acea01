"""The steady states of a case: everything from the case to the files."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from mpi4py import MPI

from turbine_fenicsx.foundation.errors import InputError, ModelError, StepFailure
from turbine_fenicsx.foundation.interrupts import end_immediately_alone
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.linear_solvers.memory import check_memory
from turbine_fenicsx.records.folder_lock import lock_folder
from turbine_fenicsx.records.output_folder import keep_results, make_target_folder, remove_results
from turbine_fenicsx.records.steady_tables import write_steady
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.run.resume import write_case
from turbine_fenicsx.turbine.steady.operating_states import Schedule, make_schedule
from turbine_fenicsx.turbine.steady.steady_results import SteadyReader, SteadyState
from turbine_fenicsx.turbine.steady.steady_turbine import SteadyTurbine

log = logging.getLogger(__name__)


def find_steady(
    case: Case,
    out: str | os.PathLike[str],
    comm: MPI.Intracomm,
    winds: Sequence[float],
    schedule: str | None = None,
    azimuths: int = 2,
    overwrite: bool = False,
    found: Callable[[SteadyState], bool] = lambda _: False,
) -> list[SteadyState]:
    """Find the steady states of a case over the wind speed and write them into a folder.

    Written are ``steady.csv``, ``steady_blade.csv``, ``steady.yaml`` and ``case.json``, after each
    wind speed. A wind speed without a steady state is left out with a warning in the log.

    Args:
        case: The case.
        out: Output folder, created if it does not exist.
        comm: Communicator.
        winds: Wind speeds [m/s].
        schedule: Table of speeds and pitch angles (CSV), or input file of ROSCO (``.IN``); by the
            controller of the case if None.
        azimuths: As of `SteadyTurbine`.
        overwrite: Whether earlier steady states in the folder may be replaced.
        found: Called after each wind speed; where it returns True on any rank, the rest is left.

    Returns:
        The steady states; on all ranks.

    Raises:
        InputError: if the folder cannot be written or holds other results, the case cannot be
            built, or nothing says how the turbine is run.
        FileError: if a file cannot be written.
        KeyboardInterrupt: if a signal came before the first one was found.
    """
    _check(case)
    with lock_folder(comm, out) as folder:
        on_rank0(comm, lambda: keep_results(folder, "steady states", overwrite))
        plan = on_rank0(comm, lambda: make_schedule(case, schedule))
        with end_immediately_alone(comm):
            steady = SteadyTurbine(case, comm, azimuths)
            check_memory(steady.turbine.system, "lu", shared=False)
        on_rank0(comm, lambda: make_target_folder(folder))
        on_rank0(comm, lambda: remove_results(folder))
        write_case(case, folder, comm)
        return _find(steady, plan, folder, winds, found)


def _find(
    steady: SteadyTurbine,
    plan: Schedule,
    folder: Path,
    winds: Sequence[float],
    found: Callable[[SteadyState], bool],
) -> list[SteadyState]:
    """Find the steady states one after another, each from the one before."""
    comm, reader = steady.turbine.comm, SteadyReader(steady)
    states: list[SteadyState] = []
    near: State | None = None
    for wind in winds:
        try:
            with end_immediately_alone(comm):
                operating, (state, *others) = steady.find(plan, wind, near)
                read = reader.read(operating, [state, *others])
        except (ModelError, StepFailure) as failure:
            if comm.rank == 0:
                log.warning("no steady state at %g m/s: %s", wind, failure)
            continue
        except KeyboardInterrupt:
            if not states:
                raise
            break
        for each in (*others, *([near] if near is not None else [])):
            each.destroy()
        near = state
        states.append(read)
        rows = [(each.numbers, each.along) for each in states]
        on_rank0(comm, partial(write_steady, folder, rows))
        if comm.allreduce(bool(found(read))):
            break
    if near is not None:
        near.destroy()
    return states


def _check(case: Case) -> None:
    """Refuse what has no steady states."""
    if case.aero.file is None and case.turbine.file is None:
        raise InputError("steady states need the aerodynamics of the blades: give aero.file")
