"""Pictures and movies of the whole turbine, drawn from its fields alone.

Drawing needs PyVista and a graphics library. Where that library is missing, VTK ends the process
instead of raising, so that `turbine_fenicsx.postprocessing.scene` draws in a child process.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.mpi_environment import environment_without_mpi
from turbine_fenicsx.postprocessing import scene
from turbine_fenicsx.postprocessing.camera import VIEWS
from turbine_fenicsx.postprocessing.colours import DEFAULT_FIELD
from turbine_fenicsx.records.output_folder import read_field_parts, read_field_times

SIZE = (1440, 1200)
"""Width and height of pictures, which a turbine and its legend fill."""

_MOST_FRAMES_PER_SECOND = 60.0


@dataclass(frozen=True)
class Look:
    """How a model is drawn.

    Args:
        scalar: Point or cell field that colours it; of a vector its length. `DEFAULT_FIELD` is
            stress, or the deflection where there is none. With None parts are plain, as rigid ones
            always are under stress.
        scale: Factor of the deformation of flexible parts relative to what carries them.
        view: One of `turbine_fenicsx.postprocessing.camera.VIEWS`.
        limits: Values at the ends of the colours, in the units of the legend; None takes zero and
            what 99 % of all values are below that are drawn together, for stress body by body.
        size: Width and height in pixels; movies need even numbers.
        coloured: Names of the parts or bodies that have colours, with ``*`` for any letters; none
            for all that have the field.
        smooth: Whether fields of cells are averaged at the points.
        edges: Whether the edges of the mesh are drawn.
        title: Words beside the time; none if empty.
    """

    scalar: str | None = DEFAULT_FIELD
    scale: float = 1.0
    view: str = "oblique"
    limits: tuple[float, float] | None = None
    size: tuple[int, int] = SIZE
    coloured: tuple[str, ...] = ()
    smooth: bool = True
    edges: bool = False
    title: str = ""


def render_turbine(
    fields: str | os.PathLike[str],
    png: str | os.PathLike[str],
    time: float | None = None,
    look: Look = Look(),
) -> Path:
    """Draw the turbine at one time.

    Args:
        time: Time [s], the nearest one written is drawn; the last one if None.
    """
    times = read_field_times(fields)
    step = len(times) - 1 if time is None else find_nearest_step(times, time)
    draw_scene(fields, [(step, os.fspath(png))], None, look)
    return Path(png)


def render_times(
    fields: str | os.PathLike[str],
    folder: str | os.PathLike[str],
    times: Sequence[float] | None = None,
    look: Look = Look(),
    done: Callable[[], object] = lambda: None,
) -> list[Path]:
    """Draw the turbine at several times, all on the same scale of colours.

    Args:
        fields: Field output of a run.
        folder: Where to write ``turbine_t5.png``, named after the nearest time written.
        times: Times [s]; the last one if None.
        look: How it is drawn.
        done: Called after each picture.

    Returns:
        The pictures; one for times with the same nearest time.

    Raises:
        InputError: if a time is outside of the run or the pictures cannot be drawn.
    """
    written = read_field_times(fields)
    steps = [find_nearest_step(written, t) for t in (written[-1:] if times is None else times)]
    pictures = {step: Path(folder) / f"turbine_t{written[step]:.6g}.png" for step in steps}
    draw_scene(fields, [(i, str(path)) for i, path in pictures.items()], None, look, done)
    return list(pictures.values())


def render_hot_spot(
    fields: str | os.PathLike[str],
    png: str | os.PathLike[str],
    time: float | None = None,
    field: str = "tsai_wu",
    title: str = "",
    size: tuple[int, int] = (1600, 900),
) -> Path:
    """Draw the flexible part in which a field of cells is largest, whole and from near by.

    Args:
        fields: Field output of a run.
        png: The picture.
        time: Time [s], the nearest one written is drawn; the last one if None.
        field: The field.
        title: Lines above the picture.
        size: Width and height in pixels.

    Raises:
        InputError: if it cannot be drawn.
    """
    times = read_field_times(fields)
    step = len(times) - 1 if time is None else find_nearest_step(times, time)
    look = Look(field, size=size, title=title)
    draw_scene(fields, [(step, os.fspath(png))], None, look, hot_spot=True)
    return Path(png)


def choose_movie_steps(times: Sequence[float], speed: float) -> tuple[list[int], float]:
    """Which times a movie shows, and how many frames per second.

    Args:
        times: Times written [s].
        speed: Simulated seconds in a second of the movie.
    """
    if len(times) < 2:
        raise InputError("a movie needs fields at two times or more; set output.fields_every")
    rate = speed * (len(times) - 1) / (times[-1] - times[0])
    stride = max(1, int(np.ceil(rate / _MOST_FRAMES_PER_SECOND - 1e-9)))
    return list(range(0, len(times), stride)), rate / stride


def render_movie(
    fields: str | os.PathLike[str],
    mp4: str | os.PathLike[str],
    speed: float = 1.0,
    look: Look = Look(),
    done: Callable[[], object] = lambda: None,
) -> Path:
    """Make a movie of all times written.

    Args:
        speed: Simulated seconds in a second of the movie.
    """
    steps, rate = choose_movie_steps(list(read_field_times(fields)), speed)
    draw_scene(fields, [], {"path": os.fspath(mp4), "fps": rate, "steps": steps}, look, done)
    return Path(mp4)


def find_nearest_step(times: Any, wanted: float) -> int:
    """Number of the time written that is nearest to a wanted one [s].

    Raises:
        InputError: if it is outside of the run.
    """
    slack = 1e-6 * max(abs(times[-1]), 1e-3)
    if not times[0] - slack <= wanted <= times[-1] + slack:
        raise InputError(
            f"t = {wanted:g} s is outside of the run, whose fields are from {times[0]:g} s to "
            f"{times[-1]:g} s"
        )
    return int(np.abs(times - wanted).argmin())


def draw_scene(
    fields: str | os.PathLike[str],
    pictures: Sequence[tuple[int, str]],
    movie: dict[str, Any] | None,
    look: Look,
    done: Callable[[], object] = lambda: None,
    titles: Sequence[str] = (),
    hot_spot: bool = False,
) -> None:
    """Let the child process draw.

    Args:
        movie: File, frames per second and steps of a movie, of modes also phases; None for none.
        titles: What each step is called if they are modes.
        hot_spot: Whether the pictures show where the field is largest.
    """
    if look.view not in VIEWS:
        raise InputError(f"there is no view {look.view!r}, but {', '.join(VIEWS)}")
    job = {
        "fields": os.fspath(fields),
        "parts": read_field_parts(fields).to_text(),
        "pictures": list(pictures),
        "movie": movie,
        "titles": list(titles),
        "hot_spot": hot_spot,
    }
    env = environment_without_mpi()
    package = str(Path(scene.__file__).parents[1])
    env["PYTHONPATH"] = os.pathsep.join(filter(None, [env.get("PYTHONPATH"), package]))
    # files, since writing to a pipe whose reader has died raises a signal that PETSc does not like
    with tempfile.TemporaryFile("w+") as order, tempfile.TemporaryFile("w+") as complaints:
        json.dump(job | asdict(look), order)
        order.seek(0)
        child = subprocess.Popen(
            [sys.executable, "-P", "-m", scene.__name__],
            env=env,
            stdin=order,
            stdout=subprocess.PIPE,
            stderr=complaints,
            text=True,
        )
        with child:
            assert child.stdout is not None
            for _ in child.stdout:
                done()
        code = child.returncode
        complaints.seek(0)
        lines = complaints.read().strip().splitlines() or [f"exit code {code}"]
    target = pictures[0][1] if pictures else str(movie and movie["path"])
    if code < 0:
        raise InputError(
            f"cannot draw {target}: PyVista ended with signal {-code}, probably because there is "
            "no graphics library (on Debian: apt install libegl1) and no display either"
        )
    if code > 0:
        raise InputError(f"cannot draw {target}: {lines[-1]}")
