"""Claims about the constants of materials: stiffness matrices, and what is refused."""

import numpy as np
import pytest
from material_laws import PAPER, POISSON, SHEAR, YOUNG

from turbine_fenicsx import MooneyRivlin, NeoHooke, StVenantKirchhoff
from turbine_fenicsx.materials.orthotropic import OrthotropicSVK, stiffness_matrix


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
