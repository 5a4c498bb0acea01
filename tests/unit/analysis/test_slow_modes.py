"""Modes near zero: slender bodies, divergence, rotors of few coordinates; what is rigid."""

import numpy as np
import pytest
from bricks import box, facets_at

from turbine_fenicsx import Gravity, JointSpring, Revolute, StVenantKirchhoff
from turbine_fenicsx.analysis.damped_modes import damped_modes
from turbine_fenicsx.analysis.modes import modes
from turbine_fenicsx.analysis.turning_modes import turning_modes
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.rotations import E2, E3
from turbine_fenicsx.system.system import MultibodySystem

pytest.importorskip("slepc4py")

LENGTH, YOUNG, DENSITY = 10.0, 2e11, 7800.0


def make_wire(comm, width, holder=None):
    """A steel wire of square section along x and what holds its end."""
    mesh = box(comm, [LENGTH, width, width], [60, 1, 1])
    wire = FlexibleBody("wire", mesh, StVenantKirchhoff(0.0, 0.5 * YOUNG), DENSITY, degree=2)
    return [wire, Coupling("end", wire, facets_at(mesh, 0.0), holder)]


def bending_frequency(width):
    """The first of a clamped Euler-Bernoulli beam [rad/s]."""
    return 1.8751041**2 * np.sqrt(YOUNG * width**2 / (12.0 * DENSITY * LENGTH**4))


def free(found):
    found.destroy()
    found.state.destroy()


@pytest.mark.parallel
@pytest.mark.parametrize("find", [modes, damped_modes])
def test_a_clamped_wire_of_a_thousand_diameters_vibrates(comm, find):
    found = find(MultibodySystem(comm, make_wire(comm, 0.008)), count=2)
    assert [mode.is_rigid for mode in found.modes] == [False, False]
    squares = [mode.eigenvalue.imag**2 for mode in found.modes]
    # round-off of the stiffness is half a per cent of the squares
    assert squares == pytest.approx([bending_frequency(0.008) ** 2] * 2, rel=0.05)
    free(found)


@pytest.mark.parallel
def test_a_wire_that_is_too_thin_is_warned_of(comm, caplog):
    found = modes(MultibodySystem(comm, make_wire(comm, 0.001)), count=2)
    assert not any(mode.is_rigid for mode in found.modes)
    if comm.rank == 0:
        assert "2 modes of up to 0.0" in caplog.text
        assert "lie near round-off" in caplog.text
    free(found)


def test_a_turning_wire_has_one_rigid_motion_and_flaps_half_as_fast_again(comm):
    hub = RigidBody("hub", 1.0, (10.0,) * 3)
    shaft = Revolute("shaft", None, hub, point=(0.0, 0.0, 0.0), axis=E3)
    system = MultibodySystem(comm, [hub, shaft, *make_wire(comm, 0.008, hub)])
    found = turning_modes(system, "shaft", 0.5, count=2)
    assert [mode.is_rigid for mode in found.modes] == [True, False]
    # a cable flaps with the speed, stiffness adds 1.19 w^2 (Southwell)
    expected = np.sqrt(0.5**2 * 1.19 + bending_frequency(0.008) ** 2)
    assert found.modes[1].eigenvalue.imag == pytest.approx(expected, rel=0.02)
    free(found)


@pytest.mark.parametrize("part", [0.9, 1.2, 5.0])
def test_a_pendulum_that_turns_too_fast_diverges(comm, part):
    """On a shaft that is free, with s^2 = W^2 - g/l."""
    hub = RigidBody("hub", 1.0, (10.0,) * 3)
    bob = RigidBody("bob", 1.0, (1e-9,) * 3, position=-E3)
    joints = [
        Revolute("shaft", None, hub, point=(0.0, 0.0, 0.0), axis=E3),
        Revolute("hinge", hub, bob, point=(0.0, 0.0, 0.0), axis=E2),
    ]
    system = MultibodySystem(comm, [hub, bob, *joints, Gravity(-9.81 * E3)])
    found = turning_modes(system, "shaft", part * np.sqrt(9.81), count=2)
    rigid, other = found.modes
    assert rigid.is_rigid
    assert other.eigenvalue**2 == pytest.approx(9.81 * (part**2 - 1.0), rel=1e-8)
    assert other.is_unstable == (part > 1.0)
    free(found)


MASS, ARM, OFFSET = 2.0, 1.5, 0.5


def make_rotor(comm, axis, euler=(1.0, 1.0, 1.0), blade=(1e-9,) * 3, spring=0.0):
    """A hub on a free shaft with two hinged blades opposite each other."""
    hub = RigidBody("hub", 1.0, euler)
    parts = [hub, Revolute("shaft", None, hub, point=(0.0, 0.0, 0.0), axis=E3)]
    for side in (1.0, -1.0):
        name = f"{side:+.0f}"
        bob = RigidBody(f"blade{name}", MASS, blade, position=(side * (OFFSET + ARM), 0.0, 0.0))
        at = (side * OFFSET, 0.0, 0.0)
        parts += [bob, Revolute(f"hinge{name}", hub, bob, point=at, axis=axis)]
        if spring:
            parts.append(JointSpring(f"spring{name}", f"hinge{name}", spring))
    return MultibodySystem(comm, parts)


def lag(euler, spring):
    """Squares over the speed, of the blades against each other and together with the shaft."""
    inertia, own = euler[0] + euler[1], MASS * ARM**2
    both = MASS * ARM * (ARM + OFFSET)
    whole = inertia + 2.0 * MASS * (ARM + OFFSET) ** 2
    stiffness = MASS * ARM * OFFSET + spring / 9.0
    return stiffness / own, stiffness / (own - 2.0 * both**2 / whole)


@pytest.mark.parametrize("euler", [(1.0, 1.0, 1.0), (4.0, 4.0, 1.0)])
@pytest.mark.parametrize("spring", [0.0, 100.0])
@pytest.mark.parametrize("kind", ["flap", "lag", "feather"])
def test_hinged_blades_on_a_free_shaft_have_one_rigid_motion(comm, kind, spring, euler):
    axis = {"flap": E2, "lag": E3, "feather": (1.0, 0.0, 0.0)}[kind]
    # thin flat blades turn back into the plane of rotation: (E2 - E3)/(E2 + E3)
    blade = (1e-9, 0.3, 0.1) if kind == "feather" else (1e-9,) * 3
    squares = {
        "flap": (1.0 + OFFSET / ARM + spring / (9.0 * MASS * ARM**2),) * 2,
        "lag": lag(euler, spring),
        "feather": (0.5 + spring / (9.0 * 0.4),) * 2,
    }[kind]
    system = make_rotor(comm, axis, euler, blade, spring)
    found = turning_modes(system, "shaft", 3.0, count=3)
    assert [mode.is_rigid for mode in found.modes] == [True, False, False]
    frequencies = [mode.eigenvalue.imag for mode in found.modes[1:]]
    assert frequencies == pytest.approx(3.0 * np.sqrt(sorted(squares)), rel=1e-6)
    free(found)


def test_blades_that_turn_out_of_the_plane_diverge(comm):
    """Growing motions come before the decaying ones of the same size."""
    system = make_rotor(comm, (1.0, 0.0, 0.0), blade=(1e-9, 0.1, 0.3))
    found = turning_modes(system, "shaft", 3.0, count=3)
    assert [mode.is_rigid for mode in found.modes] == [True, False, False]
    values = [mode.eigenvalue for mode in found.modes[1:]]
    assert values == pytest.approx([3.0 * np.sqrt(0.5)] * 2, rel=1e-6)
    free(found)
