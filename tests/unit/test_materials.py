"""Claims about strain energies, evaluated as UFL sees them; oracle: numpy.

A mesh of volume one turns an integral of a constant into its value.
"""

from dataclasses import dataclass

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh

from turbine_fenicsx.kinematics import green_lagrange, right_cauchy_green
from turbine_fenicsx.materials import Material, NeoHooke, OrthotropicSVK, StVenantKirchhoff
from turbine_fenicsx.materials.base import second_piola_kirchhoff
from turbine_fenicsx.materials.orthotropic import stiffness_matrix
from turbine_fenicsx.rotations import rotation_about

LAWS = ("svk", "neo_hooke", "orthotropic")
LAMBDA, MU = 3.0, 0.8
YOUNG, SHEAR, POISSON = (45.0, 15.0, 12.0), (5.4, 4.9, 6.1), (0.3, 0.25, 0.35)
FRAME = rotation_about((1.0, 2.0, 0.5), 1.1)  # columns a1, a2, a3
PAPER = {"young": (45.0, 15.0, 15.0), "shear": (5.4, 5.4, 5.4), "poisson": (0.3, 0.3, 0.3)}
ROUND_OFF = 2e-14
"""Moduli up to fifty times strains up to one, in sums of a dozen terms, relative to moduli."""


@pytest.fixture(scope="module")
def cells(comm):
    return mesh.create_box(
        comm, [[0, 0, 0], [1, 1, 1]], [2, 1, 1], cell_type=mesh.CellType.hexahedron
    )


class Law:
    """W and S of a material as functions of numpy arrays."""

    def __init__(self, comm, cells, make):
        def constant(value):
            return fem.Constant(cells, np.array(value, dtype=float, order="C"))

        def form(integrand):
            compiled = fem.form(integrand * ufl.dx(domain=cells))
            return lambda: float(comm.allreduce(fem.assemble_scalar(compiled)))

        self.frame = [constant(a) for a in FRAME.T]
        self.material = make(self.frame)

        def energy(C):
            return self.material.strain_energy(C, constant)

        self._C, self._F, self._A = (constant(np.eye(3)) for _ in range(3))
        self._W_of_C = form(energy(self._C))
        self._W_of_F = form(energy(right_cauchy_green(self._F)))
        self._S = form(ufl.inner(second_piola_kirchhoff(energy, self._C), self._A))

    def energy(self, C):
        self._C.value = C
        return self._W_of_C()

    def energy_of_deformation(self, F):
        self._F.value = F
        return self._W_of_F()

    def stress(self, C):
        self._C.value = C
        S = np.zeros((3, 3))
        for i in range(3):
            for j in range(3):
                self._A.value = np.outer(np.eye(3)[i], np.eye(3)[j])
                S[i, j] = self._S()
        return S


@pytest.fixture(scope="module")
def laws(comm, cells):
    return {
        "svk": Law(comm, cells, lambda _: StVenantKirchhoff(LAMBDA, MU)),
        "neo_hooke": Law(comm, cells, lambda _: NeoHooke(LAMBDA, MU)),
        "orthotropic": Law(comm, cells, lambda a: OrthotropicSVK(YOUNG, SHEAR, POISSON, tuple(a))),
    }


@pytest.fixture(scope="module")
def transversely_isotropic(comm, cells):
    """The paper's law with G23 as eq. (64) has it, and as listed."""
    G23 = 15.0 / (2 * (1 + 0.3))
    return [
        Law(comm, cells, lambda a, G=G: OrthotropicSVK(**(PAPER | {"shear": G}), frame=tuple(a)))
        for G in ((5.4, 5.4, G23), PAPER["shear"])
    ]


@pytest.fixture
def rng():
    return np.random.default_rng(25)


def deformation(rng, size=0.2):
    F = np.eye(3) + size * rng.uniform(-1, 1, (3, 3))
    return F, F.T @ F


def energy_by_hand(law, C):
    """W from the definitions, with numpy."""
    E = 0.5 * (C - np.eye(3))
    if law == "svk":
        return 0.5 * LAMBDA * np.trace(E) ** 2 + MU * np.sum(E * E)
    if law == "neo_hooke":
        ln_J = 0.5 * np.log(np.linalg.det(C))
        return 0.5 * MU * (np.trace(C) - 3) - MU * ln_J + 0.5 * LAMBDA * ln_J**2
    e = FRAME.T @ E @ FRAME
    voigt = np.array([e[0, 0], e[1, 1], e[2, 2], 2 * e[1, 2], 2 * e[0, 2], 2 * e[0, 1]])
    (E1, E2, E3), (G12, G13, G23), (n12, n13, n23) = YOUNG, SHEAR, POISSON
    S = np.diag([1 / E1, 1 / E2, 1 / E3, 1 / G23, 1 / G13, 1 / G12])
    S[0, 1] = S[1, 0] = -n12 / E1
    S[0, 2] = S[2, 0] = -n13 / E1
    S[1, 2] = S[2, 1] = -n23 / E2
    return 0.5 * voigt @ np.linalg.solve(S, voigt)


def test_materials_are_materials(laws):
    assert all(isinstance(law.material, Material) for law in laws.values())
    assert {name: law.material.quadratic for name, law in laws.items()} == {
        "svk": True,
        "neo_hooke": False,
        "orthotropic": True,
    }


@pytest.mark.parametrize("law", LAWS)
def test_energy_equals_its_definition(laws, rng, law):
    for _ in range(3):
        _, C = deformation(rng)
        assert laws[law].energy(C) == pytest.approx(
            energy_by_hand(law, C), rel=1e-13, abs=ROUND_OFF
        )


@pytest.mark.parametrize("law", LAWS)
def test_energy_and_stress_vanish_without_deformation_and_energy_is_positive_else(laws, rng, law):
    assert abs(laws[law].energy(np.eye(3))) <= 1e-15
    assert np.max(np.abs(laws[law].stress(np.eye(3)))) <= ROUND_OFF
    for size in (0.25, 1e-2, 1e-4):
        for _ in range(3):
            assert laws[law].energy(deformation(rng, size)[1]) > 0.0


@pytest.mark.parametrize("law", LAWS)
def test_stress_is_twice_the_derivative_of_the_energy(laws, rng, law):
    _, C = deformation(rng)
    S, h = laws[law].stress(C), 1e-4
    assert np.allclose(S, S.T, rtol=0, atol=ROUND_OFF)
    scale = np.max(np.abs(S))
    for i in range(3):
        for j in range(i, 3):
            A = np.zeros((3, 3))
            A[i, j] = A[j, i] = 1.0
            difference = (laws[law].energy(C + h * A) - laws[law].energy(C - h * A)) / h
            # exact for W quadratic in C up to 1e-16/h; h^2/6 times a third derivative of the
            # neo-Hookean energy, about ten moduli
            tolerance = 1e-10 if laws[law].material.quadratic else 1e-6
            assert np.sum(S * A) == pytest.approx(difference, abs=tolerance * scale)


@pytest.mark.parametrize("law", LAWS)
def test_energy_is_objective(laws, rng, law):
    F, C = deformation(rng)
    Q = rotation_about((0.2, -1.0, 0.7), 2.0)
    W = laws[law].energy_of_deformation(F)
    assert W == pytest.approx(laws[law].energy(C), rel=1e-13, abs=ROUND_OFF)
    assert laws[law].energy_of_deformation(Q @ F) == pytest.approx(W, rel=1e-13, abs=ROUND_OFF)


@pytest.mark.parametrize("law", LAWS)
def test_only_the_orthotropic_law_knows_directions(laws, rng, law):
    _, C = deformation(rng)
    Q = rotation_about((0.2, -1.0, 0.7), 2.0)
    W, turned = laws[law].energy(C), laws[law].energy(Q.T @ C @ Q)
    if law == "orthotropic":
        assert abs(turned - W) > 0.1 * W
    else:
        assert turned == pytest.approx(W, rel=1e-13, abs=ROUND_OFF)


def test_orthotropic_law_is_invariant_under_half_turns_about_its_axes(laws, rng):
    _, C = deformation(rng)
    W = laws["orthotropic"].energy(C)
    for axis in FRAME.T:
        Q = rotation_about(axis, np.pi)
        assert laws["orthotropic"].energy(Q.T @ C @ Q) == pytest.approx(W, rel=1e-13)


def test_law_is_isotropic_about_the_fibre_only_if_G23_fits(transversely_isotropic, rng):
    _, C = deformation(rng)
    Q = rotation_about(FRAME[:, 0], 0.8)
    fits, listed = ([law.energy(C), law.energy(Q.T @ C @ Q)] for law in transversely_isotropic)
    assert fits[1] == pytest.approx(fits[0], rel=1e-13)
    assert abs(listed[1] - listed[0]) > 1e-4 * listed[0]  # 5.4 GPa instead of 5.77 GPa


def test_another_parameter_needs_no_new_form(laws, rng):
    """Parameters and frame are UFL constants: the frame of the same form may turn."""
    law, (_, C) = laws["orthotropic"], deformation(rng)
    Q = rotation_about((0.2, -1.0, 0.7), 2.0)
    before = law.energy(C)
    try:
        for constant, a in zip(law.frame, FRAME.T, strict=True):
            constant.value = Q @ a
        assert law.energy(Q @ C @ Q.T) == pytest.approx(before, rel=1e-13)
    finally:
        for constant, a in zip(law.frame, FRAME.T, strict=True):
            constant.value = a


def uniaxial(axis, e, contractions):
    """C of a stretch along one axis of the frame with contractions along the others."""
    strains = np.array([e * (1.0 if k == axis else -contractions[k]) for k in range(3)])
    return np.eye(3) + 2 * (FRAME * strains) @ FRAME.T


def test_tension_along_an_axis_recovers_youngs_modulus_and_poissons_ratios(laws):
    (E1, E2, E3), (n12, n13, n23) = YOUNG, POISSON
    n21, n31, n32 = n12 * E2 / E1, n13 * E3 / E1, n23 * E3 / E2
    for axis, modulus, contractions in (
        (0, E1, {1: n12, 2: n13}),
        (1, E2, {0: n21, 2: n23}),
        (2, E3, {0: n31, 1: n32}),
    ):
        S = laws["orthotropic"].stress(uniaxial(axis, 1e-3, contractions))
        expected = modulus * 1e-3 * np.outer(FRAME[:, axis], FRAME[:, axis])
        assert np.allclose(S, expected, rtol=0, atol=5 * ROUND_OFF)  # exact: S is linear in E


def test_shear_in_the_frame_recovers_the_shear_moduli(laws):
    for (i, j), G in zip(((0, 1), (0, 2), (1, 2)), SHEAR, strict=True):
        gamma, a, b = 1e-3, FRAME[:, i], FRAME[:, j]
        S = laws["orthotropic"].stress(np.eye(3) + gamma * (np.outer(a, b) + np.outer(b, a)))
        assert a @ S @ b == pytest.approx(G * gamma, rel=1e-11)
        assert a @ S @ a == pytest.approx(0.0, abs=5 * ROUND_OFF)


@pytest.mark.parametrize("law", ["svk", "neo_hooke"])
def test_lame_constants_give_the_classical_modulus_and_ratio(laws, law):
    young = MU * (3 * LAMBDA + 2 * MU) / (LAMBDA + MU)
    nu = LAMBDA / (2 * (LAMBDA + MU))
    e = 1e-6
    S = laws[law].stress(uniaxial(0, e, {1: nu, 2: nu}))
    # neo-Hooke is linear up to ten times e
    expected = young * e * np.outer(FRAME[:, 0], FRAME[:, 0])
    assert np.allclose(S, expected, rtol=0, atol=20 * e * young * e)


def test_paper_stiffness_equals_the_hand_calculation():
    """Jones, Mechanics of Composite Materials (2.24): nu21 = nu31 = 0.1, nu32 = 0.3,
    Delta = 1 - nu12 nu21 - nu23 nu32 - nu13 nu31 - 2 nu21 nu32 nu13 = 0.832."""
    D = stiffness_matrix(**PAPER)
    D11, D12, D22, D23 = 45 * 0.91, 15 * 0.39, 15 * 0.97, 15 * 0.33
    expected = np.diag([0, 0, 0, 5.4, 5.4, 5.4])
    expected[:3, :3] = np.array([[D11, D12, D12], [D12, D22, D23], [D12, D23, D22]]) / 0.832
    assert np.allclose(D, expected, rtol=1e-14, atol=0)
    assert D[0, 0] == pytest.approx(49.21875, rel=1e-14)


def test_stiffness_of_equal_constants_is_the_isotropic_one():
    E, nu = 210.0, 0.3
    G, lam = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    D = stiffness_matrix((E,) * 3, (G,) * 3, (nu,) * 3)
    expected = np.diag([2 * G] * 3 + [G] * 3)
    expected[:3, :3] += lam
    assert np.allclose(D, expected, rtol=1e-13, atol=1e-12)


def test_shear_moduli_stand_in_voigt_order():
    assert np.diag(stiffness_matrix(YOUNG, SHEAR, POISSON))[3:].tolist() == [6.1, 4.9, 5.4]


@pytest.mark.parametrize(
    "change",
    [
        {"young": (45.0, 0.0, 15.0)},
        {"young": (45.0, 15.0, -1.0)},
        {"shear": (5.4, -5.4, 5.4)},
        {"shear": (0.0, 5.4, 5.4)},
        {"poisson": (0.3, 0.3, 1.0)},  # |nu23| < sqrt(E2/E3)
        {"poisson": (1.74, 0.0, 0.0)},  # |nu12| < sqrt(E1/E2) = 1.732
        {"poisson": (-1.74, 0.0, 0.0)},
        {"young": (1.0,) * 3, "poisson": (0.5,) * 3},  # incompressible
    ],
)
def test_materials_that_are_not_positive_definite_are_refused(change):
    with pytest.raises(ValueError, match="material is not positive definite"):
        stiffness_matrix(**(PAPER | change))
    with pytest.raises(ValueError, match="material is not positive definite"):
        OrthotropicSVK(**(PAPER | change), frame=(None,) * 3)


@pytest.mark.parametrize(
    "change",
    [{"young": (45.0, float("nan"), 15.0)}, {"shear": (float("nan"),) * 3}],
)
def test_moduli_that_are_no_numbers_are_refused(change):
    with pytest.raises(ValueError, match="material is not positive definite"):
        stiffness_matrix(**(PAPER | change))


def test_poissons_ratios_that_are_no_numbers_are_refused():
    with pytest.raises(ValueError, match="material is not positive definite"):
        stiffness_matrix(**(PAPER | {"poisson": (float("nan"), 0.3, 0.3)}))


def test_bounds_of_positive_definiteness_are_sharp():
    for poisson in ((1.73, 0.0, 0.0), (-1.73, 0.0, 0.0), (0.0, 0.0, 0.999)):
        D = stiffness_matrix(**(PAPER | {"poisson": poisson}))
        assert np.linalg.eigvalsh(D)[0] > 0


@pytest.mark.parametrize("law", [StVenantKirchhoff, NeoHooke])
@pytest.mark.parametrize(
    ("lam", "mu"),
    [(1.0, 0.0), (1.0, -1.0), (-0.7, 1.0), (1.0, float("nan")), (float("nan"), 1.0)],
)
def test_lame_constants_without_positive_moduli_are_refused(law, lam, mu):
    with pytest.raises(ValueError, match="material is not positive definite"):
        law(lam, mu)


@pytest.mark.parametrize("law", [StVenantKirchhoff, NeoHooke])
def test_first_lame_constant_may_be_negative_while_the_bulk_modulus_is_positive(law):
    assert law(-0.6, 1.0).first_lame == -0.6


def test_a_users_own_energy_is_a_material_with_a_stress(comm, cells, rng):
    """W = k (E11 + E22 + E33)^3, whose stress is 3 k (tr E)^2 I."""

    @dataclass(frozen=True)
    class Cubic:
        k: float
        quadratic = False

        def strain_energy(self, C, parameter):
            return parameter(self.k) * ufl.tr(green_lagrange(C)) ** 3

    law = Law(comm, cells, lambda _: Cubic(2.0))
    _, C = deformation(rng)
    assert isinstance(law.material, Material)
    tr_E = 0.5 * (np.trace(C) - 3)
    assert np.allclose(law.stress(C), 6.0 * tr_E**2 * np.eye(3), rtol=1e-13, atol=1e-15)
