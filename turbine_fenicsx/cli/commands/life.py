"""Find which ply of reduced blades fails first by fatigue, and when.

OUT is a run, several runs that each stand for a part of the life, or a load set, whose runs happen
as often as its winds do. The stress of every ply is recovered from the motion. Its cycles along and
across the fibre, of shear and of the exertion of Tsai and Hill are counted by the rainflow method,
and Miner's rule sums up their damage. S-N curves are those of the windIO file and of the table life
of the case, see --set.

Prints where a ply fails first. Writes life.csv, with the worst places, life_section.csv and
life_winds.csv, with damage around the section of the first and by wind speed. Fields of all plies
are in life.vtkhdf, if h5py is there. With life.adhesive, life_bonds.csv has an estimate for feet of
webs and trailing edges. Draws life.png, life_section.png and life_winds.png.
"""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from turbine_fenicsx.cli.commands._common import OK, add_overrides, need_dolfinx, warn
from turbine_fenicsx.cli.commands._progress import show_part


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("folders", metavar="OUT", nargs="+", help="output folders")
    parser.add_argument(
        "--weights",
        metavar="W,W,...",
        help="part of the life that each run stands for; default: equal parts",
    )
    parser.add_argument(
        "--start",
        metavar="T",
        type=float,
        help="time in s before which nothing of runs counts; default: 0; a load set has its own",
    )
    add_overrides(parser, "life.years=25 life.material.glass_biax.slope=9")
    parser.add_argument(
        "-o", "--out", metavar="FOLDER", help="where to write; default: OUT, if it is one"
    )
    parser.add_argument("--no-pictures", action="store_true", help="draw nothing")
    parser.add_argument("--overwrite", action="store_true", help="replace files that are there")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")


def run(options: argparse.Namespace, comm: Any) -> int:
    """Write the files and print where plies fail first."""
    from turbine_fenicsx.foundation.errors import FileError, InputError
    from turbine_fenicsx.foundation.parallel import on_rank0

    need_dolfinx()
    from turbine_fenicsx.turbine.life.life_files import write_life_tables
    from turbine_fenicsx.turbine.life.ply_life import find_ply_life
    from turbine_fenicsx.turbine.life.worst_bonds import find_worst_bonds
    from turbine_fenicsx.turbine.life.worst_places import WorstPlaces

    folder, runs, years = on_rank0(comm, lambda: _read(options))
    try:
        progress = show_part(comm, options.quiet)
        life = find_ply_life(runs, comm, options.overrides, years, progress)
        finder = WorstPlaces(life)
        places = finder.find()
        section = finder.find_section(places[0])
        bonds = find_worst_bonds(life)
        files = write_life_tables(life, places, section, bonds, folder)
        files += _write_fields(life, places[0], folder, options, comm)
    except FileError as error:
        raise InputError(str(error)) from None
    lines = [*_describe(life, places[0]), *map(str, bonds[:1])]
    if comm.rank == 0 and not options.quiet:
        print(*lines, ", ".join(str(folder / name) for name in files), sep="\n", flush=True)
    return OK


def _read(options: argparse.Namespace) -> tuple[Path, Any, float | None]:
    """The folder to write to, the runs, and the life they belong to if it is not the case's."""
    from turbine_fenicsx.cli.commands._numbers import parse_numbers
    from turbine_fenicsx.foundation.errors import InputError
    from turbine_fenicsx.load_sets.life_runs import find_life_runs
    from turbine_fenicsx.records import life_tables as tables
    from turbine_fenicsx.records.output_folder import holds_set, make_target_folder, need_folder
    from turbine_fenicsx.turbine.life.weighted_run import weigh
    from turbine_fenicsx.turbine.run.recovery_files import refuse_to_overwrite

    folders = [need_folder(folder) for folder in options.folders]
    sets = [folder for folder in folders if holds_set(folder)]
    if sets and len(folders) > 1:
        raise InputError(f"{str(sets[0])!r} is a load set: give it alone")
    if options.out is None and len(folders) > 1:
        raise InputError("several runs: give the folder to write to with --out")
    if sets:
        for name in ("weights", "start"):
            if getattr(options, name) is not None:
                raise InputError(f"--{name}: the load set {str(sets[0])!r} has its own")
        if any(text.strip().startswith("life.years") for text in options.overrides):
            raise InputError("--set life.years: the life is that of the load set, lifetime.years")
        runs, years = find_life_runs(sets[0])
    else:
        weights = [] if options.weights is None else parse_numbers("--weights", options.weights)
        start = options.start or 0.0
        if not 0.0 <= start < float("inf"):
            raise InputError(f"--start {start:g}: must be a time from 0 on")
        runs, years = weigh(options.folders, weights, start), None
    folder = make_target_folder(options.out or folders[0])
    if not options.overwrite:
        refuse_to_overwrite(folder, tables.ALL)
    return folder, runs, years


def _write_fields(
    life: Any, place: Any, folder: Path, options: argparse.Namespace, comm: Any
) -> list[str]:
    """Write fields and pictures, those that can be; names of their files. Collective."""
    from turbine_fenicsx.foundation.errors import InputError
    from turbine_fenicsx.foundation.parallel import on_rank0
    from turbine_fenicsx.postprocessing.life_plots import plot_life
    from turbine_fenicsx.postprocessing.pictures import render_hot_spot
    from turbine_fenicsx.records import life_tables as tables
    from turbine_fenicsx.records.vtkhdf_layout import need_h5py
    from turbine_fenicsx.turbine.life.life_files import INDEX, LifeFields

    fields, files = LifeFields(life), []
    try:
        on_rank0(comm, need_h5py)
        fields.write(folder / tables.FIELDS)
        files.append(tables.FIELDS)
    except InputError as error:
        warn(comm, [f"there is no {tables.FIELDS}: {error}"])
    if options.no_pictures:
        return files
    title = "\n".join([life.recovery.run.turbine.case.title, *str(place).splitlines()])
    with TemporaryDirectory() as scratch:  # each rank makes one, all write into that of rank 0
        path = Path(comm.bcast(scratch)) / "fields.xdmf"
        fields.write(path, ["displacement", INDEX])
        draw = partial(render_hot_spot, path, folder / tables.BLADE, field=INDEX, title=title)
        try:
            on_rank0(comm, draw)
            files.append(tables.BLADE)
        except InputError as error:
            warn(comm, [f"there is no {tables.BLADE}: {error}"])
    try:
        files += [path.name for path in on_rank0(comm, lambda: plot_life(folder))]
    except ImportError as error:
        warn(comm, [f"there are no diagrams: {error}"])
    return files


def _describe(life: Any, place: Any) -> list[str]:
    """Lines for people. Collective."""
    counted, left_out = life.count_cells()
    return [
        *life.notes,
        f"{len(life.runs)} run{'s' * (len(life.runs) > 1)} as {life.years:g} years; {left_out} of "
        f"{counted} cells are left out, as their largest ranges cannot matter",
        str(place),
    ]
