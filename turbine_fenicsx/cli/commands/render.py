"""Draw pictures of a model, or a movie, coloured by stress.

Everything is where fields.xdmf has it; a turbine whose tower is no part of the model gets a pale
one. All pictures of one call share their scales of colours, see --range. --scale S exaggerates the
deformation: of each blade relative to the hub or the ring that carries its root, of the tower
relative to the ground, with nacelle and rotor riding on it; turning, yaw and pitch stay as they
are. Rigid parts are never deformed. No display is needed.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from turbine_fenicsx.cli.commands._common import OK


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("folder", metavar="OUT", help="output folder")
    parser.add_argument(
        "--times",
        metavar="T,T,...",
        help="draw turbine_tT.png at these times in s, for example 0,5,9,12; the nearest ones "
        "written are taken; default: the last one, unless there is a movie",
    )
    parser.add_argument("--movie", metavar="FILE", help="make a movie (.mp4) of all times written")
    parser.add_argument(
        "-o", "--out", metavar="FOLDER", help="where pictures go; default: the output folder"
    )
    parser.add_argument(
        "--scale", metavar="S", type=float, default=1.0, help="factor of the deformation"
    )
    parser.add_argument(
        "--view",
        choices=("oblique", "front", "side"),
        default="oblique",
        help="where to look from; default: oblique",
    )
    colours = parser.add_mutually_exclusive_group()
    colours.add_argument(
        "--field",
        metavar="NAME",
        default="von_mises_stress",
        help="field that gives the colours: von_mises_stress (default), cauchy_stress_norm, "
        "displacement, velocity",
    )
    colours.add_argument("--plain", action="store_true", help="no field, each part in one colour")
    parser.add_argument(
        "--parts",
        metavar="NAME,NAME,...",
        help="what has these colours, for example blades or 'blade_*' or tower; default: all that "
        "has the field",
    )
    parser.add_argument(
        "--range",
        metavar="LOW,HIGH",
        help="ends of the scale of colours in the units of its legend (MPa, m, m/s); default: 0 "
        "and what 99 %% of the values drawn are below, for stress blades and tower apart",
    )
    parser.add_argument(
        "--cells", action="store_true", help="one value a cell instead of averages at its corners"
    )
    parser.add_argument("--edges", action="store_true", help="show the edges of the mesh")
    parser.add_argument(
        "--size",
        metavar="WxH",
        default="1920x1080",
        help="width and height in pixels; default: 1920x1080",
    )
    parser.add_argument(
        "--speed",
        metavar="X",
        type=float,
        default=1.0,
        help="simulated seconds in a second of the movie; default: 1",
    )


def run(options: argparse.Namespace, comm: Any) -> int:
    """Draw and print the paths of the pictures."""
    from turbine_fenicsx.foundation.parallel import on_rank0

    on_rank0(comm, lambda: _render(options))
    return OK


def _render(options: argparse.Namespace) -> None:
    """Draw all there is to draw."""
    from turbine_fenicsx.cli.commands._frames import Frames
    from turbine_fenicsx.cli.commands._numbers import numbers
    from turbine_fenicsx.foundation.errors import InputError
    from turbine_fenicsx.postprocessing.output_folder import field_times, need_folder, target_folder
    from turbine_fenicsx.postprocessing.pictures import (
        Look,
        movie_steps,
        render_movie,
        render_times,
    )

    folder = need_folder(options.folder)
    times = None if options.times is None else numbers("--times", options.times)
    limits = None if options.range is None else numbers("--range", options.range)
    if limits is not None and (len(limits) != 2 or limits[0] >= limits[1]):
        raise InputError(f"--range {options.range}: give a low and a higher number")
    for name in ("scale", "speed"):
        value = getattr(options, name)
        if not 0.0 <= value < float("inf") or (name == "speed" and value == 0.0):
            raise InputError(f"--{name} {value:g}: must be a positive number")
    if options.movie is not None and Path(options.movie).suffix != ".mp4":
        raise InputError(f"--movie {options.movie}: the name of a movie ends in .mp4")
    look = Look(
        None if options.plain else options.field,
        options.scale,
        options.view,
        None if limits is None else (limits[0], limits[1]),
        _size(options.size, options.movie is not None),
        tuple(filter(None, (options.parts or "").split(","))),
        not options.cells,
        options.edges,
    )
    fields = folder / "fields.xdmf"
    written = field_times(fields)
    if times is not None or options.movie is None:
        out = target_folder(options.out or folder)
        with Frames(len(times) if times else 1) as frames:
            paths = render_times(fields, out, times, look, frames.count)
        print(*paths, sep="\n", flush=True)
    if options.movie is not None:
        target_folder(Path(options.movie).parent)
        if Path(options.movie).is_dir():
            raise InputError(f"cannot write {options.movie!r}: it is a folder")
        n_frames = len(movie_steps(list(written), options.speed)[0])
        with Frames(n_frames) as frames:
            path = render_movie(fields, options.movie, options.speed, look, frames.count)
        print(path, flush=True)


def _size(text: str, movie: bool) -> tuple[int, int]:
    """Width and height of a picture in pixels.

    Raises:
        InputError: if they are none, or odd for a movie.
    """
    from turbine_fenicsx.foundation.errors import InputError

    width, _, height = text.lower().partition("x")
    numbers = [int(n) for n in (width, height) if n.isdecimal()]
    if len(numbers) < 2 or not all(100 <= n <= 10_000 for n in numbers):
        raise InputError(f"--size {text}: give width x height from 100x100 to 10000x10000 pixels")
    if movie and any(n % 2 for n in numbers):
        raise InputError(f"--size {text}: the numbers must be even for a movie")
    return numbers[0], numbers[1]
