"""Claims about gears, screws and other relations between joint coordinates."""

from math import pi

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx import (
    Constant,
    Cylindrical,
    Gravity,
    JointSpring,
    JointTorque,
    PrescribedMotion,
    Revolute,
    Rigid,
)
from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import E1, E2, E3
from turbine_fenicsx.joints.relation import JointRelation, Relation, gear_pair, screw
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum

DT, STEPS = 0.02, 60
I1, I2 = 3.0, 0.4  # about the axes of the rotors [kg m^2]
AXES = {"slow": E3, "fast": (E1 + 2.0 * E2) / np.sqrt(5.0)}


def rotor(name, J, axis, place, spin=0.0):
    """A body that can only turn about an axis through its centre; all its axes are principal."""
    body = RigidBody(name, 2.0, (0.5 * J,) * 3, position=place, angular_velocity=spin * axis)
    return [body, Revolute(name.upper(), None, body, point=place, axis=axis)]


def two_rotors(spin=0.0, ratio=0.0):
    """Rotors on axes that are not parallel, as in a bevel gear."""
    slow = rotor("slow", I1, AXES["slow"], (0.0, 0.0, 0.0), spin)
    return [*slow, *rotor("fast", I2, AXES["fast"], (1.0, 2.0, 0.0), ratio * spin)]


def run(parts, steps=STEPS, comm=MPI.COMM_WORLD):
    """Advance; yields report, energy and state after each step, the state at its start, system."""
    system = MultibodySystem(comm, parts)
    solver = EnergyMomentum(system)
    state = system.initial_state()
    for _ in range(steps):
        other = state.copy()
        report = solver.advance(state, DT, other)
        yield report, system.balance(other).total, other, state, system
        state = other
    solver.destroy()


def turned(w):
    """Angle of a steady rotation in a step of the scheme."""
    return 2.0 * np.arctan(0.5 * w * DT)


@pytest.mark.parametrize("ratio", [2.5, -4.0])
def test_a_gear_keeps_its_ratio_and_the_energy(ratio):
    parts = [*two_rotors(), gear_pair("gear", "SLOW", "FAST", ratio)]
    spring = JointSpring("spring", "FAST", 5.0, 0.7)
    energies = []
    for report, energy, state, _, system in run([*parts, spring], 200):
        slow, fast = state.joint_coordinates
        assert fast == pytest.approx(ratio * slow, abs=1e-12)
        assert system.constraint_error(state) <= 1e-12
        assert report.works == () and report.dissipated == ()
        energies.append(energy)
    # Newton's method ends at 1e-12 of the forces, in each of 200 steps
    assert np.ptp(energies) <= 1e-11 * energies[0]
    assert abs(fast) > 0.1


@pytest.mark.parametrize("driven", ["SLOW", "FAST"])
@pytest.mark.parametrize("ratio", [3.0, -0.5])
def test_acceleration_under_a_torque_is_that_of_the_reduced_inertia(driven, ratio):
    """M (times i on the driven rotor) over J1 + i^2 J2: from rest, to second order in the turn."""
    M = 0.2
    torque = M if driven == "SLOW" else ratio * M
    parts = [*two_rotors(), gear_pair("gear", "SLOW", "FAST", ratio)]
    parts.append(JointTorque("torque", driven, M))
    for _, _, state, _, _ in run(parts, 10):
        t = state.time
        expected = 0.5 * torque / (I1 + ratio**2 * I2) * t**2
        assert state.joint_coordinates[0] == pytest.approx(expected, rel=1e-4)


def test_power_passes_from_one_rotor_to_the_other():
    """What the torque does to the slow one and does not stay there arrives at the fast one."""
    ratio, M = -3.0, 0.9
    parts = [*two_rotors(), gear_pair("gear", "SLOW", "FAST", ratio)]
    parts.append(JointTorque("torque on SLOW", "SLOW", M))
    for report, _, state, before, system in run(parts):
        kinetic = []
        for s in (before, state):
            momenta = system.rigid_model.masses * s.q_dot
            kinetic.append(0.5 * (s.q_dot * momenta).reshape(2, 12).sum(axis=1))
        gained = kinetic[1] - kinetic[0]
        turn, force = state.joint_coordinates - before.joint_coordinates, state.multipliers[-1]
        assert report.work == pytest.approx(M * turn[0], rel=1e-12)
        assert gained.sum() == pytest.approx(report.work, rel=1e-10, abs=1e-14)
        # -S^T pi on the joint coordinates, S = (-i, 1)
        assert gained[0] == pytest.approx((M + ratio * force) * turn[0], rel=1e-10, abs=1e-14)
        assert gained[1] == pytest.approx(-force * turn[1], rel=1e-10, abs=1e-14)
    assert gained[1] / gained[0] == pytest.approx(ratio**2 * I2 / I1, rel=0.01)


def test_rotors_that_turn_at_the_ratio_go_on_as_if_there_were_no_gear():
    """Except for the steps, in which both turn by 2 atan(w dt/2): slow rotors turn as they say."""
    spin, ratio = 0.1, 2.0
    parts = [*two_rotors(spin, ratio), gear_pair("gear", "SLOW", "FAST", ratio)]
    for n, (_, _, state, _, _) in enumerate(run(parts, 20), start=1):
        assert state.joint_coordinates[0] == pytest.approx(n * turned(spin), rel=1e-5)
        assert abs(state.multipliers[-1]) <= 1e-4


def test_a_screw_moves_by_its_lead_in_one_turn():
    lead = -0.05
    body = RigidBody("nut", 2.0, (0.1, 0.1, 0.1))
    parts = [body, Cylindrical("j", None, body, point=(0, 0, 0), axis=E3)]
    parts += [screw("thread", "j.angle", "j.displacement", lead), Gravity((0.0, 0.0, -9.81))]
    start = None
    for report, energy, state, _, _ in run(parts, 500):
        angle, way = state.joint_coordinates
        assert way == pytest.approx(lead * angle / (2.0 * pi), abs=1e-12)
        start = energy if start is None else start
        assert energy == pytest.approx(start, abs=1e-11)
        assert report.works == (0.0,)  # gravity
        assert state.q[2] == pytest.approx(way, abs=1e-12)
    assert angle > 4.0 * pi
    # m g h against the energy of spin and slide: an acceleration against J + m h^2
    h = lead / (2.0 * pi)
    acceleration = -2.0 * 9.81 * h / (0.2 + 2.0 * h**2)
    assert angle == pytest.approx(0.5 * acceleration * state.time**2, rel=0.01)


def test_a_differential_shares_the_sum_of_two_angles():
    """Half the sum of two shafts follows the third; the torque on it is shared in halves."""
    J = {"LEFT": 0.5, "RIGHT": 0.2, "CARRIER": 1.0}
    parts = []
    for k, name in enumerate(J):
        parts += rotor(name.lower(), J[name], E1, (0.0, 3.0 * k, 0.0))
    factors = {"LEFT": 0.5, "RIGHT": 0.5, "CARRIER": -1.0}
    parts += [
        JointRelation("differential", factors),
        JointTorque("torque on CARRIER", "CARRIER", 0.3),
    ]
    for _, _, state, _, _ in run(parts, 20):
        left, right, carrier = state.joint_coordinates
        assert 0.5 * (left + right) == pytest.approx(carrier, abs=1e-13)
        assert J["LEFT"] * left == pytest.approx(J["RIGHT"] * right, rel=1e-4)


def test_a_relation_with_a_motion_is_followed_and_does_work():
    """The difference of two angles is driven; a motion of one coordinate is a special case."""
    relation = JointRelation("drive", {"FAST": 1.0, "SLOW": -2.0}, lambda t: t**3)
    done = 0.0
    for report, energy, state, _, system in run([*two_rotors(), relation]):
        assert state.joint_coordinates @ [-2.0, 1.0] == pytest.approx(state.time**3, abs=1e-12)
        assert system.work_names == ("drive",)
        done += report.work
        assert energy == pytest.approx(done, abs=1e-12)
    assert done > 0.1


def test_a_motion_and_the_same_relation_are_one(comm):
    ends = []
    for part in (
        PrescribedMotion("SLOW", lambda t: t**3),
        JointRelation("m", {"SLOW": 1.0}, lambda t: t**3),
    ):
        *_, (_, energy, state, _, _) = run([*two_rotors(), part, Gravity()])
        ends.append([energy, *state.q, *state.joint_coordinates, *state.multipliers])
        assert isinstance(part, Relation)
    assert np.array_equal(*ends)


def test_equilibrium_knows_of_gears():
    """A torque on one rotor and a spring on the other: M = i c phi."""
    ratio, c, M = -3.0, 2.0, 1.2
    parts = [*two_rotors(), gear_pair("gear", "SLOW", "FAST", ratio), JointSpring("s", "FAST", c)]
    state = equilibrium(
        MultibodySystem(MPI.COMM_WORLD, [*parts, JointTorque("torque on SLOW", "SLOW", M)])
    )
    assert state.joint_coordinates[1] == pytest.approx(M / (ratio * c), rel=1e-12)
    assert state.joint_coordinates[0] == pytest.approx(
        state.joint_coordinates[1] / ratio, rel=1e-12
    )
    assert -state.multipliers[-1] == pytest.approx(c * state.joint_coordinates[1], rel=1e-12)


@pytest.mark.parallel
def test_flexible_bodies_may_hang_on_geared_ones_on_any_number_of_ranks(comm, machine):
    """The machine's rotor drives a wheel; on all ranks together and on each alone."""
    found = []
    for c in (comm, MPI.COMM_SELF):
        m = machine(comm=c)
        wheel = rotor("wheel", 0.3, E3, (3.0, 0.0, 0.0))
        gear = gear_pair("gear", "rotor", "WHEEL", -2.0)
        parts = [
            *m.parts,
            *wheel,
            gear,
            JointTorque("torque on rotor", "rotor", 2.0),
        ]
        work, start = 0.0, None
        for report, energy, state, before, system in run(parts, 10, c):
            start = system.balance(before).total if start is None else start
            work += report.work
            angles = dict(zip(system.joint_coordinate_names, state.joint_coordinates, strict=True))
            assert angles["WHEEL"] == pytest.approx(-2.0 * angles["rotor"], abs=1e-12)
            assert energy == pytest.approx(start + work, abs=1e-10)
        assert angles["rotor"] > 1e-3
        b = system.balance(state)
        found.append([*state.q, *state.joint_coordinates, b.kinetic, b.strain, *b.angular])
    assert np.allclose(*found, rtol=0, atol=1e-9)


# --- mistakes


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: JointRelation("r", {}), "relation 'r' needs the factor of a joint coordinate"),
        (lambda: JointRelation("r", {"a": 0.0}), "factor of 'a' in 'r' must not be zero"),
        (lambda: JointRelation("r", {"a": 1.0, "b": np.nan}), "factor of 'b' in 'r' must be a num"),
        (lambda: gear_pair("g", "a", "b", 0.0), "factor of 'a' in 'g' must not be zero"),
        (lambda: gear_pair("g", "a", "b", np.inf), "ratio of 'g' must be a number"),
        (lambda: screw("s", "a", "b", np.nan), "lead of 's' must be a number"),
        (
            lambda: JointRelation("r", {"a": 1.0}, lambda t: np.nan),
            "at t = 0 must be a number, got",
        ),
    ],
)
def test_wrong_numbers_are_refused_in_a_sentence(make, words):
    with pytest.raises(ModelError, match=words):
        make()


def test_a_motion_must_be_a_function():
    with pytest.raises(
        TypeError, match=r"motion of 'r' must be a function of time, got float 2\.0"
    ):
        JointRelation("r", {"a": 1.0}, 2.0)


def refused(parts, words):
    with pytest.raises(ModelError, match=words):
        MultibodySystem(MPI.COMM_WORLD, [*two_rotors(), *parts])


def test_a_relation_of_an_unknown_coordinate_names_those_there_are():
    words = r"no joint coordinate 'WHEEL'; there are \['FAST', 'SLOW'\]"
    refused([gear_pair("gear", "SLOW", "WHEEL", 2.0)], words)


def test_relations_that_depend_on_each_other_are_refused_by_name():
    gear = gear_pair("gear", "SLOW", "FAST", 2.0)
    words = " depends on the joints and the other relations of joint coordinates"
    refused([gear, gear_pair("back", "FAST", "SLOW", 0.5)], "'back'" + words)
    refused(
        [gear, gear_pair("other", "SLOW", "FAST", 3.0), PrescribedMotion("SLOW", Constant(0.0))],
        "'motion of SLOW'" + words,
    )
    MultibodySystem(MPI.COMM_WORLD, [*two_rotors(), gear, gear_pair("lock", "SLOW", "FAST", 3.0)])


def test_a_relation_of_what_a_joint_locks_is_refused():
    parts = two_rotors()
    lock = Rigid("lock", None, parts[0], (0, 0, 0))
    with pytest.raises(ModelError, match="'held' depends on the joints"):
        MultibodySystem(MPI.COMM_WORLD, [*parts, lock, JointRelation("held", {"SLOW": 2.0})])


def test_names_of_relations_must_be_unique():
    gears = [gear_pair("gear", "SLOW", "FAST", ratio) for ratio in (2.0, 3.0)]
    refused(gears, r"names must be unique, but \['gear'\] occur more than once")
