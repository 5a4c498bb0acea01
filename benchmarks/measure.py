"""What every competitor reports about itself, in the same words. Needs nothing but Python."""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import resource
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from problem import Problem


def arguments(**choices: Any) -> tuple[Problem, argparse.Namespace]:
    """The problem and all arguments of a competitor.

    Args:
        choices: More options; the value is the default or a list of choices, first the default.
    """
    parser = argparse.ArgumentParser()
    parser.add_argument("problem", help="JSON file of the problem")
    parser.add_argument("result", help="JSON file to write")
    for name, value in choices.items():
        if isinstance(value, list):
            parser.add_argument(f"--{name.replace('_', '-')}", choices=value, default=value[0])
        else:
            parser.add_argument(f"--{name.replace('_', '-')}", type=type(value), default=value)
    args = parser.parse_args()
    return Problem.load(args.problem), args


def seconds_since_start() -> float:
    """Seconds since this process was started, imports included; to a hundredth."""
    ticks = Path("/proc/self/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[19]
    uptime = Path("/proc/uptime").read_text(encoding="utf-8").split()[0]
    return float(uptime) - float(ticks) / os.sysconf("SC_CLK_TCK")


def peak_memory() -> float:
    """Largest resident memory of this process [MB]."""
    text = Path("/proc/self/status").read_text(encoding="utf-8")
    return float(re.search(r"VmHWM:\s+(\d+)", text).group(1)) / 1024.0


def peak_memory_of_child() -> float:
    """Largest resident memory of the largest child process that has ended [MB]."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0


def loaded_blas(text: str = "") -> str:
    """BLAS libraries that a process has loaded, each with its folder.

    Args:
        text: Memory map or list of shared libraries; the map of this process if empty.
    """
    text = text or Path("/proc/self/maps").read_text(encoding="utf-8")
    files = {Path(word).resolve() for word in text.split() if word.startswith("/")}
    names = ("blas", "mkl_rt", "mkl_core", "blis", "spooles")
    found = {f"{f.parent.name}/{f.name}" for f in files if any(n in f.name for n in names)}
    return ", ".join(sorted(found)) or "built in"


def versions(*packages: str) -> dict[str, str]:
    """Versions of Python and of installed packages."""
    found = {"python": platform.python_version()}
    for name in packages:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


def write(
    path: str,
    problem: Problem,
    *,
    set_up: float,
    steps: list[float],
    iterations: list[int],
    tips: Any,
    versions: dict[str, str],
    memory: float | None = None,
    blas: str | None = None,
    ranks: int = 1,
    threads: int = 1,
    **more: Any,
) -> None:
    """Write the result of one competitor.

    Args:
        path: File to write.
        problem: The problem.
        set_up: Seconds before the first step.
        steps: Seconds of each step, warm-up included.
        iterations: Newton (or quasi-Newton) iterations of each step.
        tips: Displacements of the three tips after the last step, shape (3, 3) [m].
        versions: Versions of what was used.
        memory: Peak memory of all ranks [MB]; of this process if None.
        blas: BLAS in use; that of this process if None.
        ranks: MPI ranks.
        threads: Threads of each.
        more: Anything else.
    """
    result = {
        "unknowns": problem.unknowns,
        "set_up": set_up,
        "steps": steps,
        "iterations": iterations,
        "tips": [[float(x) for x in tip] for tip in tips],
        "memory": peak_memory() if memory is None else memory,
        "ranks": ranks,
        "threads": threads,
        "blas": loaded_blas() if blas is None else blas,
        "versions": versions,
        **more,
    }
    Path(path).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
