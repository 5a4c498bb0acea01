"""Claims about strains, stresses and failure of plies; oracle: formulas by hand."""

import numpy as np
import pytest
from walls import CARBON, FOAM, laminate

from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.materials.ply import PlyMaterial, Strengths
from turbine_fenicsx.materials.ply_failure import (
    CRITERIA,
    maximum_strain,
    maximum_stress,
    tsai_wu,
)
from turbine_fenicsx.materials.ply_table import PlyTable

XT, XC, YT, YC, S = 1500e6, 900e6, 50e6, 200e6, 70e6
STRENGTHS = Strengths((XT, YT, YT), (XC, YC, YC), (S, S, S))
STRONG = PlyMaterial(
    "strong", 1600.0, (130e9, 9e9, 9e9), (5e9, 5e9, 4e9), (0.3, 0.3, 0.4), STRENGTHS
)


def strained(table, stress):
    """Strains of all plies of a table, at one point, for one stress in ply axes."""
    return np.array([[[np.linalg.solve(Q, stress)]] for Q in table.stiffness])


@pytest.mark.parametrize("name", CRITERIA)
def test_a_ply_fails_in_each_direction_at_its_strength(name):
    table = PlyTable([laminate((STRONG, 0.001, 20))])
    for stress in np.diag([XT, YT, S]), np.diag([-XC, -YC, -S]):
        for row in stress:
            # the index is proportional to the load
            for factor in (1.0, 0.3, 2.0):
                index = CRITERIA[name](table, strained(table, factor * row))
                assert index == pytest.approx(factor, rel=1e-12)
                assert index.shape == (1, 1, 1)


def test_strain_fails_a_ply_at_strength_over_modulus():
    table = PlyTable([laminate((STRONG, 0.001, 0))])
    for strain, expected in (
        ((XT / 130e9, 0.0, 0.0), 1.0),
        ((-XC / 130e9, 0.0, 0.0), 1.0),
        ((0.0, 2 * YT / 9e9, 0.0), 2.0),
        ((0.0, -YC / 9e9, 0.0), 1.0),
        ((0.0, 0.0, 0.5 * S / 5e9), 0.5),
        ((0.5 * XT / 130e9, 0.0, -0.75 * S / 5e9), 0.75),
    ):
        assert maximum_strain(table, np.array([[strain]])) == pytest.approx(expected, rel=1e-12)


def test_tsai_wu_is_one_where_the_polynomial_is(rng):
    table = PlyTable([laminate((STRONG, 0.001, 0))])
    F1, F2, F11, F22 = 1 / XT - 1 / XC, 1 / YT - 1 / YC, 1 / (XT * XC), 1 / (YT * YC)
    for _ in range(20):
        stress = rng.normal(size=3) * [1e9, 1e8, 1e8]
        (index,) = tsai_wu(table, strained(table, stress)).ravel()
        s1, s2, t = stress / index
        polynomial = F1 * s1 + F2 * s2 + F11 * s1**2 + F22 * s2**2 + t**2 / S**2
        polynomial -= np.sqrt(F11 * F22) * s1 * s2
        assert polynomial == pytest.approx(1.0, rel=1e-10)


def test_combined_stresses_fail_where_none_alone_does():
    table = PlyTable([laminate((STRONG, 0.001, 0))])
    strain = strained(table, (0.9 * XT, 0.0, 0.9 * S))
    assert maximum_stress(table, strain) == pytest.approx(0.9)
    assert tsai_wu(table, strain) > 1.1


@pytest.mark.parametrize("name", CRITERIA)
def test_plies_of_unknown_strength_do_not_fail(name):
    table = PlyTable([laminate((CARBON, 0.001, 0))])
    assert CRITERIA[name](table, np.full((1, 2, 4, 3), 0.1)) == pytest.approx(0.0, abs=0.0)


def test_plies_have_the_strain_of_their_place_in_the_wall():
    """Stretched by 1e-3 and bent, so that the outer face has four times the strain of the inner."""
    plies = laminate((STRONG, 0.001, 0), (FOAM, 0.002, 90), (STRONG, 0.001, 30))
    table = PlyTable([plies, plies[:1]])
    inner = np.array([[[0.4e-3, 0.0, 0.0]], [[1e-3, 0.0, 0.0]]])
    outer = np.array([[[1.6e-3, 0.0, 0.0]], [[3e-3, 0.0, 0.0]]])
    e = table.strains(inner, outer)
    assert e.shape == (4, 2, 1, 3)
    assert np.allclose(e[0, :, 0, 0], [1.6e-3, 1.3e-3], rtol=1e-13)
    assert np.allclose(e[1, :, 0, 1], [1.3e-3, 0.7e-3], rtol=1e-13)  # across the fibre
    R = rotation_about((0.0, 0.0, 1.0), np.deg2rad(30))[:2, :2]
    turned = R.T @ np.diag([0.4e-3, 0.0]) @ R
    assert np.allclose(e[2, 1, 0], [turned[0, 0], turned[1, 1], 2 * turned[0, 1]], rtol=1e-13)
    assert np.allclose(e[3, :, 0, 0], [3e-3, 1e-3], rtol=1e-13)
    stress = table.stresses(e)
    assert np.allclose(stress[2, 1, 0], table.stiffness[2] @ e[2, 1, 0], rtol=1e-13)


def test_the_largest_index_of_each_wall_names_its_ply():
    plies = laminate((STRONG, 0.001, 0), (FOAM, 0.002, 0), (STRONG, 0.001, 0))
    table = PlyTable([plies, plies[:2], plies])
    indices = np.zeros((8, 2, 4))
    indices[2, 1, 3], indices[0, 0, 0], indices[4, 0, 1] = 0.7, 0.6, 0.2
    largest, ply = table.largest(indices)
    assert largest.tolist() == [0.7, 0.2, 0.0]
    assert ply.tolist() == [2, 1, 0]
    none = PlyTable([])
    assert none.strains(np.zeros((0, 4, 3)), np.zeros((0, 4, 3))).shape == (0, 2, 4, 3)
    assert [len(x) for x in none.largest(np.zeros((0, 2, 4)))] == [0, 0]
