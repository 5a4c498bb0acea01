"""Pictures of the shapes of modes, one by one and all together, and movies of their motion."""

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import read_regular
from turbine_fenicsx.postprocessing.field_reader import AMPLITUDE
from turbine_fenicsx.postprocessing.pictures import Look, draw_scene
from turbine_fenicsx.records.mode_tables import TITLES
from turbine_fenicsx.records.output_folder import read_field_times

LOOK = Look(AMPLITUDE, view="corner", limits=(0.0, 1.0), size=(1000, 1200))
"""How modes are drawn: those parts are red that move most."""

_CYCLES, _FRAMES, _RATE = 3, 40, 25.0
"""Cycles of a movie, its frames in each, and in a second."""

_TILE, _COLUMNS = (400, 480), 4
"""Largest width and height of a mode on a sheet [pixels], and how many stand side by side."""


def read_mode_titles(path: str | os.PathLike[str]) -> list[str]:
    """Titles of the modes in ``modes.xdmf``, in their order."""
    n = len(read_field_times(path))
    for item in ElementTree.fromstring(read_regular(path)).iter("Information"):
        if item.get("Name") == TITLES:
            titles = [str(title) for title in json.loads(item.attrib["Value"])]
            return titles[:n]
    raise InputError(f"{os.fspath(path)!r} does not hold modes")


def render_modes(
    path: str | os.PathLike[str],
    folder: str | os.PathLike[str],
    numbers: Sequence[int] | None = None,
    look: Look = LOOK,
    done: Callable[[], object] = lambda: None,
) -> list[Path]:
    """Draw the shapes of modes, the shape at rest beside them in grey.

    Args:
        folder: Where to write ``mode_1.png`` and so on, and of several modes ``modes.png``, a sheet
            of all of them.
        numbers: Numbers of the modes from 1; all if None.
    """
    titles = read_mode_titles(path)
    steps = [find_step(n, titles) for n in numbers or range(1, len(titles) + 1)]
    pictures = {step: Path(folder) / f"mode_{step + 1}.png" for step in steps}
    jobs = [(step, str(file)) for step, file in pictures.items()]
    draw_scene(path, jobs, None, look, done, titles)
    files = list(pictures.values())
    return [*files, _compose_sheet(files, Path(folder) / "modes.png")] if len(files) > 1 else files


def render_mode_movie(
    path: str | os.PathLike[str],
    mp4: str | os.PathLike[str],
    number: int,
    look: Look = LOOK,
    done: Callable[[], object] = lambda: None,
) -> Path:
    """Make a movie of some cycles of a mode.

    Args:
        number: Number of the mode from 1.
    """
    titles = read_mode_titles(path)
    phases = 2.0 * np.pi * np.arange(count_movie_frames()) / _FRAMES
    movie = {
        "path": os.fspath(mp4),
        "fps": _RATE,
        "steps": [find_step(number, titles)] * len(phases),
        "phases": phases.tolist(),
    }
    draw_scene(path, [], movie, look, done, titles)
    return Path(mp4)


def count_movie_frames() -> int:
    """Number of frames of a movie of a mode."""
    return _CYCLES * _FRAMES


def find_step(number: int, titles: Sequence[str]) -> int:
    """Which time of the file a mode is."""
    if not 1 <= number <= len(titles):
        raise InputError(f"there is no mode {number}, they are numbered from 1 to {len(titles)}")
    return number - 1


def _compose_sheet(pictures: Sequence[Path], target: Path) -> Path:
    """Put pictures on one sheet."""
    from PIL import Image

    columns = min(_COLUMNS, len(pictures))
    rows = -(-len(pictures) // columns)
    with Image.open(pictures[0]) as first:
        small = first.convert("RGB")
        small.thumbnail(_TILE)
        width, height = small.size
    sheet = Image.new("RGB", (columns * width, rows * height), "white")
    for k, file in enumerate(pictures):
        with Image.open(file) as picture:
            small = picture.convert("RGB").resize((width, height), Image.Resampling.LANCZOS)
        sheet.paste(small, (k % columns * width, k // columns * height))
    sheet.save(target, dpi=(300, 300))
    return target
