"""Print the versions of everything that matters."""

from __future__ import annotations

import argparse
from typing import Any

from turbine_fenicsx.cli.commands._common import OK

alone = True


def arguments(parser: argparse.ArgumentParser) -> None:
    """No arguments."""


def run(options: argparse.Namespace, comm: Any) -> int:
    """Print the versions, and where DOLFINx is or how to get it."""
    from turbine_fenicsx.foundation.versions import dolfinx_folder, how_to_install, list_versions

    if comm is not None and comm.rank != 0:
        return OK
    for name, number in list_versions().items():
        print(f"{name:<21}{number}")
    try:
        import dolfinx  # noqa: F401
    except ImportError as error:
        print(how_to_install(error))
    else:
        print(f"{'dolfinx':<21}{dolfinx_folder()}")
    return OK
