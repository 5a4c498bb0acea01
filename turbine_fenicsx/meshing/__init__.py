"""Meshes of blades and tower: parametric shapes, hexahedra and tetrahedra, reading, quality."""

from turbine_fenicsx.meshing.blade import BladeGeometry as BladeGeometry
from turbine_fenicsx.meshing.blade import RotorLayout as RotorLayout
from turbine_fenicsx.meshing.errors import MeshError as MeshError
from turbine_fenicsx.meshing.hollow import HollowBlock as HollowBlock
from turbine_fenicsx.meshing.hollow import mesh_hollow as mesh_hollow
from turbine_fenicsx.meshing.hollow_shape import HollowShape as HollowShape
from turbine_fenicsx.meshing.hollow_shape import Web as Web
from turbine_fenicsx.meshing.load import LoadedMesh as LoadedMesh
from turbine_fenicsx.meshing.load import load_arrays as load_arrays
from turbine_fenicsx.meshing.load import load_msh as load_msh
from turbine_fenicsx.meshing.options import MeshOptions as MeshOptions
from turbine_fenicsx.meshing.quality import MeshReport as MeshReport
from turbine_fenicsx.meshing.read import read_msh as read_msh
from turbine_fenicsx.meshing.rotor import build_rotor as build_rotor
from turbine_fenicsx.meshing.rotor import mesh_rotor as mesh_rotor
from turbine_fenicsx.meshing.rotor import place_blades as place_blades
from turbine_fenicsx.meshing.rotor import write_rotor as write_rotor
from turbine_fenicsx.meshing.tower import TowerGeometry as TowerGeometry
from turbine_fenicsx.meshing.tower import build_tower as build_tower
from turbine_fenicsx.meshing.tower import mesh_tower as mesh_tower
