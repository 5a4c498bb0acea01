"""Diagrams of the sections of a blade: properties along the span, and sections with centres."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.diagram_style import PALETTE, STYLE
from turbine_fenicsx.records.names import split_unit
from turbine_fenicsx.sections.section import Section
from turbine_fenicsx.turbine.blades.windio_sections import CaseSections

PANELS = (
    *("mass_[kg/m]", "stretch_stiffness_[N]", "torsion_stiffness_[Nm2]"),
    *("bending_stiffness_1_[Nm2]", "bending_stiffness_2_[Nm2]", "bending_angle_[deg]"),
    *("tension_centre_y_[m]", "shear_centre_y_[m]", "shear_centre_x_[m]"),
)
"""Columns along the span."""

DRAWN = (0.05, 0.15, 0.3, 0.5, 0.7, 0.9)
"""Span fractions near which sections are drawn."""

AROUND = (0, 4, 1, 6, 3, 7, 2, 5)
"""Nodes around a quadratic quadrilateral in the order of DOLFINx."""

CENTRES = {"mass": ("mass_centre", "o"), "tension": ("tension_centre", "s")} | {
    "shear": ("shear_centre", "^")
}
"""Centres, and their markers."""


def plot_sections(folder: Path, found: CaseSections) -> str:
    """Draw the sections; the name of the picture."""
    import matplotlib
    from matplotlib.figure import Figure

    part = found.sections.stations / found.sections.length
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(12.0, 14.0), layout="constrained")
        upper, lower = figure.subfigures(2, 1, height_ratios=[9.0, 5.0])
        panels = upper.subplots(3, 3).ravel()
        for column, axes in zip(PANELS, panels, strict=True):
            name, unit = split_unit(column)
            unit = unit.replace("Nm2", "N m²")
            axes.set_title(f"{name.replace('_', ' ')} [{unit}]", fontsize=10.0)
            own = [row[column] for row in found.own]
            if found.given:
                given = [row[column] for row in found.given]
                axes.plot(part, given, color=PALETTE[1], lw=1.1, ls="--", label="of the file")
            axes.plot(part, own, ".-", color=PALETTE[0], lw=1.1, ms=3.0, label="of the layup")
            axes.set_xlabel("place along the blade [-]")
            if not column.endswith(("_[deg]", "_[m]")):
                axes.set_yscale("log")
        panels[0].legend(fontsize=8.0)
        rows = [int(np.argmin(np.abs(part - s))) for s in DRAWN]
        places = lower.subplots(2, 3).ravel()
        for k, axes in zip(rows, places, strict=True):
            _draw_section(axes, found.sections.sections[k], found.own[k])
            axes.set_title(f"at {part[k]:.2f} of the span", fontsize=10.0)
        handles = places[0].get_legend_handles_labels()
        lower.legend(*handles, fontsize=9.0, ncols=4, loc="outside upper center")
    figure.savefig(folder / "sections.png")
    return "sections.png"


def _draw_section(axes: Any, section: Section, row: dict[str, float]) -> None:
    """Cells of a section, centres and the origin; y to the right, x upwards."""
    from matplotlib.collections import PolyCollection

    mesh = section.mesh
    edges = mesh.geometry.x[_compat.nodes_of_cells(mesh)[:, AROUND], 1::-1]
    axes.add_collection(
        PolyCollection(edges, facecolors="#d9dde3", edgecolors="#6b7280", linewidths=0.4)
    )
    for k, (word, (name, marker)) in enumerate(CENTRES.items()):
        at = row[f"{name}_y_[m]"], row[f"{name}_x_[m]"]
        axes.plot(*at, marker, color=PALETTE[k + 1], ms=5.0, label=f"{word} centre", ls="none")
    axes.plot(0.0, 0.0, "+", color="black", ms=8.0, label="axis", ls="none")
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_xlabel("y [m]")
    axes.set_ylabel("x [m]")
