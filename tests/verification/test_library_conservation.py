"""Conservation with all at once: joints, elements, loads, motions, viscosity, dissipation."""

import numpy as np
import pytest
from recorded_runs import Keeper
from runs import (
    Record,
    assert_constraints_hold,
    assert_energy_is_balanced,
    assert_momenta_are_balanced,
    comm,
    mass_and_centre,
    run,
)

from turbine_fenicsx import (
    Coupling,
    Cylindrical,
    EnergyMomentum,
    FlexibleBody,
    FollowerForce,
    Gravity,
    Hat,
    JointDamper,
    JointSpring,
    JointTorque,
    KelvinVoigt,
    MultibodySystem,
    NodeForce,
    Planar,
    PointDamper,
    PointForce,
    PointSpring,
    PrescribedMotion,
    Pressure,
    Prismatic,
    Revolute,
    Rigid,
    RigidBody,
    Simulation,
    Spherical,
    StVenantKirchhoff,
    SurfaceTraction,
    Torque,
    Universal,
)
from turbine_fenicsx.foundation.rotations import E1, E2, E3, rotation_about

GRAVITY = np.array([0.0, -1.0, 0.5])
TURN = rotation_about((1.0, 2.0, 0.5), 0.6)
DT = 0.02

# Newton's method stops at 1e-12 of the forces in each step. Measured: 3e-14 to 3e-12.
SOLVER_ACCURACY = 1e-11


def body(name, at, mass=1.0, **more):
    return RigidBody(
        name, mass, mass * np.array([0.03, 0.05, 0.04]), position=at, directors=TURN, **more
    )


# --- two bodies in free fall, one joint, and inner forces


FREE = {
    "revolute": (lambda a, b: Revolute("j", a, b, point=0.5 * E1, axis=E3), ["j"]),
    "prismatic": (lambda a, b: Prismatic("j", a, b, point=0.5 * E1, axis=E1 + E2), ["j"]),
    "cylindrical": (
        lambda a, b: Cylindrical("j", a, b, point=0.5 * E1, axis=E2),
        ["j.angle", "j.displacement"],
    ),
    "universal": (
        lambda a, b: Universal("j", a, b, point=0.5 * E1, first_axis=E2, second_axis=E3),
        ["j.first", "j.second"],
    ),
    "planar": (
        lambda a, b: Planar("j", a, b, point=0.5 * E1, normal=E2),
        ["j.first", "j.second", "j.angle"],
    ),
    "spherical": (lambda a, b: Spherical("j", a, b, 0.5 * E1), []),
    "rigid": (lambda a, b: Rigid("j", a, b, 0.5 * E1), []),
}


@pytest.mark.parametrize(("joint", "names"), FREE.values(), ids=FREE)
def test_inner_forces_keep_the_momenta_and_what_they_do_is_balanced(joint, names):
    """Torque, spring, damper on each joint coordinate; a spring and a damper between points."""
    a, b = body("a", (0.0, 0.2, 0.0), 2.0, velocity=(0.1, 0.2, 0.3)), body("b", (1.0, 0.0, 0.1))
    b = body("b", (1.0, 0.0, 0.1), velocity=(0.1, 0.2, 0.3))
    inner = [
        *(JointTorque(f"torque on {n}", n, 1.0, Hat(3.0, 0.4)) for n in names),
        *(JointSpring(f"spring {n}", n, 4.0, 0.3) for n in names),
        *(JointDamper(f"damper {n}", n, 0.05) for n in names),
        PointSpring(
            "spring",
            a,
            b,
            first_point=(0, 1, 0),
            second_point=(1, -1, 0),
            stiffness=3.0,
            length=1.0,
        ),
        PointDamper("damper", a, b, first_point=(0, 1, 1), second_point=(1, -1, 0), damping=0.02),
    ]
    system = MultibodySystem(comm, [a, b, joint(a, b), *inner, Gravity(tuple(GRAVITY))])
    r = run(system, DT, 1.0)
    assert_constraints_hold(r)
    assert_momenta_are_balanced(r, *mass_and_centre(system), GRAVITY, 1e-12)
    scale = np.max(np.abs(r.total))
    assert np.max(np.abs(r.energy_error)) <= 1e-12 * scale
    if names:
        assert np.max(np.abs(r.joint_coordinates)) > 0.3
        assert np.ptp(r.total) > 0.01 * scale  # works and dissipation are not small


# --- everything


def outer_parts(base, bob, beam, side, top):
    """What ties the mechanism to the ground, and the loads from outside."""
    return [
        Planar("floor", None, base, point=(0, 0, 0), normal=E2),
        Spherical("leash end", None, post := body("post", (3.0, 1.2, 0)), (3.0, 1.5, 0)),
        post,
        Cylindrical(
            "sleeve", post, pin := body("pin", (3.0, 1.0, 0), 0.1), point=(3, 1, 0), axis=E2
        ),
        pin,
        JointSpring("sleeve spring", "sleeve.displacement", 30.0),
        PointSpring(
            "leash",
            pin,
            bob,
            first_point=(3.0, 1.0, 0),
            second_point=(2.7, 1.0, 0),
            stiffness=20.0,
        ),
        PointForce("push", base, point=(0, 0, 0.1), force=(1.0, 0.0, 2.0), function=Hat(2.0, 0.4)),
        FollowerForce("jet", bob, point=(2.6, 1.0, 0), force=(0.2, 0.5, 0.1)),
        Torque("motor", post, (0.1, 0.4, 0.0)),
        Torque("gyro", pin, (0.0, 0.01, 0.0), follower=True),
        SurfaceTraction("wind", beam, side, (0.3, 0.5, -1.0), Hat(3.0, 0.5)),
        Pressure("blast", beam, np.append(side, top), 2.0, Hat(2.0, 0.5)),
        NodeForce("hook", beam, point=(1.5, 1.2, 0.2), force=(0.2, -0.3, 0.5)),
    ]


def everything(comm=comm, free=False, viscosity=0.02):
    """A mechanism with a soft beam; without ground and outer loads if ``free``.

    The base slides on a plane (or falls), the arm turns on it, the hub slides on the arm, and the
    beam is held by the hub at one end and by a ring at the other, which a Cardan joint ties to a
    bob on a ball joint; a box is riveted to the arm.
    """
    from dolfinx import mesh

    base, arm = body("base", (0, 0, 0), 3.0), body("arm", (0.5, 0.5, 0))
    hub, ring = body("hub", (1.0, 1.0, 0)), body("ring", (2.2, 1.0, 0), 0.5)
    bob, box = body("bob", (2.6, 1.0, 0), 0.3), body("box", (0.5, 0.8, 0.2), 0.4)
    corners = [[1.0, 0.8, -0.2], [2.0, 1.2, 0.2]]
    cells = mesh.create_box(comm, corners, [2, 1, 1], mesh.CellType.hexahedron)

    def facets(k, x):
        return mesh.locate_entities_boundary(cells, 2, lambda p: np.isclose(p[k], x))

    law = StVenantKirchhoff(120.0, 80.0)
    if viscosity:
        law = KelvinVoigt(law, viscosity * 80.0, viscosity * 173.0)
    beam = FlexibleBody("beam", cells, law, 3.0)
    parts = [base, arm, hub, ring, bob, box, beam]
    parts += [
        Revolute("shoulder", base, arm, point=(0, 0.3, 0), axis=E3),
        Prismatic("slide", arm, hub, point=(1.0, 1.0, 0), axis=E1),
        Universal("cardan", ring, bob, point=(2.4, 1.0, 0), first_axis=E2, second_axis=E3),
        Rigid("rivet", arm, box, (0.5, 0.7, 0.1)),
        Coupling("root", beam, facets(0, 1.0), hub),
        Coupling("tip", beam, facets(0, 2.0), ring),
        JointTorque("torque on shoulder", "shoulder", 1.0, Hat(12.0, 0.3)),
        JointSpring("return", "slide", 60.0, 0.1),
        JointDamper("friction", "shoulder", 0.1),
        PointSpring(
            "rope",
            base,
            ring,
            first_point=(0, -0.5, 0),
            second_point=(2.2, 1.0, 0.3),
            stiffness=6.0,
            length=1.5,
        ),
        PointDamper(
            "strut", box, bob, first_point=(0.5, 0.8, 0.2), second_point=(2.6, 1.0, 0), damping=0.3
        ),
        PrescribedMotion("cardan.second", lambda t: 0.8 * t**3 / (0.01 + t**2)),
        Gravity(tuple(GRAVITY)),
    ]
    if not free:
        blown = facets(1, 0.8), facets(2, 0.2)
        parts += outer_parts(base, bob, beam, *blown)
    return MultibodySystem(comm, parts)


class Works(Record):
    """Records works and dissipation by name as well."""

    def observe(self, snapshot):
        super().observe(snapshot)
        self.works = snapshot.works
        self.dissipated = snapshot.dissipated

    def finish(self):
        works, dissipated = self.works, self.dissipated
        super().finish()
        self.works, self.dissipated = works, dissipated


def simulate(system, end=0.6, data=None, checkpoints=None):
    record = Works()
    stepper = EnergyMomentum(system, numerical_dissipation=0.2)
    simulation = Simulation(system, DT, end, [record], stepper, checkpoints=checkpoints)
    last = simulation.run(data)
    stepper.destroy()
    record.dissipation_names = stepper.dissipation_names
    assert simulation.halvings == 0
    return record, last


def test_everything_at_once_is_balanced_by_name():
    system = everything()
    r, _ = simulate(system)
    assert system.work_names == (
        "torque on shoulder",
        "gravity",
        "push",
        "jet",
        "motor",
        "gyro",
        "wind",
        "blast",
        "hook",
        "motion of cardan.second",
    )
    assert r.dissipation_names == (
        "friction",
        "strut",
        "viscosity of beam",
        "numerical dissipation of beam",
    )
    scale = max(r.largest_energy, np.max(np.abs(r.works)))
    assert np.max(np.abs(r.energy_error)) <= SOLVER_ACCURACY * scale
    change = r.works.sum() - r.dissipated.sum()
    assert r.total[-1] - r.total[0] == pytest.approx(change, abs=SOLVER_ACCURACY * scale)
    for name, work in zip(system.work_names, r.works, strict=True):
        assert abs(work) > 1e-4 * scale or name == "gravity", name
    assert np.all(r.dissipated > 1e-4 * scale)
    assert np.max(r.strain) > 0.02 * scale
    assert_constraints_hold(r)


def test_without_ground_and_outer_loads_the_momenta_follow_from_the_weight():
    system = everything(free=True)
    r, _ = simulate(system)
    assert_momenta_are_balanced(r, *mass_and_centre(system), GRAVITY, SOLVER_ACCURACY)
    assert np.max(np.abs(r.energy_error)) <= SOLVER_ACCURACY * r.largest_energy
    assert_constraints_hold(r)
    assert (
        np.max(np.abs(r.joint_coordinates[:, 0])) > 0.3
        and np.max(r.strain) > 0.01 * r.largest_energy
    )


@pytest.mark.parallel
def test_everything_is_the_same_on_all_ranks_together_and_on_each_alone():
    from mpi4py import MPI

    a, b = (simulate(everything(c), 0.2)[0] for c in (comm, MPI.COMM_SELF))
    for name in ("total", "joint_coordinates", "q", "works", "dissipated"):
        x, y = getattr(a, name), getattr(b, name)
        # two iterations that end at 1e-12 of the forces
        assert np.allclose(x, y, rtol=0, atol=1e-10 * np.max(np.abs(y))), name


@pytest.mark.parallel
def test_everything_goes_on_bit_for_bit_after_a_restart():
    keeper = Keeper()
    whole, last = simulate(everything(), 0.2, checkpoints=keeper)
    for k in (1, 6):
        part, again = simulate(everything(), 0.2, keeper.saved[k])
        assert len(part.time) == len(whole.time) - k
        for name in ("total", "joint_coordinates", "q", "multipliers", "energy_error"):
            assert np.array_equal(getattr(part, name), getattr(whole, name)[k:]), name
        assert np.array_equal(part.works, whole.works)
        assert np.array_equal(part.dissipated, whole.dissipated)
        u, v = (s.state.u[0].array_r for s in (last, again))
        assert np.array_equal(u, v)


def test_the_assertions_reject_what_is_not_balanced(monkeypatch):
    """A spring whose force is that at the start of the step does work out of nothing."""
    system = everything(free=True)
    (spring,) = (
        e
        for e, part in zip(system.rigid_model.forces, system.motion_forces, strict=True)
        if part.name == "rope"
    )
    right = spring.force
    monkeypatch.setattr(spring, "force", lambda y0, y1, step: right(y0, y0, step), raising=True)
    r, _ = simulate(system)
    assert np.max(np.abs(r.energy_error)) > 1e-5 * r.largest_energy


def test_energy_is_constant_without_works_and_dampers():
    """No viscosity, no dissipation, no loads: springs, joints and a beam in free fall."""
    a, b = body("a", (0, 0, 0), 2.0), body("b", (1.0, 0.3, 0))
    joint = Universal("j", a, b, point=(0.5, 0, 0), first_axis=E2, second_axis=E3)
    springs = [
        JointSpring("s", "j.first", 4.0, 0.5),
        PointSpring(
            "p", a, b, first_point=(0, 1, 0), second_point=(1, -1, 0), stiffness=3.0, length=1.0
        ),
    ]
    system = MultibodySystem(comm, [a, b, joint, *springs, Gravity(tuple(GRAVITY))])
    r = run(system, DT, 1.0)
    assert_energy_is_balanced(r, 0.0, 1e-12)
    assert np.ptp(r.kinetic) > 0.1
