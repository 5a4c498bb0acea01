"""Claims about rigid blades beside a windIO file, and about root loads of rigid blades."""

import numpy as np
import pytest
from windio_files import small_turbine, write_turbine

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.postprocessing.fatigue import list_loads
from turbine_fenicsx.records.output_folder import read_history
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run.inspection import describe_rigid_blades
from turbine_fenicsx.turbine.run.run import run_case
from turbine_fenicsx.turbine.run.summary import list_masses, rotor_inertia

MESH = {"span": 5, "around": 16}


@pytest.fixture
def parse(comm, shared_tmp_path):
    """Cases of the small turbine."""

    def make(model, **tables):
        on_rank0(comm, lambda: write_turbine(small_turbine(), shared_tmp_path))
        turbine = {"file": "small.yaml", "model": model, **tables.pop("turbine", {})}
        given = {"turbine": turbine, "mesh": MESH, "tower": {"flexible": False}, **tables}
        return Case.parse(given, shared_tmp_path)

    return make


@pytest.mark.parallel
def test_masses_and_inertia_are_those_of_the_flexible_blades(comm, parse):
    rigid, flexible = (build_turbine(parse(model), comm) for model in ("rigid", "hybrid"))
    masses = list_masses(rigid)
    assert [masses[f"blade_{k}"] for k in (1, 2, 3)] == pytest.approx([masses["blade_1"]] * 3)
    assert 3.0 * masses["blade_1"] == pytest.approx(list_masses(flexible)["blades"], rel=1e-12)
    assert rotor_inertia(rigid) == pytest.approx(rotor_inertia(flexible), rel=1e-9)
    first, second = (t.system.balance(t.system.initial_state()) for t in (rigid, flexible))
    assert first.potential == pytest.approx(second.potential, rel=1e-9)


def test_bearings_are_locked_and_the_layup_has_an_effect(parse):
    case = parse("rigid")
    assert (case.yaw.drive, case.pitch.drive) == ("lock", "prescribed")
    assert not case.blade.damping.acts and case.material.law != "windio"
    assert not any("no effect" in sentence for sentence in case.warnings)


def test_a_controller_moves_the_pitch(parse, tmp_path):
    (tmp_path / "own.py").write_text("class Own: pass\n")
    case = parse("rigid", control={"kind": f"python:{tmp_path / 'own.py'}:Own"})
    assert case.pitch.drive == "actuator"
    assert not any("pitch.bearings" in sentence for sentence in case.warnings)


def test_masses_of_the_case_have_no_effect(parse):
    case = parse("rigid", turbine={"blade": {"mass": 1e4}})
    assert "turbine.blade has no effect beside turbine.file" in case.warnings


def test_other_shapes_are_refused(parse):
    with pytest.raises(InputError, match=r"blade.chord = .*: expected none beside turbine.file"):
        parse("rigid", blade={"chord": [1.0, 1.0, 1.0]})


def test_check_tells_the_mass(comm, parse):
    (line,) = describe_rigid_blades(parse("rigid"), comm)
    assert line.startswith("rigid blades with the inertia of their layup: mass of a blade ")
    (line,) = describe_rigid_blades(Case.parse({"turbine": {"model": "rigid"}}), comm)
    assert line == "rigid turbine, no mesh of blades"


@pytest.mark.parallel
def test_root_loads_are_those_of_flexible_blades_at_rest(comm, parse, shared_tmp_path):
    """Weight alone, the rotor held: what flexible blades exert in equilibrium."""
    still = {
        "time": {"step": 0.01, "end": 0.02, "start": "equilibrium"},
        "generator": {"keeps": "speed"},
        "output": {"fields_every": 0.0},
        "blade": {"damping": 0},
    }
    found = []
    for model in ("rigid", "hybrid"):
        run_case(parse(model, **still), shared_tmp_path / model, comm, "none")
        h = read_history(shared_tmp_path / model / "history.csv")
        columns = [c for c in h.columns if c.startswith("root_")]
        assert len(columns) == 18
        assert set(columns) >= {c for c in list_loads(h) if "root" in c}
        found.append({c: h[c][-1] for c in columns})
    rigid, flexible = found
    force = max(abs(x) for c, x in flexible.items() if "force" in c)
    moment = max(abs(x) for c, x in flexible.items() if "moment" in c)
    for column, x in flexible.items():
        size = force if "force" in column else moment
        assert rigid[column] == pytest.approx(x, abs=5e-3 * size), column


def test_root_loads_of_the_paper_carry_the_weight(comm, tmp_path):
    """Blades of the rigid turbine at rest: the hub carries their weight, and its moment."""
    tables = {
        "turbine": {"model": "rigid", "blade_arm": "29.25 m"},
        "generator": {"keeps": "speed"},
        "yaw": {"drive": "lock"},
        "pitch": {"drive": "prescribed"},
        "time": {"end": 0.04},
    }
    run_case(Case.parse(tables), tmp_path, comm, "none")
    h = {name: x[-1] for name, x in read_history(tmp_path / "history.csv").columns.items()}
    weight, arm = 1.65e4 * 9.81, 29.25 - 2.25
    # blade 2 stands upright: its z axis is up, and weight presses on the hub
    assert h["root_force_2_z_[N]"] == pytest.approx(-weight, rel=1e-9)
    assert abs(h["root_moment_2_x_[Nm]"]) < 1e-6 * weight * arm
    # those at 120 degrees bend in the plane of the rotor
    for blade in (1, 3):
        moments = [h[f"root_moment_{blade}_{axis}_[Nm]"] for axis in "xyz"]
        assert abs(moments[0]) == pytest.approx(weight * arm * np.sin(np.pi / 3.0), rel=1e-9)
        assert np.abs(moments[1:]) == pytest.approx(0.0, abs=1e-6 * weight * arm)
    assert h["root_moment_1_x_[Nm]"] == pytest.approx(-h["root_moment_3_x_[Nm]"], rel=1e-9)
