"""Who takes part: one line a competitor, and how to start it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
PEERS = HERE / ".venv-peers" / "bin" / "python"


@dataclass(frozen=True)
class Competitor:
    """A program that solves the problem.

    Args:
        name: Name in tables.
        script: Script in this folder.
        options: Its options.
        ranks: MPI ranks.
        threads: Threads, for programs that have no ranks.
        program: Program on the PATH that it needs.
        package: Package of the peers' environment that it needs.
        most_unknowns: Larger problems are not for it.
    """

    name: str
    script: str
    options: tuple[str, ...] = ()
    ranks: int = 1
    threads: int = 0
    program: str = ""
    package: str = ""
    most_unknowns: int = 10**9

    @property
    def cores(self) -> int:
        """Cores that it uses."""
        return max(self.ranks, self.threads)

    def available(self) -> bool:
        """Whether it is installed here, with enough cores."""
        if self.cores > len(os.sched_getaffinity(0)):
            return False
        if self.program and not shutil.which(self.program):
            return False
        packages = PEERS.parent.parent.glob(f"lib/python*/site-packages/{self.package}")
        return not self.package or any(packages)

    def command(self, *arguments: str) -> list[str]:
        """The command line."""
        python = str(PEERS) if self.package else sys.executable
        command = [python, str(HERE / self.script), *arguments, *self.options]
        if self.threads:
            command += ["--threads", str(self.threads)]
        return [*mpirun(self.ranks), *command] if self.ranks > 1 else command


def _competitors() -> list[Competitor]:
    """All of them; the first FEniCSx script is the reference for tip deflections."""
    found = [
        Competitor("fenicsx-lu", "fenicsx_newton.py", ("--method", "lu")),
        Competitor("fenicsx-cholesky", "fenicsx_newton.py", ("--method", "cholesky")),
        Competitor("fenicsx-lagged", "fenicsx_newton.py", ("--method", "lagged")),
        Competitor("fenicsx-chord", "fenicsx_newton.py", ("--method", "chord")),
        Competitor("fenicsx-cholesky-2", "fenicsx_newton.py", ("--method", "cholesky"), ranks=2),
        Competitor("fenicsx-lagged-2", "fenicsx_newton.py", ("--method", "lagged"), ranks=2),
        Competitor("ours-hybrid", "ours.py"),
        Competitor("ours-hybrid-default", "ours.py", ("--tolerance", "1e-12")),
        Competitor("ours-clamped", "ours.py", ("--model", "clamped")),
        Competitor("ours-turning", "ours.py", ("--model", "turning")),
        Competitor("ours-iterative", "ours.py", ("--linear-solver", "iterative")),
        Competitor("ours-refactored", "ours.py", ("--linear-solver", "lu")),
        Competitor("ours-hybrid-2", "ours.py", ranks=2),
        Competitor("ours-iterative-2", "ours.py", ("--linear-solver", "iterative"), ranks=2),
    ]
    for threads in (1, 2):
        tail = "" if threads == 1 else f"-{threads}"
        found += [
            Competitor(f"calculix{tail}", "calculix.py", threads=threads, program="ccx"),
            Competitor(f"ngsolve{tail}", "ngsolve_newton.py", threads=threads, package="ngsolve"),
            Competitor(
                f"kratos{tail}",
                "kratos.py",
                threads=threads,
                package="KratosMultiphysics",
                most_unknowns=100_000,
            ),
        ]
    return found


COMPETITORS = {c.name: c for c in _competitors()}

SETS = {
    "growth": ("ours-hybrid", "ours-iterative", "ours-hybrid-2"),
    "large": ("ours-iterative",),
    "soft": ("fenicsx-cholesky", "ours-hybrid", "ours-refactored"),
}
"""Who runs in the parts other than "compare", where all do."""


def mpirun(ranks: int) -> list[str]:
    """The start of a command on several ranks, with the mpirun that belongs to this Python."""
    beside = Path(sys._base_executable).parent / "mpirun"
    return [str(beside) if beside.exists() else "mpirun", "-n", str(ranks)]


def environment() -> dict[str, str]:
    """Environment of all children: one BLAS thread, no trace of an mpirun around us."""
    ours = ("OMPI_COMM", "OMPI_UNIVERSE", "PMIX_", "PMI_", "PRTE_", "HYDRA_", "MPI_LOCAL")
    found = {k: v for k, v in os.environ.items() if not k.startswith(ours)}
    found |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    defaults = {
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
    }
    return {**defaults, **found}


def run(command: list[str], limit: float) -> str:
    """Run a child; returns the reason of a failure, "" if there is none."""
    try:
        done = subprocess.run(
            command, env=environment(), capture_output=True, text=True, timeout=limit
        )
    except subprocess.TimeoutExpired:
        return f"not done after {limit:.0f} s"
    if not done.returncode:
        return ""
    lines = [x for x in f"{done.stdout}\n{done.stderr}".splitlines() if x.strip(" -=")]
    words = [x for x in lines if "Error" in x] or lines or ["no message"]
    return f"{words[-1]} (code {done.returncode})"
