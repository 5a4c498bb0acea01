"""Shared by `study` and `dlc`: arguments of commands that run many cases, several at a time."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from turbine_fenicsx.cli.commands._common import add_overrides, add_progress
from turbine_fenicsx.foundation.errors import InputError


def add_many_runs(parser: argparse.ArgumentParser, processes: str, listed: str) -> None:
    """Arguments besides the file.

    Args:
        processes: What `--processes` means.
        listed: What `--list` prints.
    """
    parser.add_argument(
        "-o", "--out", metavar="OUT", help="output folder, out/NAME for a file NAME.toml"
    )
    parser.add_argument("-j", "--processes", metavar="N", type=int, help=processes)
    parser.add_argument("--list", action="store_true", help=f"only list {listed}")
    parser.add_argument(
        "--overwrite", action="store_true", help="replace results of other cases in these folders"
    )
    add_overrides(parser)
    add_progress(parser)


def choose_folder(options: argparse.Namespace, file: str) -> Path:
    """Output folder of a file of many runs."""
    return Path(options.out or Path("out") / Path(file).stem)


def choose_processes(options: argparse.Namespace, runs: Any) -> Any:
    """A study or load set with the number of processes of the command line, if it has one."""
    if options.processes is None:
        return runs
    if options.processes < 1:
        raise InputError(f"--processes {options.processes}: must be at least 1")
    return runs.model_copy(update={"processes": options.processes})
