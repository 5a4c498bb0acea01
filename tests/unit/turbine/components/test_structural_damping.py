"""Claims about the structural damping of blades and tower."""

import re
import sys

import numpy as np
import pytest
from scipy.optimize import curve_fit
from seen import Seen
from windio_files import IEA_15, find_turbine, small_turbine, write_turbine

from turbine_fenicsx import Gravity, Simulation
from turbine_fenicsx.analysis.damped_modes import damped_modes
from turbine_fenicsx.analysis.turning_modes import turning_modes
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.forces.rayleigh_damping import RayleighDamping
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.joints.prescribed_motion import PrescribedMotion
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import assemble, build_turbine, list_components

BLADES = {"mesh": {"elements": [1, 1, 6], "degree": 2}}
TOWER = {
    "turbine": {"model": "rigid"},
    "tower": {"flexible": True, "elements": [6, 1, 5], "damping": "1 %"},
    "yaw": {"drive": "lock"},
    "pitch": {"drive": "prescribed"},
}
BOTH = {"flap_1": 0.005, "edge_1": 0.006}


def find_parts(comm, tables):
    case = Case.parse(tables)
    return assemble(case, list_components(case), comm).parts


def clamp_blades(comm, damping, *forces):
    """The blades of the paper without the rest of the turbine, clamped at their roots."""
    parts = find_parts(comm, BLADES | {"blade": {"damping": damping}})
    kept = [p for p in parts if isinstance(p, FlexibleBody | RayleighDamping)]
    (body, _) = kept
    roots = [p for p in parts if getattr(p, "name", "") in ROOTS]
    held = [Coupling(root.name, body, root.facets, None) for root in roots]
    return MultibodySystem(comm, [*kept, *held, *forces])


def ratios_of(found):
    return np.array([mode.damping_ratio for mode in found.modes])


def ring(system, time, step, sample):
    """Samples of a motion that begins at rest."""
    seen = Seen(lambda snapshot: sample(snapshot.state))
    Simulation(system, step, time, [seen]).run()
    return np.array(seen.values[1:])


def fit_decay(values, step):
    """Damping ratio of a vibration about its mean whose higher modes have died out first."""

    def vibration(time, a, b, mean, w, ratio):
        return np.exp(-ratio * w * time) * (a * np.cos(w * time) + b * np.sin(w * time)) + mean

    late = values[len(values) // 4 :]
    time, size = step * np.arange(len(late)), np.ptp(late)
    spectrum = np.abs(np.fft.rfft((late - late.mean()) * np.hanning(len(late))))
    w = 2.0 * np.pi * spectrum.argmax() / (step * len(late))
    guess = (size / 2.0, size / 2.0, late.mean(), w, 0.01)
    return curve_fit(vibration, time, late, guess)[0][-1]


# --- ratios are met


@pytest.mark.parallel
def test_modes_of_clamped_blades_have_the_ratios(comm):
    found = ratios_of(damped_modes(clamp_blades(comm, BOTH), count=6))
    assert found == pytest.approx(np.repeat([0.005, 0.006], 3), rel=1e-3)


def test_one_value_counts_for_the_first_modes(comm):
    found = ratios_of(damped_modes(clamp_blades(comm, "2 % logdec"), count=6))
    assert found == pytest.approx(0.02 / (2.0 * np.pi), rel=0.01)


def test_one_named_mode_is_damped_by_stiffness_alone(comm):
    system = clamp_blades(comm, {"flap_1": "1 %"})
    assert system.flexible_models[0].damping.mass == 0.0
    found = damped_modes(system, count=6)
    w = np.array([abs(mode.eigenvalue) for mode in found.modes])
    assert ratios_of(found) == pytest.approx(0.01 * w / w[0], rel=0.01)


@pytest.mark.parametrize(("key", "down"), [("edge_1", (1.0, 0, 0)), ("flap_1", (0, 0, 1.0))])
def test_free_blades_decay_so(comm, key, down):
    """Weight that sets in suddenly, in the plane of the rotor and normal to it."""
    asked = {"flap_1": 0.02, "edge_1": 0.022}
    system = clamp_blades(comm, asked, Gravity(down))
    model = system.flexible_models[0]
    upright = np.argmax(model.positions[:, 1])
    way = int(np.argmax(down))
    values = ring(system, 20.0, 0.02, lambda s: s.u[0].array_r[3 * upright + way])
    assert fit_decay(values, 0.02) == pytest.approx(asked[key], rel=0.02)


def test_turning_blades_have_the_ratios_at_their_speed(comm):
    """Modes of a rotor on a hub that nothing accelerates, at the speed of the table."""
    speed = 1.5
    tables = BLADES | {
        "blade": {"damping": BOTH | {"speed": speed}},
        "turbine": {"hub": {"mass": 1e9, "euler": [1e12] * 3}, "nacelle": {"mass": 1e9}},
        "loads": {"gravity": 0.0},
    }
    parts = [*find_parts(comm, tables), PrescribedMotion("yaw", lambda _: 0.0)]
    found = turning_modes(MultibodySystem(comm, parts), "rotor", speed, 8)
    vibrating = [mode for mode in found.modes if mode.frequency > 0.05]
    flap, edge = vibrating[:3], vibrating[3:6]
    assert [m.damping_ratio for m in flap] == pytest.approx([0.005] * 3, rel=0.02)
    assert [m.damping_ratio for m in edge] == pytest.approx([0.006] * 3, rel=0.02)


@pytest.mark.parallel
def test_modes_of_the_tower_have_the_ratios(comm):
    parts = find_parts(comm, TOWER)
    system = MultibodySystem(comm, [*parts, PrescribedMotion("rotor", lambda _: 0.0)])
    found = damped_modes(system, count=5)
    # side-side, fore-aft, torsion, and the second ones
    assert ratios_of(found)[1] == pytest.approx(0.01, rel=1e-3)
    assert ratios_of(found)[4] == pytest.approx(0.01, rel=1e-3)


def test_the_tower_decays_so(comm):
    """Weight of nacelle and rotor sets in suddenly; their overhang bends the tower forwards."""
    parts = find_parts(comm, TOWER)
    system = MultibodySystem(comm, [*parts, PrescribedMotion("rotor", lambda _: 0.0)])
    first = system.first_coordinate[next(b for b in system.rigid_bodies if b.name == "tower_top")]
    values = ring(system, 60.0, 0.05, lambda s: s.q[first + 2])
    assert fit_decay(values, 0.05) == pytest.approx(0.01, rel=0.02)


@pytest.mark.parallel
def test_the_damping_is_the_same_on_all_ranks(comm):
    tables = BLADES | {"blade": {"damping": BOTH}, "tower": TOWER["tower"]}
    found = [p for p in find_parts(comm, tables) if isinstance(p, RayleighDamping)]
    numbers = [(d.name, d.stiffness, d.mass) for d in found]
    assert comm.bcast(numbers) == numbers
    assert [d.name for d in found] == ["damping_of_blades", "damping_of_tower"]
    expected = [[1.4e-3, 2.0e-2], [1.1e-3, 2.4e-1]]
    assert np.array([n[1:] for n in numbers]) == pytest.approx(np.array(expected), rel=0.5)


def test_what_stands_on_the_tower_counts(comm):
    """The tube moves less beside a heavier nacelle, and takes a larger factor of its mass."""
    found = []
    for mass in (2e5, 8e5):
        tables = TOWER | {"turbine": {"model": "rigid", "nacelle": {"mass": mass}}}
        (damping,) = (p for p in find_parts(comm, tables) if isinstance(p, RayleighDamping))
        found.append(damping)
    assert found[1].mass > 1.2 * found[0].mass


def test_the_coarsest_tower_is_damped(comm):
    tables = TOWER | {"tower": TOWER["tower"] | {"elements": [3, 1, 1], "degree": 1}}
    tables["tower"]["damping"] = {"fore_aft_1": "1 %"}
    (damping,) = (p for p in find_parts(comm, tables) if isinstance(p, RayleighDamping))
    assert damping.stiffness > 0.0 == damping.mass


# --- what cannot be


@pytest.mark.parametrize(
    ("damping", "sentence"),
    [
        ({"flap_1": 0.005, "edge_1": 0.05}, r"blade.damping.edge_1 = 0.05: expected 0.00\d+ to "),
        ({"flap_1": 0.005, "flap_2": 0.0001}, r"blade.damping.flap_2 = 0.0001: expected 0.00\d+"),
    ],
)
def test_ratios_that_cannot_go_together_are_refused(comm, damping, sentence):
    with pytest.raises(ModelError, match=sentence):
        find_parts(comm, BLADES | {"blade": {"damping": damping}})


def test_without_slepc_one_sentence_says_what_else_can_be(comm, monkeypatch):
    monkeypatch.setitem(sys.modules, "slepc4py", None)
    case = Case.parse(TOWER)
    words = "tower.damping: modes need slepc4py.*; without it give stiffness_time, or 0"
    with pytest.raises(InputError, match=words):
        build_turbine(case, comm)
    case = Case.parse(TOWER | {"tower": TOWER["tower"] | {"damping": {"stiffness_time": 1e-3}}})
    assert build_turbine(case, comm).part("damping_of_tower").stiffness == 1e-3


@pytest.mark.parametrize("value", ["five", "-1 %", "70 %", 0.5, True, [0.1], "1 % x", "1 Hz"])
def test_a_ratio_is_a_ratio(value):
    words = r'blade.damping = .*: expected a damping ratio from 0 to 0.3, for example "0.5 %" or'
    with pytest.raises(InputError, match=words):
        Case.parse({"blade": {"damping": value}})


@pytest.mark.parametrize(
    ("tables", "sentence"),
    [
        (
            {"blade": {"damping": {"flap_1": 0.01, "flap_2": 0.01, "edge_1": 0.01}}},
            "blade.damping: expected ratios of at most 2 modes",
        ),
        (
            {"tower": {"damping": {"stiffness_time": 0.01, "fore_aft_1": 0.01}}},
            "tower.damping.stiffness_time = 0.01: expected none beside fore_aft_1",
        ),
        (
            {"blade": {"damping": 0.01}, "material": {"shear_viscosity": 1e6}},
            "blade.damping: expected none beside material.shear_viscosity",
        ),
        ({"blade": {"damping": {"flap": 0.01}}}, "unknown key 'blade.damping.flap'; did you mean"),
    ],
)
def test_contradictions_are_refused(tables, sentence):
    if "tower" in tables:
        tables["tower"]["flexible"] = True
    with pytest.raises(InputError, match=sentence):
        Case.parse(tables)


def test_units_of_ratios():
    def ratio(value):
        return Case.parse({"blade": {"damping": value}}).blade.damping.flap_1

    assert ratio("0.5 %") == ratio(0.005) == ratio("0.005") == 0.005
    assert ratio("3 % logdec") == ratio("0.03 logdec") == pytest.approx(0.03 / 2 / np.pi, rel=1e-4)


# --- defaults


def test_turbines_of_the_paper_are_not_damped():
    case = Case.parse({"tower": {"flexible": True}})
    assert not case.blade.damping.acts and not case.tower.damping.acts
    assert case.yaw.drive == "free"


def parse_file(comm, folder, tables, change=lambda tables: None):
    def write():
        small = small_turbine()
        change(small)
        write_turbine(small, folder)

    on_rank0(comm, write)
    return Case.parse({"turbine": {"file": "small.yaml"}} | tables, folder)


def test_turbines_of_a_file_are_damped_and_do_not_yaw(comm, shared_tmp_path):
    case = parse_file(comm, shared_tmp_path, {})
    assert case.blade.damping.ratios == {"flap_1": 0.005, "edge_1": 0.005}
    assert case.tower.damping.ratios == {"fore_aft_1": 0.01, "fore_aft_2": 0.01}
    assert case.yaw.drive == "lock"


def test_the_case_overrides_the_defaults(comm, shared_tmp_path):
    tables = {
        "blade": {"damping": {"edge_1": 0.01}},
        "tower": {"damping": 0},
        "yaw": {"drive": "free"},
    }
    case = parse_file(comm, shared_tmp_path, tables)
    assert case.blade.damping.ratios == {"edge_1": 0.01}
    assert not case.tower.damping.acts
    assert case.yaw.drive == "free"


def test_viscosities_take_the_place_of_the_default(comm, shared_tmp_path):
    case = parse_file(comm, shared_tmp_path, {"material": {"shear_viscosity": 1e6}})
    assert not case.blade.damping.acts


def test_a_file_with_damping_is_heeded(comm, shared_tmp_path):
    def add(tables):
        blade, tower = (tables["components"][name]["structure"] for name in ("blade", "tower"))
        blade["elastic_properties"]["structural_damping"]["mu"] = [0, 0, 0, 0.002, 0.004, 0]
        tower["elastic_properties"] = {"structural_damping": {"mu": [1.0, 1.0, 1.0, 0, 0, 0]}}

    case = parse_file(comm, shared_tmp_path, {}, add)
    assert case.blade.damping.stiffness_time == pytest.approx(0.003)
    assert case.tower.damping.ratios == {"fore_aft_1": 0.01, "fore_aft_2": 0.01}


def test_a_hollow_blade_and_its_tower_are_damped(comm, shared_tmp_path):
    mesh = {"mesh": {"span": 4, "around": 16}}
    turbine = build_turbine(parse_file(comm, shared_tmp_path, mesh), comm)
    found = [m.damping for m in turbine.system.flexible_models]
    assert all(d is not None and d.stiffness > 0.0 and d.mass > 0.0 for d in found)


@pytest.mark.slow
def test_prebent_blades_of_laminates_are_stiffer_where_they_turn(comm, caplog):
    """The walls of such blades buckle if their stiffness is linear in the centrifugal force."""
    found = {}
    for speed in ("0 rpm", "7 rpm"):
        tables = {
            "turbine": {"file": find_turbine(IEA_15).name},
            "blade": {"damping": {"flap_1": 0.01, "edge_1": 0.01, "speed": speed}},
            "mesh": {"span": 12, "around": 16},
            "tower": {"flexible": False},
        }
        caplog.clear()
        with caplog.at_level("INFO"):
            find_parts(comm, tables)
        found[speed] = [float(x) for x in re.findall(r"at ([\d.]+) Hz", caplog.text)]
    # turning modes of the whole rotor: 0.51613 to 0.53775 Hz; in the plane the speed softens
    flap, edge = np.array(found["7 rpm"]) / found["0 rpm"]
    assert flap == pytest.approx(0.53775 / 0.51613, abs=3e-3)
    assert 1.0 < edge < 1.02
