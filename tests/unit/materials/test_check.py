"""Claims about the look at a law before it is used, and about principal stretches."""

import warnings

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh

from turbine_fenicsx import (
    FlexibleBody,
    KelvinVoigt,
    ModelError,
    ModelWarning,
    MultibodySystem,
    NeoHooke,
    OrthotropicSVK,
    Simulation,
    StVenantKirchhoff,
    TransverselyIsotropic,
    _compat,
    check_material,
    squared_stretches,
)
from turbine_fenicsx.materials.pointwise import CellPoints, write_out

NEO_HOOKE = NeoHooke(3.0, 0.8)


def cube(comm, n=2):
    return mesh.create_unit_cube(comm, n, n, n, mesh.CellType.hexahedron)


class Own:
    """A law of a user."""

    def __init__(self, energy=NEO_HOOKE.strain_energy, quadratic=False):
        self.strain_energy, self.quadratic = energy, quadratic


class Viscous(Own):
    def __init__(self, stress):
        super().__init__()
        self.viscous_stress = stress


def strain(C):
    return 0.5 * (C - ufl.Identity(3))


def one_sided(C, parameter):
    """Fibres that bear tension alone: the stress has a kink at rest."""
    stretched = ufl.conditional(ufl.gt(C[0, 0], 1.0), (C[0, 0] - 1.0) ** 2, 0.0)
    return NEO_HOOKE.strain_energy(C, parameter) + parameter(5.0) * stretched


@pytest.mark.parametrize(
    "law",
    [
        StVenantKirchhoff(3.0, 0.8),
        NEO_HOOKE,
        KelvinVoigt(NEO_HOOKE, 0.1, 0.2),
        Own(one_sided),
        Viscous(lambda E_dot, p: p(2.0) * ufl.sqrt(ufl.inner(E_dot, E_dot)) * E_dot),
    ],
)
def test_sound_laws_pass(comm, law):
    assert check_material(law, cube(comm)) == []


def test_laws_with_directions_and_fields_pass(comm):
    cells = cube(comm)
    x = ufl.SpatialCoordinate(cells)
    axes = [ufl.as_vector(a) for a in np.eye(3).tolist()]
    turned = x + ufl.as_vector([1.0, 2.0, 3.0])
    for law in (
        OrthotropicSVK(young=(45, 15, 15), shear=(5.4,) * 3, poisson=(0.3,) * 3, frame=axes),
        TransverselyIsotropic(45.0, 15.0, 5.4, 0.3, 0.35, turned),
    ):
        assert check_material(law, cells) == []


@pytest.mark.parallel
@pytest.mark.parametrize(
    ("law", "words"),
    [
        (
            Own(lambda C, p: -NEO_HOOKE.strain_energy(C, p)),
            "a negative stiffness at rest, -10.6 Pa",
        ),
        (
            Own(quadratic=True),
            "says quadratic = True, but its energy is not quadratic in C, by 0.0",
        ),
        (
            Own(lambda C, p: ufl.ln(ufl.tr(C) - 3.0)),
            "an energy or a stress at rest that is not fin",
        ),
        (Own(lambda C, p: 0.0 * ufl.tr(C)), "has no stiffness at rest"),
        (Viscous(lambda E_dot, p: -p(2.0) * E_dot), "a viscous stress that gives energy"),
        (
            Viscous(lambda E_dot, p: E_dot * ufl.as_matrix([[1, 1, 0], [0, 1, 0], [0, 0, 1]])),
            "a viscous stress that is not symmetric: angular momentum would be lost",
        ),
    ],
)
def test_wrong_laws_are_refused_when_a_body_is_bound(comm, law, words):
    body = FlexibleBody("block", cube(comm), law, 1.0)
    with pytest.raises(ModelError, match=f"law {type(law).__name__} of 'block' .*{words}"):
        MultibodySystem(comm, [body])


@pytest.mark.parametrize(
    ("energy", "words"),
    [
        (lambda C, p: 1e3 + NEO_HOOKE.strain_energy(C, p), "an energy of 1e+03 J/m^3 at rest"),
        (
            lambda C, p: NEO_HOOKE.strain_energy(C, p) + ufl.tr(strain(C)),
            "a stress of 1 Pa at rest, expected 0",
        ),
        (lambda C, p: ufl.tr(strain(C)) ** 2, "no stiffness at rest against some strain"),
        (
            lambda C, p: (
                NEO_HOOKE.strain_energy(C, p) - ufl.ln(1.0 - (20.0 * strain(C)[0, 1]) ** 2)
            ),
            "is not finite at strains of 0.1",
        ),
    ],
)
def test_suspicious_laws_are_warned_of_once(comm, energy, words):
    body = FlexibleBody("block", cube(comm), Own(energy), 1.0)
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        MultibodySystem(comm, [body])
        MultibodySystem(comm, [body])
    texts = [str(w.message) for w in found if w.category is ModelWarning]
    assert len(texts) == (comm.rank == 0)
    for text in texts:
        assert text.startswith("law Own of 'block' ") and words in text


def test_what_cannot_be_evaluated_is_logged(comm, caplog):
    caplog.set_level("INFO")
    cells = cube(comm)
    law = Own(lambda C, p: NEO_HOOKE.strain_energy(C, p) * ufl.CellVolume(cells))
    assert check_material(law, cells) == []
    assert "law Own is not checked: it depends on CellVolume" in caplog.text


@pytest.mark.parallel
@pytest.mark.parametrize("where", ["ours", "mirrored", "crushed"])
def test_a_start_that_turns_cells_inside_out_is_refused(comm, where):
    change = {"ours": [0.5, 0.0, 0.0], "mirrored": [-2.0, 0.0, 0.0], "crushed": [0.0, -1.5, 0.0]}
    body = FlexibleBody(
        "block", cube(comm), NEO_HOOKE, 1.0, displacement=lambda X: X * np.array(change[where])
    )
    if where == "ours":
        MultibodySystem(comm, [body])
    else:
        with pytest.raises(ModelError, match="displacement of 'block' turns 8 cells inside out"):
            MultibodySystem(comm, [body])


@pytest.mark.parallel
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_fields_have_their_values_in_the_middle_of_cells(comm, degree):
    cells = mesh.create_box(
        comm, [[0, 0, 0], [2.0, 1.0, 1e-7]], [3, 2, 1], mesh.CellType.hexahedron
    )
    if not cells.topology.index_map(3).size_local:
        return
    x = ufl.SpatialCoordinate(cells)
    field = fem.Function(_compat.cellwise_space(cells, (), degree))
    field.interpolate(lambda X: 1.0 + 2.0 * X[0] - X[1])
    values = CellPoints(cells, [0]).evaluate([field, x[0], x[1]], {})[0, 0]
    assert values[0] == pytest.approx(1.0 + 2.0 * values[1] - values[2], rel=1e-12)


# --- principal stretches


def rotate(values, rng):
    Q = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    return Q @ np.diag(values) @ Q.T


@pytest.mark.parametrize(
    "values", [(1.0, 1.0, 1.0), (2.0, 2.0, 0.5), (2.0, 0.5, 0.5), (1.0, 1.0 + 1e-9, 3.0), (3, 2, 1)]
)
def test_squares_of_stretches_are_eigenvalues(comm, values):
    rng = np.random.default_rng(0)
    cells = cube(comm, 1 if comm.size == 1 else 2)
    symbol = fem.Constant(cells, np.eye(3))
    if not cells.topology.index_map(3).size_local:
        return
    given = np.array([rotate(values, rng) for _ in range(20)])
    wanted = [write_out(x) for x in squared_stretches(symbol)]
    found = CellPoints(cells, [0]).evaluate(wanted, {symbol: given})[0]
    assert np.sort(found) == pytest.approx(np.tile(np.sort(values), (20, 1)), abs=1e-5)
    # a function of all three is exact to the square of that
    assert np.sum(found**1.5, axis=1) == pytest.approx(np.sum(np.array(values) ** 1.5), abs=1e-9)


class Ogden:
    """Ogden's law with a volumetric energy, in the squares c of the stretches."""

    quadratic = False
    terms = ((0.8, 2.0), (0.3, -2.0))

    def strain_energy(self, C, parameter):
        c, ln_J = squared_stretches(C), 0.5 * ufl.ln(ufl.det(C))
        W = 0.5 * parameter(3.0) * ln_J**2
        for mu, alpha in self.terms:
            W += parameter(mu / alpha) * (sum(x ** (0.5 * alpha) for x in c) - 3.0 - alpha * ln_J)
        return W


def test_ogdens_law_conserves_energy_from_equal_stretches_on(comm):
    """The body starts undeformed, and stretches most along one axis: two stretches stay equal."""
    cells = cube(comm)
    assert check_material(Ogden(), cells) == []
    body = FlexibleBody(
        "block", cells, Ogden(), 1.0, velocity=lambda X: (X - 0.5) * np.array([0.4, -0.1, -0.1])
    )
    system = MultibodySystem(comm, [body])
    last = Simulation(system, 0.1, 2.0).run()
    largest = last.balance.total
    assert last.balance.strain > 1e-3 * largest
    assert abs(last.energy_error) < 1e-9 * largest
