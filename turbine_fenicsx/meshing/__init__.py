"""Meshes of blades and tower: parametric shapes, hexahedra and tetrahedra, reading, quality."""

from turbine_fenicsx.meshing.blade import BladeGeometry, RotorLayout
from turbine_fenicsx.meshing.cache import cache_directory, cached_mesh
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.load import LoadedMesh, load_arrays, load_msh
from turbine_fenicsx.meshing.options import MeshOptions
from turbine_fenicsx.meshing.quality import MeshReport
from turbine_fenicsx.meshing.read import read_msh
from turbine_fenicsx.meshing.rotor import build_rotor, rotor_arrays
from turbine_fenicsx.meshing.tower import TowerGeometry, build_tower, tower_arrays

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
    "load_arrays",
    "load_msh",
    "read_msh",
    "rotor_arrays",
    "tower_arrays",
]
