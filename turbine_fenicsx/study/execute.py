"""Runs of a study as child processes, several at a time."""

from __future__ import annotations

import os
import shlex
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.own_code import escape
from turbine_fenicsx.study.plan import Run
from turbine_fenicsx.study.results import RESULTS, is_finished, is_interrupted

LOG = "log.txt"
_PATIENCE = 60.0  # for interrupted children to finish their step and write a checkpoint [s]
_POLL = 0.05  # [s]
_CODES = {
    2: "wrong input",
    3: "a step did not converge",
    4: "the energy balance is wrong",
    130: "interrupted",
}
_OF_STEPS = (3, 4)
RAMP = 5.0
"""Time in which the wind of a second try sets in [s]."""
# Several mpirun at a time would all bind their ranks to the same first cores (Open MPI 4, 5, 6).
_UNBOUND = {
    "OMPI_MCA_hwloc_base_binding_policy": "none",
    "PRTE_MCA_hwloc_default_binding_policy": "none",
    "PRTE_MCA_bindto": "none",
}


@dataclass(frozen=True)
class Outcome:
    """Outcome of a run.

    Attributes:
        reason: Why it failed, empty if it did not.
        seconds: Wall time [s]; None if it was finished before.
    """

    run: Run
    reason: str = ""
    seconds: float | None = None


def launcher_words(launcher: str, ranks: int) -> list[str]:
    """The words of a command that starts ranks; raises InputError if there is no such program."""
    try:
        words = [word.replace("{ranks}", str(ranks)) for word in shlex.split(launcher)]
    except ValueError:
        raise InputError(f"launcher = {launcher!r}: a quotation mark is not closed") from None
    if not words or shutil.which(words[0]) is None:
        raise InputError(f"launcher = {launcher!r}: there is no such program")
    return words


def execute(
    runs: Sequence[Run],
    out: Path,
    processes: int,
    launcher: Sequence[str],
    report: Callable[[Outcome], None],
    retry: bool = False,
) -> None:
    """Run all runs that are not finished yet, each in its own folder with its own log.

    Args:
        launcher: Words before the command of each run.
        retry: Whether a run that fails has a second try: with half the step, or where there is no
            equilibrium to start from, with wind that sets in gradually.
        report: Called with each outcome as it comes; an exception ends all runs.
    """
    waiting: deque[Run] = deque()
    for run in runs:
        if is_finished(run, out / run.name):
            report(Outcome(run))
        else:
            waiting.append(run)
    active: list[tuple[Run, subprocess.Popen[bytes], float]] = []
    retried: list[Run] = []
    with _terminate_as_interrupt():
        try:
            while waiting or active:
                while waiting and len(active) < processes:
                    run = waiting.popleft()
                    active.append((run, _start(run, out / run.name, launcher), time.perf_counter()))
                time.sleep(_POLL)
                for entry in [e for e in active if e[1].poll() is not None]:
                    active.remove(entry)
                    run, process, start = entry
                    if retry and run not in retried and process.returncode in _OF_STEPS:
                        retried.append(run)
                        change = _change_for_second_try(run, out / run.name)
                        active.append((run, _start(run, out / run.name, launcher, change), start))
                        continue
                    reason = _find_reason(process.returncode, out / run.name)
                    report(Outcome(run, reason, time.perf_counter() - start))
        finally:
            # SIGUSR1 is handed on by mpirun; SIGINT makes it kill the ranks.
            number = signal.SIGUSR1 if launcher else signal.SIGINT
            _stop([process for _, process, _ in active], number)


def _change_for_second_try(run: Run, folder: Path) -> str:
    """A change of the case of a run that has failed."""
    has_started = (folder / "history.csv").is_file()
    if not has_started and run.case.wind.blows:
        return f"wind.ramp={max(RAMP, run.case.wind.ramp)!r}"
    return f"time.step={0.5 * run.case.time.step!r}"


def _start(
    run: Run, folder: Path, launcher: Sequence[str], change: str = ""
) -> subprocess.Popen[bytes]:
    """Start a run, or resume it if it was interrupted.

    Args:
        change: A key of the case with another value; none if empty.
    """
    folder.mkdir(parents=True, exist_ok=True)
    goes_on = is_interrupted(run, folder)
    # Whatever happens to this run, an earlier one counts no longer.
    (folder / "summary.json").unlink(missing_ok=True)
    case = folder / "case.toml"
    case.write_text(run.text, encoding="utf-8")
    task = (
        ["restart", str(folder)]
        if goes_on
        else ["run", str(case), "-o", str(folder), "--overwrite"]
    )
    # -P: no Python file of the present folder is run in place of a library
    python = [sys.executable, "-P", "-m", "turbine_fenicsx"]
    command = [*launcher, *python, *task, "--progress", "log"]
    if change:
        command += ["--set", change]
    # os.environ is as it was when this process began, before MPI added to it.
    with (folder / LOG).open("ab" if goes_on else "wb") as log:
        return subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            env=_UNBOUND | dict(os.environ),
            start_new_session=True,  # Ctrl-C reaches the study alone, which then ends its children
        )


def _find_reason(code: int, folder: Path) -> str:
    """Why a child failed in a few words, empty if it did not."""
    if code == 0:
        lacking = [name for name in RESULTS if not (folder / name).is_file()]
        return f"the launcher ended without writing {' and '.join(lacking)}" if lacking else ""
    text = (folder / LOG).read_text(encoding="utf-8", errors="replace")
    lines = [line.strip() for line in text.splitlines()]
    errors = [line.removeprefix("error: ") for line in lines if line.startswith("error: ")]
    what = _CODES.get(code, f"killed by signal {-code}" if code < 0 else f"exit code {code}")
    said = escape("; ".join(errors) or _find_last_words(lines))
    return f"{what}: {said}" if said else what


def _find_last_words(lines: Sequence[str]) -> str:
    """The last line outside of banners, as of mpirun; without any how the first banner begins."""
    outside: list[str] = []
    banner: list[str] = []
    in_banner = False
    for line in lines:
        if line and not line.strip("-=*#"):
            in_banner = not in_banner
        elif in_banner:
            banner.append(line)
        elif line:
            outside.append(line)
    if outside:
        return outside[-1]
    end = banner.index("") if "" in banner else len(banner)
    return " ".join(banner[:end])


def _stop(processes: Sequence[subprocess.Popen[bytes]], number: signal.Signals) -> None:
    """Ask children to end, wait for them, and kill those that do not."""
    if processes:
        print(
            f"ending {len(processes)} run{'s' * (len(processes) > 1)}, Ctrl-C again kills",
            file=sys.stderr,
            flush=True,
        )
    for process in processes:
        process.send_signal(number)
    try:
        deadline = time.monotonic() + _PATIENCE
        while any(p.poll() is None for p in processes) and time.monotonic() < deadline:
            time.sleep(_POLL)
    finally:  # also after a second Ctrl-C
        for process in processes:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@contextmanager
def _terminate_as_interrupt() -> Iterator[None]:
    """Treat SIGTERM, of a batch system for instance, and a closed terminal like Ctrl-C."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    numbers = (signal.SIGTERM, signal.SIGHUP)
    previous = {number: signal.signal(number, interrupt) for number in numbers}
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
