"""Claims about the stiffness of laminates; oracle: formulas of the textbooks."""

import numpy as np
import pytest
from walls import CARBON, FOAM, GLASS, laminate

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.materials.laminate_theory import (
    fit_moments,
    interfaces,
    laminate_stiffness,
    mass_per_area,
    reduced_stiffness,
    strain_in_ply,
    tabulate_walls,
    transverse_stiffness,
)
from turbine_fenicsx.materials.ply import PlyMaterial
from turbine_fenicsx.materials.wall_quadrature import STABILISING, wall_quadrature

E, NU = 70e9, 0.3
METAL = PlyMaterial("metal", 2700.0, (E,) * 3, (E / 2 / (1 + NU),) * 3, (NU,) * 3)
WILD = laminate((GLASS, 0.004, 30), (FOAM, 0.02, 0), (CARBON, 0.002, -50), (GLASS, 0.001, 10))


@pytest.mark.parametrize("angle", [0.0, 0.4])
def test_an_isotropic_wall_is_the_plate_of_the_textbook(angle):
    h = 0.02
    A, B, D = laminate_stiffness(laminate((METAL, 0.5 * h, angle), (METAL, 0.5 * h, 10.0)))
    plate = E / (1 - NU**2) * np.array([[1, NU, 0], [NU, 1, 0], [0, 0, (1 - NU) / 2]])
    assert np.allclose(A, plate * h, rtol=1e-13, atol=1e-13 * A[0, 0])
    assert np.allclose(D, plate * h**3 / 12, rtol=1e-13, atol=1e-13 * D[0, 0])
    assert np.max(np.abs(B)) <= 1e-13 * A[0, 0] * h


@pytest.mark.parametrize("degrees", [0, 15, 30, 45, 60, 90, -30])
def test_moduli_off_the_fibre_are_those_of_the_textbook(degrees):
    (E1, E2, _), G, nu = CARBON.young, CARBON.shear[0], CARBON.poisson[0]
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    compliance = np.linalg.inv(reduced_stiffness(CARBON, np.deg2rad(degrees)))
    along = c**4 / E1 + (1 / G - 2 * nu / E1) * s**2 * c**2 + s**4 / E2
    shear = 2 * (2 / E1 + 2 / E2 + 4 * nu / E1 - 1 / G) * s**2 * c**2 + (s**4 + c**4) / G
    assert compliance[0, 0] == pytest.approx(along, rel=1e-12)
    assert compliance[2, 2] == pytest.approx(shear, rel=1e-12)
    # a fibre at a positive angle is stretched by positive shear
    assert np.sign(np.round(reduced_stiffness(CARBON, np.deg2rad(degrees))[0, 2])) == np.sign(
        np.round(c * s, 12)
    )


def test_strain_along_the_fibre_is_that_of_the_strain_tensor():
    e, angle = np.array([1e-3, -4e-4, 7e-4]), 0.7
    tensor = np.array([[e[0], e[2] / 2], [e[2] / 2, e[1]]])
    fibre, across = [np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]
    expected = [fibre @ tensor @ fibre, across @ tensor @ across, 2 * (fibre @ tensor @ across)]
    assert np.allclose(strain_in_ply(angle) @ e, expected, rtol=1e-13)


def test_coupling_has_the_sign_of_the_outer_ply():
    """[0/90]: the fibre along the span lies outside, at positive z."""
    h = 0.01
    A, B, D = laminate_stiffness(laminate((CARBON, h / 2, 0), (CARBON, h / 2, 90)))
    Q = reduced_stiffness(CARBON)
    for k in (0, 1):
        assert A[k, k] == pytest.approx((Q[0, 0] + Q[1, 1]) * h / 2, rel=1e-12)
    assert B[0, 0] == pytest.approx((Q[0, 0] - Q[1, 1]) * h**2 / 8, rel=1e-12)
    assert B[1, 1] == pytest.approx(-B[0, 0], rel=1e-12)
    assert D[0, 0] == pytest.approx((Q[0, 0] + Q[1, 1]) * h**3 / 24, rel=1e-12)


def test_a_sandwich_bends_by_its_faces():
    t, c = 0.003, 0.05
    _, B, D = laminate_stiffness(laminate((GLASS, t, 0), (FOAM, c, 0), (GLASS, t, 0)))
    face, core = reduced_stiffness(GLASS)[0, 0], reduced_stiffness(FOAM)[0, 0]
    expected = 2 * face * (t**3 / 12 + t * ((c + t) / 2) ** 2) + core * c**3 / 12
    assert D[0, 0] == pytest.approx(expected, rel=1e-12)
    assert np.max(np.abs(B)) <= 1e-13 * face * c**2


def test_three_directions_of_fibres_are_quasi_isotropic():
    A, _, _ = laminate_stiffness(laminate(*[(CARBON, 0.001, k) for k in (0, 60, -60)]))
    assert A[0, 0] == pytest.approx(A[1, 1], rel=1e-12)
    assert A[2, 2] == pytest.approx((A[0, 0] - A[0, 1]) / 2, rel=1e-12)
    assert abs(A[0, 2]) + abs(A[1, 2]) <= 1e-12 * A[0, 0]


def test_plies_are_springs_in_series_through_the_wall():
    plies = laminate((GLASS, 0.002, 0), (FOAM, 0.03, 0))
    E3, G = transverse_stiffness(plies)
    for found, k in ((E3, None), (G[0, 0], 1), (G[1, 1], 2)):
        moduli = [m.young[2] if k is None else m.shear[k] for m in (GLASS, FOAM)]
        assert found == pytest.approx(0.032 / (0.002 / moduli[0] + 0.03 / moduli[1]), rel=1e-13)
    assert G[0, 1] == 0.0


def test_shear_through_a_turned_ply_is_stiff_along_its_fibre():
    _, G = transverse_stiffness(laminate((CARBON, 0.01, 30)))
    fibre, across = np.array([0.75**0.5, 0.5]), np.array([-0.5, 0.75**0.5])
    assert fibre @ G @ fibre == pytest.approx(CARBON.shear[1], rel=1e-13)
    assert across @ G @ across == pytest.approx(CARBON.shear[2], rel=1e-13)
    assert abs(fibre @ G @ across) <= 1e-13 * CARBON.shear[1]


def stiffness_at_points(plies):
    """Q at the inner face, in the middle and at the outer face."""
    return [stiffness_at(plies, zeta) for zeta in (-0.5, 0.0, 0.5)]


def stiffness_at(plies, zeta):
    return sum(Q * zeta**k for k, Q in enumerate(fit_moments(plies)))


def moments_of_points(plies):
    """A, B and D as the quadrature through the wall gives them."""
    h, (points, weights) = 2 * interfaces(plies)[0], wall_quadrature()
    z = points[:, 2] - 0.5
    Q = [stiffness_at(plies, zeta) for zeta in z]
    return [np.tensordot(h * weights * (h * z) ** k, Q, 1) for k in range(3)]


def near(found, expected):
    return np.allclose(found, expected, rtol=0, atol=1e-12 * np.max(np.abs(expected)))


def test_points_through_the_wall_give_all_of_ABD():
    plies = laminate((GLASS, 0.004, 30), (FOAM, 0.02, 0), (CARBON, 0.001, 50), (GLASS, 0.003, 10))
    A, B, D = laminate_stiffness(plies)
    assert np.max(np.abs(B)) > 0.02 * np.max(np.abs(A)) * 0.028  # it couples
    assert all(near(*pair) for pair in zip(moments_of_points(plies), (A, B, D), strict=True))


ONE_SIDED = laminate((GLASS, 0.002, 45), (CARBON, 0.02, 10), (FOAM, 0.02, 0), (GLASS, 0.002, 45))


@pytest.mark.parametrize("plies", [ONE_SIDED, ONE_SIDED[::-1]])
def test_a_laminate_with_one_stiff_side_is_nowhere_of_negative_stiffness(plies):
    A, B, D = laminate_stiffness(plies)
    h = 2 * interfaces(plies)[0]
    assert min(np.linalg.eigvalsh(2 * D + sign * B * h)[0] for sign in (1, -1)) < 0.0
    for Q in stiffness_at_points(plies):
        assert np.linalg.eigvalsh(Q)[0] >= -1e-12 * np.max(Q)
    moments = moments_of_points(plies)
    assert near(moments[0], A) and near(moments[1], B)
    excess = np.linalg.eigvalsh(moments[2] - D)
    assert excess[0] >= -1e-12 * np.max(D) and 0.0 < excess[-1] < np.max(D)


def test_the_fit_of_a_uniform_wall_is_uniform():
    for Q in stiffness_at_points(laminate((CARBON, 0.01, 20))):
        assert np.allclose(Q, reduced_stiffness(CARBON, np.deg2rad(20)), rtol=2 * STABILISING)


@pytest.mark.parametrize("face", [1e-5, 1e-3, 0.02])
def test_a_sandwich_has_its_ABD_and_is_nowhere_of_negative_stiffness(face):
    """With Gauss points the middle of thin faces on a core would be."""
    plies = laminate((CARBON, face, 20), (FOAM, 0.05, 0), (CARBON, face, 20))
    assert all(np.linalg.eigvalsh(Q)[0] > 0.0 for Q in stiffness_at_points(plies))
    A, _, D = laminate_stiffness(plies)
    assert near(moments_of_points(plies)[0], A) and near(moments_of_points(plies)[2], D)


# --- tables


def test_a_thinner_wall_of_the_mesh_carries_the_same_force_and_mass():
    table = tabulate_walls([WILD, WILD], np.array([0.027, 0.0135]))
    A = laminate_stiffness(WILD)[0][np.triu_indices(3)]
    E3, G = transverse_stiffness(WILD)
    for row, h in enumerate((0.027, 0.0135)):
        assert np.allclose(table.in_plane[row] * h, A, rtol=1e-13)
        assert table.density[row] * h == pytest.approx(mass_per_area(WILD), rel=1e-13)
    assert np.allclose(table.through[0], [E3, G[0, 0], G[0, 1], G[1, 1]], rtol=1e-13)
    assert np.allclose(table.through[1], 2 * table.through[0], rtol=1e-13)
    assert mass_per_area(WILD) == pytest.approx(1940 * 0.005 + 130 * 0.02 + 1580 * 0.002, rel=1e-13)


def test_moments_are_three_matrices_a_wall():
    table = tabulate_walls([WILD], np.array([0.02]), moments=True)
    fit = fit_moments(WILD) * (0.027 / 0.02)
    assert np.allclose(table.in_plane[0].reshape(3, 6), [Q[np.triu_indices(3)] for Q in fit])


def test_rows_follow_the_walls():
    others = [laminate((GLASS, 0.001 * k, 0)) for k in (1, 2, 1)]
    table = tabulate_walls([*others, WILD], np.full(4, 0.01))
    assert table[[3, 0]].density.tolist() == [table.density[3], table.density[0]]
    assert table.density[0] == table.density[2] == table.density[1] / 2
    empty = tabulate_walls([], np.zeros(0))
    assert empty.in_plane.shape == (0, 6) and empty.through.shape == (0, 4)


@pytest.mark.parametrize(
    ("plies", "thickness", "message"),
    [
        ((), 0.01, "a laminate needs a ply, but one has none"),
        (WILD, 0.0, "thickness of a wall must be positive, got 0"),
        (WILD, np.inf, "thickness of a wall must be positive, got inf"),
    ],
)
def test_walls_that_cannot_be_are_refused(plies, thickness, message):
    with pytest.raises(ModelError, match=message):
        tabulate_walls([plies], np.array([thickness]))
