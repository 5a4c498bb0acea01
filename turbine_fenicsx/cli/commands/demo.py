"""List the demo cases, or write one as a case file to start from.

Without NAME it lists them. An existing file is not overwritten.
"""

from __future__ import annotations

import argparse
import shlex
import tomllib
from pathlib import Path
from typing import Any

from turbine_fenicsx.cli.commands._common import OK

alone = True

CASES = Path(__file__).parents[2] / "demos"
"""In a checkout they are links to the folder demos at its top level."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("name", metavar="NAME", nargs="?", help="name of the demo case")
    parser.add_argument("-o", "--out", metavar="FILE", help="case file; default: NAME.toml")


def run(options: argparse.Namespace, comm: Any) -> int:
    """List the cases or write one, on one rank."""

    def work() -> str:
        return _list() if options.name is None else _write(options.name, options.out)

    if comm is None:
        text = work()
    else:
        from turbine_fenicsx.foundation.parallel import on_rank0

        text = on_rank0(comm, work)
    if comm is None or comm.rank == 0:
        print(text, flush=True)
    return OK


def _list() -> str:
    """Name and title of every case."""
    files = sorted(CASES.glob("*.toml"))
    titles = {f.stem: tomllib.loads(f.read_text(encoding="utf-8"))["title"] for f in files}
    return "\n".join(f"{name:<20}{title}" for name, title in titles.items())


def _write(name: str, out: str | None) -> str:
    """Write a case; returns what to do next."""
    from turbine_fenicsx.foundation.errors import InputError

    known = {file.stem: file for file in sorted(CASES.glob("*.toml"))}
    if name not in known:
        raise InputError(f"there is no demo case {name!r}; choose from {', '.join(known)}")
    path = Path(out or f"{name}.toml")
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(known[name].read_text(encoding="utf-8"))
    except FileExistsError:
        raise InputError(f"{str(path)!r} exists; give another file with -o") from None
    except OSError as error:
        raise InputError(f"cannot write {str(path)!r}: {error.strerror}") from None
    return f"wrote {path}; now: turbine-fenicsx run {shlex.quote(str(path))} -o out/{name}"
