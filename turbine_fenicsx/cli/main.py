"""Command line: ``turbine-fenicsx COMMAND ...``, see `turbine_fenicsx.cli.commands`.

Exit codes: 0 done, 2 wrong input, 3 a step did not converge, 4 the energy balance is wrong,
130 interrupted.
"""

from __future__ import annotations

import argparse
import atexit
import gc
import importlib
import io
import logging
import os
import pkgutil
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from turbine_fenicsx.cli import commands
from turbine_fenicsx.cli.commands._common import INTERRUPTED, OK, WRONG_INPUT, fail
from turbine_fenicsx.foundation.interrupts import SIGNALS, end_quietly


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: Arguments without the program name; those of the process if None. Arguments after
    """
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # one thread per rank; read when numpy is imported
    logging.basicConfig(format="%(levelname)s: %(message)s")  # before FFCx does it otherwise
    gc.set_threshold(10_000)  # imports make many objects and no garbage: search them rarely
    atexit.register(gc.freeze)  # and not once more when the process ends
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # titles that the locale cannot show
            stream.reconfigure(errors="backslashreplace")
    from turbine_fenicsx.foundation.errors import CompilationError, FileError, InputError

    comm = None
    try:
        with end_quietly():
            mine, petsc_options = _split(list(sys.argv[1:] if arguments is None else arguments))
            _check(mine + petsc_options)
            options = _make_parser().parse_args(mine)
            comm = _start(petsc_options, options.alone)
            command: Callable[[argparse.Namespace, Any], int] = options.command
            with _warnings_on_stderr():
                return command(options, comm)
    except (InputError, CompilationError, FileError) as error:
        return fail(comm, str(error), WRONG_INPUT)
    except BrokenPipeError:  # as in `turbine-fenicsx ... | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return OK
    except KeyboardInterrupt:
        return fail(comm, "interrupted; what was written so far is complete", INTERRUPTED)


def _make_parser() -> argparse.ArgumentParser:
    """The parser of all commands."""
    parser = argparse.ArgumentParser(
        prog="turbine-fenicsx",
        description="Energy-momentum dynamics of wind turbines with flexible blades.",
        epilog="Options for PETSc follow after --, for example: -- -tfx_snes_monitor",
        allow_abbrev=False,
    )
    parsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for name in sorted(m.name for m in pkgutil.iter_modules(commands.__path__)):
        if name.startswith("_"):
            continue
        module = importlib.import_module(f"{commands.__name__}.{name}")
        summary = str(module.__doc__).splitlines()[0]
        command = parsers.add_parser(
            name, help=summary, description=module.__doc__, allow_abbrev=False
        )
        module.arguments(command)
        command.set_defaults(command=module.run, alone=getattr(module, "alone", False))
    return parser


def _check(arguments: list[str]) -> None:
    """Refuse what no argument can be."""
    from turbine_fenicsx.foundation.errors import InputError

    for argument in arguments:
        if not argument.removeprefix("--out=").removeprefix("-o="):
            raise InputError("an argument is empty; is a variable of the shell not set?")
        try:
            argument.encode()
        except UnicodeEncodeError:
            encoding = sys.getfilesystemencoding()
            raise InputError(f"the argument {argument!a} is no text in {encoding}") from None


def _start(petsc_options: list[str], alone: bool) -> Any:
    """Start PETSc and MPI.

    Returns:
        The communicator of all ranks; None where there is no MPI.
    """
    from turbine_fenicsx.foundation.errors import InputError
    from turbine_fenicsx.foundation.mpi_environment import start_mpi_alone

    try:
        import petsc4py

        if petsc_options:
            petsc_options.append("-options_left")
        with start_mpi_alone():
            # a .petscrc in some folder could load libraries; who wants it says -options_file
            petsc4py.init(["turbine-fenicsx", "-skip_petscrc", *petsc_options])
            from mpi4py import MPI
    except ImportError as error:
        if alone:
            return None
        from turbine_fenicsx.foundation.versions import how_to_install

        raise InputError(how_to_install(error)) from None
    except RuntimeError as error:  # PETSc has no other word for a file that it cannot read
        given = " ".join(petsc_options)
        raise InputError(f"PETSc does not start with the options '{given}': {error}") from None
    for number in SIGNALS:  # PETSc puts its own handlers in the place of some
        signal.signal(number, signal.getsignal(number))
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)  # PETSc would abort where a reader has left
    from turbine_fenicsx.foundation.own_code import end_all_on_error

    end_all_on_error(MPI.COMM_WORLD)
    return MPI.COMM_WORLD


def _split(arguments: list[str]) -> tuple[list[str], list[str]]:
    """Own arguments, and those after ``--`` for PETSc."""
    if "--" not in arguments:
        return arguments, []
    at = arguments.index("--")
    return arguments[:at], arguments[at + 1 :]


@contextmanager
def _warnings_on_stderr() -> Iterator[None]:
    """Print what the package warns of while a command runs; only one rank logs each warning."""
    from turbine_fenicsx.foundation.errors import ModelWarning

    logger, handler = logging.getLogger("turbine_fenicsx"), logging.StreamHandler(sys.stderr)
    handler.setLevel(logging.WARNING)
    handler.setFormatter(logging.Formatter("warning: %(message)s"))
    logger.addHandler(handler)
    logger.propagate = False  # or the handler of everybody's messages says it again
    try:
        with warnings.catch_warnings():  # what is wrong with the balance is an error here
            warnings.filterwarnings("ignore", "the energy balance", ModelWarning)
            yield
    finally:
        logger.propagate = True
        logger.removeHandler(handler)
