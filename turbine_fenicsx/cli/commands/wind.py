"""Write the turbulence of a case for other programs: a file of TurbSim, or three of Mann's format.

FILE.bts is the whole wind in the format of TurbSim. FILE.bin stands for FILE_u.bin, FILE_v.bin and
FILE_w.bin, the fluctuations alone, as HAWC2 and InflowWind read them.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from turbine_fenicsx.cli.commands._common import OK, add_case, load_case
from turbine_fenicsx.cli.commands._progress import show_making
from turbine_fenicsx.foundation.errors import FileError, InputError


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add_case(parser)
    parser.add_argument("-o", "--out", metavar="FILE", required=True, help="FILE.bts or FILE.bin")
    parser.add_argument("--overwrite", action="store_true", help="replace files that are there")
    parser.add_argument("--quiet", action="store_true", help="print neither progress nor table")


def run(options: argparse.Namespace, comm: Any) -> int:
    """Write the files and print what is in them."""
    from turbine_fenicsx.foundation.parallel import on_rank0

    files = list_files(options.out)
    case = load_case(options, comm)
    if not case.wind.has_box:
        raise InputError(
            'wind.turbulence.model = "none": expected one, to have turbulence to write'
        )
    with show_making(comm, options.quiet):
        lines = on_rank0(comm, lambda: _write(case, files, options.overwrite))
    if comm.rank == 0 and not options.quiet:
        print("\n".join(lines), flush=True)
    return OK


def list_files(out: str) -> list[Path]:
    """The files of ``--out``.

    Raises:
        InputError: if its ending is none of the two.
    """
    path = Path(out)
    if path.suffix.lower() == ".bts":
        return [path]
    if path.suffix.lower() == ".bin":
        return [path.with_name(f"{path.stem}_{k}{path.suffix}") for k in "uvw"]
    raise InputError(f"--out {out}: expected a name that ends with .bts or .bin")


def _write(case: Any, files: list[Path], overwrite: bool) -> list[str]:
    """Write the turbulence of a case; its deviations and its grid in words."""
    import numpy as np

    from turbine_fenicsx.turbine.case.inflow import load_box
    from turbine_fenicsx.wind.mann import write_mann_box
    from turbine_fenicsx.wind.turbsim import write_turbsim

    for file in files:
        if os.path.lexists(file) and not overwrite:
            raise InputError(f"{str(file)!r} is there already: --overwrite replaces it")
        if not os.access(file.parent, os.W_OK):
            raise InputError(
                f"cannot write {str(file)!r}: {str(file.parent)!r} is no folder that may be written"
            )
    wind = load_box(case)
    try:
        if len(files) == 1:
            write_turbsim(files[0], wind, case.title)
        else:
            write_mann_box(files, wind)
    except FileError as error:
        raise InputError(str(error)) from None
    field = wind.fluctuations
    n_t, n_z, n_y, _ = field.values.shape
    spacing = field.dt * field.speed, field.y[1] - field.y[0], field.z[1] - field.z[0]
    u, v, w = (field.values.std(axis=(0, 1, 2), dtype=float) / np.abs(field.slope)).tolist()
    return [
        f"{wind.mean.speed:g} m/s at {wind.mean.hub_height:g} m, standard deviations {u:.3f}, "
        f"{v:.3f} and {w:.3f} m/s",
        f"{n_t} x {n_y} x {n_z} points, {spacing[0]:.6g} x {spacing[1]:.6g} x {spacing[2]:.6g} m, "
        f"a plane every {field.dt:.6g} s",
        ", ".join(map(str, files)),
    ]
