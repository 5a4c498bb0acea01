"""Claims about the linear solver that "auto" stands for, and the memory that it is chosen by."""

import numpy as np
import pytest
from dolfinx.mesh import CellType, create_unit_cube
from rotor_meshes import BLADE, ROTOR

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.linear_solvers.choice import choose_solver
from turbine_fenicsx.linear_solvers.memory import (
    FITS,
    choose_by_memory,
    estimate_memory,
    shares_factor,
)
from turbine_fenicsx.materials import StVenantKirchhoff
from turbine_fenicsx.meshing import MeshOptions, load_arrays
from turbine_fenicsx.meshing.rotor import mesh_rotor
from turbine_fenicsx.meshing.size import MeshSize
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel


@pytest.fixture
def memory(monkeypatch):
    """Sets the memory of the machines [B]."""
    name = "turbine_fenicsx.linear_solvers.choice.machine_memory"
    return lambda size: monkeypatch.setattr(name, lambda comm: size)


def test_solver_is_chosen_by_memory_and_shape(machine, memory, comm):
    rod = machine().system()
    cube = create_unit_cube(comm, 12, 12, 12, CellType.hexahedron)
    solid = MultibodySystem(comm, [FlexibleBody("cube", cube, StVenantKirchhoff(1.0, 1.0), 1.0)])
    memory(10e9 * comm.size)
    assert choose_solver("auto", rod) == choose_solver("auto", solid) == "frozen"
    memory(0.2e9 * comm.size)
    assert choose_solver("auto", solid) == "iterative"
    # two cells: a rod, whose factor is small at any length
    assert choose_solver("auto", rod) == "frozen"
    assert choose_solver("lu", solid) == "lu"


@pytest.mark.parametrize(("layers", "most"), [(24, 4), (8, 1)])
def test_equal_blades_need_less_where_ranks_have_the_same_slab_of_each(
    comm, memory, monkeypatch, layers, most
):
    arrays = mesh_rotor(BLADE, ROTOR, MeshOptions("hexahedron", 1, elements=(4, 4, layers)))
    mesh = load_arrays(comm, lambda: arrays, "rotor").mesh
    body = FlexibleBody("blades", mesh, StVenantKirchhoff(1.0, 1.0), 1.0)
    system = MultibodySystem(comm, [body])
    cells, nodes = 48 * layers, 75 * (layers + 1)
    counts = MeshSize("hexahedron", cells, nodes, nodes, parts=3, layers=layers)
    monkeypatch.setattr("turbine_fenicsx.linear_solvers.memory.SOLID", {"hexahedron": 0.5})
    monkeypatch.setattr("turbine_fenicsx.linear_solvers.memory.EQUAL_PARTS", 1e3)
    shared, own = (estimate_memory("frozen", [counts], comm.size, x) for x in (True, False))
    memory((shared + 0.5 * (own - shared)) / FITS - 1e6)
    assert choose_solver("auto", system) == ("frozen" if comm.size <= most else "iterative")
    assert shared < own
    assert shares_factor(counts, comm.size) == (comm.size <= most)


@pytest.mark.parametrize(
    ("cell", "section", "layers", "expected"),
    [
        ("hexahedron", (8, 8), 10**4, "iterative"),
        ("hexahedron", (8, 8), 10, "frozen"),  # small
        ("hexahedron", (1, 400), 10**4, "frozen"),  # a wall
        ("tetrahedron", (8, 8), 10**4, "iterative"),
        ("tetrahedron", (1, 400), 10**4, "frozen"),
    ],
)
def test_iteration_is_for_solids_whose_factor_does_not_fit(cell, section, layers, expected):
    cells = np.prod(section) * layers * {"hexahedron": 1, "tetrahedron": 6}[cell]
    vertices = np.prod(np.add(section, 1)) * (layers + 1)
    counts = MeshSize(cell, cells, vertices, vertices)
    assert choose_by_memory([counts], 1, True, 10e9) == expected
    assert choose_by_memory([counts], 1, True, 200e9) == "frozen"
