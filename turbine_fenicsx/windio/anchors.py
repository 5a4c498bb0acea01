"""Anchors: places along a contour that layers and webs refer to."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.windio.curves import Curve, read_curve
from turbine_fenicsx.windio.entry import Entry

HANDLES = ("start_nd_arc", "end_nd_arc", "midpoint_nd_arc")
"""What an anchor can be asked for."""

LONGEST = 20
"""References from anchor to anchor."""

_SMALL = 1e-4
"""Places may lie outside of 0 to 1 by this much."""


class Anchors:
    """A list of anchors, of the shell or of a web.

    Args:
        entry: The list.
        others: Where anchors are sought that are not in the list.
    """

    def __init__(self, entry: Entry | None, others: Anchors | None = None) -> None:
        self._anchors = {e["name"].text(): e for e in entry.entries()} if entry else {}
        self._others = others
        self._known: dict[tuple[str, str], Curve] = {}

    def resolve(self, place: Entry) -> Curve:
        """Where something lies along the span.

        Args:
            place: A curve, or a reference to an anchor.

        Raises:
            ModelError: for an anchor that does not exist or has no resolved places.
        """
        return self._resolve(place, ())

    def _resolve(self, place: Entry, trail: tuple[str, ...]) -> Curve:
        if "anchor" not in place:
            curve = read_curve(place, -_SMALL, 1.0 + _SMALL)
            return Curve(curve.grid, np.clip(curve.values, 0.0, 1.0))
        reference = place["anchor"]
        name, handle = reference["name"].text(), reference["handle"].text()
        if handle not in HANDLES:
            reference.fail(f"has the handle {handle!r}, allowed are {', '.join(HANDLES)}")
        step = f"{name}.{handle}"
        if step in trail:
            reference.fail(f"refers to itself: {quote(' to '.join((*trail, step)))}")
        if len(trail) >= LONGEST:
            reference.fail(f"is reached by more than {LONGEST} references, one after the other")
        anchors = self._find(name)
        if anchors is None:
            reference.fail(f"names the anchor {name!r}, which does not exist")
        if (name, handle) not in anchors._known:
            anchors._known[name, handle] = anchors._follow(name, handle, (*trail, step))
        return anchors._known[name, handle]

    def _follow(self, name: str, handle: str, trail: tuple[str, ...]) -> Curve:
        anchor = self._anchors[name]
        if handle in anchor:
            return self._resolve(anchor[handle], trail)
        if handle == HANDLES[2] and HANDLES[0] in anchor and HANDLES[1] in anchor:
            start, end = (self._resolve(anchor[h], trail) for h in HANDLES[:2])
            grid = np.union1d(start.grid, end.grid)
            return Curve(grid, 0.5 * (start(grid) + end(grid)))
        anchor.fail(
            f"is not resolved: it has no {handle!r} with grid and values (widths, offsets and "
            "planes alone are not read, the program that writes the file resolves them)"
        )

    def _find(self, name: str) -> Anchors | None:
        if name in self._anchors:
            return self
        return self._others._find(name) if self._others else None
