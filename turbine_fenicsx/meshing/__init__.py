"""Meshes of blades and tower: parametric shapes, hexahedra and tetrahedra, reading, quality."""

from turbine_fenicsx.meshing.blade import BladeGeometry, RotorLayout
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.hollow import mesh_hollow
from turbine_fenicsx.meshing.hollow_block import HollowBlock
from turbine_fenicsx.meshing.hollow_shape import HollowShape, Web
from turbine_fenicsx.meshing.load import LoadedMesh, load_arrays, load_msh
from turbine_fenicsx.meshing.options import MeshOptions
from turbine_fenicsx.meshing.quality import MeshReport
from turbine_fenicsx.meshing.read import read_msh
from turbine_fenicsx.meshing.rotor import build_rotor, mesh_rotor, place_blades, write_rotor
from turbine_fenicsx.meshing.tower import TowerGeometry, build_tower, mesh_tower

__all__ = [
    "BladeGeometry",
    "HollowBlock",
    "HollowShape",
    "LoadedMesh",
    "MeshError",
    "MeshOptions",
    "MeshReport",
    "RotorLayout",
    "TowerGeometry",
    "Web",
    "build_rotor",
    "build_tower",
    "load_arrays",
    "load_msh",
    "mesh_hollow",
    "mesh_rotor",
    "mesh_tower",
    "place_blades",
    "read_msh",
    "write_rotor",
]
