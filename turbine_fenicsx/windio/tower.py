"""The tower of a windIO file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.materials.ply import PlyMaterial
from turbine_fenicsx.windio.curves import Curve, read_curve
from turbine_fenicsx.windio.entry import Entry

HIGHEST = 1000.0
"""A tower is no higher [m]."""


@dataclass(frozen=True, eq=False)
class Tower:
    """An upright tube.

    Args:
        base: Height of its base above ground or mean sea level [m].
        top: Height of its top [m].
        diameter: Outer diameter over the fraction of its height [m].
        wall: Thickness of the wall over the fraction of its height [m].
        outfitting: Its mass over that of the tube alone [-].
    """

    base: float
    top: float
    diameter: Curve
    wall: Curve
    material: PlyMaterial
    outfitting: float

    @property
    def mass(self) -> float:
        """Mass of tube and outfitting [kg]."""
        s = np.linspace(0.0, 1.0, 401)
        area = np.pi * self.wall(s) * (self.diameter(s) - self.wall(s))
        density = self.material.density * self.outfitting
        return density * (self.top - self.base) * Curve(s, area).integral


def read_tower(entry: Entry, materials: Mapping[str, PlyMaterial]) -> Tower:
    """The component `tower`."""
    x, y, z = (
        read_curve(entry["reference_axis"][key], -HIGHEST, HIGHEST, whole=True) for key in "xyz"
    )
    if max(np.ptp(x.values), np.ptp(y.values)) > 1e-3:
        entry["reference_axis"].fail("must be upright: x and y must not change")
    if (np.diff(z.values) <= 0.0).any():
        entry["reference_axis"]["z"].fail("must rise from the base to the top")
    diameter = read_curve(entry["outer_shape"]["outer_diameter"], 0.01, 100.0, whole=True)
    structure = entry["structure"]
    layers = [(e["material"].text(), e) for e in structure["layers"].entries()]
    names = {name for name, _ in layers}
    if len(names) != 1:
        structure["layers"].fail(f"must be of one material, got {len(names)}")
    name = names.pop()
    if name not in materials:
        structure["layers"].fail(f"are of {name!r}, which is not among the materials of the file")
    walls = [read_curve(layer["thickness"], 0.0, 5.0, whole=True) for _, layer in layers]
    grid = np.unique(np.concatenate([wall.grid for wall in walls]))
    wall = Curve(grid, np.asarray(sum(wall(grid) for wall in walls)))
    wrong = grid[(wall.values <= 0.0) | (2.0 * wall.values >= diameter(grid))]
    if len(wrong):
        structure["layers"].fail(
            f"must be thicker than 0 and thinner than the radius, got {wall(wrong[0]):g} m at "
            f"station {wrong[0]:g}"
        )
    outfitting = structure.get("outfitting_factor")
    return Tower(
        base=float(z.values[0]),
        top=float(z.values[-1]),
        diameter=diameter,
        wall=wall,
        material=materials[name],
        outfitting=outfitting.number(1.0, 10.0) if outfitting else 1.0,
    )
