"""Claims about frames without mass on surfaces of flexible bodies."""

import numpy as np
import pytest
from bricks import box, facets_at, frequencies

from turbine_fenicsx import (
    Coupling,
    EnergyMomentum,
    Fields,
    FlexibleBody,
    GeneralisedAlpha,
    Gravity,
    JointSpring,
    ModelError,
    MultibodySystem,
    PointForce,
    Revolute,
    RigidBody,
    Simulation,
    SolverOptions,
    StVenantKirchhoff,
    SurfaceFrame,
    equilibrium,
    initial_motion,
    modes,
)
from turbine_fenicsx.records.output_folder import read_field_times

pytestmark = pytest.mark.parallel

LAW = StVenantKirchhoff(3e7, 2e7)


def beam(comm, name, start, length=1.0, cells=4):
    """A beam along e1."""
    mesh = box(comm, [length, 0.2, 0.2], [cells, 1, 1])
    mesh.geometry.x[:, 0] += start
    return FlexibleBody(name, mesh, LAW, 800.0)


def ends(body, start):
    return [facets_at(body.mesh, start + x) for x in (0.0, 1.0)]


def pendulum(comm, foot=None, more=()):
    """Two beams in a row, joined to each other and to a hinge on the ground."""
    a, b = beam(comm, "a", 0.0), beam(comm, "b", 1.0)
    (a0, a1), (b0, _) = ends(a, 0.0), ends(b, 1.0)
    foot = foot or SurfaceFrame("foot", (a, a0), point=(0, 0, 0))
    held = [] if isinstance(foot, SurfaceFrame) else [Coupling("root", a, a0, foot)]
    weld = SurfaceFrame("weld", (a, a1), (b, b0), point=(1.0, 0.1, 0.1))
    hinge = Revolute("hinge", None, foot, point=(0, 0, 0), axis=(0, 0, 1))
    return MultibodySystem(comm, [a, b, foot, weld, hinge, *held, *more])


@pytest.mark.parametrize("solver", ["lu", "frozen", "monolithic"])
def test_flexible_bodies_are_joined_and_conserve(comm, solver):
    system = pendulum(comm, more=[Gravity((0, -9.81, 0))])
    stepper = EnergyMomentum(system, options=SolverOptions(linear_solver=solver))
    last = Simulation(system, 0.01, 0.3, stepper=stepper).run()
    assert last.state.joint_coordinates[0] < -0.2
    assert abs(last.energy_error) < 1e-8 * last.balance.kinetic
    assert last.constraint_error < 1e-12
    q = last.state.q.reshape(2, 4, 3)
    assert np.allclose(q[1, 0] - q[0, 0], q[1, 0]) and np.linalg.norm(q[1, 0]) > 0.99


def test_a_frame_is_the_limit_of_a_small_mass(comm):
    angles = []
    for mass in (None, 1e-2, 1e-4):
        foot = mass and RigidBody("foot", mass, (mass,) * 3)
        system = pendulum(comm, foot, more=[Gravity((0, -9.81, 0))])
        last = Simulation(system, 0.01, 0.2).run()
        angles.append(last.state.joint_coordinates[0])
    far, near = (abs(angle - angles[0]) for angle in angles[1:])
    assert 50.0 < far / near < 200.0  # in proportion to the mass


def test_statics_modes_and_initial_rates_take_frames(comm):
    pytest.importorskip("slepc4py")
    spring = JointSpring("spring", "hinge", 5e3)
    system = pendulum(comm, more=[spring])
    small = pendulum(comm, RigidBody("foot", 1e-7, (1e-9,) * 3), more=[spring])
    assert np.allclose(
        frequencies(modes(system, count=3)), frequencies(modes(small, count=3)), rtol=1e-6
    )
    hanging = pendulum(comm, more=[spring, Gravity((0, -9.81, 0))])
    weight = 9.81 * 800.0 * 2.0 * 0.04
    angle = equilibrium(hanging).joint_coordinates[0]
    # the beams sag too, so that their centre is less than 1 m from the hinge
    assert -5e3 * angle == pytest.approx(weight * np.cos(angle), rel=0.2)
    start = initial_motion(system, {"hinge": 2.0})
    last = Simulation(system, 0.005, 0.05, start=start).run()
    assert abs(last.energy_error) < 1e-9 * last.balance.total


def test_other_schemes_and_forces_take_frames(comm):
    a = beam(comm, "a", 0.0)
    root, tip = (SurfaceFrame(n, (a, f), point=(x, 0, 0)) for n, f, x in
                 zip(("root", "tip"), ends(a, 0.0), (0.0, 1.0), strict=True))  # fmt: skip
    hinge = Revolute("hinge", None, root, point=(0, 0, 0), axis=(0, 0, 1))
    push = PointForce("push", tip, point=(1.0, 0, 0), force=(0, 10.0, 0))
    system = MultibodySystem(comm, [a, root, tip, hinge, push])
    runs = [
        Simulation(system, 0.005, 0.2, stepper=scheme(system)).run()
        for scheme in (EnergyMomentum, lambda s: GeneralisedAlpha(s, 0.9))
    ]
    assert runs[0].external_work > 0.0
    assert abs(runs[0].energy_error) < 1e-9 * runs[0].balance.total
    angles = [run.state.joint_coordinates[0] for run in runs]
    assert angles[0] == pytest.approx(angles[1], rel=0.02)


def test_frames_are_not_drawn(comm, shared_tmp_path):
    system, path = pendulum(comm), shared_tmp_path / "fields.xdmf"
    Simulation(system, 0.01, 0.02, [Fields(system, path, 0.01, 0.02)]).run()
    assert len(read_field_times(path)) == 3
    assert "weld" not in path.read_text()


def test_mistakes_are_sentences(comm):
    a = beam(comm, "a", 0.0)
    with pytest.raises(ModelError, match="frame 'f' needs a surface: a flexible body and its fac"):
        SurfaceFrame("f", point=(0, 0, 0))
    for surface in (a, (a,), (RigidBody("r", 1.0, (1, 1, 1)), []), 3):
        with pytest.raises(
            TypeError, match="surface of frame 'f' must be a pair of a flexible bod"
        ):
            SurfaceFrame("f", surface, point=(0, 0, 0))
    with pytest.raises(ModelError, match="position of 'f' must be three numbers"):
        SurfaceFrame("f", (a, []), point=0.0)
    empty = SurfaceFrame("f", (a, np.zeros(0, np.int32)), point=(0, 0, 0))
    with pytest.raises(ModelError, match="coupling 'f on a' holds no node"):
        MultibodySystem(comm, [a, empty])
    hinge = Revolute("hinge", None, a, point=(0, 0, 0), axis=(0, 0, 1))
    with pytest.raises(TypeError, match=r"or the ground, got .*; a SurfaceFrame holds its surface"):
        MultibodySystem(comm, [a, hinge])
