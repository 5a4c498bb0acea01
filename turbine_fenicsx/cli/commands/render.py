"""Draw pictures of a model, or a movie, coloured by stress; of modes their shapes.

Everything is where the fields of the run have it; a turbine whose tower is no part of the model
gets a pale one. All pictures of one call share their scales of colours, see --range. The option
--scale S exaggerates the deformation of each blade relative to the hub or ring that holds its root,
and of the tower relative to the ground, with nacelle and rotor riding on it. Turning, yaw and pitch
stay as they are. Rigid parts are never deformed. No display is needed.

If OUT holds modes, the pictures are mode_1.png and so on, and modes.png with all of them; red is
what moves most. --modes chooses some, --movie shows one in motion, --scale makes it larger.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
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
    parser.add_argument(
        "--movie", metavar="FILE", help="make a movie (.mp4) of all times written, or of one mode"
    )
    parser.add_argument(
        "--modes",
        metavar="N,N,...",
        help="numbers of the modes to draw, if OUT holds modes; default: all",
    )
    parser.add_argument(
        "-o", "--out", metavar="FOLDER", help="where pictures go; default: the output folder"
    )
    parser.add_argument(
        "--scale", metavar="S", type=float, default=1.0, help="factor of the deformation"
    )
    parser.add_argument(
        "--view",
        choices=("oblique", "corner", "front", "side"),
        help="where to look from; default: oblique, of modes corner",
    )
    _add_colours(parser)
    parser.add_argument("--edges", action="store_true", help="show the edges of the mesh")
    parser.add_argument(
        "--size",
        metavar="WxH",
        help="width and height in pixels; default: 1440x1200, of modes 1000x1200",
    )
    parser.add_argument(
        "--speed",
        metavar="X",
        type=float,
        default=1.0,
        help="simulated seconds in a second of the movie; default: 1",
    )


def _add_colours(parser: argparse.ArgumentParser) -> None:
    """Arguments that say what has which colour."""
    colours = parser.add_mutually_exclusive_group()
    colours.add_argument(
        "--field",
        metavar="NAME",
        help="field that gives the colours: von_mises_stress (default where there is one), "
        "cauchy_stress_norm, deflection from the rigid motion of the root (default elsewhere), "
        "displacement, velocity; of laminates tsai_wu",
    )
    colours.add_argument("--plain", action="store_true", help="no field, each part in one colour")
    parser.add_argument(
        "--parts",
        metavar="NAME,NAME,...",
        help="parts with these colours, for example blades or 'blade_*' or tower; default: all "
        "with the field",
    )
    parser.add_argument(
        "--range",
        metavar="LOW,HIGH",
        help="ends of the scale of colours in the units of its legend (MPa, m, m/s); default: 0 "
        "and what 99 %% of the values drawn are below, for stress blades and tower apart",
    )
    parser.add_argument(
        "--cells", action="store_true", help="one value per cell instead of averages at its corners"
    )


def run(options: argparse.Namespace, comm: Any) -> int:
    """Draw and print the paths of the pictures."""
    from turbine_fenicsx.foundation.parallel import on_rank0

    on_rank0(comm, lambda: _render(options))
    return OK


def _render(options: argparse.Namespace) -> None:
    """Draw all there is to draw."""
    from turbine_fenicsx.cli.commands._frames import Frames
    from turbine_fenicsx.cli.commands._numbers import parse_numbers
    from turbine_fenicsx.foundation.errors import InputError
    from turbine_fenicsx.postprocessing.colours import DEFAULT_FIELD
    from turbine_fenicsx.postprocessing.pictures import (
        Look,
        choose_movie_steps,
        render_movie,
        render_times,
    )
    from turbine_fenicsx.records.output_folder import (
        find_fields,
        holds_modes,
        make_target_folder,
        need_folder,
        read_field_times,
        read_tables,
    )

    folder = need_folder(options.folder)
    if holds_modes(folder):
        _render_modes(folder, options)
        return
    if options.modes is not None:
        raise InputError(f"--modes {options.modes}: there are no modes in {options.folder!r}")
    times = None if options.times is None else parse_numbers("--times", options.times)
    limits = None if options.range is None else parse_numbers("--range", options.range)
    if limits is not None and (len(limits) != 2 or limits[0] >= limits[1]):
        raise InputError(f"--range {options.range}: give a low and a higher number")
    _check(options)
    look = Look(
        None if options.plain else options.field or DEFAULT_FIELD,
        options.scale,
        options.view or "oblique",
        None if limits is None else (limits[0], limits[1]),
        _size(options.size or "1440x1200", options.movie is not None),
        tuple(filter(None, (options.parts or "").split(","))),
        not options.cells,
        options.edges,
        str((read_tables(folder / "case.json") or {}).get("title") or ""),
    )
    fields = find_fields(folder)
    written = read_field_times(fields)
    if times is not None or options.movie is None:
        out = make_target_folder(options.out or folder)
        with Frames(len(times) if times else 1) as frames:
            paths = render_times(fields, out, times, look, frames.count)
        print(*paths, sep="\n", flush=True)
    if options.movie is not None:
        _check_movie(options.movie)
        n_frames = len(choose_movie_steps(list(written), options.speed)[0])
        with Frames(n_frames) as frames:
            path = render_movie(fields, options.movie, options.speed, look, frames.count)
        print(path, flush=True)


def _render_modes(folder: Path, options: argparse.Namespace) -> None:
    """Draw shapes of modes, or a movie of one."""
    from turbine_fenicsx.cli.commands._frames import Frames
    from turbine_fenicsx.cli.commands._numbers import parse_numbers
    from turbine_fenicsx.foundation.errors import InputError
    from turbine_fenicsx.postprocessing import mode_pictures
    from turbine_fenicsx.records.output_folder import make_target_folder

    _check(options)
    for name in ("times", "range"):
        if getattr(options, name) is not None:
            raise InputError(f"--{name} {getattr(options, name)}: modes have none")
    titles = mode_pictures.read_mode_titles(folder / "modes.xdmf")
    wanted = [float(n) for n in range(1, len(titles) + 1)]
    if options.modes is not None:
        wanted = parse_numbers("--modes", options.modes)
    if any(n not in range(1, len(titles) + 1) for n in wanted):
        raise InputError(f"--modes {options.modes}: they are numbered from 1 to {len(titles)}")
    if options.movie is not None and len(wanted) != 1:
        raise InputError("--movie shows one mode: choose it with --modes N")
    size = _size(options.size or "1000x1200", options.movie is not None)
    look = replace(
        mode_pictures.LOOK,
        scalar=None if options.plain else mode_pictures.LOOK.scalar,
        scale=options.scale,
        view=options.view or mode_pictures.LOOK.view,
        size=size,
        coloured=tuple(filter(None, (options.parts or "").split(","))),
        edges=options.edges,
    )
    path, chosen = folder / "modes.xdmf", [int(n) for n in wanted]
    if options.movie is not None:
        _check_movie(options.movie)
        with Frames(mode_pictures.count_movie_frames()) as frames:
            mode_pictures.render_mode_movie(path, options.movie, chosen[0], look, frames.count)
        print(options.movie, flush=True)
        return
    out = make_target_folder(options.out or folder)
    with Frames(len(chosen)) as frames:
        paths = mode_pictures.render_modes(path, out, chosen, look, frames.count)
    print(*paths, sep="\n", flush=True)


def _check(options: argparse.Namespace) -> None:
    """Refuse numbers that are not positive, and movies of another kind."""
    from turbine_fenicsx.foundation.errors import InputError

    for name in ("scale", "speed"):
        value = getattr(options, name)
        if not 0.0 <= value < float("inf") or (name == "speed" and value == 0.0):
            raise InputError(f"--{name} {value:g}: must be a positive number")
    if options.movie is not None and Path(options.movie).suffix != ".mp4":
        raise InputError(f"--movie {options.movie}: the name of a movie ends in .mp4")


def _check_movie(path: str) -> None:
    """Refuse a movie that cannot be written."""
    from turbine_fenicsx.foundation.errors import InputError
    from turbine_fenicsx.records.output_folder import make_target_folder

    make_target_folder(Path(path).parent)
    if Path(path).is_dir():
        raise InputError(f"cannot write {path!r}: it is a folder")


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
