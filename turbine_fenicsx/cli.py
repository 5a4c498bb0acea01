"""Command line: ``turbine-fenicsx run | mesh | check | info``.

Exit codes: 0 done, 2 wrong input, 3 a step did not converge, 130 interrupted.
"""

from __future__ import annotations

import argparse
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any

OK, WRONG_INPUT, NOT_CONVERGED, INTERRUPTED = 0, 2, 3, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: Arguments without the program name; those of the process if None. Whatever
            follows ``--`` goes to PETSc.

    Returns:
        The exit code.
    """
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # one thread a rank; read when numpy is imported
    mine, petsc_options = _split(list(sys.argv[1:] if arguments is None else arguments))
    options = _parser().parse_args(mine)
    import petsc4py

    if petsc_options:
        petsc_options.append("-options_left")
    petsc4py.init(["turbine-fenicsx", *petsc_options])
    from mpi4py import MPI

    from turbine_fenicsx.errors import InputError

    comm = MPI.COMM_WORLD
    if comm.size > 1:
        sys.excepthook = _abort_all
    try:
        command: Callable[[argparse.Namespace, Any], int] = options.command
        return command(options, comm)
    except InputError as error:
        return _fail(comm, str(error), WRONG_INPUT)
    except KeyboardInterrupt:
        return _fail(comm, "interrupted; what was written so far is complete", INTERRUPTED)


def run(options: argparse.Namespace, comm: Any) -> int:
    """Run a case."""
    case = _load_case(options, comm)
    _need_dolfinx()
    from turbine_fenicsx.parallel import on_rank0
    from turbine_fenicsx.solver import StepFailure
    from turbine_fenicsx.turbine.run import run_case
    from turbine_fenicsx.turbine.summary import table

    try:
        result = run_case(case, options.out, comm, options.progress)
    except StepFailure as failure:
        return _fail(comm, f"{failure}. Results up to there are in {options.out}", NOT_CONVERGED)
    pictures = on_rank0(comm, lambda: _picture(options.out))
    if comm.rank == 0:
        names = ["history.csv", "summary.json", *pictures]
        if case.output.fields_every > 0.0:
            names.insert(1, "fields.xdmf")
        print(f"{case.title or 'turbine'}, {comm.size} rank{'s' * (comm.size > 1)}")
        print(table(result))
        print(f"  {'results':<22}{options.out}/: {', '.join(names)}", flush=True)
    return OK


def mesh(options: argparse.Namespace, comm: Any) -> int:
    """Write the blade mesh of a case."""
    case = _load_case(options, comm)
    from turbine_fenicsx.errors import InputError
    from turbine_fenicsx.meshing import build_rotor
    from turbine_fenicsx.parallel import on_rank0
    from turbine_fenicsx.turbine.model import blade_geometry, mesh_options, rotor_layout

    try:
        report = on_rank0(
            comm,
            lambda: build_rotor(
                blade_geometry(case), rotor_layout(case), mesh_options(case), options.out
            ),
        )
    except (ValueError, OSError) as error:
        raise InputError(str(error)) from None
    if comm.rank == 0:
        print(f"{options.out}\n{report}", flush=True)
    return OK


def check(options: argparse.Namespace, comm: Any) -> int:
    """Check a case and its mesh without running it."""
    case = _load_case(options, comm)
    _need_dolfinx()
    from turbine_fenicsx.turbine.model import blade_geometry, load_mesh

    blade_geometry(case)
    report = "rigid turbine, no mesh"
    if case.turbine.model == "hybrid":
        report = str(load_mesh(case, comm).report)
    if comm.rank == 0:
        print(f"{options.case}: valid\n{report}", flush=True)
    return OK


def info(options: argparse.Namespace, comm: Any) -> int:
    """Print versions."""
    _need_dolfinx()
    from turbine_fenicsx.turbine.summary import versions

    if comm.rank == 0:
        for name, number in versions().items():
            print(f"{name:<18}{number}")
    return OK


def _parser() -> argparse.ArgumentParser:
    """The parser of all commands."""
    parser = argparse.ArgumentParser(
        prog="turbine-fenicsx",
        description="Energy-momentum dynamics of wind turbines with flexible blades.",
        epilog="Options for PETSc follow after --, for example: -- -tfx_snes_monitor",
        allow_abbrev=False,
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def add(name: str, function: Callable[..., int], text: str) -> argparse.ArgumentParser:
        command = commands.add_parser(name, help=text, description=text, allow_abbrev=False)
        command.set_defaults(command=function)
        return command

    def add_case(command: argparse.ArgumentParser) -> None:
        command.add_argument("case", metavar="CASE", help="case file (TOML)")
        command.add_argument(
            "--set",
            dest="overrides",
            metavar="KEY=VALUE",
            nargs="+",
            action="extend",
            default=[],
            help="change keys of the case, for example --set time.end=1.0 time.step=0.01",
        )

    command = add("run", run, "Run a case.")
    add_case(command)
    command.add_argument("-o", "--out", metavar="OUT", required=True, help="output folder")
    command.add_argument(
        "--progress", choices=("auto", "bar", "log", "none"), default="auto", help="on stderr"
    )
    command = add("mesh", mesh, "Write the blade mesh of a case as a .msh file.")
    add_case(command)
    command.add_argument("-o", "--out", metavar="FILE", required=True, help="mesh file (.msh)")
    add_case(add("check", check, "Check a case and its mesh without running it."))
    add("info", info, "Print the versions of everything that matters.")
    return parser


def _split(arguments: list[str]) -> tuple[list[str], list[str]]:
    """Own arguments, and those after ``--`` for PETSc."""
    if "--" not in arguments:
        return arguments, []
    at = arguments.index("--")
    return arguments[:at], arguments[at + 1 :]


def _load_case(options: argparse.Namespace, comm: Any) -> Any:
    """Read the case on rank 0 for all."""
    from turbine_fenicsx.parallel import on_rank0
    from turbine_fenicsx.turbine.case import Case

    return on_rank0(comm, lambda: Case.load(options.case, options.overrides))


def _need_dolfinx() -> None:
    """Say in one sentence how to get DOLFINx if it is missing."""
    try:
        import dolfinx  # noqa: F401
    except ImportError:
        from turbine_fenicsx.errors import InputError

        raise InputError(
            f"DOLFINx is not installed for {sys.executable}; run `make setup` in the project and "
            "use .venv/bin/turbine-fenicsx"
        ) from None


def _picture(out: str) -> list[str]:
    """Draw energies and angles; without matplotlib say so."""
    try:
        from turbine_fenicsx.plots import plot_summary

        plot_summary(f"{out}/history.csv", f"{out}/history.png")
    except ImportError:
        print("no picture: matplotlib is not installed", file=sys.stderr)
        return []
    return ["history.png"]


def _fail(comm: Any, message: str, code: int) -> int:
    """Print an error once and return the exit code."""
    if comm.rank == 0:
        print("\n".join(f"error: {line}" for line in message.splitlines()), file=sys.stderr)
        sys.stderr.flush()
    comm.Barrier()
    return code


def _abort_all(
    kind: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    """An unexpected error on one rank ends all, instead of leaving them waiting."""
    from mpi4py import MPI

    traceback.print_exception(kind, error, trace)
    sys.stderr.flush()
    MPI.COMM_WORLD.Abort(1)


if __name__ == "__main__":
    sys.exit(main())
