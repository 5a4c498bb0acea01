"""Claims about the flexible tower of a turbine: parts, masses, sizes, columns."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.materials.lame import lame_constants
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.components.tower import tower_geometry
from turbine_fenicsx.turbine.run.inspection import describe_tower
from turbine_fenicsx.turbine.run.run import make_stepper, run_case, turbine_channels
from turbine_fenicsx.turbine.run.summary import count_unknowns, list_masses, rotor_inertia
from turbine_fenicsx.turbine.tables.tower import TowerCase

pytestmark = pytest.mark.parallel

MESH = {"elements": [1, 1, 2]}
SMALL = {"flexible": True, "elements": [4, 1, 2], "degree": 1}


def a_case(model="hybrid", **tower):
    data = {"turbine": {"model": model}, "tower": SMALL | tower}
    return Case.parse(data if model == "rigid" else data | {"mesh": MESH})


@pytest.fixture(scope="module")
def turbine():
    """The hybrid turbine on a small tower."""
    from mpi4py import MPI

    return build_turbine(a_case(), MPI.COMM_WORLD)


def test_tower_stands_between_ground_and_yaw_bearing(turbine):
    system = turbine.system
    top, foot, head = (turbine.part(f"tower_{name}") for name in ("top", "foot", "head"))
    assert [body.name for body in system.flexible_bodies] == ["blades", "tower"]
    assert foot.rigid is None and head.rigid is top
    assert np.array_equal(top.position, np.zeros(3))
    (yaw,) = (joint for joint in system.joints if joint.name == "yaw")
    assert (yaw.first.name, yaw.second.name) == ("tower_top", "nacelle")
    contact = system.coupling_blocks[1]
    heights = {
        c.name: system.flexible_models[1].positions[contact.nodes[rows], 1]
        for c, rows in zip(contact.couplings, contact.slices, strict=True)
    }
    assert np.allclose(heights["tower_foot"], -80.0, rtol=0, atol=1e-12)
    assert np.allclose(heights["tower_head"], 0.0, rtol=0, atol=1e-12)
    counts = system.comm.allreduce(np.array([len(x) for x in heights.values()]))
    assert counts.tolist() == [8, 8]


def test_cells_of_the_tower_are_a_part_of_their_own(turbine):
    blades, tower = turbine.parts_of_cells()
    assert set(blades) <= {2.0, 3.0, 4.0}
    assert set(tower) <= {5.0} and turbine.part_names()[5] == "tower"


def test_the_tower_has_a_mass_but_does_not_turn_with_the_rotor(turbine, comm):
    found = list_masses(turbine)
    # four flat cells around have the area of squares
    mass = tower_geometry(TowerCase()).volume * 7850.0 * 2.0 / np.pi
    assert found["tower"] == pytest.approx(mass, rel=1e-12)
    assert found["tower_top"] == 2000.0
    without = build_turbine(Case.parse({"mesh": MESH}), comm)
    assert rotor_inertia(turbine) == pytest.approx(rotor_inertia(without), rel=1e-12)


def test_without_a_tower_there_is_nothing_of_it(comm):
    case = Case.parse({"mesh": MESH})
    turbine = build_turbine(case, comm)
    assert list(turbine.meshes) == ["blades"] and turbine.find("tower_top") is None
    channels = turbine_channels(turbine, make_stepper(turbine.case, turbine.system), stress=True)
    columns = [name for c in (*channels.history, *channels.openfast) for name in c.columns]
    assert not [name for name in columns if name.startswith(("tower", "TTDsp", "Twr"))]
    assert "tower" not in list_masses(turbine)


def test_columns_of_the_tower_follow_those_of_the_blades(turbine):
    channels = turbine_channels(turbine, make_stepper(turbine.case, turbine.system), stress=False)
    names = [name for channel in channels.history for name in channel.columns]
    start = names.index("tower_top_displacement_x_[m]")
    assert names[start - 1] == "root_moment_3_z_[Nm]"
    assert names[start + 3 : start + 10] == [
        *(f"tower_base_force_{axis}_[N]" for axis in "xyz"),
        *(f"tower_base_moment_{axis}_[Nm]" for axis in "xyz"),
        "work_of_torque_on_rotor_[J]",
    ]
    out = [name for channel in channels.openfast for name in channel.columns]
    assert out[-12:] == [
        *(f"TTDsp{name}_[m]" for name in ("FA", "SS", "Ax")),
        *(f"TTDsp{name}_[deg]" for name in ("Roll", "Ptch", "Twst")),
        *(f"TwrBsF{axis}t_[kN]" for axis in "xyz"),
        *(f"TwrBsM{axis}t_[kN-m]" for axis in "xyz"),
    ]


@pytest.mark.parametrize("model", ["rigid", "hybrid"])
def test_summary_counts_the_tower(comm, shared_tmp_path, model):
    data = a_case(model).model_dump(mode="json") | {
        "time": {"end": 0.04},
        "output": {"fields_every": 0.02},
    }
    case = Case.parse(data)
    result = run_case(case, shared_tmp_path, comm, "none")
    assert result["tower_mesh"]["cells"] == 8
    assert (result["mesh"] is None) == (model == "rigid")


@pytest.mark.parametrize("tower", [{}, {"elements": [3, 2, 4]}, {"degree": 2}], ids=str)
def test_check_describes_the_tower_and_counts_its_unknowns(comm, tower):
    case = a_case("rigid", **tower)
    size, *_, unknowns, mass = "\n".join(describe_tower(case)).splitlines()
    counted = count_unknowns(build_turbine(case, comm))
    n, m = counted["displacements"], counted["coupling_multipliers"]
    assert unknowns == f"unknowns: {n} displacements, {m} coupling multipliers"
    if not tower:
        assert size == "8 linear hexahedra, 24 nodes"
        assert mass.startswith("mass of the tower 249.1")


def test_lame_parameters_are_those_of_young_and_poisson():
    first, shear = lame_constants(210e9, 0.3)
    assert shear == pytest.approx(80.769e9, rel=1e-5)
    assert shear * (3 * first + 2 * shear) / (first + shear) == pytest.approx(210e9)
    assert first / (2 * (first + shear)) == pytest.approx(0.3)


def test_a_tower_without_a_hollow_is_refused():
    with pytest.raises(InputError, match=r"tower\.wall"):
        tower_geometry(TowerCase(wall=5.0))
