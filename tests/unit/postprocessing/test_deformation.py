"""Exaggerated deformations, seen from what carries each part."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.rotations import E1, E2, E3, rotation_about
from turbine_fenicsx.postprocessing.field_reader import exaggerate, find_deflections, fit_motion
from turbine_fenicsx.records.parts import Part, Parts

CUBE = np.array([(x, y, z) for y in (0, 1, 2) for x in (-1, 1) for z in (-1, 1)], dtype=float)
"""A column of two cubes: four points at y = 0, four at 1, four at 2."""


def exaggerated(x, X, coupling, part, parts, scale):
    def points_of(number):
        return part == number

    deflections = find_deflections(x, x - X, coupling, points_of, parts)
    return exaggerate(x, deflections, coupling, points_of, parts, scale)


def test_flat_points_are_turned_and_not_mirrored():
    X = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], dtype=float)
    motion = fit_motion(X, X @ rotation_about(E1, 3.0).T + E2)
    other = np.array([[3.0, 1.0, 2.0]])
    assert np.allclose(motion(other), other @ rotation_about(E1, 3.0).T + E2)


@pytest.mark.parametrize("X", [np.array([[1.0, 2.0, 3.0]]), np.outer(np.arange(4.0), E2)])
def test_points_in_a_line_are_only_shifted(X):
    assert np.allclose(fit_motion(X, X + E3).rotation, np.eye(3))


def test_part_without_carrier_is_seen_from_its_own_mean_motion():
    X = CUBE.copy()
    R = rotation_about((1, 2, 3), 2.0)
    wave = 0.1 * np.cos(np.pi * X[:, 1])[:, None] * E1  # shifts and turns nothing on the whole
    wave -= wave.mean(axis=0)
    x = (X + wave) @ R.T + (5.0, 6.0, 7.0)
    held = np.zeros(len(X), int)
    parts = Parts((Part(0, "free", "free"),))
    found = exaggerated(x, X, held, held, parts, 4.0)
    assert np.allclose(found, (X + 4.0 * wave) @ R.T + (5.0, 6.0, 7.0), atol=1e-12)


def test_nacelle_and_blade_ride_on_the_exaggerated_tower():
    tower, nacelle, blade = CUBE, CUBE + 2.0 * E2, CUBE + 4.0 * E2
    X = np.concatenate([tower, nacelle, blade])
    part = np.repeat([5, 0, 2], 12)
    coupling = np.zeros(36, int)
    coupling[:4], coupling[8:12], coupling[24:28] = 4, 5, 1  # foot, head, root
    parts = Parts(
        (Part(0, "nacelle", "nacelle", 5), Part(5, "tower", "tower"), Part(2, "blade", "blades")),
        {4: 0, 1: 5},
    )
    lean, yaw, flap = 0.3 * E1, rotation_about(E2, 1.1), 0.05 * E3
    x = X.copy()
    x[8:12] += lean  # the top of the tower
    x[12:] = X[12:] @ yaw.T + lean
    x[32:] += flap  # the tip of the blade
    found = exaggerated(x, X, coupling, part, parts, 10.0)
    assert np.array_equal(found[:8], X[:8])
    assert np.allclose(found[8:12], X[8:12] + 10.0 * lean, atol=1e-12)
    assert np.allclose(found[12:32], X[12:32] @ yaw.T + 10.0 * lean, atol=1e-12)
    assert np.allclose(found[32:], X[32:] @ yaw.T + 10.0 * lean + 10.0 * flap, atol=1e-12)
    assert np.allclose(exaggerated(x, X, coupling, part, parts, 1.0), x, atol=1e-12)
    alone = find_deflections(x, x - X, coupling, lambda number: part == number, parts)
    wanted = np.zeros_like(x)
    wanted[8:12], wanted[32:] = lean, flap  # each part beside its own root
    assert np.allclose(alone, wanted, atol=1e-12)


def test_coupler_between_two_bodies_is_seen_from_both():
    X = CUBE.copy()
    coupling = np.repeat([1, 0, 2], 4)
    parts = Parts((Part(3, "coupler", "coupler"),), {1: 0, 2: 0})
    R = rotation_about(E3, 0.7)
    x = X @ R.T
    x[4:8] += 0.01 * E3  # between its ends, which move as one
    found = exaggerated(x, X, coupling, np.full(12, 3), parts, 5.0)
    assert np.allclose(found[4:8], X[4:8] @ R.T + 0.05 * E3, atol=1e-12)
    assert np.allclose(found[coupling > 0], x[coupling > 0], atol=1e-12)
