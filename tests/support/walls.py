"""Walls of one quadratic hexahedron through the thickness, for tests."""

import runpy
from pathlib import Path

import numpy as np

from turbine_fenicsx.materials.ply import Ply, PlyMaterial

_BENCHMARK = Path(__file__).parents[2] / "demos" / "verification" / "laminate_walls"
_MESH = runpy.run_path(str(_BENCHMARK / "mesh.py"))
HEXAHEDRON, wall_arrays, load_wall = (
    _MESH[name] for name in ("HEXAHEDRON", "wall_arrays", "load_wall")
)
GLASS = PlyMaterial("glass", 1940.0, (44e9, 17e9, 16e9), (3.5e9, 3.3e9, 3.1e9), (0.26, 0.24, 0.3))
CARBON = PlyMaterial("carbon", 1580.0, (114e9, 8e9, 8e9), (6e9, 5e9, 4e9), (0.31, 0.3, 0.4))
FOAM = PlyMaterial("foam", 130.0, (130e6, 120e6, 110e6), (49e6, 45e6, 40e6), (0.3, 0.3, 0.3))


def laminate(*plies):
    """Plies of (material, thickness [m], angle [degree]) from the outer to the inner face."""
    return tuple(Ply(material, t, np.deg2rad(angle)) for material, t, angle in plies)
