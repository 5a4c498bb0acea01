"""Claims about Rayleigh damping of flexible bodies."""

import numpy as np
import pytest
from bricks import box, facets_at
from dolfinx import mesh

from turbine_fenicsx import EnergyMomentum, GeneralisedAlpha, NeoHooke, StVenantKirchhoff
from turbine_fenicsx.analysis.damped_modes import damped_modes
from turbine_fenicsx.analysis.modes import modes
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.rayleigh_damping import HeldPart, RayleighDamping
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel

LAME, DENSITY = (6e4, 4e4), 3.0
LAWS = {"quadratic": StVenantKirchhoff(*LAME), "general": NeoHooke(*LAME)}
BETA, ALPHA = 2e-3, 0.7


def make_beam(comm, law="quadratic", velocity=None, degree=2):
    cells = box(comm, [1.0, 0.2, 0.1], [4, 1, 1])
    return FlexibleBody("beam", cells, LAWS[law], DENSITY, degree, velocity=velocity)


def damp(body, beta=BETA, alpha=ALPHA):
    held = [HeldPart(facets_at(body.mesh, 0.0))]
    return RayleighDamping("damping", body, stiffness=beta, mass=alpha, held=held)


def clamp(comm, body, *more):
    root = Coupling("root", body, facets_at(body.mesh, 0.0), None)
    return MultibodySystem(comm, [body, root, *more])


def make_flyer(comm, law, *more):
    """A hub that flies and turns, with a beam that swings out."""
    hub = RigidBody(
        "hub", 0.3, (0.02, 0.02, 0.02), velocity=(0.3, 0.1, 0), angular_velocity=(2.0, 3.0, 1.0)
    )
    body = make_beam(comm, law, velocity=None)
    parts = [hub, body, Coupling("root", body, facets_at(body.mesh, 0.0), hub)]
    return MultibodySystem(comm, [*parts, *(make(body) for make in more)])


@pytest.mark.parametrize("law", LAWS)
def test_modes_of_a_clamped_body_are_damped_by_the_formula(comm, law):
    body = make_beam(comm, law)
    found = damped_modes(clamp(comm, body, damp(body, alpha=0.0)), count=4)
    of_stiffness = [0.5 * BETA * abs(mode.eigenvalue) for mode in found.modes]
    assert [m.damping_ratio for m in found.modes] == pytest.approx(of_stiffness, rel=1e-6)
    body = make_beam(comm, law)
    found = damped_modes(clamp(comm, body, damp(body, beta=0.0)), count=4)
    of_mass = [0.5 * ALPHA / abs(mode.eigenvalue) for mode in found.modes]
    # the weights of the nodes are a lumped mass
    assert [m.damping_ratio for m in found.modes] == pytest.approx(of_mass, rel=0.03)


@pytest.mark.parametrize("law", LAWS)
def test_damping_takes_energy_and_leaves_momenta_alone(comm, law):
    system = make_flyer(comm, law, damp)
    start = system.balance(system.initial_state())
    last = Simulation(system, 0.02, 1.0, stepper=EnergyMomentum(system)).run()
    assert last.dissipated.size == 1
    assert last.dissipated[0] > 1e-4 * start.total
    assert abs(last.energy_error) < 1e-10 * start.total
    size = np.linalg.norm(start.angular)
    assert last.balance.linear == pytest.approx(start.linear, abs=1e-10)
    assert last.balance.angular == pytest.approx(start.angular, abs=1e-10 * size)


def test_each_part_dissipates(comm):
    lost = []
    for beta, alpha in ((BETA, 0.0), (0.0, ALPHA), (BETA, ALPHA)):
        system = make_flyer(comm, "quadratic", lambda body, b=beta, a=alpha: damp(body, b, a))
        stepper = EnergyMomentum(system)
        assert stepper.dissipation_names == ("structural damping of beam",)
        lost.append(Simulation(system, 0.02, 0.1, stepper=stepper).run().dissipated[0])
    assert min(lost[:2]) > 1e-3 * lost[2]
    assert lost[2] == pytest.approx(lost[0] + lost[1], rel=0.1)


def test_the_generalised_alpha_method_damps_as_much(comm):
    lost = []
    for scheme in (EnergyMomentum, GeneralisedAlpha):
        system = make_flyer(comm, "quadratic", damp)
        lost.append(Simulation(system, 0.002, 0.1, stepper=scheme(system)).run().dissipated[0])
    assert lost[1] == pytest.approx(lost[0], rel=1e-2)


def test_the_matrix_gives_the_forces(comm):
    body = make_beam(comm)
    system = clamp(comm, body, damp(body, beta=0.0))
    model = system.flexible_models[0]
    u, v, product = (model.new_vector() for _ in range(3))
    rng = np.random.default_rng(1)
    u.array[:] = 1e-2 * rng.standard_normal(u.array.size)
    v.array[:] = rng.standard_normal(v.array.size)
    model.damping_matrix(u, 0.0).mult(v, product)
    forces = np.zeros(v.array.size)
    model.mass_damper.add_forces(u.array_r, v.array_r, -1.0, forces)
    assert product.array_r == pytest.approx(forces, abs=1e-12)
    power = comm.allreduce(model.mass_damper.power(u.array_r, v.array_r))
    assert v.dot(product) == pytest.approx(power, rel=1e-12)


def test_a_rigid_motion_is_not_resisted(comm):
    system = make_flyer(comm, "quadratic", damp)
    model = system.flexible_models[0]
    u, v = model.new_vector(), model.new_vector()
    v.array[:] = (np.cross([1.0, 2.0, 3.0], model.positions) + 4.0).ravel()
    forces = np.zeros(v.array.size)
    model.mass_damper.add_forces(u.array_r, v.array_r, 1.0, forces)
    assert np.abs(forces).max(initial=0.0) < 1e-12


def test_masses_of_nodes_add_up_to_the_body(comm):
    body = make_beam(comm)
    model = clamp(comm, body, damp(body, beta=0.0)).flexible_models[0]
    u, v = model.new_vector(), model.new_vector()
    far = model.positions[:, 0] > 1e-6  # a unit velocity of all but the root
    v.array.reshape(-1, 3)[far, 2] = 1.0
    power = comm.allreduce(model.mass_damper.power(u.array_r, v.array_r))
    assert 0.9 < power / (ALPHA * DENSITY * 0.02) < 1.0


def test_undamped_modes_stay_where_they_are(comm):
    body = make_beam(comm)
    without = modes(clamp(comm, body), count=3)
    body = make_beam(comm)
    found = damped_modes(clamp(comm, body, damp(body)), count=3)
    undamped = [abs(mode.eigenvalue) for mode in found.modes]
    assert undamped == pytest.approx([abs(m.eigenvalue) for m in without.modes], rel=1e-4)


def test_parts_are_held_on_their_own(comm):
    """Two beams in one body, held at their outer ends, and damped as two bodies are."""
    cells = box(comm, [2.0, 0.2, 0.1], [8, 1, 1])
    body = FlexibleBody("beams", cells, LAWS["quadratic"], DENSITY, 2)
    middles = mesh.compute_midpoints(
        cells, 3, np.arange(cells.topology.index_map(3).size_local, dtype=np.int32)
    )
    ends = [facets_at(cells, x) for x in (0.0, 2.0)]
    halves = [np.flatnonzero(sign * (middles[:, 0] - 1.0) < -0.2) for sign in (1, -1)]
    held = [HeldPart(f, c) for f, c in zip(ends, halves, strict=True)]
    damping = RayleighDamping("damping", body, stiffness=0.0, mass=ALPHA, held=held)
    model = MultibodySystem(comm, [body, damping]).flexible_models[0]
    u, v = model.new_vector(), model.new_vector()
    arms = model.positions - [2.0, 0.0, 0.0]
    turning = np.cross([0.0, 0.0, 1.0], arms)  # as the second end does
    v.array[:] = np.where(model.positions[:, :1] > 1.0, turning, 0.0).ravel()
    forces = np.zeros(v.array.size)
    model.mass_damper.add_forces(u.array_r, v.array_r, 1.0, forces)
    assert np.abs(forces).max(initial=0.0) < 1e-12
    v.array[:] = (turning * arms[:, :1]).ravel()  # now both bend
    model.mass_damper.add_forces(u.array_r, v.array_r, 1.0, forces)
    assert comm.allreduce(np.abs(forces).max(initial=0.0)) > 1e-3


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({"stiffness": -1.0}, "stiffness of 'damping' must not be negative, got -1"),
        ({"stiffness": 0.0, "mass": -2.0}, "mass of 'damping' must not be negative, got -2"),
        ({"stiffness": 0.0, "mass": 1.0}, "mass of 'damping' = 1 needs held, the surfaces"),
    ],
)
def test_wrong_numbers_are_refused(comm, numbers, words):
    with pytest.raises(ModelError, match=words):
        RayleighDamping("damping", make_beam(comm), **numbers)


def test_a_body_is_damped_once(comm):
    body = make_beam(comm)
    twice = [damp(body), RayleighDamping("more", body, stiffness=1.0)]
    with pytest.raises(ModelError, match=r"one Rayleigh damping, but \['beam'\] have more"):
        clamp(comm, body, *twice)
