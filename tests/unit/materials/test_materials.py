"""Claims about strain energies, evaluated as UFL sees them; oracle: numpy.

A mesh of volume one turns an integral of a constant into its value.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from scipy.optimize import brentq

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.materials import (
    KelvinVoigt,
    Material,
    MooneyRivlin,
    NeoHooke,
    OrthotropicSVK,
    StVenantKirchhoff,
    TransverselyIsotropic,
    Viscous,
)
from turbine_fenicsx.materials.base import second_piola_kirchhoff
from turbine_fenicsx.materials.kinematics import green_lagrange, right_cauchy_green
from turbine_fenicsx.materials.orthotropic import stiffness_matrix
from turbine_fenicsx.materials.transversely_isotropic import neo_hookean_share
from turbine_fenicsx.time_stepping.discrete_gradients import general_stress

QUADRATIC = ("svk", "orthotropic")
TRANSVERSE = ("composite", "soft_fibre")
LAWS = (*QUADRATIC, "neo_hooke", "mooney_rivlin", *TRANSVERSE)
DIRECTED = ("orthotropic", *TRANSVERSE)
LAMBDA, MU = 3.0, 0.8
YOUNG, SHEAR, POISSON = (45.0, 15.0, 12.0), (5.4, 4.9, 6.1), (0.3, 0.25, 0.35)
FRAME = rotation_about((1.0, 2.0, 0.5), 1.1)  # columns a1, a2, a3
C10, C01, KAPPA = 0.3, 0.1, 4.0
COMPOSITE = (45.0, 15.0, 5.4, 0.3, 0.35)
SOFT_FIBRE = (10.0, 50.0, 4.0, 0.06, 0.1)
PAPER = {"young": (45.0, 15.0, 15.0), "shear": (5.4, 5.4, 5.4), "poisson": (0.3, 0.3, 0.3)}
ROUND_OFF = 2e-14
"""Moduli up to fifty times strains up to one, in sums of a dozen terms, relative to moduli."""


@pytest.fixture(scope="module")
def cells(comm):
    return mesh.create_box(
        comm, [[0, 0, 0], [1, 1, 1]], [2, 1, 1], cell_type=mesh.CellType.hexahedron
    )


class Law:
    """W and S of a material as functions of numpy arrays; what is not asked for is not compiled."""

    def __init__(self, comm, cells, make):
        self.comm, self.cells = comm, cells
        self.frame = [self.constant(a) for a in FRAME.T]
        self.material = make(self.frame)
        self._C, self._F, self._D, self._A = (self.constant(np.eye(3)) for _ in range(4))

    def constant(self, value):
        return fem.Constant(self.cells, np.array(value, dtype=float, order="C"))

    def form(self, integrand):
        measure = ufl.dx(domain=self.cells, metadata={"quadrature_degree": 1})
        return fem.form(integrand * measure)

    def value(self, form):
        return float(self.comm.allreduce(fem.assemble_scalar(form)))

    def _W(self, C):
        return self.material.strain_energy(C, self.constant)

    @cached_property
    def _W_of_C(self):
        return self.form(self._W(self._C))

    @cached_property
    def _W_of_F(self):
        return self.form(self._W(right_cauchy_green(self._F)))

    @cached_property
    def _S(self):
        return self.form(ufl.inner(second_piola_kirchhoff(self._W, self._C), self._A))

    @cached_property
    def _defect(self):
        F, D = self._F, self._D
        work = 0.5 * ufl.inner(general_stress(self._W, F, D), F.T * D + D.T * F)
        W0, W1 = (self._W(right_cauchy_green(F + sign * D)) for sign in (-0.5, 0.5))
        return self.form(work - (W1 - W0))

    def energy(self, C):
        self._C.value = C
        return self.value(self._W_of_C)

    def energy_of_deformation(self, F):
        self._F.value = F
        return self.value(self._W_of_F)

    def stress(self, C):
        self._C.value = C
        S = np.zeros((3, 3))
        for i, j in np.ndindex(3, 3):
            self._A.value = np.outer(np.eye(3)[i], np.eye(3)[j])
            S[i, j] = fem.assemble_scalar(self._S)
        return self.comm.allreduce(S)

    def defect(self, F, D):
        """S_alg : dC/2 - (W_{n+1} - W_n) of the general algorithmic stress, F at the midpoint."""
        self._F.value, self._D.value = F, D
        return self.value(self._defect)


@pytest.fixture(scope="module")
def laws(comm, cells):
    return {
        "svk": Law(comm, cells, lambda _: StVenantKirchhoff(LAMBDA, MU)),
        "neo_hooke": Law(comm, cells, lambda _: NeoHooke(LAMBDA, MU)),
        "orthotropic": Law(comm, cells, lambda a: OrthotropicSVK(YOUNG, SHEAR, POISSON, tuple(a))),
        "mooney_rivlin": Law(comm, cells, lambda _: MooneyRivlin(C10, C01, KAPPA)),
        "composite": Law(comm, cells, lambda a: TransverselyIsotropic(*COMPOSITE, a[0])),
        "soft_fibre": Law(comm, cells, lambda a: TransverselyIsotropic(*SOFT_FIBRE, a[0])),
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
    if law == "mooney_rivlin":
        I1, I2, J = np.trace(C), 0.5 * (np.trace(C) ** 2 - np.sum(C * C)), np.linalg.det(C) ** 0.5
        W = C10 * (I1 / J ** (2 / 3) - 3) + C01 * (I2 / J ** (4 / 3) - 3)
        return W + KAPPA / 4 * (J**2 - 1 - 2 * np.log(J))
    if law in TRANSVERSE:
        return transverse_energy(COMPOSITE if law == "composite" else SOFT_FIBRE, C)
    e = FRAME.T @ E @ FRAME
    voigt = np.array([e[0, 0], e[1, 1], e[2, 2], 2 * e[1, 2], 2 * e[0, 2], 2 * e[0, 1]])
    (E1, E2, E3), (G12, G13, G23), (n12, n13, n23) = YOUNG, SHEAR, POISSON
    S = np.diag([1 / E1, 1 / E2, 1 / E3, 1 / G23, 1 / G13, 1 / G12])
    S[0, 1] = S[1, 0] = -n12 / E1
    S[0, 2] = S[2, 0] = -n13 / E1
    S[1, 2] = S[2, 1] = -n23 / E2
    return 0.5 * voigt @ np.linalg.solve(S, voigt)


def transverse_stiffness(E1, E2, G, n12, n23):
    return stiffness_matrix((E1, E2, E2), (G, G, E2 / (2 * (1 + n23))), (n12, n12, n23))


def transverse_energy(data, C):
    """W from the parts of C in the frame of the fibre: C11, t = (C12, C13), and the area, which
    is what is left of C22, C23, C33 by elimination of C11."""
    D, c = transverse_stiffness(*data), FRAME.T @ C @ FRAME
    mu, k = (D[1, 1] - D[1, 2]) / 2, (D[1, 1] + D[1, 2]) / 2
    K = np.array([[D[0, 0], D[0, 1]], [D[0, 1], k]])
    s, neo_hooke = 1.0, np.diag([2 * mu, mu])
    if np.linalg.eigvalsh(K - neo_hooke)[0] < 0:
        s = brentq(lambda s: np.linalg.eigvalsh(K - s * neo_hooke)[0], 0, 1, xtol=1e-15)
    shear = c[0, 1:] @ c[0, 1:] / c[0, 0]
    area = c[1:, 1:] - np.outer(c[0, 1:], c[0, 1:]) / c[0, 0]
    y, z = 0.5 * np.log(c[0, 0]), 0.5 * np.log(np.linalg.det(area))
    W = s * mu * (0.5 * (c[0, 0] - 1) - y + np.exp(z) - 1 - z)
    W += mu * (0.5 * np.trace(area) - np.exp(z)) + 0.5 * data[2] * shear
    return W + 0.5 * np.array([y, z]) @ (K - s * neo_hooke) @ np.array([y, z])


def test_materials_are_materials(laws):
    assert set(laws) == set(LAWS)
    for name, law in laws.items():
        assert isinstance(law.material, Material) and not isinstance(law.material, Viscous)
        assert law.material.quadratic == (name in QUADRATIC)


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
            # other energies, about ten moduli
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
def test_only_laws_with_a_frame_or_a_fibre_know_directions(laws, rng, law):
    _, C = deformation(rng)
    Q = rotation_about((0.2, -1.0, 0.7), 2.0)
    W, turned = laws[law].energy(C), laws[law].energy(Q.T @ C @ Q)
    if law in DIRECTED:
        assert abs(turned - W) > 0.1 * W
    else:
        assert turned == pytest.approx(W, rel=1e-13, abs=ROUND_OFF)


@pytest.mark.parametrize("law", DIRECTED)
def test_law_is_invariant_under_half_turns_about_its_axes(laws, rng, law):
    _, C = deformation(rng)
    W = laws[law].energy(C)
    for axis in FRAME.T:
        Q = rotation_about(axis, np.pi)
        assert laws[law].energy(Q.T @ C @ Q) == pytest.approx(W, rel=1e-13)


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


# --- stiffness at rest


STIFFNESS = {
    "svk": lambda: isotropic_stiffness(LAMBDA, MU),
    "neo_hooke": lambda: isotropic_stiffness(LAMBDA, MU),
    "mooney_rivlin": lambda: isotropic_stiffness(
        KAPPA - 4 / 3 * (C10 + C01),
        2 * (C10 + C01),  # Lambda = kappa - 2/3 of the shear modulus
    ),
    "orthotropic": lambda: stiffness_matrix(YOUNG, SHEAR, POISSON),
    "composite": lambda: transverse_stiffness(*COMPOSITE),
    "soft_fibre": lambda: transverse_stiffness(*SOFT_FIBRE),
}


def isotropic_stiffness(lam, mu):
    D = np.diag([2 * mu] * 3 + [mu] * 3)
    D[:3, :3] += lam
    return D


@pytest.mark.parametrize("law", LAWS)
def test_stiffness_at_rest_is_the_linear_one(laws, law):
    """All 36 entries in the frame of the material, for engineering shear strains of 2e-4."""
    D, h, pairs = np.zeros((6, 6)), 1e-4, ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
    for k, (i, j) in enumerate(pairs):
        e = np.zeros((3, 3))
        e[i, j] += 0.5
        e[j, i] += 0.5
        dC = 2 * h * FRAME @ e @ FRAME.T
        dS = laws[law].stress(np.eye(3) + dC) - laws[law].stress(np.eye(3) - dC)
        c = FRAME.T @ dS @ FRAME / (2 * h)
        D[:, k] = [c[p] for p in pairs]
    # h^2/6 = 2e-9 times a third derivative of the stress, up to forty moduli; round-off / h = 1e-10
    assert np.allclose(D, STIFFNESS[law](), rtol=0, atol=1e-7 * np.max(D))


# --- the discrete gradient of laws that are not quadratic


@pytest.mark.parametrize("law", [law for law in LAWS if law not in QUADRATIC])
@pytest.mark.parametrize("size", [0.5, 0.1, 1e-2, 1e-4])
def test_general_stress_is_a_discrete_gradient_of_the_energy(laws, rng, law, size):
    Q = rotation_about((0.2, -1.0, 0.7), 2.0)
    modulus = np.max(STIFFNESS[law]())
    for _ in range(3):
        F, D = deformation(rng)[0], size * rng.uniform(-0.5, 0.5, (3, 3))
        for turn in (np.eye(3), Q):
            # terms up to the modulus are rounded
            assert abs(laws[law].defect(turn @ F, turn @ D)) <= 10 * ROUND_OFF * modulus


# --- large strains


def stretched(stretches):
    """C of stretches along the axes of the frame."""
    return (FRAME * np.square(stretches)) @ FRAME.T


def force(law, stretches, axis=0):
    """Force per area at rest along an axis of the frame."""
    a = FRAME[:, axis]
    return stretches[axis] * a @ law.stress(stretched(stretches)) @ a


STRETCHES = np.geomspace(1.0, 0.05, 25)


@pytest.mark.parametrize("law", [law for law in LAWS if law not in QUADRATIC])
@pytest.mark.parametrize("axis", range(3))
def test_resistance_to_compression_grows_without_end(laws, law, axis):
    """Down to 5 % of the length, sides held; a linear force would end at -0.95 of the stiffness."""
    forces = [force(laws[law], np.where(np.arange(3) == axis, s, 1.0), axis) for s in STRETCHES]
    assert np.all(np.diff(forces) < 0)
    assert forces[-1] < -5.0 * STIFFNESS[law]()[axis, axis]


def test_st_venant_kirchhoff_gives_way_in_compression(comm, cells):
    """The same constants as the law above: the force is largest at 1/sqrt(3) of the length."""
    E1, E2, G, n12, n23 = COMPOSITE
    data = ((E1, E2, E2), (G, G, E2 / (2 * (1 + n23))), (n12, n12, n23))
    law = Law(comm, cells, lambda a: OrthotropicSVK(*data, tuple(a)))
    forces = [force(law, (s, 1.0, 1.0)) for s in STRETCHES]
    assert STRETCHES[np.argmin(forces)] == pytest.approx(3**-0.5, rel=0.07)
    assert forces[-1] > 0.15 * min(forces)
    assert law.energy(stretched((1e-8, 1.0, 1.0))) < 0.13 * transverse_stiffness(*COMPOSITE)[0, 0]


@pytest.mark.parametrize("law", TRANSVERSE)
def test_resistance_to_compression_along_the_fibre_grows_with_free_sides_too(laws, law):
    a2, side, forces = FRAME[:, 1], 1.0, []

    def stress_at_side(side, stretch):
        return a2 @ laws[law].stress(stretched((stretch, side, side))) @ a2

    for stretch in STRETCHES:
        side = brentq(stress_at_side, 0.9 * side, 3.0 * side, args=(stretch,), xtol=1e-12)
        forces.append(force(laws[law], (stretch, side, side)))
    assert np.all(np.diff(forces) < 0)
    assert forces[-1] < -8.0 * (COMPOSITE if law == "composite" else SOFT_FIBRE)[0]


@pytest.mark.parametrize("law", ["mooney_rivlin", *TRANSVERSE])
def test_energy_is_positive_for_large_strains_and_grows_without_bound(laws, rng, law):
    modulus = np.min(np.diag(STIFFNESS[law]()))
    for size in (0.5, 1.0, 2.0):
        for _ in range(20):
            Q, stretches = (
                np.linalg.qr(rng.normal(size=(3, 3)))[0],
                np.exp(size * rng.normal(size=3)),
            )
            assert laws[law].energy((Q * stretches**2) @ Q.T) > 1e-3 * modulus
    for axis in (*FRAME.T, np.ones(3) / 3**0.5):
        for sign in (1, -1):
            energies = [
                laws[law].energy(np.eye(3) + (np.exp(2 * sign * x) - 1) * np.outer(axis, axis))
                for x in (2.0, 4.0, 8.0)
            ]
            assert energies[0] > modulus and np.all(np.diff(energies) > energies[:2])
    for stretches in ((0.02,) * 3, (50.0,) * 3, (0.02, 50.0, 0.02), (50.0, 0.02, 50.0)):
        assert laws[law].energy(stretched(stretches)) > 10 * modulus


@pytest.mark.parametrize("law", TRANSVERSE)
def test_transversely_isotropic_law_is_isotropic_about_its_fibre(laws, rng, law):
    for _ in range(3):
        _, C = deformation(rng, 0.4)
        W = laws[law].energy(C)
        for angle in (0.3, 1.0, 2.5):
            Q = rotation_about(FRAME[:, 0], angle)
            assert laws[law].energy(Q.T @ C @ Q) == pytest.approx(W, rel=1e-12)


def test_length_of_the_fibre_vector_does_not_matter(comm, cells, laws, rng):
    law = Law(comm, cells, lambda a: TransverselyIsotropic(*COMPOSITE, -3.0 * a[0]))
    _, C = deformation(rng)
    assert law.energy(C) == pytest.approx(laws["composite"].energy(C), rel=1e-13)


def test_transversely_isotropic_law_with_isotropic_constants_is_neo_hookean(comm, cells, rng):
    E, nu = MU * (3 * LAMBDA + 2 * MU) / (LAMBDA + MU), LAMBDA / (2 * (LAMBDA + MU))
    law = Law(comm, cells, lambda a: TransverselyIsotropic(E, E, MU, nu, nu, a[0]))
    for _ in range(3):
        _, C = deformation(rng, 0.4)
        assert law.energy(C) == pytest.approx(energy_by_hand("neo_hooke", C), rel=1e-12)


def test_stiffness_of_the_transversely_isotropic_law_is_given():
    D = TransverselyIsotropic(*COMPOSITE, None).stiffness()
    assert np.allclose(D, transverse_stiffness(*COMPOSITE), rtol=1e-14, atol=0)


def test_neo_hookean_share_is_the_largest_that_leaves_a_convex_rest(rng):
    """For every stiffness that is positive definite; usual composites have the whole share."""
    for data in (COMPOSITE, (140.0, 10.0, 5.0, 0.3, 0.4), (12.0, 0.8, 0.7, 0.4, 0.45)):
        assert neo_hookean_share(transverse_stiffness(*data)) == 1.0
    shares = []
    while len(shares) < 200:
        data = (*np.exp(2 * rng.normal(size=3)), *rng.uniform(-0.99, 0.99, 2))
        try:
            D = transverse_stiffness(*data)
        except ValueError:
            continue
        mu, k, s = (D[1, 1] - D[1, 2]) / 2, (D[1, 1] + D[1, 2]) / 2, neo_hookean_share(D)
        K = np.array([[D[0, 0], D[0, 1]], [D[0, 1], k]])
        lowest = [np.linalg.eigvalsh(K - f * s * np.diag([2 * mu, mu]))[0] for f in (1, 1.001)]
        assert 0.0 < s <= 1.0 and lowest[0] >= -1e-12 * D[0, 0].clip(k)
        assert s == 1.0 or lowest[1] < 0.0
        shares.append(s)
    assert 20 < shares.count(1.0) < 180


@pytest.mark.parametrize("change", [(0, 0.0), (1, -1.0), (2, 0.0), (2, float("nan")), (0, np.inf)])
def test_transversely_isotropic_moduli_must_be_positive(change):
    data = list(COMPOSITE)
    data[change[0]] = change[1]
    with pytest.raises(ValueError, match="material is not positive definite"):
        TransverselyIsotropic(*data, None)


@pytest.mark.parametrize("ratios", [(0.3, 1.0), (0.3, -1.0), (1.74, 0.0), (0.9, 0.6)])
def test_transversely_isotropic_ratios_must_leave_a_positive_energy(ratios):
    with pytest.raises(ValueError, match="material is not positive definite"):
        TransverselyIsotropic(*COMPOSITE[:3], *ratios, None)


@pytest.mark.parametrize(
    ("data", "mistake"),
    [
        ((0.0, 0.0, 1.0), "c10 = 0 Pa and c01 = 0 Pa"),
        ((-0.1, 1.0, 1.0), "c10 = -0.1 Pa"),
        ((1.0, -0.1, 1.0), "c01 = -0.1 Pa"),
        ((float("nan"), 1.0, 1.0), "c10 = nan Pa"),
        ((1.0, 0.0, 0.0), "bulk modulus 0 Pa"),
        ((1.0, 0.0, -2.0), "bulk modulus -2 Pa"),
        ((1.0, 0.0, float("nan")), "bulk modulus nan Pa"),
        ((1.0, 0.0, float("inf")), "bulk modulus inf Pa"),
    ],
)
def test_rubber_without_positive_energy_is_refused(data, mistake):
    with pytest.raises(ValueError, match=f"material is not positive definite: .*{mistake}"):
        MooneyRivlin(*data)


def test_rubber_may_have_one_factor_only():
    assert MooneyRivlin(1.0, 0.0, 1.0).c01 == MooneyRivlin(0.0, 1.0, 1.0).c10 == 0.0


# --- fields


def test_frame_and_fibre_may_be_fields(comm, cells, laws, rng):
    """Two cells with two frames, cellwise constant and as a formula in X."""
    space = _compat.cellwise_space(cells, (3,))
    Q = rotation_about((0.2, -1.0, 0.7), 2.0)
    axes = [fem.Function(space) for _ in range(3)]
    for field, a in zip(axes, FRAME.T, strict=True):
        field.interpolate(lambda x, a=a: np.where(x[0] < 0.5, *np.array([a, Q @ a])[..., None]))
        field.x.scatter_forward()
    first = ufl.lt(ufl.SpatialCoordinate(cells)[0], 0.5)
    a, b = (laws["composite"].constant(v) for v in (FRAME[:, 0], Q @ FRAME[:, 0]))
    formula = ufl.as_vector([ufl.conditional(first, a[k], b[k]) for k in range(3)])
    _, C = deformation(rng)
    for name, make in (
        ("orthotropic", lambda: OrthotropicSVK(YOUNG, SHEAR, POISSON, tuple(axes))),
        ("composite", lambda: TransverselyIsotropic(*COMPOSITE, axes[0])),
        ("composite", lambda: TransverselyIsotropic(*COMPOSITE, formula)),
    ):
        halves = [laws[name].energy(c) for c in (C, Q.T @ C @ Q)]
        assert abs(halves[1] - halves[0]) > 0.1 * halves[0]
        law = Law(comm, cells, lambda _, make=make: make())
        assert law.energy(C) == pytest.approx(np.mean(halves), rel=1e-12)


# --- viscous stress


@pytest.fixture(scope="module")
def viscous_stress(comm, cells):
    """S_v of a Kelvin-Voigt material as a function of a rate of strain."""
    rate, A = (fem.Constant(cells, np.zeros((3, 3))) for _ in range(2))
    material = KelvinVoigt(NeoHooke(LAMBDA, MU), 0.7, 0.4)
    S = material.viscous_stress(rate, lambda c: fem.Constant(cells, np.array(c, dtype=float)))
    form = fem.form(ufl.inner(S, A) * ufl.dx(domain=cells))

    def evaluate(E_dot):
        rate.value, S = E_dot, np.zeros((3, 3))
        for index in np.ndindex(3, 3):
            A.value = np.zeros((3, 3))
            A.value[index] = 1.0
            S[index] = comm.allreduce(fem.assemble_scalar(form))
        return S

    return evaluate


def test_viscous_stress_is_that_of_its_two_viscosities(viscous_stress, rng):
    for _ in range(3):
        E_dot = rng.normal(size=(3, 3))
        E_dot += E_dot.T
        trace = np.trace(E_dot)
        S = viscous_stress(E_dot)
        expected = 2 * 0.7 * (E_dot - trace / 3 * np.eye(3)) + 0.4 * trace * np.eye(3)
        assert np.allclose(S, expected, rtol=0, atol=1e-14)
        assert np.array_equal(S, S.T) and np.sum(S * E_dot) > 0.0


def test_viscous_material_keeps_its_elastic_energy():
    class Elastic:
        quadratic = True

        def strain_energy(self, C, parameter):
            return "W", C, parameter

    material = KelvinVoigt(Elastic(), 1.0)
    assert isinstance(material, Material) and isinstance(material, Viscous)
    assert material.strain_energy("C", "parameter") == ("W", "C", "parameter")
    assert material.quadratic and not KelvinVoigt(NeoHooke(1.0, 1.0), 1.0).quadratic
    assert material.bulk_viscosity == 0.0


@pytest.mark.parametrize("name", ["shear", "bulk"])
@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_viscosities_that_are_negative_or_no_numbers_are_refused(name, value):
    data = {"shear_viscosity": 1.0, "bulk_viscosity": 1.0} | {f"{name}_viscosity": value}
    with pytest.raises(
        ValueError, match=f"{name} viscosity must not be negative, got {value:g} Pa s"
    ):
        KelvinVoigt(NeoHooke(1.0, 1.0), **data)
    assert KelvinVoigt(NeoHooke(1.0, 1.0), 0.0).shear_viscosity == 0.0


def test_elastic_part_must_be_a_material_and_not_viscous_itself():
    with pytest.raises(TypeError, match="must be a material, got int 3"):
        KelvinVoigt(3, 1.0)
    with pytest.raises(TypeError, match=r"must not be viscous itself, got .*KelvinVoigt"):
        KelvinVoigt(KelvinVoigt(NeoHooke(1.0, 1.0), 1.0), 1.0)
