"""Claims about prescribed motions of joint coordinates."""

import numpy as np
import pytest

from turbine_fenicsx import (
    Cylindrical,
    Gravity,
    JointTorque,
    PrescribedMotion,
    Revolute,
    Rigid,
    Universal,
)
from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.time_functions import Constant, Ramp
from turbine_fenicsx.foundation.errors import ModelError, StepFailure
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum

pytestmark = pytest.mark.parallel

DT = 0.02
N = np.array([0.3, 1.0, 0.2]) / np.linalg.norm([0.3, 1.0, 0.2])
START = rotation_about((1, 0, 2), 0.7)
A = RigidBody("a", 2.0, (1, 2, 3), position=(1.0, 0, 0), directors=START)
B = RigidBody("b", 3.0, (4, 2, 3), position=(2.0, 0.5, 0))
SCREW = Cylindrical("screw", None, A, point=(0.2, 0, 0), axis=N)
HINGE = Revolute("hinge", A, B, point=(1.5, 0, 0), axis=(0, 0, 1))


def smooth(size):
    """From rest to a uniform motion."""
    return lambda t: size * t**3 / (0.1 + t**2)


def run(comm, parts, steps=40):
    """Advance; yields time, report, energies before and after, state and system of each step."""
    system = MultibodySystem(comm, parts)
    solver = EnergyMomentum(system)
    state = system.initial_state()
    energy = system.balance(state).total
    for _ in range(steps):
        other = state.copy()
        report = solver.advance(state, DT, other)
        before, energy = energy, system.balance(other).total
        yield other.time, report, before, energy, other, system
        state = other
    solver.destroy()


def test_motions_are_reached_exactly_and_the_body_is_there(comm):
    turn, slide = smooth(9.0), smooth(-2.0)
    motions = (PrescribedMotion("screw.displacement", slide), PrescribedMotion("screw.angle", turn))
    for t, _, _, _, state, system in run(comm, [A, SCREW, Gravity(), *motions]):
        assert np.allclose(state.joint_coordinates, [turn(t), slide(t)], rtol=0, atol=1e-13)
        R = rotation_about(N, turn(t))
        place = R @ (np.asarray(A.position) - SCREW.point) + SCREW.point + slide(t) * N
        assert np.allclose(state.q[:3], place, rtol=0, atol=1e-12)
        assert np.allclose(state.q[3:].reshape(3, 3).T, R @ START, rtol=0, atol=1e-12)
        assert system.constraint_error(state) <= 1e-13
    assert turn(t) > 6.0


def test_works_of_motions_close_the_balance_of_energy_by_name(comm):
    """With a second body that swings on the driven one, under gravity and a torque."""
    motions = (
        PrescribedMotion("screw.angle", smooth(9.0)),
        PrescribedMotion("screw.displacement", smooth(-2.0)),
    )
    loads = [Gravity(), JointTorque("torque on hinge", "hinge", 3.0)]
    sizes, names = np.zeros(4), ()
    for _, report, before, after, _, system in run(comm, [A, B, SCREW, HINGE, *loads, *motions]):
        assert after - before == pytest.approx(report.work, abs=1e-12 * (abs(before) + abs(after)))
        sizes, names = sizes + np.abs(report.works), system.work_names
    assert names == (
        "gravity",
        "torque on hinge",
        "motion of screw.angle",
        "motion of screw.displacement",
    )
    assert sizes[0] == 0.0 and np.all(sizes[1:] > 1.0)


def test_multiplier_is_the_torque_that_the_drive_needs(comm):
    """Uniform acceleration of a body about a principal axis through its centre: J times it."""
    body = RigidBody("a", 2.0, (1, 2, 3))
    parts = [body, Revolute("j", None, body, point=(0, 0, 0), axis=(0, 0, 1))]
    rate = 4.0
    for k, (t, report, _, _, state, _) in enumerate(
        run(comm, [*parts, PrescribedMotion("j", lambda t: 0.5 * rate * t**2)], 10)
    ):
        assert state.multipliers[-1] == pytest.approx(-3.0 * rate, rel=3e-3)  # of second order
        assert report.work == pytest.approx(0.5 * 3.0 * rate**2 * (t**2 - (t - DT) ** 2), rel=3e-3)
        assert k < 10


def test_a_motion_that_fits_the_initial_velocity_needs_no_work(comm):
    body = RigidBody("a", 2.0, (1, 2, 3), angular_velocity=(0, 0, 5.0))
    parts = [body, Revolute("j", None, body, point=(0, 0, 0), axis=(0, 0, 1))]
    rate = 2 / DT * np.arctan(0.5 * DT * 5.0)  # of a body of that velocity in steps of this size
    motion = PrescribedMotion("j", lambda t: rate * t)
    for t, report, _, after, state, _ in run(comm, [*parts, motion], 30):
        assert abs(report.work) <= 4e-12 * 37.5  # of the energy; steps end at 1e-12 of their terms
        assert after == pytest.approx(0.5 * 3.0 * 25.0, rel=1e-12)
        assert state.joint_coordinates[0] == pytest.approx(rate * t, rel=1e-13)


def test_a_motion_at_rest_is_a_lock(comm):
    joint = Universal("u", None, A, point=(0, 0, 0), first_axis=(0, 0, 1), second_axis=(0, 1, 0))
    motions = [PrescribedMotion(f"u.{k}", Constant(0.0)) for k in ("first", "second")]
    for _, report, _, _, state, _ in run(comm, [A, joint, Gravity(), *motions], 5):
        assert np.allclose(state.q, A.coordinates, rtol=0, atol=1e-14)
        assert abs(report.work) <= 1e-15


def test_a_motion_by_more_than_a_quarter_of_a_revolution_in_a_step_is_not_followed(comm):
    jump = PrescribedMotion("screw.angle", lambda t: 2.0 if t else 0.0)
    with pytest.raises(StepFailure, match="a joint turns by a quarter of a revolution or more"):
        list(run(comm, [A, SCREW, jump], 1))


def test_a_motion_that_is_no_number_at_the_start_is_refused():
    with pytest.raises(ValueError, match="motion of 'j' at t = 0 must be a number, got nan"):
        PrescribedMotion("j", lambda t: np.nan + t)


def test_a_motion_that_does_not_begin_at_zero_needs_a_start_that_fits(comm):
    """Turned to where the motion begins, nothing jumps: a lock there does no work."""
    joint = Revolute("hinge", None, A, point=(0, 0, 0), axis=(0, 0, 1))
    system = MultibodySystem(comm, [A, joint, PrescribedMotion("hinge", Constant(0.5)), Gravity()])
    words = "'motion of hinge' begins at 0.5, but the run starts at 0: give it a start"
    with pytest.raises(ModelError, match=words):
        Simulation(system, DT, 1.0).run()
    start = system.initial_state()
    turning_frame(system, "hinge", 0.0, start).turn(start, 0.5)
    last = Simulation(system, DT, 0.2, start=start).run()
    assert abs(last.external_work) < 1e-12 * abs(last.balance.potential)
    assert np.allclose(last.state.q, start.q, rtol=0.0, atol=1e-12)


def test_a_motion_must_be_a_function_of_time():
    words = r"motion of 'j' must be a function of time, got float 3\.0"
    with pytest.raises(TypeError, match=words):
        PrescribedMotion("j", 3.0)


def test_a_motion_of_an_unknown_coordinate_names_those_there_are(comm):
    motion = PrescribedMotion("screw", Ramp(1.0, 1.0))
    words = r"no joint coordinate 'screw'; there are \['screw\.angle', 'screw\.displacement'\]"
    with pytest.raises(ValueError, match=words):
        MultibodySystem(comm, [A, SCREW, motion])


def test_two_motions_of_one_coordinate_are_refused(comm):
    motions = [PrescribedMotion("screw.angle", Ramp(x, 1.0)) for x in (1.0, 2.0)]
    with pytest.raises(ValueError, match=r"'motion of screw\.angle'.* occur more than once"):
        MultibodySystem(comm, [A, SCREW, *motions])


def test_motions_that_depend_on_joints_or_on_each_other_are_refused_by_name(comm):
    lock = Rigid("lock", None, A, (0, 0, 0))
    twin = Cylindrical("twin", None, A, point=(0.2, 0, 0), axis=N)
    motions = [PrescribedMotion(f"{j}.angle", Ramp(1.0, 1.0)) for j in ("screw", "twin")]
    words = "'motion of {}.angle' depends on the joints and the other relations"
    with pytest.raises(ValueError, match=words.format("screw")):
        MultibodySystem(comm, [A, SCREW, lock, motions[0]])
    with pytest.raises(ValueError, match=words.format("twin")):
        MultibodySystem(comm, [A, SCREW, twin, *motions])
    MultibodySystem(comm, [A, SCREW, twin, motions[1]])  # one of them alone is fine
