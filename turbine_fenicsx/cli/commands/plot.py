"""Draw the diagrams of one run, or of several on top of each other.

The figures show history.csv: energies and their error per step, angular momentum and its change per
step, rotor speed and angles. Further figures show the balance of power where several forces do
work; in wind power, thrust, speed and pitch; for flexible parts tip deflections, root moments and
motion of the tower. Of several runs each panel shows one quantity. Angles and loads have the signs
of OpenFAST, see history.out. Runs that were aborted or still continue are drawn as far as they
came. The error per step is the change of the total energy H minus the work W of the loads plus the
losses D. Of the angular momentum only the vertical component L2 stays constant after the yaw
torque, because the tower holds the other two. The dashed line is the solver tolerance of the
(first) run times its largest energy or momentum.
"""

from __future__ import annotations

import argparse
from typing import Any

from turbine_fenicsx.cli.commands._common import OK


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("folders", metavar="OUT", nargs="+", help="output folders, at most six")
    parser.add_argument(
        "-o", "--out", metavar="FOLDER", help="where to write; default: the first output folder"
    )
    parser.add_argument(
        "--format",
        metavar="FORMAT",
        nargs="+",
        choices=("png", "pdf", "svg"),
        default=["png", "pdf"],
        help="png, pdf, svg; default: png pdf",
    )
    parser.add_argument(
        "--together", action="store_true", help="all diagrams in one figure, diagrams.png"
    )
    parser.add_argument(
        "--angles", choices=("rad", "deg"), default="deg", help="unit of angles; default: deg"
    )
    parser.add_argument(
        "--tolerance",
        metavar="X",
        type=float,
        help="height of the dashed line in kJ and kNms instead, for example 1e-7, that of the "
        "figures of the paper",
    )


def run(options: argparse.Namespace, comm: Any) -> int:
    """Draw and print the paths of the figures."""
    from turbine_fenicsx.foundation.parallel import on_rank0

    paths = on_rank0(comm, lambda: _draw(options))
    if comm.rank == 0:
        print(*paths, sep="\n", flush=True)
    return OK


def _draw(options: argparse.Namespace) -> list[str]:
    """Draw all figures."""
    from turbine_fenicsx.foundation.errors import InputError
    from turbine_fenicsx.postprocessing.plots import choose_figures, draw
    from turbine_fenicsx.postprocessing.split_panels import split_panels
    from turbine_fenicsx.records.output_folder import (
        make_target_folder,
        read_histories,
        read_solver_tolerance,
    )

    if options.tolerance is not None and not 0.0 < options.tolerance < float("inf"):
        raise InputError(f"--tolerance {options.tolerance:g}: must be greater than 0")
    runs = read_histories(options.folders)
    relative = read_solver_tolerance(options.folders[0])
    out = make_target_folder(options.out or options.folders[0])
    wanted = {name: split_panels(panels, runs) for name, panels in choose_figures(runs).items()}
    if options.together:
        panels = (panel for panels in wanted.values() for panel in panels)
        wanted = {"diagrams": list(dict.fromkeys(panels))}
    try:
        return [
            str(path)
            for name, panels in wanted.items()
            for path in draw(
                runs,
                panels,
                [out / f"{name}.{suffix}" for suffix in options.format],
                tolerance=options.tolerance,
                relative_tolerance=relative,
                degrees=options.angles == "deg",
            )
        ]
    except ImportError as error:
        raise InputError(str(error)) from None
