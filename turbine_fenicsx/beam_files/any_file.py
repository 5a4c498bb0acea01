"""Files of beams of any code, which their names distinguish."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from turbine_fenicsx.beam_files import beamdyn, hawc2
from turbine_fenicsx.beam_files.beam_blade import BeamBlade

READERS: dict[str, Callable[[str], BeamBlade]] = {".htc": hawc2.read_hawc2}
"""Readers by the ending of the name; other files are those of BeamDyn."""


def read_beam(path: str | os.PathLike[str]) -> BeamBlade:
    """Read a primary file of BeamDyn, or the body ``blade1`` of an htc file of HAWC2.

    Raises:
        InputError: if something is missing or wrong.
        FileError: if a file cannot be read.
    """
    read = READERS.get(Path(path).suffix.lower(), beamdyn.read_beamdyn)
    return read(os.fspath(path))


def list_parts(path: str | os.PathLike[str]) -> list[str]:
    """Files that such a file names."""
    is_hawc2 = Path(path).suffix.lower() == ".htc"
    return hawc2.list_parts(path) if is_hawc2 else beamdyn.list_parts(path)
