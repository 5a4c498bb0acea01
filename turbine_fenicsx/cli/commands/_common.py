"""Exit codes, case arguments and errors of several commands."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from typing import Any

OK, WRONG_INPUT, NOT_CONVERGED, UNBALANCED, INTERRUPTED = 0, 2, 3, 4, 130


def add_case(parser: argparse.ArgumentParser) -> None:
    """Arguments of a command that reads a case."""
    parser.add_argument("case", metavar="CASE", help="case file (TOML)")
    add_overrides(parser)


def add_overrides(
    parser: argparse.ArgumentParser, example: str = "time.end=1.0 time.step=0.01"
) -> None:
    """The argument that changes keys of a case, with changes for its help."""
    parser.add_argument(
        "--set",
        dest="overrides",
        metavar="KEY=VALUE",
        nargs="+",
        action="extend",
        default=[],
        help=f"change keys of the case, for example --set {example}",
    )


def add_force(parser: argparse.ArgumentParser) -> None:
    """The argument that continues where the memory seems too small."""
    parser.add_argument(
        "--force", action="store_true", help="continue even if the memory seems too small"
    )


def add_progress(parser: argparse.ArgumentParser) -> None:
    """The arguments that choose what is printed during and after a run."""
    parser.add_argument(
        "--progress", choices=("auto", "bar", "log", "none"), default="auto", help="on stderr"
    )
    parser.add_argument(
        "--quiet", action="store_true", help="neither progress nor table; errors are printed"
    )


def load_case(options: argparse.Namespace, comm: Any) -> Any:
    """Read the case on rank 0 for all."""
    from turbine_fenicsx.foundation.parallel import on_rank0
    from turbine_fenicsx.turbine.case.case import Case

    case = on_rank0(comm, lambda: Case.load(options.case, options.overrides))
    warn(comm, on_rank0(comm, lambda: case.warnings))
    return case


def warn(comm: Any, sentences: Iterable[str]) -> None:
    """Print warnings on one rank."""
    if comm.rank == 0:
        print(*(f"warning: {w}\n" for w in sentences), sep="", end="", file=sys.stderr, flush=True)


def need_dolfinx() -> None:
    """Say in one sentence how to get DOLFINx if it is missing."""
    try:
        import dolfinx  # noqa: F401
    except ImportError as error:
        from turbine_fenicsx.foundation.errors import InputError
        from turbine_fenicsx.foundation.versions import how_to_install

        raise InputError(how_to_install(error)) from None


def fail(comm: Any, message: str, code: int) -> int:
    """Print an error once and return the exit code; without MPI ``comm`` is None."""
    if comm is None or comm.rank == 0:
        red, plain = ("\033[31m", "\033[0m") if sys.stderr.isatty() else ("", "")
        lines = "\n".join(f"error: {line}" for line in message.splitlines())
        print(f"{red}{lines}{plain}", file=sys.stderr)
        sys.stderr.flush()
    if comm is not None:
        comm.Barrier()
    return code
