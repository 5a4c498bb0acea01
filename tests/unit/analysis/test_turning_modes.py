"""Claims about modes of what turns steadily: frames, multiblade coordinates, whirl."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from small_rotor import HUB, Rotor

from turbine_fenicsx import Gravity, PointDamper, PointSpring, PrescribedMotion, Revolute, Spherical
from turbine_fenicsx.analysis import campbell as module
from turbine_fenicsx.analysis.campbell import campbell
from turbine_fenicsx.analysis.cyclic_shift import cyclic_shift
from turbine_fenicsx.analysis.turning import turning_equilibrium
from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.analysis.turning_modes import turning_modes
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.rotations import E2, E3, rotation_about
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum

SPEEDS = (0.0, 3.0, -7.0)


def angular_frequencies(modes):
    return np.array([mode.eigenvalue.imag for mode in modes.modes])


def free(modes):
    modes.destroy()
    modes.state.destroy()


@pytest.mark.parallel
@pytest.mark.parametrize("speed", SPEEDS)
def test_hinged_blades_on_a_driven_hub_vibrate_as_in_closed_form(comm, speed):
    rotor = Rotor(blades=2, speed=speed)
    found = turning_modes(rotor.system(comm), "rotor", speed, 4)
    expected = np.repeat(sorted(rotor.frequencies(speed)), 2)
    assert angular_frequencies(found) == pytest.approx(expected, rel=1e-9)
    assert all(abs(mode.damping_ratio) <= 1e-9 and mode.whirl is None for mode in found.modes)
    assert (found.joint, found.speed, found.blades) == ("rotor", speed, None)
    free(found)


@pytest.mark.parametrize("blades", [3, 4, 5])
@pytest.mark.parametrize("speed", [3.0, -7.0])
def test_seen_from_outside_whirl_is_faster_or_slower_by_the_speed(comm, blades, speed):
    rotor = Rotor(blades=blades, speed=speed)
    found = turning_modes(rotor.system(comm), "rotor", speed, 2 * blades, blades)
    expected = []
    for w in rotor.frequencies(speed):
        expected += [(w, "collective"), (w - abs(speed), "backward"), (w + abs(speed), "forward")]
        expected += [(w, "reactionless")] * (blades - 3)
    expected.sort()
    assert angular_frequencies(found) == pytest.approx([w for w, _ in expected], rel=1e-9)
    seen = sorted((round(m.eigenvalue.imag, 6), m.whirl.name) for m in found.modes)
    if blades == 3:
        assert [name for _, name in seen] == [name for _, name in expected]
    totals = np.sum([list(vars(m.whirl).values()) for m in found.modes], axis=0)
    assert totals == pytest.approx([2, 2, 2, 2 * (blades - 3)], abs=1e-6)
    free(found)


def end_of_run(system, state, change, dt, steps):
    """Coordinates q after some steps from a state with a small change (q, q', T)."""
    now, stepper = state.copy(), EnergyMomentum(system)
    now.q, now.q_dot = now.q + change[0], now.q_dot + change[1]
    now.joint_coordinates = now.joint_coordinates + change[2]
    after = now.copy()
    for _ in range(steps):
        stepper.advance(now, dt, after)
        now, after = after, now
    stepper.destroy()
    return now.q


@pytest.mark.parametrize(("blades", "damping"), [(3, 0.0), (3, 4.0), (5, 4.0)])
def test_a_run_that_starts_in_a_mode_of_a_rotor_on_a_soft_bearing_stays_in_it(
    comm, blades, damping
):
    """All terms of multiblade coordinates, against the nonlinear equations in space."""
    speed, size, steps, dt = 4.0, 1e-6, 200, 1e-3
    system = Rotor(blades, yaw=300.0, flap=100.0, lag=150.0, damping=damping).system(comm)
    found = turning_modes(system, "rotor", speed, 8, blades)
    state = found.state
    frame = turning_frame(system, "rotor", speed, state)
    J, psi = cyclic_shift(frame, state, blades).rigid_generator, speed * dt * steps
    turns = np.diag(frame.rigid_turns.astype(float))
    S = np.kron(turns, np.kron(np.eye(4), frame.spin))
    R = np.kron(turns, np.kron(np.eye(4), rotation_about(frame.axis, psi)))
    R += np.eye(len(J)) - np.kron(turns, np.eye(12))
    T = R @ (np.eye(len(J)) + J @ J * (1.0 - np.cos(psi)) - J * np.sin(psi))
    elastic = [mode for mode in found.modes if not mode.is_rigid]
    assert len(elastic) == 7
    unchanged = end_of_run(system, state, (0.0, 0.0, 0.0), dt, steps)
    for mode in elastic:
        s, b = mode.eigenvalue, mode.imaginary
        z = size * (mode.real.q + (0.0 if b is None else 1j * b.q))
        start = z.real, (s * z).real + (S - speed * J) @ z.real, size * mode.real.joint_coordinates
        change = end_of_run(system, state, start, dt, steps) - unchanged
        error = change - T @ (z * np.exp(s * dt * steps)).real
        assert np.linalg.norm(error) <= 2e-4 * np.linalg.norm(z)
    free(found)


def test_dampers_of_blades_damp_their_modes(comm):
    rotor = Rotor(blades=3, speed=2.0, damping=6.0)
    found = turning_modes(rotor.system(comm), "rotor", 2.0, 6)
    w, inertia = rotor.frequencies(2.0)[0], 0.05 + 2.5 + 3.0 * 1.6**2
    damped = sorted(found.modes, key=lambda m: m.damping_ratio)[3:]
    ratios = [m.damping_ratio for m in damped]
    assert ratios == pytest.approx([6.0 / (2.0 * w * inertia)] * 3, rel=1e-9)
    assert [abs(m.eigenvalue) for m in damped] == pytest.approx([w] * 3, rel=1e-9)
    free(found)


def test_modes_are_followed_where_their_frequencies_cross(comm):
    rotor = Rotor(blades=1, speed=0.0, flap=500.0, lag=900.0)
    speeds = np.linspace(0.0, 12.0, 7)
    diagram = campbell(_at_any_speed(comm, rotor), "rotor", speeds, 3)
    expected = np.array([rotor.frequencies(speed) for speed in speeds])
    assert np.any(np.diff(np.sign(expected[:, 0] - expected[:, 1])))
    assert 2.0 * np.pi * diagram.frequencies[:, 1:] == pytest.approx(expected, rel=2e-3)
    assert all(modes.modes[0].is_rigid for modes in diagram.modes)
    assert diagram.damping_ratios == pytest.approx(0.0, abs=1e-9)
    assert np.array_equal(diagram.speeds, speeds) and len(diagram.modes) == 7
    assert diagram.names == ("mode 1", "mode 2", "mode 3")
    diagram.destroy()


@pytest.mark.parametrize("yaw", [20_000.0, 300.0])
def test_whirl_from_rest_needs_no_speeds_between(comm, monkeypatch, yaw):
    """Motions at rest that a stiff nacelle takes little apart mix at once as the rotor turns."""
    looked_at, find = [], module.turning_modes_near

    def count(system, joint, speed, *more):
        looked_at.append(speed)
        return find(system, joint, speed, *more)

    monkeypatch.setattr(module, "turning_modes_near", count)
    rotor = Rotor(3, yaw=yaw)
    diagram = campbell(rotor.system(comm), "rotor", (0.0, 3.0), 7, 3)
    assert looked_at == [0.0, 3.0]
    assert len(set(diagram.names)) == 7
    diagram.destroy()


def _at_any_speed(comm, rotor):
    """A hub so heavy that blades do not change its speed, in place of one that is driven."""
    parts = list(replace(rotor, speed=None).parts())
    (hub,) = (p for p in parts if getattr(p, "name", "") == "hub")
    object.__setattr__(hub, "euler", (1e4, 1e4, 1.0))
    return MultibodySystem(comm, parts)


# --- what is refused


@pytest.mark.parametrize(
    ("rotor", "blades", "words"),
    [
        (Rotor(2, yaw=300.0), 2, "three or more equal blades, got 2"),
        (Rotor(3, yaw=300.0), True, "three or more equal blades, got True"),
        (Rotor(3, yaw=300.0), None, "what carries joint 'rotor' can move"),
        (Rotor(3, yaw=300.0), 4, "'ring_0' has no equal 1/4 of a revolution further"),
        (Rotor(3, yaw=300.0, heavier=1.01), 3, "'blade_0' has no equal"),
        (Rotor(3, yaw=300.0, stiffer=1.01), 3, "turned by 1/3 of a revolution, the springs of"),
    ],
)
def test_rotors_that_multiblade_coordinates_do_not_suit_are_refused(comm, rotor, blades, words):
    with pytest.raises(ModelError, match=words):
        turning_modes(rotor.system(comm), "rotor", 2.0, 4, blades)


def test_a_hub_with_two_moments_of_inertia_is_refused(comm):
    parts = list(Rotor(3, yaw=300.0).parts())
    object.__setattr__(parts[1], "euler", (0.6, 0.7, 0.4))
    with pytest.raises(ModelError, match="mass of the rigid bodies changes"):
        turning_modes(MultibodySystem(comm, parts), "rotor", 2.0, 4, 3)


def test_a_joint_that_holds_one_blade_only_is_refused(comm):
    parts = [*Rotor(3, yaw=300.0).parts(), PrescribedMotion("flap_1", lambda t: 0.0)]
    with pytest.raises(ModelError, match="what the joints allow of the rigid bodies changes"):
        turning_modes(MultibodySystem(comm, parts), "rotor", 2.0, 4, 3)


@pytest.mark.parametrize("speed", [np.inf, np.nan, "fast", None])
def test_speeds_that_are_no_numbers_are_refused(comm, speed):
    with pytest.raises(ModelError, match="speed of 'rotor'"):
        turning_modes(Rotor().system(comm), "rotor", speed, 4)


def test_joints_that_do_not_turn_are_refused(comm):
    system = Rotor().system(comm)
    with pytest.raises(ModelError, match="no joint 'shaft'"):
        turning_modes(system, "shaft", 1.0, 4)
    hub = next(b for b in system.rigid_bodies if b.name == "hub")
    ball = MultibodySystem(comm, [hub, Spherical("ball", None, hub, HUB)])
    with pytest.raises(ModelError, match="'ball' has no angle about one axis"):
        turning_modes(ball, "ball", 1.0, 4)


@pytest.mark.parametrize("count", [0, -1, 2.0, True, 9])
def test_numbers_of_modes_that_there_are_not_are_refused(comm, count):
    words = "9 modes are more than the 8 degrees" if count == 9 else "positive whole number"
    with pytest.raises(ModelError, match=words):
        turning_modes(Rotor(3, speed=None, yaw=300.0).system(comm), "rotor", 1.0, count, 3)


def test_a_wheel_on_the_ground_has_its_free_rotation_in_both_coordinates(comm):
    wheel = RigidBody("wheel", 1.0, (0.1, 0.1, 0.1))
    system = MultibodySystem(
        comm, [wheel, Revolute("axle", None, wheel, point=np.zeros(3), axis=E3)]
    )
    for blades in (None, 3):
        found = turning_modes(system, "axle", 2.0, 1, blades)
        assert [mode.is_rigid for mode in found.modes] == [True]
        free(found)


def test_all_modes_there_are_can_be_had(comm):
    found = turning_modes(Rotor(3, yaw=300.0).system(comm), "rotor", 1.0, 8, 3)
    assert [mode.is_rigid for mode in found.modes] == [True] + 7 * [False]
    free(found)


@pytest.mark.parallel
def test_a_damper_that_resists_the_rotation_itself_is_refused(comm):
    rotor = Rotor(3, yaw=300.0)
    parts = list(rotor.parts())
    nacelle, hub = parts[:2]
    damper = PointDamper(
        "d", nacelle, hub, first_point=(0.5, 0.0, 0.0), second_point=HUB + 0.4 * E2, damping=2.0
    )
    with pytest.raises(ModelError, match="the dampers of the rigid bodies change"):
        turning_modes(MultibodySystem(comm, [*parts, damper]), "rotor", 2.0, 4, 3)


def test_weight_across_the_axis_is_refused(comm):
    with pytest.raises(ModelError, match="is not steady"):
        turning_modes(Rotor(3, yaw=300.0).system(comm, Gravity()), "rotor", 2.0, 4, 3)


def test_without_slepc4py_one_sentence_says_how_to_get_it(comm, monkeypatch):
    monkeypatch.setitem(sys.modules, "slepc4py", None)
    with pytest.raises(InputError, match="modes need slepc4py"):
        turning_modes(Rotor().system(comm), "rotor", 1.0, 4)


def test_a_spring_that_finds_the_rotor_alike_at_every_azimuth_is_allowed(comm):
    parts = list(Rotor(3, yaw=300.0).parts())
    nacelle, hub = parts[:2]
    spring = PointSpring(
        "s", nacelle, hub, first_point=(0.0, 0.0, 0.5), second_point=HUB - 0.5 * E3, stiffness=50.0
    )
    found = turning_modes(MultibodySystem(comm, [*parts, spring]), "rotor", 2.0, 4, 3)
    assert len(found.modes) == 4
    free(found)


@pytest.mark.parallel
def test_the_state_of_the_modes_is_the_turning_equilibrium(comm):
    system = Rotor(3, speed=2.0).system(comm)
    found, expected = (
        turning_modes(system, "rotor", 2.0, 2),
        turning_equilibrium(system, "rotor", 2.0),
    )
    assert np.array_equal(found.state.q, expected.q)
    free(found)
    expected.destroy()
