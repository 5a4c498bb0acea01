"""Table and picture of the refinement."""

import numpy as np

from turbine_fenicsx.postprocessing.plots import PALETTE
from turbine_fenicsx.study.convergence import observed_order, richardson

QUANTITIES = {
    "tip": "Tip deflection under weight",
    "flap": "First flap frequency",
    "edge": "First edge frequency",
}
KINDS = {  # cell, degree, geometry degree
    ("hexahedron", 1, 1): "linear hexahedra",
    ("tetrahedron", 1, 1): "linear tetrahedra",
    ("hexahedron", 2, 2): "quadratic hexahedra",
    ("tetrahedron", 2, 2): "quadratic tetrahedra",
}
STYLES = {  # colour, marker, filled
    ("hexahedron", 1, 1): (PALETTE[1], "s", False),
    ("tetrahedron", 1, 1): (PALETTE[4], "^", False),
    ("hexahedron", 2, 2): (PALETTE[0], "s", True),
    ("tetrahedron", 2, 2): (PALETTE[2], "^", True),
}
PAPER = 2
"""Level of the paper's mesh."""

LINEAR = ("hexahedron", 1, 1)
SHAPE = ("hexahedron", 2, 1)
"""Quadratic hexahedra on the flat meshes of the linear ones: what the polygons alone do."""


def of_kind(rows, kind):
    """Rows of one kind of elements by level, coarsest first."""
    found = [row for row in rows if (row.cell, row.degree, row.geometry_degree) == kind]
    return {row.level: row for row in sorted(found, key=lambda row: row.level)}


def limits(rows):
    """Limits of all quantities, by Richardson from the three finest quadratic hexahedra."""
    finest = list(of_kind(rows, ("hexahedron", 2, 2)).values())
    h = np.array([1.0 / row.level for row in finest])
    found = {}
    for name in QUANTITIES:
        values = np.array([getattr(row, name) for row in finest])
        limit = richardson(h, values)
        found[name] = limit if np.isfinite(limit) else values[-1]
    return found


def errors(found, name, limit):
    """Relative errors of a quantity in rows by level, with signs, shape (n,)."""
    return np.array([getattr(row, name) for row in found.values()]) / limit - 1.0


def markdown(rows):
    """Tables: all errors, then what is shape and what is locking for linear elements."""
    exact = limits(rows)
    lines = [
        "| elements | level | unknowns | volume | tip deflection | flap | edge |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for kind, words in KINDS.items():
        found = of_kind(rows, kind)
        for row in found.values():
            wrong = (getattr(row, name) / exact[name] - 1.0 for name in QUANTITIES)
            cells = " | ".join(map(percent, (row.volume - 1.0, *wrong)))
            lines.append(f"| {words} | {row.level} | {row.unknowns} | {cells} |")
        h = np.array([1.0 / level for level in found])
        orders = (observed_order(h, np.abs(errors(found, name, exact[name]))) for name in exact)
        volume = observed_order(h, np.array([abs(row.volume - 1.0) for row in found.values()]))
        cells = " | ".join(f"{p:.1f}" for p in (volume, *orders))
        lines.append(f"| {words} | order | | {cells} |")
    values = f"{exact['tip']:.4f} m, {exact['flap']:.4f} Hz and {exact['edge']:.4f} Hz"
    lines += ["", f"Errors against {values}.", "", *_parts(rows, exact)]
    return "\n".join(lines) + "\n"


def _parts(rows, exact):
    """Lines that tell apart the error of the shape and locking, for linear elements."""
    lines = [
        "| linear | level | quantity | error | of which shape | of which locking |",
        "| --- | ---: | --- | ---: | ---: | ---: |",
    ]
    for cell, words in (("hexahedron", "hexahedra"), ("tetrahedron", "tetrahedra")):
        linear, quadratic = of_kind(rows, (cell, 1, 1)), of_kind(rows, (cell, 2, 1))
        for level in sorted(linear.keys() & quadratic.keys()):
            for name, title in QUANTITIES.items():
                a, b = getattr(linear[level], name), getattr(quadratic[level], name)
                shares = (a / exact[name], b / exact[name], a / b)
                cells = " | ".join(percent(share - 1.0) for share in shares)
                lines.append(f"| {words} | {level} | {title.lower()} | {cells} |")
    return lines


def percent(share):
    """A share with its sign."""
    digits = 1 if abs(share) > 0.01 else 2
    return f"{100.0 * share:+.{digits}f} %"


def plot(rows, path):
    """Draw the errors of all quantities over the number of unknowns.

    Args:
        rows: The results.
        path: Picture to write.
    """
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter

    exact = limits(rows)
    style = {"font.size": 9.0, "axes.titlesize": 10.0, "axes.titlelocation": "left"}
    style |= {"axes.spines.top": False, "axes.spines.right": False, "savefig.dpi": 200}
    with matplotlib.rc_context(style):
        figure = Figure(figsize=(9.6, 3.9), layout="constrained")
        panels = figure.subplots(1, len(QUANTITIES), sharey=True, sharex=True)
        for axes, (name, title) in zip(panels, QUANTITIES.items(), strict=True):
            linear, found = of_kind(rows, LINEAR), of_kind(rows, SHAPE)
            n = [linear[level].unknowns for level in found]
            e = 100.0 * np.abs(errors(found, name, exact[name]))
            axes.loglog(n, e, "--", color="#888888", lw=1.2, label="their shape alone")
            for kind, words in KINDS.items():
                found = of_kind(rows, kind)
                color, marker, filled = STYLES[kind]
                n = np.array([row.unknowns for row in found.values()])
                e = 100.0 * np.abs(errors(found, name, exact[name]))
                face = color if filled else "white"
                axes.loglog(n, e, f"{marker}-", color=color, mfc=face, ms=5.0, lw=1.4, label=words)
            paper = linear.get(PAPER)
            if paper:
                e = 100.0 * abs(getattr(paper, name) / exact[name] - 1.0)
                axes.annotate(
                    f"the paper's mesh\n{percent(getattr(paper, name) / exact[name] - 1.0)}",
                    (paper.unknowns, e),
                    (0, 9),
                    textcoords="offset points",
                    fontsize=8.0,
                )
            axes.set(title=title, xlabel="unknowns")
            axes.grid(color="#dddddd", lw=0.6)
            axes.set_axisbelow(True)
        panels[0].set_ylabel("error")
        panels[0].yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g} %"))
        low, high = panels[0].get_ylim()
        panels[0].set_ylim(low, 3.0 * high)
        handles, labels = panels[0].get_legend_handles_labels()
        for items in (handles, labels):
            items.insert(1, items.pop(0))  # after the linear hexahedra
        figure.legend(handles, labels, loc="lower center", ncols=5, frameon=False)
        figure.get_layout_engine().set(rect=(0.0, 0.08, 1.0, 0.92))
        figure.savefig(path)
