"""Claims about the state in which the run of a case starts."""

import os
import signal

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.forces.time_functions import Hat, Product, Ramp
from turbine_fenicsx.foundation.errors import ModelError, NoEquilibrium, StepFailure
from turbine_fenicsx.foundation.interrupts import catch_signals
from turbine_fenicsx.joints.relation import gear_pair
from turbine_fenicsx.records.conventions import OPENFAST_SIGNS
from turbine_fenicsx.records.output_folder import holds_run
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.start import initial_motion
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.loads import make_hat
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run import run
from turbine_fenicsx.turbine.run.run import make_stepper
from turbine_fenicsx.turbine.run.start import list_held, make_start

RPM = np.pi / 30.0
SMALL = {"elements": [1, 1, 4]}
TOWER = {"flexible": True, "elements": [4, 1, 2]}


def started(comm, turbine=None, time=None, **tables):
    """A case with a small mesh, its turbine, and its start."""
    case = Case.parse(
        {"mesh": SMALL, "turbine": turbine or {}, "time": {"step": 0.04, **(time or {})}, **tables}
    )
    built = build_turbine(case, comm)
    return case, built, make_start(case, built.system)


def history(case, turbine, state, end):
    """Largest tip deflection and root moment of blade 1, and energy, of each step; iterations."""
    channels = [c for component in turbine.components for c in component.channels(turbine).history]
    stepper, rows, iterations = make_stepper(case, turbine.system), [], []

    class Watch:
        name = "watch"

        def start(self, snapshot, resumed):
            pass

        def observe(self, snapshot):
            values = {
                n: v for c in channels for n, v in zip(c.columns, c.values(snapshot), strict=True)
            }
            moment = [values[f"root_moment_1_{axis}_[Nm]"] for axis in "xyz"]
            rows.append(
                (
                    snapshot.state.time,
                    values["tip_deflection_1_[m]"],
                    float(np.linalg.norm(moment)),
                    snapshot.balance.total,
                    snapshot.energy_error,
                )
            )
            iterations.append(snapshot.report.newton_iterations)

        def finish(self):
            pass

    Simulation(turbine.system, case.time.step, end, [Watch()], stepper, start=state).run()
    stepper.destroy()
    return np.array(rows), iterations


def from_hub(turbine, state):
    """Positions of the owned nodes of the blades in the axes of the hub."""
    hub = 12 * [body.name for body in turbine.system.rigid_bodies].index("hub")
    x = turbine.system.flexible_models[0].positions + state.u[0].array_r.reshape(-1, 3)
    return (x - state.q[hub : hub + 3]) @ state.q[hub + 3 : hub + 12].reshape(3, 3).T


# --- undeformed


def test_without_speed_and_azimuth_a_run_starts_as_the_system(comm):
    assert started(comm)[2] is None


@pytest.mark.parametrize("model", ["rigid", "hybrid"])
def test_the_rotor_turns_from_the_beginning(comm, model):
    _, turbine, state = started(comm, {"model": model, "rotor_speed": "12 rpm"})
    names = turbine.system.joint_coordinate_names
    rates = dict.fromkeys(names, 0.0) | {"rotor": 12 * RPM}
    expected = initial_motion(turbine.system, rates)
    assert np.allclose(state.q_dot, expected.q_dot, rtol=0, atol=1e-10)
    assert np.allclose(state.joint_rates, expected.joint_rates, rtol=0, atol=1e-12)
    for v, w in zip(state.v, expected.v, strict=True):
        assert (v - w).norm() <= 1e-10 * w.norm()
    assert np.array_equal(state.q, expected.q)


@pytest.mark.parallel
@pytest.mark.parametrize("start", ["undeformed", "turning"])
def test_the_azimuth_is_the_angle_of_the_rotor(comm, start):
    _, turbine, state = started(
        comm, {"rotor_speed": 1.0, "azimuth": "-100 deg"}, {"start": start}, tower=TOWER
    )
    names = turbine.system.joint_coordinate_names
    angle = state.joint_coordinates[names.index("rotor")]
    assert angle == pytest.approx(np.radians(-100), abs=1e-14)
    assert turbine.system.constraint_error(state) <= 1e-12
    turning_frame(turbine.system, "rotor", 1.0, state).turn(state, -angle)
    if start == "undeformed":  # what is turned back stands as it was made
        assert np.allclose(state.q, turbine.system.initial_state().q, rtol=0, atol=1e-12)
        assert state.u[0].norm() <= 1e-10


@pytest.mark.parallel
@pytest.mark.parametrize("model", ["rigid", "hybrid"])
def test_each_blade_starts_at_the_pitch_of_its_entry(comm, model):
    angles = np.radians([10.0, -5.0, 40.0])
    bearings = {"bearings": True} if model == "hybrid" else {}
    pitch = bearings | {"drive": "lock", "initial": angles.tolist()}
    _, turbine, state = started(comm, {"model": model}, pitch=pitch)
    names = turbine.system.joint_coordinate_names
    found = [state.joint_coordinates[names.index(f"pitch_{k}")] for k in (1, 2, 3)]
    assert found == pytest.approx([OPENFAST_SIGNS[f"pitch_{k + 1}"] * angles[k] for k in range(3)])
    assert turbine.system.constraint_error(state) <= 1e-12


# --- equilibrium


@pytest.mark.parametrize("tower", [{}, TOWER])
def test_a_turbine_in_equilibrium_stays_there(comm, tower):
    case, turbine, state = started(comm, {"azimuth": 0.3}, {"start": "equilibrium"}, tower=tower)
    assert state.u[0].norm(3) > 0.05
    rows, _ = history(case, turbine, state, 2.0)
    assert np.ptp(rows[:, 1]) <= 1e-3 * rows[0, 1]  # let go, the rotor hardly turns
    free = started(comm, {"azimuth": 0.3}, tower=tower)
    rows, _ = history(*free, 2.0)
    assert np.ptp(rows[:, 1]) > 0.05


def test_what_nothing_drives_is_held(comm):
    case, turbine, _ = started(comm, pitch={"bearings": True})
    assert list_held(case, turbine.system) == ["rotor", "yaw", "pitch_1", "pitch_2", "pitch_3"]
    spring = {"bearings": True, "drive": "spring", "stiffness": 1e8}
    case, turbine, _ = started(comm, pitch=spring)
    assert list_held(case, turbine.system) == ["rotor", "yaw"]
    case, turbine, _ = started(comm)
    assert list_held(case, turbine.system) == ["rotor", "yaw"]


# --- turning


@pytest.mark.parametrize(("solver", "turns", "most"), [("lu", 10, 1.0), ("frozen", 2, 2.5)])
def test_blades_keep_still_without_loads(comm, solver, turns, most):
    """One iteration per step; with the frozen factor two or three, as its tangent is not exact."""
    speed, still = 12 * RPM, {"gravity": 0.0}
    case, turbine, state = started(
        comm,
        {"rotor_speed": "12 rpm"},
        {"start": "turning"},
        loads=still,
        solver={"linear_solver": solver},
    )
    shape = from_hub(turbine, state)
    assert state.u[0].norm(3) > 1e-3
    rows, iterations = history(case, turbine, state, turns * 2 * np.pi / speed)
    assert np.ptp(rows[:, 1]) <= 1e-9 * case.blade.length
    assert np.max(np.abs(rows[:, 3] / rows[0, 3] - 1.0)) <= 1e-11
    assert np.mean(iterations) <= most
    assert np.max(np.abs(from_hub(turbine, state) - shape), initial=0.0) == 0.0  # not changed


@pytest.mark.parametrize("tower", [{}, TOWER])
def test_under_the_weight_there_is_no_shock(comm, tower):
    """Peaks of the first turn are those of the next; an undeformed start makes them higher."""
    turn, loads = 5.0, {}
    for start in ("turning",) if tower else ("turning", "undeformed"):
        case, turbine, state = started(
            comm, {"rotor_speed": "12 rpm"}, {"start": start}, tower=tower
        )
        rows, _ = history(case, turbine, state, 2 * turn)
        assert np.max(np.abs(rows[:, 4])) <= 1e-9 * np.max(np.abs(rows[:, 3]))
        loads[start] = [rows[k, 1:3].max(axis=0) for k in (rows[:, 0] <= turn, rows[:, 0] > turn)]
    first, second = loads["turning"]
    assert np.all(first <= 1.02 * second)
    if not tower:
        assert np.all(loads["undeformed"][0] > 1.4 * second)


@pytest.mark.parallel
def test_a_start_is_the_same_on_any_number_of_ranks(comm):
    args = ({"rotor_speed": "12 rpm", "azimuth": 1.0}, {"start": "turning"})
    _, turbine, state = started(comm, *args)
    _, alone, expected = started(MPI.COMM_SELF, *args)
    assert np.allclose(state.q, expected.q, rtol=0, atol=1e-9)
    assert np.allclose(state.q_dot, expected.q_dot, rtol=0, atol=1e-6)
    for name in ("u", "v"):
        sizes = [getattr(s, name)[0].norm() for s in (state, expected)]
        assert sizes[0] == pytest.approx(sizes[1], rel=1e-8)
    mine, theirs = turbine.system.balance(state), alone.system.balance(expected)
    assert mine.total == pytest.approx(theirs.total, rel=1e-10)


def test_a_rotor_that_drives_a_gear_is_refused(comm):
    case = Case.parse({"turbine": {"model": "rigid", "rotor_speed": 1.0}})
    turbine = build_turbine(case, comm)
    system = MultibodySystem(comm, [*turbine.parts, gear_pair("gear", "rotor", "yaw", 97.0)])
    with pytest.raises(ModelError, match="'gear' ties the angle of joint 'rotor'"):
        make_start(case, system)


def test_no_start_is_told_with_its_key(comm, monkeypatch):
    from turbine_fenicsx.turbine.run import start

    def fail(*args, **options):
        raise NoEquilibrium("no equilibrium at t = 0 s", "held=[...] may help")

    monkeypatch.setattr(start, "equilibrium", fail)
    with pytest.raises(StepFailure) as caught:
        started(comm, time={"start": "equilibrium"})
    assert str(caught.value) == (  # in keys of the case
        'time.start = "equilibrium": no equilibrium at t = 0 s; time.start = "undeformed" with '
        "time.ramp lets the loads set in gradually"
    )


# --- ramp


def test_torques_set_in_smoothly():
    loads = Case.parse({"loads": {"duration": 3.0}}).loads
    assert make_hat(loads, 0.0) == Hat(1.0, 3.0)
    hat = make_hat(loads, 1.0)
    assert hat == Product(Hat(1.0, 3.0), Ramp(1.0, 1.0, smooth=True))
    assert hat(2.0) == Hat(1.0, 3.0)(2.0) > hat(0.5) > 0.0 == hat(0.0)
    assert hat(0.01) < 1e-3 * Hat(1.0, 3.0)(0.01)


def test_the_balance_of_energy_closes_with_a_ramp(comm):
    case, turbine, _ = started(
        comm,
        {"model": "rigid"},
        {"ramp": "1 s"},
        loads={"rotor_torque": -36e6, "yaw_torque": 1e6, "pitch_torque": 1e4},
    )
    stepper = make_stepper(case, turbine.system)
    last = Simulation(turbine.system, 0.04, 3.0, (), stepper).run()
    assert abs(last.energy_error) <= 1e-11 * last.balance.kinetic
    assert last.works.sum() > 1e5
    names = [p.name for p in turbine.parts if isinstance(getattr(p, "function", None), Product)]
    assert names == [f"torque on {x}" for x in ("rotor", "yaw", "pitch_1", "pitch_2", "pitch_3")]
    stepper.destroy()


def test_a_turbine_that_turns_freely_has_an_equilibrium_once_it_is_held(comm):
    """Its rotor is indifferent: where it stands is up to round-off, unless it is held."""
    _, turbine, _ = started(comm, tower=TOWER)
    with pytest.raises(StepFailure, match=r"or to hold what turns freely, of yaw, rotor, by held"):
        equilibrium(turbine.system, max_iterations=3)
    state = equilibrium(turbine.system, held=["rotor", "yaw"])
    assert state.u[0].norm(3) > 0.2 and not state.joint_coordinates.any()


@pytest.mark.parallel
def test_a_signal_ends_a_start_that_takes_long_and_leaves_no_results(monkeypatch, tmp_path):
    def start(case, system):
        os.kill(os.getpid(), signal.SIGTERM)
        raise AssertionError("the start goes on")

    monkeypatch.setattr(run, "make_start", start)
    case = Case.parse({"turbine": {"model": "rigid"}, "time": {"step": 0.1, "end": 0.1}})
    with catch_signals(), pytest.raises(KeyboardInterrupt):
        run.run_case(case, tmp_path, MPI.COMM_SELF, "none")
    assert not holds_run(tmp_path)
