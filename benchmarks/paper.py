"""The paper's hybrid turbine, 144 hexahedra and 600 steps: wall time of the whole command.

Usage: paper.py RESULT. The first, short run only fills the caches. A run under cProfile tells the
seconds inside the functions of petsc4py and DOLFINx, which the profiler does not slow down; the
rest of a run without it is the share of Python, imports and pictures.
"""

from __future__ import annotations

import json
import pstats
import subprocess
import sys
import tempfile
import time
from pathlib import Path

CASE = Path(__file__).parent.parent / "demos" / "paper" / "hybrid_stiff.toml"
KERNELS = ("petsc4py", "dolfinx", "PyCapsule", "nanobind")


def run(folder, *settings, profile=""):
    """Run the case; returns seconds and the summary."""
    command = [sys.executable, *(["-m", "cProfile", "-o", profile] if profile else [])]
    command += ["-m", "turbine_fenicsx", "run", str(CASE), "-o", folder, "--overwrite"]
    for setting in settings:
        command += ["--set", setting]
    start = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    seconds = time.perf_counter() - start
    return seconds, json.loads((Path(folder) / "summary.json").read_text(encoding="utf-8"))


def seconds_in_kernels(path):
    """Seconds inside the functions of petsc4py and DOLFINx, without what they call back."""
    return sum(
        own
        for (file, _, name), (_, _, own, _, _) in pstats.Stats(path).stats.items()
        if file == "~" and any(kernel in name for kernel in KERNELS)
    )


def main():
    with tempfile.TemporaryDirectory() as folder:
        run(folder, "time.end=0.04")
        with_fields, summary = run(folder)
        without_fields, _ = run(folder, "output.fields_every=0")
        profile = str(Path(folder) / "profile")
        run(folder, "output.fields_every=0", profile=profile)
        result = {
            "seconds": with_fields,
            "seconds_without_fields": without_fields,
            "share_outside_kernels": 1.0 - seconds_in_kernels(profile) / without_fields,
            "step_by_part": summary["time_per_step_by_part_[s]"],
            "step": summary["time_per_step_[s]"],
            "iterations": summary["mean_newton_iterations"],
        }
    Path(sys.argv[1]).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
