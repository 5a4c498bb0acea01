"""Field output of any system: parts, their names, boxes of rigid bodies, what carries what."""

import importlib.util
from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest
from dolfinx import mesh
from outputs import read_fields

from turbine_fenicsx import (
    Coupling,
    FlexibleBody,
    Gravity,
    MultibodySystem,
    Revolute,
    RigidBody,
    Simulation,
    StVenantKirchhoff,
)
from turbine_fenicsx.bodies.rigid_surface import inertia_box
from turbine_fenicsx.cli.main import main
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.records.output_folder import read_field_parts
from turbine_fenicsx.records.parts import Part
from turbine_fenicsx.simulation.observers.field_grid import find_carriers
from turbine_fenicsx.simulation.observers.fields import Fields
from turbine_fenicsx.simulation.observers.history import History, angle_channel, energy_channel

pytestmark = pytest.mark.parallel

comm = MPI.COMM_WORLD


@pytest.fixture
def folder(tmp_path):
    """A folder that all ranks share."""
    return Path(comm.bcast(str(tmp_path)))


def pendulum():
    """A rigid arm on the ground, a flexible rod below it, and a weight at its end."""
    arm = RigidBody("arm", 2.0, euler=(0.06, 0.24, 0.0), position=(0.0, -0.5, 0.0))
    weight = RigidBody("weight", 3.0, euler=(0.01, 0.01, 0.01), position=(0.0, -2.1, 0.0))
    box = [(-0.05, -2.0, -0.05), (0.05, -1.0, 0.05)]
    cells = mesh.create_box(comm, box, [1, 8, 1], mesh.CellType.hexahedron)

    def facets(y):
        return mesh.locate_entities_boundary(cells, 2, lambda x: np.isclose(x[1], y))

    rod = FlexibleBody("rod", cells, StVenantKirchhoff(1e7, 1e7), density=1000.0)
    return MultibodySystem(
        comm,
        [
            arm,
            weight,
            rod,
            Revolute("pivot", None, arm, point=(0, 0, 0), axis=(0, 0, 1)),
            Coupling("grip", rod, facets(-1.0), arm),
            Coupling("end", rod, facets(-2.0), weight),
            Gravity((3.0, -9.81, 0.0)),
        ],
    )


def test_outputs_at_no_distance_at_all_are_those_of_all_steps(folder):
    system = pendulum()
    path = folder / "often.xdmf"
    Simulation(system, 0.02, 0.06, [Fields(system, path, every=1e-320, end=0.06)]).run()
    comm.Barrier()
    assert list(read_fields(path)) == pytest.approx([0.0, 0.02, 0.04, 0.06])


def test_any_system_is_written_with_default_parts(folder):
    system = pendulum()
    path = folder / "fields.xdmf"
    Simulation(system, 0.02, 0.1, [Fields(system, path, every=0.05, end=0.1)]).run()
    comm.Barrier()
    found = read_fields(path)
    assert list(found) == pytest.approx([0.0, 0.06, 0.1])
    assert read_field_parts(path).parts == (
        Part(0, "arm", "arm", 0),
        Part(1, "weight", "weight", 2),
        Part(2, "rod", "rod"),
    )
    assert read_field_parts(path).roots == {1: 0}  # the arm holds the rod, the rod the weight
    first, last = found[0.0], found[max(found)]
    assert sorted(last["part"].tolist()) == [0] * 6 + [1] * 6 + [2] * 8
    at = {k: first["Geometry"][first["coupling"] == k][:, 1] for k in (1, 2)}
    assert at[1].tolist() == pytest.approx([-1.0] * 4)
    assert at[2].tolist() == pytest.approx([-2.0] * 4)
    for name in ("displacement", "velocity", "von_mises_stress", "cauchy_stress_norm"):
        assert not first[name].any()  # exact zeros, on rigid surfaces too
        assert last[name].any()


def test_box_has_the_mass_and_euler_values_of_its_body():
    R = rotation_about((1, 2, 3), 0.8)
    body = RigidBody("arm", 2.0, (0.06, 0.24, 0.0), position=(1, 2, 3), directors=R)
    box = inertia_box(body, 4)
    sides = np.ptp(body.body_coordinates(box.points), axis=0)
    # m a^2/12 for the sides a; no thickness becomes a hundredth of the length
    assert sides == pytest.approx([0.6, 1.2, 0.012])
    assert box.points.mean(axis=0) == pytest.approx([1, 2, 3])
    corners = box.points[box.quadrilaterals]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    outwards = corners.mean(axis=1) - box.points.mean(axis=0)
    assert np.all(np.sum(normals * outwards, axis=1) > 0.0)


def test_surfaces_and_names_of_ones_own(folder):
    system = pendulum()
    map_3 = system.flexible_bodies[0].mesh.topology.index_map(3)
    numbers = np.full(map_3.size_local + map_3.num_ghosts, 7)
    path = folder / "fields.xdmf"
    writer = Fields(system, path, 1.0, 1.0, surfaces=(), parts=[numbers], names={7: "spring"})
    Simulation(system, 0.01, 0.01, [writer]).run()
    comm.Barrier()
    assert read_field_parts(path).parts == (Part(7, "spring", "rod"),)
    with pytest.raises(ValueError, match="2 arrays of parts for 1 flexible bodies"):
        Fields(system, path, 1.0, 1.0, parts=[numbers, numbers])


def test_carriers_of_a_tower_with_a_rotor_and_of_what_floats():
    from turbine_fenicsx.turbine.case.case import Case
    from turbine_fenicsx.turbine.components.model import build_turbine

    case = Case.parse({"tower": {"flexible": True}, "pitch": {"bearings": True}})
    system = build_turbine(case, comm).system
    names = [c.name for c in system.couplings]
    stands_on, roots = find_carriers(system)
    head = 1 + names.index("tower_head")
    assert {body.name: k for body, k in stands_on.items()} == {
        body.name: head for body in system.rigid_bodies
    }
    assert roots == {
        1 + names.index("tower_foot"): 0,
        **{1 + names.index(f"root_{k}"): head for k in (1, 2, 3)},
    }
    floating = MultibodySystem(comm, [RigidBody(n, 1.0, (1.0, 1.0, 1.0)) for n in "ab"])
    assert find_carriers(floating) == (dict.fromkeys(floating.rigid_bodies, 0), {})


@pytest.mark.skipif(comm.size > 1, reason="pictures are drawn by one process")
@pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in ("matplotlib", "pyvista")),
    reason="Matplotlib or PyVista, which draw, is missing",
)
@pytest.mark.filterwarnings("ignore:Unable to import Axes3D")
def test_pendulum_is_drawn_and_reported(tmp_path, capfd):
    from PIL import Image

    system = pendulum()
    history = History(comm, tmp_path / "history.csv", [energy_channel(), angle_channel(system)])
    fields = Fields(system, tmp_path / "fields.xdmf", every=0.5, end=0.5)
    Simulation(system, 0.02, 0.5, [history, fields]).run()
    assert (
        main(["render", str(tmp_path), "--times", "0,0.5", "--scale", "3", "--size", "640x360"])
        == 0
    )
    for name in ("turbine_t0.png", "turbine_t0.5.png"):
        shown = np.asarray(Image.open(tmp_path / name).convert("RGB")).min(axis=-1) < 245
        model = shown[:, 100:500]
        rows, columns = np.flatnonzero(model.any(axis=1)), np.flatnonzero(model.any(axis=0))
        assert 0 < rows[0] < rows[-1] < 359  # all of it is inside
        assert 0 < columns[0] < columns[-1] < 399
        assert len(rows) > 200  # and fills the picture
    assert main(["report", str(tmp_path), "--times", "0.5"]) == 0
    page = (tmp_path / "report.html").read_text()
    assert "There are no pictures" not in page
    assert page.count("data:image/png") >= 4
    assert "pivot" in page
