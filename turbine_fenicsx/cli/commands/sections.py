"""Find the sections of a blade from its layup: 6 x 6 stiffness, mass, centres.

OUT gets sections.csv, sections.png, and beams for BeamDyn, HAWC2 and windIO. Those in prisms/ have
sections as other codes assume them. Those in inclined/ know that the walls of a blade that tapers
are inclined: under bending they twist as the blade does in three dimensions. Where the file has
matrices, the command compares with them. With loads in sections it finds the stresses of all plies.
"""

from __future__ import annotations

import argparse
import sys
import time
from typing import Any

from turbine_fenicsx.cli.commands._common import OK, add_case, load_case, need_dolfinx
from turbine_fenicsx.foundation.errors import FileError, InputError

LIMITS = {"stations": (4, 400), "around": (16, 400)}
"""Smallest and largest numbers of the mesh."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add_case(parser)
    parser.add_argument("-o", "--out", metavar="OUT", required=True, help="output folder")
    parser.add_argument(
        "--stations", metavar="N", type=int, default=50, help="number of sections; default: 50"
    )
    parser.add_argument(
        "--around",
        metavar="N",
        type=int,
        default=40,
        help="number of cells around a section, without those of webs; default: 40",
    )
    parser.add_argument(
        "--loads",
        metavar="FILE",
        help="table of forces and moments along the blade, such as steady_blade.csv: "
        "section_plies.csv gets stresses and failure indices of all plies under them",
    )
    parser.add_argument("--overwrite", action="store_true", help="replace sections in OUT")
    parser.add_argument("--quiet", action="store_true", help="print neither progress nor table")


def run(options: argparse.Namespace, comm: Any) -> int:
    """Find the sections, write and print them."""
    for name, (least, most) in LIMITS.items():
        if not least <= getattr(options, name) <= most:
            raise InputError(f"--{name} {getattr(options, name)}: must be from {least} to {most}")
    case = load_case(options, comm)
    need_dolfinx()
    from turbine_fenicsx.foundation.parallel import on_rank0
    from turbine_fenicsx.meshing.errors import MeshError

    try:
        lines = on_rank0(comm, lambda: _find(case, options))
    except (FileError, MeshError) as error:
        words = str(error).replace("mesh.around =", "--around").replace("mesh.span =", "--stations")
        raise InputError(words) from None
    if comm.rank == 0 and not options.quiet:
        print("\n".join(lines), flush=True)
    return OK


def _find(case: Any, options: argparse.Namespace) -> list[str]:
    """Find and write the sections; what there is to say."""
    from turbine_fenicsx.records.loads_along import read_loads
    from turbine_fenicsx.records.output_folder import (
        keep_results,
        make_target_folder,
        remove_results,
    )
    from turbine_fenicsx.turbine.blades.loaded_plies import (
        describe_worst,
        find_loaded_plies,
        write_loaded_plies,
    )
    from turbine_fenicsx.turbine.blades.section_files import write_sections
    from turbine_fenicsx.turbine.blades.windio_sections import find_sections

    states = read_loads(options.loads) if options.loads else []
    keep_results(options.out, "sections", options.overwrite)
    folder = make_target_folder(options.out)
    progress = _Progress(options.stations, options.quiet)
    found = find_sections(case, options.stations, options.around, progress)
    plies = find_loaded_plies(found.sections, found.line, states) if states else []
    remove_results(folder)
    mu = case.blade.damping.mu or (0.0,) * 6
    files = write_sections(folder, found.sections, found.line, case.title, mu)
    lines = [*_list_rows(found), *found.compare()]
    if plies:
        files.append(write_loaded_plies(folder, plies))
        lines += describe_worst(plies)
    try:
        from turbine_fenicsx.postprocessing.section_plots import plot_sections

        files.append(plot_sections(folder, found))
    except ImportError:
        print("no picture: matplotlib is not installed", file=sys.stderr)
    return [*lines, f"results {options.out}/: {', '.join(files)}"]


def _list_rows(found: Any) -> list[str]:
    """A table of some of the sections."""
    from turbine_fenicsx.turbine.blades.section_files import tabulate_sections

    rows = tabulate_sections(found.sections)
    lines = ["  span       mass         EA        EI 1        EI 2          GJ"]
    lines += ["     -       kg/m          N        N m2        N m2        N m2"]
    for row in rows[:: max(1, len(rows) // 10)]:
        keys = ["mass_[kg/m]", "stretch_stiffness_[N]", "bending_stiffness_1_[Nm2]"]
        keys += ["bending_stiffness_2_[Nm2]", "torsion_stiffness_[Nm2]"]
        mass, *stiffness = (row[key] for key in keys)
        numbers = "  ".join(f"{x:10.4g}" for x in stiffness)
        lines.append(f"{row['span_[-]']:6.3f}  {mass:9.2f} {numbers}")
    return lines


class _Progress:
    """Prints now and then how many sections are done, with the time left."""

    def __init__(self, number: int, quiet: bool) -> None:
        self._number, self._quiet = number, quiet
        self._start = self._last = time.perf_counter()

    def __call__(self, done: int) -> None:
        """After a section."""
        now = time.perf_counter()
        if self._quiet or done == 1 or now - self._last < 2.0:  # the first one may compile
            return
        self._last = now
        left = (now - self._start) * (self._number - done) / done
        words = f"{done} of {self._number} sections, {left:.0f} s left"
        print(words, file=sys.stderr, flush=True)
