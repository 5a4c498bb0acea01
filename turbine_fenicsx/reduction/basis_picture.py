"""A picture of a basis: what its states had beyond it, and its errors along the span."""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

from turbine_fenicsx.foundation.diagram_style import LINE_STYLES, PALETTE, STYLE
from turbine_fenicsx.foundation.types import Array


def draw_basis(
    path: str | os.PathLike[str],
    singular_values: Array,
    stations: Array,
    errors: Mapping[str, tuple[Array, Array]],
) -> None:
    """Draw singular values and errors.

    Args:
        path: Picture to write.
        singular_values: The largest first, shape (k,) [sqrt(J)].
        stations: Places along the span, shape (stations,).
        errors: Errors of displacement [% of that of the tip] and twist [deg] at the stations, of
            each state by its name.

    Raises:
        ImportError: if Matplotlib is missing.
    """
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    with matplotlib.rc_context(STYLE):
        rows = 2 + 0.11 * len(errors)
        figure = Figure(figsize=(11.0, 2.0 + rows), layout=ConstrainedLayoutEngine())
        left, middle, right = figure.subplots(1, 3)
        shown = singular_values[singular_values > 1e-6 * max(singular_values, default=0.0)]
        left.semilogy(np.arange(1, len(shown) + 1), shown, "o-", ms=3.0, color=PALETTE[0])
        left.set(title="Equilibria beyond the first functions", xlabel="number")
        left.set_ylabel("singular value [√J]")
        for k, (name, pair) in enumerate(errors.items()):
            look = {
                "color": PALETTE[k % len(PALETTE)],
                "linestyle": LINE_STYLES[k // len(PALETTE) % len(LINE_STYLES)],
            }
            for axes, values in zip((middle, right), pair, strict=True):
                axes.plot(stations, values, label=name, **look)
        middle.set(title="Error of the displacement", ylabel="of that of the tip [%]")
        right.set(title="Error of the twist", ylabel="[deg]")
        for axes in (middle, right):
            axes.set(xlabel="place along the span", xlim=(0.0, 1.0))
            axes.set_ylim(bottom=0.0)
        if errors:
            handles, labels = middle.get_legend_handles_labels()
            figure.legend(handles, labels, loc="outside lower center", ncols=2)
        figure.savefig(os.fspath(path))
