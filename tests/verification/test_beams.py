"""Claims about beams of section matrices: statics, frequencies, section loads, conservation."""

import numpy as np
import pytest
from cosserat_rod import bend_arc
from reduced_beams import march, placements
from scipy.spatial import cKDTree
from section_beams import (
    COMM,
    LENGTH,
    bent_line,
    carried,
    move_axis,
    pull_end,
    sections,
)

from turbine_fenicsx import (
    BeamLine,
    BeamSections,
    Coupling,
    EnergyMomentum,
    Fields,
    ModelError,
    MultibodySystem,
    NodeForce,
    ReducedBody,
    Revolute,
    RigidBody,
    SolverOptions,
    beam_basis,
    box_carrier,
    equilibrium,
    modes,
    turning_modes,
)
from turbine_fenicsx.simulation.observers.field_grid import FieldGrid
from turbine_fenicsx.simulation.observers.section_loads import BeamLoads
from turbine_fenicsx.system import gram_strain

CONSERVED = 1e-11


# --- statics


@pytest.fixture(scope="module")
def twisted():
    """The bar of BeamDyn's test bd_static_twisted_with_k1 as a function of its elements."""
    C = np.diag([8.2604167e9, 8.2604167e9, 2.5e10, 0.520833e9, 0.130208333e9, 0.141872656e9])
    M = np.diag([678.935, 678.935, 678.935, 973.04, 972.86, 1945.9])
    line = BeamLine.straight(LENGTH, -0.5 * np.pi)
    bar = BeamSections([0.0, LENGTH], np.array([C, C]), np.array([M, M]))

    def bend(elements, degree, force=4e6):
        box = box_carrier("bar", line, (0.2, 0.2), elements * degree, COMM)
        basis = beam_basis(box.carrier, line, bar, elements, degree, box.start, hold=1.0)
        body = ReducedBody("bar", box.carrier, basis)
        clamp = Coupling("clamp", body, box.start, None)
        system = MultibodySystem(COMM, [body, clamp, *pull_end((0.0, -force, 0.0))(body)])
        state = equilibrium(system, np.linspace(0.2, 1.0, 5))
        return system, state, basis

    return bend


def test_a_twisted_bar_bends_as_that_of_beamdyn(twisted):
    system, state, basis = twisted(8, 3)
    tip = move_axis(state, basis)
    of_beamdyn = np.array([1.71810805, -3.59245231, -1.14114462])
    assert np.linalg.norm(tip - of_beamdyn) < 1e-3 * np.linalg.norm(of_beamdyn)
    # the load holds all sections in equilibrium, about their own axes
    root = BeamLoads(system, system.flexible_bodies[0], [0.0, 1.0]).at(state)[0, 0]
    assert root[:3] == pytest.approx([0.0, -4e6, 0.0], abs=5e3)
    end = np.array([0.0, 0.0, LENGTH]) + tip
    assert root[3:] == pytest.approx(np.cross(end, [0.0, -4e6, 0.0]), abs=2e5)


def test_a_curved_beam_bends_out_of_its_plane_as_a_cosserat_rod():
    """The arc of 45 degrees of Bathe and Bolourchi, and of BeamDyn's test bd_curved_beam."""
    radius, force = 100.0, (0.0, 600.0, 0.0)
    stiffness = np.array([4.16667e6, 4.16667e6, 1e7, 8.333e5, 8.333e5, 8.333e5])
    a = np.linspace(0.0, np.pi / 4.0, 101)
    c, s, o = np.cos(a), np.sin(a), 0.0 * a
    directors = np.stack([np.stack([c, o, -s], 1), np.stack([o, o + 1.0, o], 1)], axis=1)
    line = BeamLine(a, radius * np.stack([1.0 - c, o, s], 1), directors)
    C = np.array([np.diag(stiffness)] * 2)
    arc = BeamSections([0.0, line.length], C, np.array([np.eye(6)] * 2))
    box = box_carrier("arc", line, (0.2, 0.2), 24, COMM)
    basis = beam_basis(box.carrier, line, arc, 8, 3, box.start, hold=1.0)
    body = ReducedBody("arc", box.carrier, basis)
    clamp = Coupling("clamp", body, box.start, None)
    system = MultibodySystem(COMM, [body, clamp, *pull_end(force)(body)])
    tip = move_axis(equilibrium(system, np.linspace(0.1, 1.0, 10)), basis)
    of_rod = bend_arc(a[-1], radius, stiffness, force)
    assert np.linalg.norm(tip - of_rod) < 3e-4 * np.linalg.norm(of_rod)


@pytest.mark.parametrize(("degree", "elements"), [(1, 8), (2, 4), (3, 2)])
def test_small_deflections_converge_with_twice_the_degree(twisted, degree, elements):
    def bend(elements, degree):
        return move_axis(*twisted(elements, degree, 4e3)[1:])

    errors = [np.linalg.norm(bend(n, degree) - bend(8, 5)) for n in (elements, 2 * elements)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2 * degree, abs=0.1)


def test_couplings_of_a_section_turn_a_beam_that_bends():
    """A clamped beam under a moment at its end has the curvature C^-1 M everywhere."""
    C = np.diag([3.0e7, 2.0e7, 6.0e7, 4.0e5, 9.0e5, 2.5e5])
    C[3, 5] = C[5, 3] = 1.2e5
    box, basis = carried()
    basis = beam_basis(
        box.carrier, BeamLine.straight(LENGTH), sections(stiffness=C), 4, 3, box.start
    )
    body = ReducedBody("beam", box.carrier, basis)
    corners = basis.points[np.argsort(-basis.points[:, 2])[:4]]
    M, arm = 100.0, 0.4
    pairs = [
        NodeForce(
            f"pull {k}",
            body,
            point=p,
            force=(0.0, 0.0, M * np.sign(p[1]) / arm),
            function=lambda t: t,
        )
        for k, p in enumerate(corners)
    ]
    clamp = Coupling("start", body, box.start, None)
    state = equilibrium(MultibodySystem(COMM, [body, clamp, *pairs]), [1.0])
    bend, turn = np.linalg.solve(C, [0.0, 0.0, 0.0, M, 0.0, 0.0])[[3, 5]] * LENGTH
    high, low = (
        basis.functions[np.argmin(np.linalg.norm(basis.points - (x, 0.1, LENGTH), axis=1))]
        for x in (0.2, -0.2)
    )
    across = (high - low) @ state.u[0].array.reshape(-1, 3)
    assert across[1] / 0.4 == pytest.approx(turn, rel=1e-3)
    assert move_axis(state, basis)[1] == pytest.approx(-0.5 * bend * LENGTH, rel=1e-3)


# --- mass and modes


@pytest.mark.parametrize("ends", [0, 1, 2])
def test_rigid_motions_have_no_strain_and_the_momenta_of_the_sections(ends):
    _, basis = carried("bent", ends=ends, taper=0.4)
    z = basis.vectors
    assert np.allclose(basis.functions @ z, basis.points, rtol=0.0, atol=1e-12)
    turn = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))[0]
    moved = z @ turn.T + np.outer(basis.is_point, [1.0, 2.0, 3.0])
    assert np.allclose(basis.functions @ moved, basis.points @ turn.T + [1.0, 2.0, 3.0], atol=1e-12)
    strain = gram_strain.GramStrain(
        basis.strain_factor, basis.strain_vectors, basis.strain_vectors @ z, range(0)
    )
    stress = strain.strain(strain.vectors(moved[None]))
    assert np.max(np.abs(stress)) < 1e-9 * np.sqrt(6e7 * LENGTH)
    # mass, centre and second moments by a fine sum over sections
    line, own = bent_line(), sections(bent_line().length, taper=0.4)
    s = (np.arange(4000) + 0.5) / 4000 * line.length
    r, d = line.at(s)
    A = own.moments_at(s) * line.length / 4000
    of_sections = np.concatenate([r[:, None], d], axis=1)
    second = np.einsum("kai,kab,kbj->ij", of_sections, A, of_sections)
    first = np.einsum("kb,kbj->j", A[:, 0], of_sections)
    h = basis.is_point
    assert h @ basis.mass @ h == pytest.approx(A[:, 0, 0].sum(), rel=1e-7)
    assert np.allclose(h @ basis.mass @ z, first, rtol=1e-4)
    assert np.allclose(z.T @ basis.mass @ z, second, rtol=1e-4, atol=1e-4 * second.max())


@pytest.mark.parametrize(("ends", "roots"), [(1, (1.8751, 4.6941)), (2, (4.7300, 7.8532))])
def test_slender_beams_have_the_frequencies_of_bernoulli(ends, roots):
    C = np.diag([4e9, 4e9, 4e9, 4e5, 9e5, 2.5e7])
    box, _ = carried(ends=ends)
    M = 300.0 * np.diag([1.0, 1.0, 1.0, 1e-4, 1e-4, 2e-4])
    own = BeamSections([0.0, LENGTH], np.array([C, C]), np.array([M, M]))
    line = BeamLine.straight(LENGTH)
    held = (box.start, box.end)[:ends]
    basis = beam_basis(box.carrier, line, own, 8, 3, *held)
    body = ReducedBody("beam", box.carrier, basis)
    clamps = [Coupling(f"clamp {k}", body, facets, None) for k, facets in enumerate(held)]
    system = MultibodySystem(COMM, [body, *clamps])
    found = [mode.frequency for mode in modes(system, count=4).modes]
    wanted = [
        root**2 * np.sqrt(EI / 300.0) / (2.0 * np.pi * LENGTH**2)
        for root in roots
        for EI in (4e5, 9e5)
    ]
    assert found == pytest.approx(sorted(wanted), rel=2e-3)


def test_a_free_beam_has_six_rigid_motions():
    _, basis = carried(ends=0)
    assert np.linalg.eigvalsh(basis.mass)[0] > 0.0
    strain = gram_strain.GramStrain(
        basis.strain_factor,
        basis.strain_vectors,
        basis.strain_vectors @ basis.vectors,
        range(0),
    )
    J = strain.jacobian(strain.vectors(basis.vectors[None]))[0]
    energies = np.linalg.eigvalsh(J.T @ J)
    assert np.count_nonzero(energies < 1e-9 * energies[-1]) == 6


# --- dynamics


def make_rotor(axis=(1.0, 0.0, 0.0)):
    """Three beams on a hub, and their basis.

    Args:
        axis: Of its revolute joint on the ground; None for a hub in free flight.
    """
    box, basis = carried("bent", taper=0.5)
    spin = 1.5 * np.array([1.0, 0.2, -0.1] if axis is None else axis)
    hub = RigidBody("hub", 2000.0, (500.0,) * 3, angular_velocity=spin)
    joint = [] if axis is None else [Revolute("main", None, hub, (0.0, 0.0, 0.0), axis=axis)]
    body = ReducedBody("blades", box.carrier, basis, placements())
    roots = [Coupling(f"root {k}", body, box.start, hub, k) for k in range(3)]
    return MultibodySystem(COMM, [hub, *joint, body, *roots]), basis


def test_modes_that_whirl_are_seen_faster_or_slower_by_the_rotation():
    """Multiblade coordinates need no mesh that comes to lie on itself, but equal copies."""
    system, _ = make_rotor()
    speed = 1.5
    turning = turning_modes(system, "main", speed, count=12)
    still = turning_modes(system, "main", speed, count=9, blades=3)
    seen_turning = np.array([mode.frequency for mode in turning.modes])
    whirling = [mode for mode in still.modes if mode.whirl is not None and not mode.is_rigid]
    assert {mode.whirl.name for mode in whirling} >= {"backward", "forward"}
    for mode in whirling:
        shifts = np.abs(np.abs(seen_turning - mode.frequency) - speed / (2.0 * np.pi))
        others = np.abs(seen_turning - mode.frequency)
        together = mode.whirl.name == "collective"
        assert np.min(others if together else shifts) < 1e-6 * mode.frequency, mode


@pytest.mark.parallel
@pytest.mark.parametrize(
    ("steps", "dt"),
    [(200, 0.05), *(pytest.param(2000, dt, marks=pytest.mark.slow) for dt in (0.02, 0.05))],
)
@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), None])
def test_beams_on_a_hub_keep_energy_and_momenta(steps, dt, axis):
    """On a revolute joint the moment about its axis; in free flight all of both."""
    system, basis = make_rotor(axis)
    state = system.initial_state()
    if COMM.rank == 0:  # the blades do not start as their hub does
        v = state.v[0].array.reshape(3, -1, 3)
        axis_nodes = slice(4, 4 + (len(basis.mass) - 4) // 3)
        noise = np.random.default_rng(0).standard_normal(v[:, axis_nodes].shape)
        v[:, axis_nodes] += 0.05 * noise
    before = system.balance(state)
    state, _, _ = march(
        EnergyMomentum(system, options=SolverOptions(tolerance=1e-13)), state, dt, steps
    )
    after = system.balance(state)
    assert after.total == pytest.approx(before.total, rel=CONSERVED)
    size = np.linalg.norm(before.angular)
    gap = np.abs(after.angular - before.angular)
    assert (np.max(gap) if axis is None else gap[0]) < CONSERVED * size


def test_a_free_beam_that_tumbles_keeps_energy_and_momenta():
    """The residuals of 200 steps, each below 1e-13, add up to 1e-11 here."""
    box, basis = carried("bent", ends=0, taper=0.5)
    spin, middle = np.array([0.5, 1.5, 0.3]), np.array([0.2, -0.1, 0.5 * LENGTH])

    def velocity(X):
        return np.cross(spin, X - middle) + np.array([1.0, 0.0, -0.5])

    def bend(X):
        s = 2.0 * X[:, 2] / LENGTH - 1.0
        return np.column_stack([0.2 * s * s, 0.0 * s, 0.0 * s])

    body = ReducedBody("beam", box.carrier, basis, velocity=velocity, displacement=bend)
    system = MultibodySystem(COMM, [body])
    state = system.initial_state()
    before = system.balance(state)
    assert before.strain > 1e-3 * before.total
    stepper = EnergyMomentum(system, options=SolverOptions(tolerance=1e-13))
    state, _, _ = march(stepper, state, 0.02, 200)
    after = system.balance(state)
    assert after.total == pytest.approx(before.total, rel=10.0 * CONSERVED)
    for name in ("linear", "angular"):
        a, b = getattr(before, name), getattr(after, name)
        assert np.max(np.abs(a - b)) < 10.0 * CONSERVED * np.linalg.norm(a)


def test_fields_show_all_copies_where_their_points_are(tmp_path):
    system, _ = make_rotor()
    state, _, _ = march(EnergyMomentum(system), system.initial_state(), 0.05, 5)
    grid = FieldGrid(system, surfaces=[])
    (model,) = system.flexible_models
    wanted = (model.body.points + model.expand(state.u[0])).reshape(-1, 3)
    found = grid.positions + grid.displacement(state.q, state.u)
    assert len(found) == len(wanted)
    assert np.max(cKDTree(wanted).query(found)[0]) < 1e-12 * LENGTH
    fields = Fields(system, tmp_path / "fields.xdmf", 1.0, 1.0)
    with pytest.raises(ModelError, match="stresses need a body on a mesh, and 'blades' is reduced"):
        fields.write(fields.open(tmp_path / "fields.xdmf", None, 1), state)
