"""Turbines of windIO files: hub, nacelle, tower, section matrices, and where files are found."""

import numpy as np
import pytest
from windio_files import IEA_15, IEA_22, curve, load_turbine, small_turbine, write_turbine

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.windio import files, find_turbine_file, read_turbine


@pytest.fixture
def small(tmp_path):
    return read_turbine(write_turbine(small_turbine(), tmp_path))


def test_numbers_of_the_whole_turbine_are_those_of_the_file(small):
    assert (small.name, small.blade_count, small.upwind) == ("small", 3, True)
    assert (small.hub_height, small.rated_power) == (40.0, 2e5)
    assert (small.hub.radius, small.hub.cone_angle) == (1.0, 3.0)
    nacelle = small.nacelle
    assert (nacelle.tilt, nacelle.overhang, nacelle.height) == (5.0, 3.0, 1.5)
    assert nacelle.gear_ratio == 50.0
    assert nacelle.generator.mass == 2e3
    assert np.diag(nacelle.generator.inertia) == pytest.approx([5e2, 3e2, 3e2])
    for part in (small.hub.body, nacelle.body, small.yaw):
        assert part.mass == 1e4
        assert part.inertia.tolist() == [[3e4, 0.0, 1e3], [0.0, 2e4, 0.0], [1e3, 0.0, 2e4]]
        assert part.location.tolist() == [-1.0, 0.0, 1.0]


def test_the_tower_is_that_of_the_file(small):
    tower = small.tower
    assert (tower.base, tower.top, tower.outfitting) == (0.0, 38.5, 1.05)
    assert tower.diameter(0.5) == 2.5
    assert tower.wall(0.5) == 0.02
    assert tower.material.name == "steel"
    assert tower.top + small.nacelle.height == small.hub_height


def test_walls_of_a_tower_in_several_layers_add_up(tmp_path):
    tables = small_turbine()
    layers = tables["components"]["tower"]["structure"]["layers"]
    layers.append(
        {**layers[0], "name": "more", "thickness": curve((0, 0.0), (0.5, 0.0), (1, 0.01))}
    )
    tower = read_turbine(write_turbine(tables, tmp_path)).tower
    assert tower.wall(np.array([0.0, 0.5, 0.75, 1.0])) == pytest.approx([0.02, 0.02, 0.025, 0.03])


def test_what_a_file_leaves_out_is_none(tmp_path):
    tables = small_turbine()
    for key in ("drivetrain", "yaw", "tower"):
        del tables["components"][key]
    del tables["components"]["hub"]["elastic_properties"]
    del tables["components"]["blade"]["structure"]["elastic_properties"]
    del tables["assembly"]["hub_height"], tables["assembly"]["rated_power"]
    turbine = read_turbine(write_turbine(tables, tmp_path))
    assert turbine.nacelle is turbine.yaw is turbine.tower is turbine.hub.body is None
    assert turbine.blade_sections is turbine.hub_height is turbine.rated_power is None


def test_a_downwind_rotor_is_told(tmp_path):
    tables = small_turbine()
    tables["assembly"]["rotor_orientation"] = "Downwind"
    assert not read_turbine(write_turbine(tables, tmp_path)).upwind


def test_section_matrices_are_symmetric_with_the_offsets_of_the_mass(small):
    sections = small.blade_sections
    assert sections.grid.tolist() == [0.0, 1.0]
    assert np.diagonal(sections.stiffness[0]).tolist() == [k * 1e10 for k in range(1, 7)]
    inertia = sections.inertia[0]  # a mass of 100 at x = y = 2, moments 2, their product 0.5
    assert inertia[:3, 3:].tolist() == [
        [0.0, 0.0, -200.0],
        [0.0, 0.0, 200.0],
        [200.0, -200.0, 0.0],
    ]
    assert inertia[3:, 3:].tolist() == [[2.0, -0.5, 0.0], [-0.5, 2.0, 0.0], [0.0, 0.0, 4.0]]
    assert np.array_equal(inertia, inertia.T)


@pytest.mark.parametrize("name", [IEA_22, IEA_15])
def test_moments_of_inertia_and_centres_of_section_matrices_go_together(name):
    """Only about the right axes: m y^2 is no more than the moment of inertia about x."""
    sections = load_turbine(name).blade_sections
    assert np.linalg.eigvalsh(sections.inertia).min() > 0.0
    assert np.linalg.eigvalsh(sections.stiffness).min() > 0.0
    outboard = (sections.grid > 0.2) & (sections.grid < 0.95)
    for matrices in (sections.stiffness, sections.inertia):
        edge, flap = matrices[outboard, 3, 3], matrices[outboard, 4, 4]
        assert np.min(edge / flap) > 1.5


def test_section_matrices_may_stand_beside_the_structure_too(tmp_path):
    tables = small_turbine()
    blade = tables["components"]["blade"]
    blade["elastic_properties"] = blade["structure"].pop("elastic_properties")
    assert read_turbine(write_turbine(tables, tmp_path)).blade_sections.stiffness[0, 0, 0] == 1e10


@pytest.mark.parametrize(
    ("name", "radius", "hub_height", "mass", "length"),
    [(IEA_22, 4.2, 170.0, 1_565_246.0, 138.20), (IEA_15, 3.97, 150.0, 644_799.0, 117.15)],
)
def test_the_turbines_of_windio_are_read_whole(name, radius, hub_height, mass, length):
    turbine = load_turbine(name)
    assert turbine.hub.radius == radius
    assert turbine.hub.cone_angle == 4.0
    assert turbine.nacelle.tilt == pytest.approx(6.0)
    assert turbine.nacelle.body.mass == pytest.approx(mass, rel=1e-6)
    assert turbine.tower.top + turbine.nacelle.height == pytest.approx(hub_height)
    assert turbine.hub_height == hub_height
    assert turbine.blade.length == pytest.approx(length, abs=0.01)


def test_the_drivetrains_inertia_is_about_its_centre_of_mass():
    """IEA-22's file has the inertia about the tower's top too, which nothing here reads."""
    body = load_turbine(IEA_22).nacelle.body
    r = body.location
    about_top = body.inertia + body.mass * (r @ r * np.eye(3) - np.outer(r, r))
    expected = [40382417.22, 113661607.76, 81137518.30, 0.0, 50512766.23, 290709.08]
    found = about_top[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    assert found == pytest.approx(expected, rel=1e-6, abs=1.0)


def test_a_file_beside_the_case_comes_before_the_examples(tmp_path):
    mine = write_turbine(small_turbine(), tmp_path, IEA_22)
    assert find_turbine_file(IEA_22, tmp_path) == mine
    assert find_turbine_file(str(mine), "elsewhere") == mine


@pytest.mark.parametrize("folder", [None, "empty"])
def test_a_missing_file_is_told_with_the_way_to_the_examples(tmp_path, monkeypatch, folder):
    monkeypatch.setattr(files, "find_windio", lambda: folder and tmp_path)
    with pytest.raises(
        InputError, match=r"no windIO file 'x\.yaml' in .*pip install --no-deps windIO"
    ):
        find_turbine_file("x.yaml", tmp_path)


@pytest.mark.parametrize("name", ["a\0b", "x" * 5000, "", "../turbine/" + IEA_22])
def test_names_that_are_none_are_refused(tmp_path, name):
    with pytest.raises(InputError):
        read_turbine(find_turbine_file(name, tmp_path / "deeper"))
