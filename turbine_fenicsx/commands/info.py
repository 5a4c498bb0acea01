"""Print the versions of everything that matters."""

from __future__ import annotations

import argparse
from typing import Any

from turbine_fenicsx.commands._common import OK, need_dolfinx


def arguments(parser: argparse.ArgumentParser) -> None:
    """No arguments."""


def run(options: argparse.Namespace, comm: Any) -> int:
    """Print the versions."""
    need_dolfinx()
    from turbine_fenicsx.turbine.summary import versions

    if comm.rank == 0:
        for name, number in versions().items():
            print(f"{name:<18}{number}")
    return OK
