"""Meshes of blades and tower: parametric shapes, hexahedra and tetrahedra, reading, quality."""

from turbine_fenicsx.meshing.blade import BladeGeometry, RotorLayout
from turbine_fenicsx.meshing.cache import cache_directory, cached_mesh, cached_tower
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.load import LoadedMesh, load_msh
from turbine_fenicsx.meshing.options import MeshOptions
from turbine_fenicsx.meshing.quality import MeshReport
from turbine_fenicsx.meshing.rotor import build_rotor
from turbine_fenicsx.meshing.tower import TowerGeometry, build_tower

__all__ = [
    "BladeGeometry",
    "LoadedMesh",
    "MeshError",
    "MeshOptions",
    "MeshReport",
    "RotorLayout",
    "TowerGeometry",
    "build_rotor",
    "build_tower",
    "cache_directory",
    "cached_mesh",
    "cached_tower",
    "load_msh",
]
