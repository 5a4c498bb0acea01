"""Claims about turbines that a case takes from a windIO file."""

import json
from pathlib import Path

import numpy as np
import pytest
from windio_files import IEA_15, IEA_22, find_turbine, load_yaml, small_turbine, write_turbine

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.description import describe_bearings, describe_case
from turbine_fenicsx.turbine.case.turbine_file import describe_file, list_origins, load_turbine
from turbine_fenicsx.turbine.components.tower import tower_geometry
from turbine_fenicsx.turbine.run.inspection import inspect_mesh
from turbine_fenicsx.turbine.run.resume import label_case, write_case


@pytest.fixture
def folder(tmp_path):
    """A folder with the file of a small turbine."""
    write_turbine(small_turbine(), tmp_path)
    return tmp_path


def parse(folder, turbine=(), **tables):
    """A case of the small turbine."""
    return Case.parse({"turbine": {"file": "small.yaml", **dict(turbine)}, **tables}, folder)


def test_values_of_the_file_become_those_of_the_keys(folder):
    """windIO's x, y, z point downwind, to the left looking downwind, up: e3, e1, e2."""
    case = parse(folder, time={"start": "equilibrium"})
    t = case.turbine
    assert (t.hub_distance, t.hub_rise) == (3.0, 1.5)
    assert np.degrees([t.tilt, t.precone]) == pytest.approx([-5.0, -3.0])  # away from the tower
    assert t.nacelle.mass == 1e4
    assert t.nacelle.centre == (0.0, 1.0, -1.0)
    assert t.nacelle.tensor == ((2e4, 0.0, 0.0), (0.0, 2e4, 1e3), (0.0, 1e3, 3e4))
    assert t.hub.centre == (0.0, 1.0, -1.0)
    assert (case.blade.hub_radius, case.blade.length) == (1.0, pytest.approx(20.0, rel=1e-2))
    assert case.material.law == "windio"
    assert case.warnings == []


def test_the_tower_of_the_file_is_flexible_and_has_its_mass_and_stiffness(folder):
    tower = parse(folder).tower
    assert tower.flexible and tower.height == 38.5
    assert (tower.young, tower.poisson) == (2e11, 0.265)
    mass = np.pi * 0.02 * (2.5 - 0.02) * 38.5 * 7850.0 * 1.05  # mean diameter, outfitting
    assert tower_geometry(tower).volume * tower.density == pytest.approx(mass, rel=1e-12)
    assert tower.top_mass == 1e4  # the yaw system


def test_the_tower_of_a_published_turbine_has_the_published_sections():
    """Bending stiffness and mass per length that the file has beside diameters and walls."""
    case = Case.parse({"turbine": {"file": IEA_22}})
    given = load_yaml(find_turbine(IEA_22))["components"]["tower"]["structure"]
    stiffness = given["elastic_properties"]["stiffness_matrix"]
    t, s = case.tower, np.array(stiffness["grid"])
    d, w = (np.interp(s, t.stations, values) for values in (t.diameters, t.walls))
    bending = t.young * np.pi / 64.0 * (d**4 - (d - 2.0 * w) ** 4)
    error = bending / np.array(stiffness["K44"]) - 1.0
    assert np.abs(error).max() < 0.04  # at one station, where the diameter has a kink
    assert np.median(np.abs(error)) < 0.007


def test_without_a_flexible_tower_nothing_of_it_is_taken(folder):
    case = parse(folder, tower={"flexible": False}, loads={"gravity": 0.0})
    assert case.tower == Case.parse({"tower": {"flexible": False}}).tower
    assert case.warnings == []


def test_the_case_overrides_single_values(folder):
    case = parse(
        folder,
        {"tilt": "-7 deg", "hub": {"mass": "2 t"}},
        blade={"hub_radius": 1.2},
        tower={"young": "100 GPa"},
    )
    assert np.degrees(case.turbine.tilt) == pytest.approx(-7.0)
    assert case.turbine.hub.mass == 2000.0
    assert case.turbine.hub.centre == (0.0, 1.0, -1.0)
    assert plan_rotor(case).blades.hub_radius == 1.2
    taken, overridden = list_origins(case)
    assert overridden == ["turbine.tilt", "turbine.hub.mass", "blade.hub_radius", "tower.young"]
    assert "turbine.hub.centre" in taken and "tower.walls" in taken
    told = "\n".join(describe_file(case))
    assert "small.yaml: small" in told
    assert "overridden by the case: turbine.tilt, turbine.hub.mass" in told


def test_euler_values_of_the_case_replace_the_tensor_of_the_file(folder):
    case = parse(folder, {"hub": {"euler": [1e4, 1e4, 1e4]}})
    assert case.turbine.hub.inertia is None
    assert case.turbine.hub.euler == (1e4, 1e4, 1e4)


def test_a_file_stands_beside_the_case_or_among_the_examples(folder, tmp_path, monkeypatch):
    path = folder / "case.toml"
    path.write_text('[turbine]\nfile = "small.yaml"\n')
    monkeypatch.chdir("/")
    assert Case.load(path).turbine.file == str(folder / "small.yaml")
    example = find_turbine(IEA_22)
    assert Case.load(path, [f"turbine.file={IEA_22}"]).turbine.file == str(example)
    with pytest.raises(InputError, match=r"there is no windIO file 'none.yaml' in .*pip install"):
        Case.load(path, ["turbine.file=none.yaml"])


def test_the_demo_is_a_case_without_warnings(comm):
    """And its mesh can be made."""
    path = Path(__file__).parents[4] / "demos" / "iea15" / "iea15.toml"
    find_turbine(IEA_15)
    case = Case.load(path)
    assert case.warnings == []
    found = inspect_mesh(case, comm)
    assert found.mistakes == found.warnings == ()
    assert "mass of a blade 66." in found.report  # 67.0 t by the published sections


@pytest.mark.parametrize(
    ("tables", "sentence"),
    [
        ({"blade": {"stations": [0, 1]}}, "blade.stations = .*expected none beside turbine.file"),
        ({"blade": {"length": 25.0}}, "blade.length = 25: .*whose blades have 20"),
        ({"material": {"young": [1e9, 1e9, 1e9]}}, "material.young = .*has the layup of the"),
        ({"material": {"density": 1e3}}, "material.density = .*has the layup of the blades"),
        ({"material": {"law": "neo_hooke"}}, 'material.law = "neo_hooke": expected "windio"'),
        ({"mesh": {"elements": [1, 1, 1]}}, "mesh.elements = .*mesh.span and mesh.around"),
        ({"mesh": {"span": 0}}, "mesh.span = 0"),
        ({"mesh": {"span": 100_000, "around": 100_000}}, "expected at most 1000000 elements"),
        ({"blade": {"layup": "plies"}}, "blade.layup = 'plies'"),
    ],
)
def test_keys_that_contradict_the_file_are_refused(folder, tables, sentence):
    with pytest.raises(InputError, match=sentence) as caught:
        parse(folder, **tables)
    assert len(str(caught.value).splitlines()) == 1


def test_a_layup_needs_a_file():
    with pytest.raises(InputError, match=r'material.law = "windio": expected turbine.file'):
        Case.parse({"material": {"law": "windio"}})
    case = Case.parse({"blade": {"layup": "laminate"}})
    assert case.warnings == ["blade.layup has no effect without turbine.file"]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda t: t["assembly"].update(number_of_blades=2), "has 2 blades, expected 3"),
        (lambda t: t["assembly"].update(rotor_orientation="Downwind"), "in front of it"),
        (lambda t: t["components"].pop("drivetrain"), "has no components.drivetrain,"),
        (
            lambda t: t["components"]["hub"].pop("elastic_properties"),
            "has no components.hub.elastic_properties",
        ),
        (lambda t: t.update(windIO_version="1.0"), "is of windIO 1"),
    ],
)
def test_turbines_that_cannot_be_built_are_refused(folder, change, sentence):
    tables = small_turbine()
    change(tables)
    write_turbine(tables, folder, "other.yaml")
    with pytest.raises(InputError, match=sentence) as caught:
        parse(folder, {"file": "other.yaml"})
    assert len(str(caught.value).splitlines()) == 1  # nothing that only follows from it


def test_masses_that_a_file_does_not_have_are_those_of_the_case(folder):
    tables = small_turbine()
    for component in ("drivetrain", "hub"):
        del tables["components"][component]["elastic_properties"]
    write_turbine(tables, folder, "light.yaml")
    given = {"mass": "9 t", "inertia": ["9e3 kg m^2"] * 3}
    case = parse(folder, {"file": "light.yaml", "nacelle": given, "hub": given})
    assert case.turbine.nacelle.mass == case.turbine.hub.mass == 9e3
    with pytest.raises(InputError) as caught:
        parse(folder, {"file": "light.yaml", "nacelle": {"mass": "9 t"}, "hub": given})
    assert str(caught.value) == (
        "turbine.file: light.yaml has no components.drivetrain.elastic_properties: give "
        "turbine.nacelle.mass and turbine.nacelle.inertia, and turbine.nacelle.centre if it is not "
        "zero"
    )


@pytest.mark.parallel
def test_a_case_of_an_output_folder_is_the_same_again(comm, shared_tmp_path):
    if comm.rank == 0:
        write_turbine(small_turbine(), shared_tmp_path)
    comm.barrier()
    case = parse(shared_tmp_path, {"tilt": "-7 deg"})
    write_case(case, shared_tmp_path, comm)
    data = json.loads((shared_tmp_path / "case.json").read_text())
    assert Case.parse(data) == case
    assert Path(data["turbine"]["file"]).is_absolute()
    data["turbine"]["file"] = "/moved/away.yaml"  # a report is made without the file
    told = describe_case(data)
    assert "young" not in told["material"] and "stations_[m]" not in told["blade"]
    assert told["turbine"]["tilt_[rad]"] == case.turbine.tilt
    assert "rated speed" not in "".join(describe_file(case))


def test_a_run_knows_the_contents_of_its_file(folder):
    before = label_case(parse(folder))
    tables = small_turbine()
    tables["materials"][0]["rho"] += 1.0
    write_turbine(tables, folder)
    after = label_case(parse(folder))
    assert before["case"] == after["case"]
    assert before["windIO file"] != after["windIO file"]


def test_the_rated_speed_is_told_where_the_file_has_it(folder):
    tables = small_turbine() | {"control": {"rated_rotor_speed": 28.5}}
    write_turbine(tables, folder, "other.yaml")
    told = describe_file(parse(folder, {"file": "other.yaml"}))
    assert told[-1] == "rated speed of the rotor 28.5 rpm"


DEFAULT = "blades 0.5 % of flap_1 and edge_1"


@pytest.mark.parametrize(
    ("damping", "line"),
    [
        ({}, DEFAULT),
        ({"speed": "7.56 rpm"}, f"{DEFAULT}, at 7.56 rpm"),
        (
            {"flap_1": "1 %"},
            "blades 1 % of flap_1, others in proportion to their frequencies (without the default "
            "of edge_1)",
        ),
        ({"flap_1": "1 %", "edge_1": "1 %"}, "blades 1 % of flap_1 and edge_1"),
        ({"flap_1": 0, "speed": "7 rpm"}, "none"),
    ],
)
def test_defaults_of_damping_count_where_no_mode_has_a_ratio(folder, damping, line):
    tables = {"turbine": {"file": "small.yaml"}, "blade": {"damping": damping}}
    case = Case.parse(tables | {"tower": {"flexible": False}}, folder)
    assert describe_bearings(case)[1] == f"structural damping: {line}"


@pytest.mark.parametrize("speed", [-1.0, 1e9])
def test_absurd_speeds_of_damped_blades_are_refused(speed):
    with pytest.raises(InputError, match=r"blade\.damping\.speed"):
        Case.parse({"blade": {"damping": {"flap_1": 0.01, "speed": speed}}})


def test_damping_that_is_not_read_is_named(folder):
    tables = small_turbine()
    damping = {"mu": [0.004, 0.004, 4e-4, 0, 0, 0], "ratio": 0.01}
    tables["components"]["tower"]["structure"]["elastic_properties"] = {
        "structural_damping": damping
    }
    write_turbine(tables, folder)
    place = "components.tower.structure.elastic_properties.structural_damping"
    lines = describe_file(Case.parse({"turbine": {"file": "small.yaml"}}, folder))
    assert f"not read: {place}.mu = [0.004, 0.004, 0.0004, 0, 0, 0], which has nothing for" in (
        lines[-2].replace(" bending", "")
    )
    assert lines[-1] == f"not read: {place}.ratio"


def test_a_file_that_changed_is_read_again(folder):
    assert parse(folder).turbine.hub_distance == 3.0
    tables = small_turbine()
    tables["components"]["drivetrain"]["outer_shape"]["overhang"] = 3.25
    write_turbine(tables, folder)
    assert parse(folder).turbine.hub_distance == 3.25


def test_everything_that_a_file_lacks_is_in_one_report(folder):
    tables = small_turbine()
    components = tables["components"]
    del components["drivetrain"]["elastic_properties"], components["hub"]["elastic_properties"]
    del components["hub"]["diameter"]
    write_turbine(tables, folder, "light.yaml")
    with pytest.raises(InputError) as caught:
        parse(folder, {"file": "light.yaml"})
    drivetrain, hub, diameter = str(caught.value).splitlines()
    assert "no components.drivetrain.elastic_properties: give turbine.nacelle.mass" in drivetrain
    assert "no components.hub.elastic_properties: give turbine.hub.mass" in hub
    assert diameter.endswith("no components.hub.diameter: give blade.hub_radius, half of it")


def test_each_component_is_read_although_others_are_wrong(folder):
    tables = small_turbine()
    tables["components"]["drivetrain"]["outer_shape"]["uptilt"] = "steep"
    tables["components"]["tower"]["structure"]["layers"] = []
    del tables["components"]["blade"]["outer_shape"]["chord"]
    write_turbine(tables, folder, "bad.yaml")
    with pytest.raises(InputError) as caught:
        parse(folder, {"file": "bad.yaml"})
    lines = str(caught.value).splitlines()
    assert len(lines) == 3
    for words in ("has no 'chord'", "uptilt must be a finite number", "tower.structure.layers"):
        assert sum(words in line for line in lines) == 1


def test_the_hub_of_the_case_counts_where_the_file_has_no_diameter(folder):
    tables = small_turbine()
    del tables["components"]["hub"]["diameter"]
    write_turbine(tables, folder, "hubless.yaml")
    data = {"turbine": {"file": "hubless.yaml"}, "blade": {"hub_radius": "1.1 m"}}
    case = Case.parse(data, folder)
    assert case.blade.hub_radius == 1.1
    taken, overridden = list_origins(case)
    assert "blade.hub_radius" not in [*taken, *overridden]
    assert not [x for x in case.warnings if "hub" in x]


def test_webs_whose_layers_reach_a_station_too_far_are_read_as_far_as_they_go(folder):
    tables = small_turbine()
    structure = tables["components"]["blade"]["structure"]
    structure["webs"][0]["anchors"][0] |= {
        key: {"grid": [0.0, 0.8], "values": [value] * 2}
        for key, value in (("start_nd_arc", 0.0), ("end_nd_arc", 1.0))
    }
    for layer in structure["layers"]:
        if layer.get("web"):
            grid, values = [0.0, 0.1, 0.12, 0.79, 0.83, 1.0], [0, 0, 2e-3, 2e-3, 0, 0]
            layer["thickness"] = {"grid": grid, "values": [float(x) for x in values]}
    write_turbine(tables, folder, "web.yaml")
    case = Case.parse({"turbine": {"file": "web.yaml"}}, folder)
    told = [x for x in case.warnings if "it is read as far as they go" in x]
    assert len(told) == 3 and "from 0.11 to 0.81, its anchors from 0 to 0.8" in told[0]
    (web,) = load_turbine(case.turbine.file).blade.webs
    assert (web.start, web.end) == pytest.approx((0.11, 0.8))
