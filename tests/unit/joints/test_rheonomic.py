"""Claims about joints whose constraints follow time: a point that is led around a circle."""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from turbine_fenicsx import Gravity, Revolute, Rheonomic
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.start import initial_motion
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.generalised_alpha import GeneralisedAlpha

E1, E2, E3 = np.eye(3)
RADIUS, SPEED, ARM, MASS = 0.8, 3.0, 0.5, 2.0
EULER = (0.02, 0.3, 0.05)
SPIN = (0.0, 0.0, 4.0)


@dataclass(frozen=True, eq=False)
class Guide:
    """A point of a body that follows a path: its coordinates as functions of time."""

    name: str
    second: RigidBody
    point: np.ndarray
    path: tuple[Callable, Callable, Callable]
    first: None = None

    @property
    def bodies(self):
        return self.first, self.second

    def constraints(self, a, b):
        components = b.point(self.point).components()
        return [Rheonomic(f, p) for f, p in zip(components, self.path, strict=True)]

    def coordinates(self, a, b):
        return {}


def circle(angle):
    return (
        lambda t: RADIUS * np.cos(angle(t)),
        lambda t: RADIUS * np.sin(angle(t)),
        lambda t: 0.0,
    )


def accelerating(t):
    """From rest."""
    return 5.0 * t**3 / (0.3 + t)


def accelerating_rate(t):
    return 5.0 * (3.0 * t**2 * (0.3 + t) - t**3) / (0.3 + t) ** 2


def led(comm, *more):
    """A spinning body led by its centre of mass, from rest."""
    body = RigidBody("body", MASS, EULER, position=RADIUS * E1, angular_velocity=SPIN)
    guide = Guide("guide", body, RADIUS * E1, circle(accelerating))
    return MultibodySystem(comm, [body, guide, *more])


def swinging(comm):
    """A body held at its end, which turns steadily on a circle and stretches outwards."""
    body = RigidBody(
        "body",
        MASS,
        EULER,
        position=(RADIUS + ARM) * E1,
        velocity=SPEED * (RADIUS + ARM) * E2,
        angular_velocity=SPEED * E3,
    )
    guide = Guide("guide", body, RADIUS * E1, circle(lambda t: SPEED * t))
    return MultibodySystem(comm, [body, guide])


def states(system, dt, end, make=EnergyMomentum):
    """Reports and states of all steps."""
    stepper, state = make(system), system.initial_state()
    found = [(None, state)]
    for _ in range(round(end / dt)):
        other = state.copy()
        found.append((stepper.advance(state, dt, other), other))
        state = other
    stepper.destroy()
    return found


def test_the_point_follows_its_path_and_the_work_closes_the_balance(comm):
    system = led(comm, Gravity((1.0, -9.81, 0.0)))
    assert system.work_names == ("gravity", "guide")
    found = states(system, 0.02, 1.0)
    energies = [system.balance(state).total for _, state in found]
    works = [report.works[1] for report, _ in found[1:]]
    for _, state in found[1:]:
        place = [p(state.time) for p in circle(accelerating)]
        assert np.allclose(state.q[:3], place, rtol=0, atol=1e-13)
        assert system.constraint_error(state) <= 1e-13
    assert np.allclose(np.diff(energies), works, rtol=0, atol=1e-11)
    assert max(np.abs(works)) > 0.5


def test_speed_energy_and_work_agree_with_the_closed_form_to_second_order(comm):
    end, errors = 1.0, []
    rate = accelerating_rate(end)
    exact = 0.5 * MASS * (RADIUS * rate) ** 2
    for dt in (0.02, 0.01, 0.005):
        found = states(led(comm), dt, end)
        work = sum(report.works[0] for report, _ in found[1:])
        speed = np.linalg.norm(found[-1][1].q_dot[:3])
        errors.append([work - exact, speed - RADIUS * rate])
    orders = np.log2(np.abs(np.array(errors[:-1]) / np.array(errors[1:])))
    assert np.allclose(orders, 2.0, rtol=0, atol=0.1)
    assert abs(errors[-1][0]) < 1e-3 * exact


def test_angular_momentum_changes_by_the_moment_of_the_guide(comm):
    system, dt = led(comm), 0.02
    found = states(system, dt, 0.4)
    n = system.rigid_model.n_constraints
    for (_, before), (_, after) in pairwise(found):
        force = -after.multipliers[n - 3 : n]
        arm = 0.5 * (before.q[:3] + after.q[:3])
        change = system.balance(after).angular - system.balance(before).angular
        assert np.allclose(change, dt * np.cross(arm, force), rtol=0, atol=1e-11)
        change = system.balance(after).linear - system.balance(before).linear
        assert np.allclose(change, dt * force, rtol=0, atol=1e-11)


@pytest.mark.parametrize("make", [EnergyMomentum, GeneralisedAlpha])
def test_a_body_that_stretches_outwards_keeps_to_the_closed_form(comm, make):
    """It turns as one with its end, held with the force m (R + l) Omega^2, without any work."""
    errors = []
    for dt in (0.02, 0.01):
        system = swinging(comm)
        *_, (report, state) = states(system, dt, 1.0, make)
        angle = SPEED * state.time
        place = (RADIUS + ARM) * np.array([np.cos(angle), np.sin(angle), 0.0])
        n = system.rigid_model.n_constraints
        force = np.linalg.norm(state.multipliers[n - 3 : n])
        errors.append(np.linalg.norm(state.q[:3] - place))
        assert force == pytest.approx(MASS * (RADIUS + ARM) * SPEED**2, rel=2e-3)
        assert abs(report.works[0]) < 1e-2 * dt * force
    assert errors[1] < 1e-3 and errors[0] / errors[1] > 3.5


def test_a_velocity_that_does_not_fit_the_path_is_told_and_can_be_found(comm, caplog):
    body = RigidBody("body", MASS, EULER, position=(RADIUS + ARM) * E1)
    guide = Guide("guide", body, RADIUS * E1, circle(lambda t: SPEED * t))
    with caplog.at_level(logging.WARNING):
        system = MultibodySystem(comm, [body, guide])
    if comm.rank == 0:
        assert "velocities of the bodies do not agree with joints 'guide'" in caplog.text
    state = initial_motion(system, {})
    rates = state.q_dot.reshape(4, 3)
    velocity = rates[0] + body.body_coordinates(RADIUS * E1) @ rates[1:]
    assert np.allclose(velocity, RADIUS * SPEED * E2, rtol=0, atol=1e-9)
    last = Simulation(system, 0.01, 0.1, start=state).run()
    assert abs(last.energy_error) < 1e-10


def test_a_path_that_fits_brings_no_warning(comm, caplog):
    with caplog.at_level(logging.WARNING):
        led(comm)
        swinging(comm)
    assert caplog.text == ""


def test_a_path_that_begins_elsewhere_is_refused(comm):
    body = RigidBody("body", MASS, EULER)
    guide = Guide("guide", body, 0.0 * E1, circle(accelerating))
    with pytest.raises(ModelError, match=r"'guide' by 0\.8 m"):
        MultibodySystem(comm, [body, guide])


def test_a_path_that_other_joints_determine_is_refused(comm):
    body = RigidBody("body", MASS, EULER, position=RADIUS * E1)
    hinge = Revolute("hinge", None, body, point=(0, 0, 0), axis=E3)
    guide = Guide("guide", body, RADIUS * E1, circle(accelerating))
    with pytest.raises(ModelError, match="'guide' has a constraint that follows a function of"):
        MultibodySystem(comm, [body, hinge, guide])
