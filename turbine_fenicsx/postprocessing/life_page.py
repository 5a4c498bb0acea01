"""The life of the plies on the page of a run or a load set, from the files of ``life``."""

from __future__ import annotations

from pathlib import Path

from turbine_fenicsx.postprocessing.page import embed_figure, format_grid, format_note
from turbine_fenicsx.records import names
from turbine_fenicsx.records.life_tables import (
    BLADE,
    BONDS,
    CURVE,
    PLACES,
    ROSETTE,
    read_life_table,
)

HEAD = ("panel", "from the root [m]", "ply", "material", "stress", "damage", "life [years]", "run")

BOND_HEAD = ("bond", "from the root [m]", "stress", "damage", "life [years]", "run")

CAPTIONS = {
    BLADE: "Fatigue index of the blades, whole and where a ply fails first.",
    ROSETTE: "Fatigue index around the section where a ply fails first.",
    CURVE: "Damage of this ply in the life, by wind speed.",
}


def format_life(folder: Path) -> str:
    """The table of the worst places, and the pictures that are there; empty without a table.

    Raises:
        InputError: for a table that is damaged.
    """
    if not (folder / PLACES).exists():
        return ""
    rows = [
        (
            row["panel"].replace("_", " "),
            *(f"{float(row[names.DISTANCE]):.4g}", f"{row['ply']} of {row['plies']}"),
            *(row["material"], row["measure"]),
            *(f"{float(row[name]):.3g}" for name in (names.DAMAGE, names.LIFE)),
            row["run"],
        )
        for row in read_life_table(folder, PLACES)
    ]
    figures = [
        embed_figure(folder / name, caption)
        for name, caption in CAPTIONS.items()
        if (folder / name).exists()
    ]
    return "".join([format_grid(HEAD, rows), *figures, _list_bonds(folder)])


def _list_bonds(folder: Path) -> str:
    """The table of the bonds; empty without one."""
    if not (folder / BONDS).exists():
        return ""
    rows = [
        (
            row["bond"].replace("_", " "),
            *(f"{float(row[names.DISTANCE]):.4g}", row["measure"]),
            *(f"{float(row[name]):.3g}" for name in (names.DAMAGE, names.LIFE)),
            row["run"],
        )
        for row in read_life_table(folder, BONDS)
    ]
    return format_grid(BOND_HEAD, rows) + format_note("Damage of bonds is an estimate.")
