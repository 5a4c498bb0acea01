"""Count the load cycles of a run and find its damage-equivalent loads.

By the rainflow method (ASTM E1049-85), from history.csv: moments of the blade roots and of the
tower base, and strain gauges, or the columns of history.csv and history.out that are named. The
equivalent range does in cycles of one frequency, over the duration of the run, the damage of all
cycles counted. Prints a table and writes it into OUT/fatigue.csv. Needs rainflow: pip install
'turbine-fenicsx[fatigue]'.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from turbine_fenicsx.cli.commands._common import OK

if TYPE_CHECKING:
    from turbine_fenicsx.postprocessing.fatigue import Fatigue


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("folder", metavar="OUT", help="output folder")
    parser.add_argument(
        "--columns",
        metavar="COLUMN",
        nargs="+",
        default=[],
        help="columns of history.csv or history.out, for example 'root_moment_1_y_[Nm]' or "
        "RootMyb1; default: moments of roots and tower base, strain gauges",
    )
    parser.add_argument(
        "--slope",
        metavar="M",
        type=float,
        nargs="+",
        default=[],
        help="slopes of S-N curves; default: 4 for tower and shafts, of steel, 10 for all others, "
        "for laminates with glass fibres",
    )
    parser.add_argument(
        "--frequency",
        metavar="F",
        type=float,
        default=1.0,
        help="of the equivalent cycles in Hz; default: 1",
    )
    parser.add_argument(
        "--start",
        metavar="T",
        type=float,
        default=0.0,
        help="time in s before which nothing counts, while the run settles; default: 0",
    )
    parser.add_argument(
        "--ultimate",
        metavar="S",
        type=float,
        nargs="+",
        default=[],
        help="ultimate loads of the columns in their order, or one of all: ranges are corrected to "
        "zero mean by Goodman; default: means do not count",
    )
    parser.add_argument(
        "--markov",
        action="store_true",
        help="also write OUT/markov.csv: numbers of cycles by range and mean, as they are counted",
    )


def run(options: argparse.Namespace, comm: Any) -> int:
    """Write the table and print it."""
    from turbine_fenicsx.foundation.parallel import on_rank0

    lines = on_rank0(comm, lambda: _write(options))
    if comm.rank == 0:
        print(*lines, sep="\n", flush=True)
    return OK


def _write(options: argparse.Namespace) -> list[str]:
    """Write the table; its lines, and the path."""
    from turbine_fenicsx.foundation.errors import FileError, InputError
    from turbine_fenicsx.foundation.files import replace_file
    from turbine_fenicsx.postprocessing.cycles import format_markov
    from turbine_fenicsx.postprocessing.fatigue import (
        find_cycles,
        find_fatigue,
        format_fatigue,
        list_loads,
    )
    from turbine_fenicsx.records.names import find_column
    from turbine_fenicsx.records.output_folder import (
        FATIGUE,
        MARKOV,
        add_openfast,
        read_histories,
    )

    for slope in options.slope:
        if not 1.0 <= slope <= 100.0:
            raise InputError(f"--slope {slope:g}: must be between 1 and 100")
    if not 0.0 < options.frequency < float("inf"):
        raise InputError(f"--frequency {options.frequency:g}: must be greater than 0")
    if options.ultimate and len(options.ultimate) not in (1, len(options.columns)):
        raise InputError("--ultimate: give one number, or one for each of --columns")
    for load in options.ultimate:
        if not 0.0 < load < float("inf"):
            raise InputError(f"--ultimate {load:g}: must be greater than 0")
    (series,) = read_histories([options.folder])
    other = Path(options.folder) / "history.out"
    known = {find_column(series.columns, name) for name in options.columns}
    if not known <= series.columns.keys() and other.exists():
        series = add_openfast(series, other, options.columns)
    try:
        columns = [find_column(series.columns, name) for name in options.columns]
        columns = columns or list_loads(series)
        loads = options.ultimate * (len(columns) if len(options.ultimate) == 1 else 1)
        found = find_fatigue(
            series,
            columns,
            options.slope,
            options.frequency,
            options.start,
            dict(zip(columns, loads, strict=False)),
        )
        folder = Path(options.folder)
        texts = {FATIGUE: format_fatigue(found)}
        if options.markov:
            texts[MARKOV] = format_markov(find_cycles(series, columns, options.start))
        for name, text in texts.items():
            replace_file(folder / name, text.encode())
    except (ImportError, FileError) as error:
        raise InputError(str(error)) from None
    return [*_format_table(found), *(str(folder / name) for name in texts)]


def _format_table(found: Sequence[Fatigue]) -> list[str]:
    """Lines for people."""
    from turbine_fenicsx.postprocessing.fatigue import list_slopes

    head = ["column", "cycles", "largest range"]
    slopes = list_slopes(found)
    head += [f"equivalent, m = {m:g}" for m in slopes]
    rows = [
        [each.column, f"{each.cycles:g}", f"{each.largest:.4g}"]
        + [f"{each.equivalent[m]:.4g}" if m in each.equivalent else "-" for m in slopes]
        for each in found
    ]
    first, *widths = [max(map(len, cells)) for cells in zip(head, *rows, strict=True)]
    return [
        "  ".join([name.ljust(first), *(x.rjust(n) for x, n in zip(cells, widths, strict=True))])
        for name, *cells in [head, *rows]
    ]
