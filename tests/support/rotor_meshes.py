"""Meshes of the default blades, made once, and files of them, for tests."""

from functools import cache

from mpi4py import MPI

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing import BladeGeometry, MeshOptions, RotorLayout
from turbine_fenicsx.meshing.rotor import mesh_rotor, write_msh

comm = MPI.COMM_WORLD
BLADE = BladeGeometry()
ROTOR = RotorLayout()
ONE_BLADE = RotorLayout(azimuths=(0.0,))
KINDS = [("hexahedron", 1), ("hexahedron", 2), ("tetrahedron", 1), ("tetrahedron", 2)]


@cache
def arrays_of(cell, degree, **kwargs):
    return mesh_rotor(BLADE, ONE_BLADE, MeshOptions(cell, degree, **kwargs))


def arrays(cell, degree, elements=(2, 2, 12), size=None):
    return arrays_of(cell, degree, elements=elements, size=size)


def write(file, mesh):
    on_rank0(comm, lambda: write_msh(mesh, file))
