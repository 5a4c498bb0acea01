"""Claims about reduced bodies: they are the full body in the motions that their basis allows."""

import numpy as np
import pytest
from reduced_beams import (
    COMM,
    DENSITY,
    SIZE,
    TAU,
    beam,
    clamped,
    clamped_basis,
    facets_at,
    free_basis,
    on_hub,
    placements,
    rotor,
)
from scipy import sparse
from scipy.linalg import block_diag

from turbine_fenicsx import (
    BodyForce,
    Coupling,
    FlexibleBody,
    Gravity,
    HeldPart,
    MultibodySystem,
    NodeForce,
    Placement,
    Pressure,
    RayleighDamping,
    ReducedBody,
    RigidBody,
    StVenantKirchhoff,
    cell_field,
    damped_modes,
    equilibrium,
    modes,
    reduce_body,
)
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.reduced_model import ReducedModel

pytestmark = pytest.mark.parallel

GRAVITY = np.array([0.4, -9.81, 1.0])
EXACT = 1e-12


def wild_vectors(model, seed=0):
    """Vectors far from rest, turned as a whole, and velocities; the same on any number of ranks."""
    rng, n = np.random.default_rng(seed), model.size_global
    R = rotation_about((1.0, 2.0, 3.0), 1.1)
    z = model.body.basis.vectors @ R.T + 0.03 * rng.standard_normal((n, 3))
    u, v = model.new_vector(), model.new_vector()
    u.array[:] = (z - model.body.basis.vectors).ravel()[: 3 * model.n_owned]
    v.array[:] = rng.standard_normal(3 * n)[: 3 * model.n_owned]
    return u, v


def on_mesh(model, full, vector):
    """The motion of the mesh that belongs to that of the vectors."""
    x = model.expand(vector)[0]
    out = full.new_vector()
    out.array[:] = x[rows_of(model, full)].ravel()
    return out


def rows_of(model, full):
    """Nodes of the basis that this rank owns of the mesh."""
    counts = COMM.allgather(full.n_owned)
    first = sum(counts[: COMM.rank])
    rows = np.arange(first, first + full.n_owned)
    assert np.allclose(model.body.basis.points[rows], full.positions)
    return rows


@pytest.fixture(params=["free", "clamped"])
def pair(request):
    """A reduced body that nothing holds, and the full one."""
    basis = free_basis() if request.param == "free" else clamped_basis()
    body = ReducedBody("reduced", beam(), basis)
    return ReducedModel(body, (), None, ()), FlexibleModel(beam())


def gathered(matrix):
    """A distributed matrix on all ranks."""
    starts, columns, entries = matrix.getValuesCSR()
    own = sparse.csr_matrix((entries, columns, starts), (len(starts) - 1, matrix.getSize()[1]))
    return sparse.vstack(COMM.allgather(own), "csr")


def project(model, full, forces):
    """F^T f, shape (n, 3)."""
    F = model.body.basis.functions[rows_of(model, full)]
    return COMM.allreduce(F.T @ forces.array_r.reshape(-1, 3))


def of_rank0(values):
    return COMM.bcast(np.array(values))


def assert_same(found, wanted):
    assert np.max(np.abs(found - wanted)) < EXACT * np.max(np.abs(wanted))


def test_energies_and_momenta_are_those_of_the_full_body(pair):
    model, full = pair
    u, v = wild_vectors(model)
    found = COMM.allreduce(model.integrals(u, v))
    wanted = COMM.allreduce(full.integrals(on_mesh(model, full, u), on_mesh(model, full, v)))
    assert found == pytest.approx(wanted, rel=EXACT, abs=EXACT * np.max(np.abs(wanted)))


def test_forces_at_rest_are_projections_of_those_of_the_full_body(pair):
    model, full = pair
    u, _ = wild_vectors(model)
    out, of_full = model.new_vector(), full.new_vector()
    model.static_forces(u, GRAVITY, 0.0, out)
    full.static_forces(on_mesh(model, full, u), GRAVITY, 0.0, of_full)
    wanted = project(model, full, of_full)
    assert_same(of_rank0(out.array_r).reshape(-1, 3), wanted)


def test_forces_on_masses_are_projections_wherever_a_copy_stands(pair):
    _, full = pair
    R, t = rotation_about((1.0, 2.0, 3.0), 0.7), np.array([1.0, -2.0, 3.0])
    places = [Placement(), Placement(position=t, rotation=R)]
    body = ReducedBody("reduced", beam(), pair[0].body.basis, places)

    def field(X):
        return np.sin(X[:, [1, 2, 0]])

    model = ReducedModel(body, [BodyForce("x", body, field=field)], None, ())
    found = model.applied_forces(np.zeros(3), 0.0)
    mass = full.new_vector()
    for copy, place in enumerate((lambda X: X, lambda X: t + X @ R.T)):
        mass.array[:] = field(place(full.positions)).ravel()
        full.momentum(mass, mass)
        assert_same(of_rank0(found)[copy], project(pair[0], full, mass))


def test_momenta_of_vectors_are_projections_too(pair):
    model, full = pair
    _, v = wild_vectors(model)
    out, of_full = model.new_vector(), full.new_vector()
    model.momentum(v, out)
    full.momentum(on_mesh(model, full, v), of_full)
    assert_same(of_rank0(out.array_r).reshape(-1, 3), project(model, full, of_full))


def test_the_stiffness_is_a_projection_of_that_of_the_full_body(pair):
    model, full = pair
    u, _ = wild_vectors(model)
    K, of_full = model.new_stiffness(), full.new_stiffness()
    model.assemble_stiffness(u, 0.0, K)
    full.assemble_stiffness(on_mesh(model, full, u), 0.0, of_full)
    P = np.kron(model.body.basis.functions, np.eye(3))
    assert_same(gathered(K).toarray(), P.T @ (gathered(of_full) @ P))


def damped(body, **numbers):
    facets = facets_at(getattr(body, "full", body), 0.0)
    return RayleighDamping("d", body, held=[HeldPart(facets)], **numbers)


def test_damping_of_masses_adds_no_momentum_and_leaves_a_rigid_motion_alone():
    body = ReducedBody("r", beam(), clamped_basis())
    model = ReducedModel(body, (), damped(body, stiffness=0.0, mass=0.3), ())
    u, v = wild_vectors(model)
    z, rates, damper = model.vectors(u.array_r), model.split(v.array_r), model.mass_damper
    f = np.zeros_like(z)
    damper.add_forces(u.array_r, v.array_r, 1.0, f.reshape(-1))
    size, D = np.abs(f).sum(), gathered(damper.matrix(u.array_r)).toarray()
    blocks, power = damper.part_matrices(u.array_r), damper.power(u.array_r, v.array_r)
    rigid = np.cross((0.3, 1.0, -0.2), z) + body.basis.is_point[:, None] * (1.0, 2.0, 3.0)
    of_rigid = damper.power(u.array_r, rigid.ravel())
    if COMM.rank == 0:
        assert np.abs(np.sum(f[:, model.is_point == 1.0], axis=1)).max() < EXACT * size
        assert np.abs(np.cross(z, f).sum(axis=1)).max() < EXACT * size
        assert np.sum(f * rates) == pytest.approx(-power, rel=1e-10)
        assert_same(-D @ rates.ravel(), f.ravel())
        assert_same(D, D.T)
        assert_same(block_diag(*blocks), D)
        assert of_rigid <= 1e-20 * size


def test_modes_are_damped_by_mass_and_stiffness_as_those_of_the_full_body():
    ratios = []
    for body in (beam(), ReducedBody("r", beam(), clamped_basis())):
        system = clamped(body, damped(body, stiffness=2e-4, mass=0.02))
        ratios.append([mode.damping_ratio for mode in damped_modes(system, count=4).modes])
    # the nodes of the mesh have lumped masses
    assert ratios[1] == pytest.approx(ratios[0], rel=0.02)
    assert min(ratios[0]) > 1e-3


@pytest.mark.parametrize("law", ["viscous", "rayleigh"])
def test_damping_is_a_projection_of_that_of_the_full_body(law):
    viscous = law == "viscous"
    body = beam("viscous" if viscous else "svk")
    basis = clamped_basis(law="viscous") if viscous else clamped_basis()
    reduced = ReducedBody("reduced", body, basis)
    dampings = [None, None]
    if not viscous:
        dampings = [RayleighDamping("d", b, stiffness=TAU) for b in (reduced, body)]
    model = ReducedModel(reduced, (), dampings[0], ())
    full = FlexibleModel(body, (), dampings[1])
    u, _ = wild_vectors(model)
    D = gathered(model.damping_matrix(u, 0.0)).toarray()
    of_full = gathered(full.damping_matrix(on_mesh(model, full, u), 0.0))
    P = np.kron(basis.functions, np.eye(3))
    wanted = P.T @ (of_full @ P)
    assert_same(D, wanted)


def test_frequencies_of_the_modes_in_the_basis_are_those_of_the_full_body():
    full = modes(clamped(beam()), count=4)
    reduced = modes(clamped(ReducedBody("reduced", beam(), clamped_basis())), count=4)
    for a, b in zip(full.modes, reduced.modes, strict=True):
        assert b.frequency == pytest.approx(a.frequency, rel=1e-8)


def bent(body):
    """Tip displacement of a clamped beam under a force and its weight."""
    force = NodeForce("tip", body, point=(0.0, 0.0, SIZE[2]), force=(300.0, 60.0, 0.0))
    system = clamped(body, force, Gravity((0.0, -6.0, 0.0)))
    state = equilibrium(system)
    model = system.flexible_models[0]
    if isinstance(model, ReducedModel):
        points, u = model.body.basis.points, model.expand(state.u[0])[0]
    else:
        points = np.concatenate(COMM.allgather(model.positions))
        u = np.concatenate(COMM.allgather(state.u[0].array_r.reshape(-1, 3)))
    return u[np.argmin(np.linalg.norm(points - (0.0, 0.0, SIZE[2]), axis=1))]


def test_equilibria_come_near_those_of_the_full_body_as_functions_are_added():
    full = bent(beam())
    assert np.linalg.norm(full) > 0.1 * SIZE[2]
    errors = [
        np.linalg.norm(bent(ReducedBody("r", beam(), clamped_basis(n))) - full)
        for n in (12, 18, 36)
    ]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 2e-3 * np.linalg.norm(full)


def test_copies_stand_where_they_are_placed_and_turn_with_their_hub():
    body = rotor()
    system = on_hub([body], speed=2.0)
    state, model = system.initial_state(), system.flexible_models[0]
    assert np.allclose(model.expand(state.u[0]), 0.0)
    v, x = model.expand(state.v[0]), body.points
    assert np.allclose(v, np.cross((2.0, 0.0, 0.0), x), atol=1e-12)
    R = np.array([np.asarray(p.rotation) for p in placements()])
    assert np.allclose(x[1] @ R[1], x[0] @ R[0], atol=1e-12)
    mass = DENSITY * np.prod(SIZE)
    balance = system.balance(state)
    assert np.allclose(balance.linear, 0.0, atol=1e-10)
    # hub, and three slender boxes about e1 at the root radius 0.5
    arm = 0.5 + 0.5 * SIZE[2]
    inertia = mass * (arm**2 + (SIZE[1] ** 2 + SIZE[2] ** 2) / 12.0)
    assert balance.angular[0] == pytest.approx(2.0 * (100.0 + 3.0 * inertia), rel=1e-9)


def test_a_field_of_velocities_that_is_affine_is_taken_exactly():
    w = np.array([0.3, 1.0, -0.2])
    body = ReducedBody(
        "r", beam(), free_basis(), velocity=lambda X: np.cross(w, X), displacement=lambda X: 0.1 * X
    )
    system = MultibodySystem(COMM, [body])
    state, model = system.initial_state(), system.flexible_models[0]
    assert np.allclose(model.expand(state.u[0])[0], 0.1 * body.basis.points, atol=1e-12)
    assert np.allclose(model.expand(state.v[0])[0], np.cross(w, body.basis.points), atol=1e-12)


def test_a_displacement_leaves_the_surface_that_is_held_alone():
    def bend(X):
        return np.column_stack([0.02 * X[:, 2] ** 2, 0.0 * X[:, 0], 0.0 * X[:, 0]])

    body = ReducedBody("r", beam(), clamped_basis(36), displacement=bend)
    system = clamped(body)
    u = system.flexible_models[0].expand(system.initial_state().u[0])[0]
    at_root = np.isclose(body.basis.points[:, 2], 0.0)
    assert np.max(np.abs(u[at_root])) == 0.0
    assert np.max(np.abs(u - bend(body.basis.points))) < 0.02


def test_displacements_of_the_vectors_may_be_given():
    basis = clamped_basis()
    z = np.zeros((basis.functions.shape[1], 3))
    z[5] = (0.01, 0.0, 0.02)
    system = clamped(ReducedBody("r", beam(), basis, displacement=z))
    u = system.flexible_models[0].expand(system.initial_state().u[0])[0]
    assert np.allclose(u, basis.functions @ z, atol=1e-15)
    with pytest.raises(ValueError, match=r"displacement of 'r' must have one row per point"):
        clamped(ReducedBody("r", beam(), basis, displacement=z[:-1]))
    z[1] = 0.1
    with pytest.raises(ValueError, match="opens coupling 'root'"):
        clamped(ReducedBody("r", beam(), basis, displacement=z))


def test_forces_that_need_the_mesh_are_refused():
    body = ReducedBody("r", beam(), clamped_basis())
    facets = facets_at(beam(), SIZE[2])
    with pytest.raises(ValueError, match="'wind' acts on the surface of 'r', which is reduced"):
        clamped(body, Pressure("wind", body, facets, 1.0))
    held = [HeldPart(facets_at(beam(), z)) for z in (0.0, SIZE[2])]
    damping = RayleighDamping("d", body, stiffness=0.0, mass=1.0, held=held)
    with pytest.raises(ValueError, match="held of 'd' must be one surface of the mesh of 'r'"):
        clamped(body, damping)


def test_couplings_hold_what_the_basis_has_an_interface_for():
    body = ReducedBody("r", beam(), clamped_basis())
    tip = Coupling("tip", body, facets_at(beam(), SIZE[2]), None)
    with pytest.raises(ValueError, match="the basis of 'r' has no interface where coupling 'tip'"):
        MultibodySystem(COMM, [body, tip])
    root = facets_at(beam(), 0.0)
    with pytest.raises(ValueError, match="copy of 'root' must be one of the 1 copies of 'r', 0 to"):
        Coupling("root", body, root, None, copy=1)
    with pytest.raises(ValueError, match=r"copy of 'root' must be a whole number, got 0\.5"):
        Coupling("root", body, root, None, copy=0.5)
    with pytest.raises(ValueError, match="copy of 'root' must be one of the 1 copies of 'beam', 0"):
        Coupling("root", beam(), root, None, copy=1)


@pytest.mark.parametrize("other", [{"cells": (1, 2, 9)}, {"degree": 2}])
def test_a_basis_of_another_mesh_is_refused(other):
    body = ReducedBody("r", beam(**other), clamped_basis())
    with pytest.raises(ValueError, match="basis of 'r' belongs to another mesh than full, 'beam'"):
        MultibodySystem(COMM, [body])


def test_fields_of_cells_count_as_in_the_full_body():
    box = beam().mesh
    law = StVenantKirchhoff(
        cell_field(box, lambda X: 1.2e7 * (1.0 + X[:, 2])), cell_field(box, lambda X: 8e6 + X[:, 1])
    )
    body = FlexibleBody("beam", box, law, cell_field(box, lambda X: 1000.0 + 50.0 * X[:, 2] ** 2))
    basis = reduce_body(clamped(body), body, 2, 12, loads=())
    model = ReducedModel(ReducedBody("reduced", body, basis), (), None, ())
    full = FlexibleModel(body)
    u, v = wild_vectors(model)
    found = COMM.allreduce(model.integrals(u, v))
    wanted = COMM.allreduce(full.integrals(on_mesh(model, full, u), on_mesh(model, full, v)))
    assert found == pytest.approx(wanted, rel=EXACT, abs=EXACT * np.max(np.abs(wanted)))


def test_bodies_that_are_wrong_are_refused():
    basis = clamped_basis()
    with pytest.raises(TypeError, match="basis of 'r' must be a ReducedBasis, got"):
        ReducedBody("r", beam(), 3.0)
    with pytest.raises(TypeError, match="full of 'r' must be a FlexibleBody or a Carrier, got"):
        ReducedBody("r", RigidBody("b", 1.0, (1.0, 1.0, 1.0)), basis)
    with pytest.raises(ValueError, match="placements of 'r' must name one copy or more"):
        ReducedBody("r", beam(), basis, [])
    with pytest.raises(TypeError, match="placements of 'r' must be Placements, got"):
        ReducedBody("r", beam(), basis, [(0.0, 0.0, 0.0)])
    with pytest.raises(ValueError, match="rotation of a placement must be a rotation, got"):
        Placement(rotation=2.0 * np.eye(3))
