"""Peel and shear of bonds: forces over the width, and beams on foundations."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp, trapezoid

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.materials.adhesive_bond import Adhesive, find_bond_stresses
from turbine_fenicsx.materials.laminate_theory import laminate_stiffness
from turbine_fenicsx.materials.ply import Ply, PlyMaterial

WALL = [Ply(PlyMaterial("glass", 1.9e3, (40e9, 15e9, 15e9), (4e9,) * 3, (0.3,) * 3), 0.01)]
WIDTH, THICKNESS = 0.08, 0.006


def strain(N22=0.0, N12=0.0, M22=0.0):
    """Strains of the inner and the outer face of the wall under forces and a moment."""
    A, _, D = laminate_stiffness(WALL)
    e, k = np.linalg.solve(A, [0.0, N22, N12]), np.linalg.solve(D, [0.0, M22, 0.0])
    return np.concatenate([e - 0.005 * k, e + 0.005 * k])


def find(loads, young, is_edge=False, shear=1.0):
    """Peel at both sides, and shear."""
    adhesive = Adhesive(THICKNESS, WIDTH, young, shear)
    found = find_bond_stresses(WALL, is_edge, adhesive) @ strain(**loads)
    assert not found[:, 0].any() and found[0, 2] == found[1, 2]
    return found[0, 1], found[1, 1], found[0, 2]


def test_a_soft_adhesive_carries_as_forces_and_moments_are_in_equilibrium():
    loads = {"N22": 2e4, "N12": 3e4, "M22": 50.0}
    force, moment = 2e4 / WIDTH, 6.0 * 50.0 / WIDTH**2
    assert find(loads, 1.0) == pytest.approx((force + moment, force - moment, 3e4 / WIDTH))
    assert find(loads, 1.0, is_edge=True) == pytest.approx((moment, -moment, 3e4 / WIDTH))


def solve_beam(k, start):
    """Largest deflection of a long beam on a foundation, by two conditions at its start."""
    D = float(laminate_stiffness(WALL)[2][1, 1])
    long = 12.0 * (4.0 * D / k) ** 0.25
    scale = long ** np.arange(4)  # derivatives by x over the length

    def slope(x, w):
        return np.vstack([w[1:], -k * long**4 / D * w[:1]])

    def ends(a, b):
        return np.array([*start(a / scale, D), b[0], b[1]])

    mesh = np.linspace(0.0, 1.0, 400)
    found = solve_bvp(slope, ends, mesh, np.zeros((4, 400)), tol=1e-8, max_nodes=20000)
    assert found.success
    return np.max(np.abs(found.sol(np.linspace(0.0, 1.0, 4001))[0]))


def test_a_stiff_adhesive_is_loaded_as_the_foundation_of_a_beam():
    young = 40e9
    k = young / THICKNESS
    foot_force = k * solve_beam(k, lambda w, D: (w[1], D * w[3] - 0.5))
    foot_moment = k * solve_beam(k, lambda w, D: (w[0], D * w[2] - 0.5))
    edge_moment = 2.0 * k * solve_beam(2.0 * k, lambda w, D: (D * w[2] - 1.0, w[3]))
    assert find({"N22": 1.0}, young)[0] == pytest.approx(foot_force, rel=1e-4)
    assert find({"M22": 1.0}, young)[0] == pytest.approx(foot_moment, rel=1e-4)
    assert find({"M22": 1.0}, young, is_edge=True)[0] == pytest.approx(edge_moment, rel=1e-4)
    assert foot_force > 1.0 / WIDTH and foot_moment > 6.0 / WIDTH**2


# t'' = 2 G/(t_a A66) t, symmetric about the middle of the bond, whose integral is the shear flow
def test_a_stiff_adhesive_has_the_peaks_of_a_lap_joint():
    G, flow = 2e9, 3e4
    rate = np.sqrt(2.0 * G / (THICKNESS * float(laminate_stiffness(WALL)[0][2, 2])))
    x = np.linspace(-0.5 * WIDTH, 0.5 * WIDTH, 20001)
    shape = np.cosh(rate * x)
    peak = flow * shape[0] / trapezoid(shape, x)
    assert find({"N12": flow}, 1.0, shear=G)[2] == pytest.approx(peak, rel=1e-6)
    assert peak > 1.2 * flow / WIDTH


def test_an_adhesive_without_width_is_refused():
    with pytest.raises(ModelError, match="must be positive"):
        Adhesive(THICKNESS, 0.0, 4e9, 1e9)
