"""Recover plies, fields and gauges of a run with reduced blades.

Reads motion.bin, the bases and case.json of the run. Without an option, --plies and --worst are
done.

--plies writes OUT/plies.csv. It has a row for each row of the motion, with the largest failure
index of each panel and web in all blades, its place, its ply and its blade.

--worst prints when, where and how a ply came nearest to failure, with what the turbine did then. It
writes OUT/worst.json, and draws OUT/worst.png.

--fields writes OUT/fields.vtkhdf, on the full meshes, for ParaView and the command render: all that
a run with full blades writes, or the fields that are named. Their times are those of --times, such
as 12.5,max(tsai_wu),min(tip_clearance_1), or equal distances with --every.

--at writes OUT/at_STATION_PANEL.csv: strain, stress and failure index of the plies there over time,
in all blades. --gauges writes OUT/gauges.csv, with the gauges of the case and those of --set, such
as output.gauges.flap.station=0.3.

--sections writes OUT/sections.csv, with force and moment in sections of beam blades.
"""

from __future__ import annotations

import argparse
from typing import Any

from turbine_fenicsx.cli.commands._common import OK, add_overrides, need_dolfinx, warn
from turbine_fenicsx.cli.commands._progress import show_part
from turbine_fenicsx.cli.commands._worst import PICTURE, draw_worst


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("folder", metavar="OUT", help="output folder of a run")
    parser.add_argument(
        "--plies", action="store_true", help="write the history of each panel and web"
    )
    parser.add_argument("--worst", action="store_true", help="find the moment nearest to failure")
    parser.add_argument(
        "--criterion",
        choices=("tsai_wu", "maximum_stress", "maximum_strain"),
        default="tsai_wu",
        help="of failure; default: tsai_wu",
    )
    parser.add_argument(
        "--fields",
        metavar="NAME,NAME,...",
        nargs="?",
        const="",
        help="write fields on the full meshes, for example displacement,von_mises_stress,tsai_wu; "
        "without names, those of a run with full blades",
    )
    parser.add_argument(
        "--at",
        metavar="STATION,PANEL[,PLY]",
        action="append",
        default=[],
        help="write the history of the plies at a fraction of the span, for example "
        "0.35,spar_cap_suction_side; again for more places",
    )
    parser.add_argument(
        "--gauges", action="store_true", help="write the history of strain gauges, see --set"
    )
    parser.add_argument(
        "--sections",
        metavar="STATION,STATION,...",
        help="write the history of force and moment in sections of beam blades, at fractions of "
        "their axis, for example 0,0.25,0.5",
    )
    add_overrides(parser, "output.gauges.flap.station=0.3")
    times = parser.add_mutually_exclusive_group()
    times.add_argument(
        "--times",
        metavar="T,T,...",
        help="of the fields in s, the nearest ones of the motion, or max(NAME) and min(NAME) of a "
        "failure criterion or a column of history.csv or history.out; default: the moment nearest "
        "to failure",
    )
    times.add_argument("--every", metavar="S", help="fields at equal distances of time in s")
    parser.add_argument("--from", dest="begin", metavar="T", help="first time of --every")
    parser.add_argument("--to", dest="end", metavar="T", help="last time of --every")
    parser.add_argument("--overwrite", action="store_true", help="replace files that are there")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")


def run(options: argparse.Namespace, comm: Any) -> int:
    """Write the files and print what was found."""
    from turbine_fenicsx.foundation.errors import FileError, InputError
    from turbine_fenicsx.foundation.parallel import on_rank0

    need_dolfinx()
    from turbine_fenicsx.turbine.run import recovery_files as files
    from turbine_fenicsx.turbine.run.recorded_run import RecordedRun
    from turbine_fenicsx.turbine.run.run_recovery import RunRecovery
    from turbine_fenicsx.turbine.run.wall_history import WallPlace

    places = [WallPlace.parse(text) for text in options.at]
    gauges = options.gauges or bool(options.overrides)
    sections = _read_sections(options.sections)
    others = options.fields is not None or places or gauges or sections
    both = not (options.plies or options.worst or others)
    plies, worst = options.plies or both, options.worst or both
    wanted = {files.PLIES: plies, files.WORST: worst, PICTURE: worst}
    wanted |= {files.FIELDS: options.fields is not None, files.GAUGES: gauges}
    wanted[files.SECTIONS] = bool(sections)
    wanted |= dict.fromkeys(map(files.name_place, places), True)
    every, begin, end = _read_times(options)
    names = [name for name, is_wanted in wanted.items() if is_wanted]
    if not options.overwrite:
        on_rank0(comm, lambda: files.refuse_to_overwrite(options.folder, names))
    run = RecordedRun.open(options.folder, comm, options.overrides)
    recovery, lines, paths = RunRecovery(run, show_part(comm, options.quiet)), [], []
    try:
        if gauges:
            paths.append(files.write_gauges(recovery))
        if sections:
            paths.append(files.write_sections(recovery, sections))
        for place in places:
            found, path = files.write_place(recovery, place, options.criterion)
            lines.append(found)
            paths.append(path)
        if options.fields is not None:
            texts = (options.times or f"max({options.criterion})").split(",")
            chosen = None if every is None else (every, begin, end)
            paths.append(files.write_fields(recovery, _split(options.fields), texts, chosen))
        if plies:
            paths.append(files.write_plies(recovery, options.criterion))
        if worst:
            moment, path = files.write_worst(recovery, options.criterion)
            lines.append(str(moment))
            paths.append(path)
            try:
                paths.append(draw_worst(recovery, moment))
            except InputError as error:
                warn(comm, [f"there is no picture: {error}"])
    except FileError as error:
        raise InputError(str(error)) from None
    if comm.rank == 0 and not options.quiet:
        print(*lines, ", ".join(map(str, paths)), sep="\n", flush=True)
    return OK


def _read_sections(text: str | None) -> list[float]:
    """The numbers of --sections; none where it is not given."""
    from turbine_fenicsx.cli.commands._numbers import parse_numbers

    return [] if text is None else list(parse_numbers("--sections", text))


def _split(names: str) -> list[str] | None:
    """Names between commas; None for all."""
    return [name.strip() for name in names.split(",")] if names else None


def _read_times(options: argparse.Namespace) -> tuple[float | None, float | None, float | None]:
    """The numbers of --every, --from and --to; None where they are not given."""
    from turbine_fenicsx.cli.commands._numbers import parse_numbers
    from turbine_fenicsx.foundation.errors import InputError

    given = {"--every": options.every, "--from": options.begin, "--to": options.end}
    found: dict[str, float | None] = dict.fromkeys(given)
    for name, text in given.items():
        if text is not None:
            found[name], *more = parse_numbers(name, text.strip().removesuffix("s"))
            if more:
                raise InputError(f"{name} {text}: give one number")
    every = found["--every"]
    if every is not None and every <= 0.0:
        raise InputError(f"--every {options.every}: expected a positive number")
    given |= {"--fields": options.fields, "--times": options.times}
    needs = {"--from": "--every", "--to": "--every", "--every": "--fields", "--times": "--fields"}
    for name, needed in needs.items():
        if given[name] is not None and given[needed] is None:
            raise InputError(f"{name} {given[name]}: counts with {needed} only")
    return every, found["--from"], found["--to"]
