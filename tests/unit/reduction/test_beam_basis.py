"""Claims about the basis of a beam: sparse factors, viscosity, its file, and what is refused."""

import numpy as np
import pytest
from reduced_beams import beam, clamped
from section_beams import COMM, LENGTH, carried, clamped_beam, sections

from turbine_fenicsx import (
    BeamBasis,
    BeamLine,
    BeamSections,
    BodyForce,
    ModelError,
    beam_basis,
    box_carrier,
    read_basis,
    write_basis,
)
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.reduction.beam_strains import _split
from turbine_fenicsx.simulation.observers.section_loads import BeamLoads
from turbine_fenicsx.system import gram_strain


def test_a_sparse_factor_gives_the_same_numbers(monkeypatch):
    _, basis = carried("bent")
    L = basis.strain_vectors
    made = []
    for share in (0.0, 0.1):
        monkeypatch.setattr(gram_strain, "SPARSE", share)
        made.append(gram_strain.GramStrain(basis.strain_factor, L, L @ basis.vectors, range(3)))
    assert isinstance(made[0]._W, np.ndarray) and not isinstance(made[1]._W, np.ndarray)
    y = L @ basis.vectors + 0.1 * np.random.default_rng(2).standard_normal((2, len(L), 3))
    for function in (
        lambda g: g.strain(y),
        lambda g: g.change(y, y[::-1]),
        lambda g: g.stress(g.strain(y)),
        lambda g: g.jacobian(y),
    ):
        dense, sparse = map(function, made)
        assert np.allclose(dense, sparse, rtol=0.0, atol=1e-12 * np.abs(dense).max())


def test_viscosity_of_each_strain_makes_the_matrix_of_damping():
    """V V^T = H and V diag(Z) V^T = sqrt(t_i t_j) H_ij."""
    rng, times = np.random.default_rng(3), np.array([0.1, 0.2, 0.0, 0.3, 0.4, 0.05])
    root = rng.standard_normal((12, 12))
    H = root @ root.T
    V, Z = _split(H, times)
    scale = np.tile(np.sqrt(times), 2)
    assert np.allclose(V @ V.T, H, atol=1e-11)
    assert np.allclose(V @ np.diag(Z) @ V.T, scale[:, None] * H * scale, atol=1e-11)
    equal = beam_basis(
        carried()[0].carrier,
        BeamLine.straight(LENGTH),
        sections(viscosity=(0.02,) * 6),
        4,
        3,
        carried()[0].start,
    )
    assert np.allclose(equal.viscosity, 0.02)


def test_a_file_keeps_the_basis_of_a_beam(shared_tmp_path):
    box, basis = carried("bent")
    file = shared_tmp_path / "beam.npz"
    on_rank0(COMM, lambda: write_basis(file, basis))
    again = read_basis(file, box.carrier)
    assert isinstance(again, BeamBasis)
    assert again.fingerprint == basis.fingerprint
    other = box_carrier("other", BeamLine.straight(LENGTH), (0.4, 0.2), 24, COMM)
    with pytest.raises(ValueError, match="the nodes of the mesh stand elsewhere"):
        read_basis(file, other.carrier)


def beam_elements(number, degree):
    """A beam of a number of elements."""
    box, _ = carried()
    return beam_basis(box.carrier, BeamLine.straight(LENGTH), sections(), number, degree, box.start)


def change(name, k, i, j, value):
    """Sections with another entry in one matrix."""

    def make():
        own = sections()
        matrices = {"stiffness": own.stiffness.copy(), "inertia": own.inertia.copy()}
        matrices[name][k, i, j] = matrices[name][k, j, i] = value
        return BeamSections(own.stations, **matrices)

    return make


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (change("stiffness", 1, 3, 3, -1.0), "at 10 m is not positive definite: entry 4, 4 is -1"),
        (change("stiffness", 0, 3, 4, 9e5), "at 0 m is not positive definite: its couplings"),
        (change("inertia", 1, 2, 2, 0.0), "inertia of the beam at 10 m must have a positive mass"),
        (change("inertia", 0, 4, 4, 0.1), "at 0 m is that of no section"),
        (lambda: BeamSections([0.0, 1.0], np.ones((2, 6, 5)), np.ones((2, 6, 6))), "stiffness of"),
        (lambda: BeamSections([1.0, 0.0], *[np.array([np.eye(6)] * 2)] * 2), "or more and rise"),
        (lambda: sections(viscosity=(-1.0,) * 6), "viscosity of a beam must not be negative"),
        (lambda: BeamLine([0.0, 1.0], np.zeros((2, 3)), np.zeros((2, 2, 3))), "must differ"),
        (lambda: BeamLine([0.0, 0.0], np.eye(3)[:2], np.zeros((2, 2, 3))), "or more and rise"),
        (
            lambda: BeamLine([0, 1], [[0, 0, 0], [0, 0, 1]], [[[1, 0, 0], [0, -1, 0]]] * 2).at(
                np.zeros(1)
            ),
            "right-handed",
        ),
        (lambda: beam_elements(0, 3), "elements of a beam must be a whole number from 1"),
        (lambda: beam_elements(2, 6), "degree of a beam must be a whole number from 1 to 5"),
        (lambda: carried(hold=0.0), "hold of a beam must be positive"),
    ],
)
def test_beams_that_cannot_be_are_refused(make, sentence):
    with pytest.raises(ModelError, match=sentence):
        make()


def test_a_matrix_that_is_not_symmetric_is_refused_with_its_station():
    own = sections()
    C = own.stiffness.copy()
    C[1, 0, 1] = 5e4
    with pytest.raises(ModelError, match="at 10 m is not symmetric: entry 1, 2 is 50000"):
        BeamSections(own.stations, C, own.inertia)


def test_a_beam_is_as_long_as_its_sections_and_held_where_it_starts():
    box, _ = carried()
    line = BeamLine.straight(LENGTH)
    with pytest.raises(ModelError, match="must reach from 0 to the length of its axis, 10 m"):
        beam_basis(box.carrier, line, sections(9.0), 4, 3, box.start)
    with pytest.raises(ModelError, match="held where its axis starts"):
        beam_basis(box.carrier, line, sections(), 4, 3, None, box.end)


def test_loads_in_sections_need_a_beam_and_places_on_it():
    system = clamped_beam()
    (body,) = system.flexible_bodies
    with pytest.raises(ModelError, match="must be fractions from 0 to 1"):
        BeamLoads(system, body, [1.1])
    solid = clamped(beam())
    with pytest.raises(ModelError, match="loads on sections need a beam, and 'beam' is none"):
        BeamLoads(solid, solid.flexible_bodies[0], [0.5])


def test_forces_on_masses_of_a_mesh_cannot_act_on_a_beam():
    with pytest.raises(ModelError, match="acts on the masses of a mesh"):
        clamped_beam(lambda body: [BodyForce("pull", body, field=lambda X: X, function=np.cos)])
