"""Claims about classes and functions of users that are wrong: a sentence names each."""

import gc
import logging

import numpy as np
import pytest
import ufl
from bricks import box, facets_at

import turbine_fenicsx
from turbine_fenicsx import (
    Checkpoints,
    EnergyMomentum,
    FlexibleBody,
    JointTorque,
    ModelError,
    MultibodySystem,
    PrescribedMotion,
    Revolute,
    Rheonomic,
    RigidBody,
    Simulation,
    initial_motion,
)
from turbine_fenicsx.foundation.errors import ForeignError
from turbine_fenicsx.joints.coordinates import Angle

pytestmark = pytest.mark.parallel

A = RigidBody("a", 1.0, (1.0, 1.0, 1.0))
HINGE = Revolute("hinge", None, A, point=(0, 0, 0), axis=(0, 0, 1))


class Own:
    """A joint that states what it is given."""

    name, bodies = "own", (None, A)

    def __init__(self, constraints=(), coordinates=None):
        self.given, self.named = constraints, coordinates or {}

    def constraints(self, a, b):
        return self.given() if callable(self.given) else self.given

    def coordinates(self, a, b):
        return self.named


class Magnet:
    """A force that returns what it is given."""

    name, kind = "pull", "external"

    def __init__(self, force, slope):
        self.returned = force, slope

    def bind(self, layout):
        _, self.index = layout.frames(A)
        return self

    def force(self, y0, y1, step):
        F, slope = self.returned
        return (F() if callable(F) else F), slope

    def energy(self, y):
        return 0.0


class Field:
    name = "field"

    def __init__(self, change):
        self.change = change

    def add_to(self, forces, time):
        self.change(forces)


class Law:
    quadratic = True

    def __init__(self, energy):
        self.energy = energy

    def strain_energy(self, C, parameter):
        return self.energy(C)


class Goo(Law):
    def strain_energy(self, C, parameter):
        E = 0.5 * (C - ufl.Identity(3))
        return 1e3 * ufl.inner(E, E)

    def viscous_stress(self, E_dot, parameter):
        return self.energy(E_dot)


class Traction:
    name, function = "push", staticmethod(lambda t: 1.0)

    def __init__(self, body, facets, traction):
        self.flexible, self.facets, self.given = body, facets, traction

    def traction(self, at):
        return self.given


def block(comm, law):
    return FlexibleBody("block", box(comm, [1.0] * 3, [2, 1, 1]), law, 1000.0)


def fails(*_):
    raise ValueError("the table\nhas no \x1b[31mrow")


def late(t):
    return fails() if t > 0.025 else 0.0


def run(comm, *parts, **options):
    return Simulation(MultibodySystem(comm, parts), 0.01, 0.05, **options).run()


FLOATS = "Own 'own' must be Quadratic or Rheonomic functions, such as dot.*, got float 0.3"
FAILED = r"ValueError: the table has no \\x1b\[31mrow"


@pytest.mark.parametrize(
    ("joint", "words"),
    [
        (Own([0.3]), FLOATS),
        (Own([Rheonomic(0.3, late)]), FLOATS),
        (Own(fails), rf"constraints\(\) of Own 'own' failed: {FAILED}"),
        (Own(7), r"constraints\(\) of Own 'own' failed: TypeError"),
        (Own((), {"x": 0.1}), r"Own 'own' at 'x' must be an Angle or a Displacement, got float"),
        (Own((), {"x": Angle(1.0, 0.0)}), "Own 'own' at 'x' must be made of Quadratic functions"),
    ],
)
def test_joints_state_functions(comm, joint, words):
    with pytest.raises(ModelError, match=words):
        MultibodySystem(comm, [A, joint])


@pytest.mark.parametrize(
    ("force", "words"),
    [
        (
            Magnet(1.0, np.zeros((12, 12))),
            r"Magnet 'pull' must return .* shape \(12,\).*got \(\) a",
        ),
        (Magnet(np.zeros(12), 0.0), r"Magnet 'pull' must return .* got \(12,\) and \(\)"),
        (Magnet(fails, 0.0), rf"force\(\) of Magnet 'pull' failed: {FAILED}"),
        (Field(fails), rf"add_to\(\) of Field 'field' failed: {FAILED}"),
        (Field(lambda f: setattr(f, "acceleration", 1.0)), r"acceleration .* of Field .*got \(\)"),
        (Field(lambda f: f.coordinates.update({A: 1.0})), "on 'a' must keep .* of Field 'field'"),
        (Field(lambda f: f.coordinates[A].__iadd__(np.ones(3))), "Field 'field' failed: ValueErr"),
    ],
)
def test_forces_have_the_shape_of_their_coordinates(comm, force, words):
    with pytest.raises(ModelError, match=words):
        run(comm, A, force)


def test_functions_of_time_that_fail_are_named(comm):
    with pytest.raises(ModelError, match="motion of 'hinge', function 'fails', at t = 0 failed: V"):
        PrescribedMotion("hinge", fails)
    for part in (PrescribedMotion("hinge", late), JointTorque("push", "hinge", 1.0, late)):
        with pytest.raises(ForeignError, match=rf"(hinge'|push').* failed: {FAILED}"):
            run(comm, A, HINGE, part)


def test_a_function_that_fails_in_a_run_leaves_a_checkpoint(comm, shared_tmp_path):
    system = MultibodySystem(comm, [A, HINGE, PrescribedMotion("hinge", late)])
    checkpoints = Checkpoints(system, shared_tmp_path)
    with pytest.raises(ForeignError, match=r"function 'late', at t = 0\.03 s"):
        Simulation(system, 0.01, 0.05, checkpoints=checkpoints).run()
    assert checkpoints.load(()).numbers["index"] == 2


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (Law(lambda C: C), r"strain_energy\(\) of law Law of 'block' must return a scalar, got"),
        (Law(fails), rf"strain_energy\(\) of law Law of 'block' failed: {FAILED}"),
        (Goo(ufl.tr), r"viscous_stress\(\) of law Goo of 'block' must return a tensor of shape"),
        (Goo(fails), r"viscous_stress\(\) of law Goo of 'block' failed: ValueError"),
    ],
)
def test_laws_are_scalars_and_tensors(comm, law, words):
    with pytest.raises(ModelError, match=words):
        MultibodySystem(comm, [block(comm, law)])


@pytest.mark.parametrize("given", [1.0, ufl.Identity(3)])
def test_tractions_are_vectors(comm, given):
    body = block(comm, Goo(lambda E: 0.0 * E))
    force = Traction(body, facets_at(body.mesh, 1.0), given)
    with pytest.raises(ModelError, match=r"traction\(\) of Traction 'push' must return a vector"):
        EnergyMomentum(MultibodySystem(comm, [body, force]))


@pytest.mark.parametrize("time", ["1 s", None, np.nan])
def test_times_are_numbers(comm, time):
    system = MultibodySystem(comm, [A])
    with pytest.raises(ModelError, match="end must be a number, got"):
        Simulation(system, 0.01, time)
    with pytest.raises(ModelError, match="dt must be a number, got"):
        Simulation(system, time, 1.0)


def test_the_stepper_of_a_snapshot_goes_with_its_simulation(comm):
    simulation = Simulation(MultibodySystem(comm, [A]), 0.01, 0.02)
    last = simulation.run()
    assert last.stepper is simulation.stepper
    del simulation
    gc.collect()
    with pytest.raises(ModelError, match="gone with its simulation: keep the Simulation"):
        _ = last.stepper


def test_a_state_that_opens_a_joint_is_not_stepped(comm):
    system = MultibodySystem(comm, [A, HINGE])
    stepper, state = EnergyMomentum(system), system.initial_state()
    out = state.copy()
    stepper.advance(state, 0.01, out)
    out.q[0] += 0.2
    for start in (out.copy(), out.copy()):
        with pytest.raises(ModelError, match=r"t = 0\.01 s opens 'hinge' by 0\.2, which"):
            stepper.advance(start, 0.01, state.copy())
    with pytest.raises(ModelError, match=r"t = 0 s opens 'hinge' by 0\.2"):
        Simulation(system, 0.01, 0.02, start=out)


def test_a_state_that_opens_a_body_or_an_angle_names_it(comm):
    system = MultibodySystem(comm, [A, HINGE])
    long, turned = system.initial_state(), system.initial_state()
    long.q[3] += 0.1
    turned.joint_coordinates[0] = 0.3
    for state, words in ((long, "'a' by 0.11"), (turned, "'hinge' by 0.3")):
        with pytest.raises(ModelError, match=f"opens {words}"):
            EnergyMomentum(system).advance(state, 0.01, state.copy())


def test_a_motion_that_starts_with_another_velocity_is_warned_of(comm, caplog):
    system = MultibodySystem(comm, [A, HINGE, PrescribedMotion("hinge", lambda t: 2.0 * t + t**2)])
    with caplog.at_level(logging.WARNING):
        Simulation(system, 0.01, 0.0, start=initial_motion(system, {"hinge": 2.0})).run()
        assert not caplog.records
        Simulation(system, 0.01, 0.0).run()
    words = "'motion of hinge' begins with the rate 2, but the bodies start with 0; velocities will"
    assert [words in r.getMessage() for r in caplog.records] == [True] * (comm.rank == 0)


def test_unknown_public_names_suggest():
    with pytest.raises(AttributeError, match="no attribute 'NeoHook'; did you mean 'NeoHooke'"):
        _ = turbine_fenicsx.NeoHook
    with pytest.raises(AttributeError, match=r"no attribute '_repr_html_'$"):
        _ = turbine_fenicsx._repr_html_
