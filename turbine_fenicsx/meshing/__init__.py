"""Meshes of the rotor: parametric blades, hexahedra and tetrahedra, reading, quality."""

from turbine_fenicsx.meshing.blade import BladeGeometry, RotorLayout
from turbine_fenicsx.meshing.cache import cache_directory, cached_mesh
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.load import LoadedMesh, load_msh
from turbine_fenicsx.meshing.options import MeshOptions
from turbine_fenicsx.meshing.quality import MeshReport
from turbine_fenicsx.meshing.rotor import build_rotor

__all__ = [
    "BladeGeometry",
    "LoadedMesh",
    "MeshError",
    "MeshOptions",
    "MeshReport",
    "RotorLayout",
    "build_rotor",
    "cache_directory",
    "cached_mesh",
    "load_msh",
]
