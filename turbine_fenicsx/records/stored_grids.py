"""Contents of an existing XDMF series, as far as its files are intact."""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from turbine_fenicsx.foundation.files import name_file_in_errors, read_regular

_GRID = re.compile(r'<Grid Name="mesh".*?</Grid>\n', re.DOTALL)


@dataclass(frozen=True)
class StoredGrid:
    """One time of a series.

    Attributes:
        time: The time [s].
        place: Number of the last of its files with numbers, and where its arrays end there [bytes].
    """

    time: float
    text: str
    place: tuple[int, int]


def read_grids(path: str | os.PathLike[str]) -> list[StoredGrid]:
    """The times of a series from its start to the first that is not whole.

    Args:
        path: The XDMF file; a missing one holds no times.
    """
    path = Path(path)
    if not path.exists():
        return []
    with name_file_in_errors("read", path):
        text = read_regular(path).decode("utf-8", "replace")
    sizes = {p.name: p.stat().st_size for p in path.parent.glob(f"{path.stem}*.bin") if p.is_file()}
    found: list[StoredGrid] = []
    for grid in _GRID.findall(text):
        try:
            stored = _parse(grid, path.stem, sizes)
        except (SyntaxError, ValueError, LookupError):  # as XML, as a number, as an attribute
            break
        found.append(stored)
    return found


def file_name(stem: str, number: int) -> str:
    """Name of a file with numbers: ``fields.bin``, ``fields.1.bin`` and so on."""
    return f"{stem}.{number}.bin" if number else f"{stem}.bin"


def _parse(text: str, stem: str, sizes: dict[str, int]) -> StoredGrid:
    """One grid."""
    node = ElementTree.fromstring(text)
    times = [float(time.attrib["Value"]) for time in node.iter("Time")]
    place = (0, 0)
    for item in node.iter("DataItem"):
        name = "".join(item.itertext()).strip()
        count = math.prod(int(n) for n in item.attrib["Dimensions"].split())
        end = int(item.attrib["Seek"]) + count * int(item.attrib["Precision"])
        number = 0 if name == file_name(stem, 0) else int(name.split(".")[-2])
        if sizes[name] < end:
            raise ValueError(f"{name} is too short")
        place = max(place, (number, end))
    return StoredGrid(times[0], text, place)
