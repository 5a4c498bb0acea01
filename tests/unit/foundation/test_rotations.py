"""Claims about directions, rotation matrices and frames."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.rotations import (
    E1,
    E2,
    E3,
    frame_with_axis,
    nearest_rotation,
    rotation_about,
    skew,
    unit,
)

ROUND_OFF = 1e-14
"""Entries are of order one and come out of about ten operations: some dozens of 1.1e-16."""


@pytest.fixture
def rng():
    return np.random.default_rng(20)


def test_unit_scales_to_length_one_and_keeps_the_direction(rng):
    for size in (1e-150, 1.0, 1e150):
        v = size * rng.normal(size=3)
        n = unit(v)
        assert np.linalg.norm(n) == pytest.approx(1.0, abs=ROUND_OFF)
        assert np.linalg.norm(n * np.linalg.norm(v) - v) <= ROUND_OFF * np.linalg.norm(v)


@pytest.mark.parametrize("bad", [(0, 0, 0), (1, 2), (1, 2, 3, 4), (np.nan, 0, 1), 1.0])
def test_unit_rejects_what_is_no_direction(bad):
    with pytest.raises(ValueError, match="a direction needs three numbers, not all zero"):
        unit(bad)


def test_skew_is_the_matrix_of_the_cross_product(rng):
    w, v = rng.normal(size=(2, 3))
    assert np.allclose(skew(w) @ v, np.cross(w, v), rtol=0, atol=ROUND_OFF)
    assert np.array_equal(skew(w), -skew(w).T)


def test_rotation_turns_counterclockwise_about_its_axis():
    half_pi = np.pi / 2
    assert np.allclose(rotation_about(E3, half_pi) @ E1, E2, rtol=0, atol=ROUND_OFF)
    assert np.allclose(rotation_about(E1, half_pi) @ E2, E3, rtol=0, atol=ROUND_OFF)
    assert np.allclose(rotation_about(E2, half_pi) @ E3, E1, rtol=0, atol=ROUND_OFF)


def test_rotation_is_the_exponential_of_the_skew_matrix(rng):
    axis, angle = rng.normal(size=3), 2.3
    series, term = np.eye(3), np.eye(3)
    for k in range(1, 40):  # 2.3^40/40! = 4e-34
        term = term @ skew(angle * unit(axis)) / k
        series = series + term
    assert np.allclose(rotation_about(axis, angle), series, rtol=0, atol=ROUND_OFF)


def test_rotations_are_proper_keep_their_axis_and_add_up(rng):
    axis = rng.normal(size=3)
    a, b = rng.uniform(-4, 4, size=2)
    R = rotation_about(axis, a)
    assert np.allclose(R.T @ R, np.eye(3), rtol=0, atol=ROUND_OFF)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=ROUND_OFF)
    assert np.allclose(R @ unit(axis), unit(axis), rtol=0, atol=ROUND_OFF)
    assert np.allclose(
        R @ rotation_about(axis, b), rotation_about(axis, a + b), rtol=0, atol=ROUND_OFF
    )


def test_frame_is_right_handed_with_its_third_axis_along_the_axis(rng):
    for axis in (*np.eye(3), -E2, *rng.normal(size=(5, 3)), 1e-8 * E1 + E3):
        for towards in (None, rng.normal(size=3)):
            frame = frame_with_axis(axis, towards)
            assert np.allclose(frame.T @ frame, np.eye(3), rtol=0, atol=ROUND_OFF)
            assert np.linalg.det(frame) == pytest.approx(1.0, abs=ROUND_OFF)
            assert np.allclose(frame[:, 2], unit(axis), rtol=0, atol=ROUND_OFF)


def test_first_axis_of_a_frame_points_towards_the_given_direction(rng):
    axis, towards = rng.normal(size=(2, 3))
    t1, t2, n = frame_with_axis(axis, towards).T
    assert t1 @ towards > 0
    assert abs(t2 @ towards) <= ROUND_OFF * np.linalg.norm(towards)
    assert np.allclose(t1 * (t1 @ towards) + n * (n @ towards), towards, rtol=0, atol=4 * ROUND_OFF)


def test_a_frame_cannot_point_along_its_own_axis():
    with pytest.raises(ValueError, match="is parallel to the axis"):
        frame_with_axis((1.0, 2.0, 3.0), (-2.0, -4.0, -6.0))
    with pytest.raises(ValueError):
        frame_with_axis(E1, (0.0, 0.0, 0.0))


def test_the_nearest_rotation_of_a_stretched_one_is_that_rotation(rng):
    R = np.array([rotation_about(rng.normal(size=3), angle) for angle in rng.uniform(0.0, 3.0, 20)])
    A = rng.normal(size=(20, 3, 3))
    stretch = np.eye(3) + A.swapaxes(1, 2) @ A
    assert np.abs(nearest_rotation(R @ stretch) - R).max() <= 100.0 * ROUND_OFF
    mirrored = nearest_rotation(R @ np.diag([1.0, 1.0, -0.1]))
    assert np.linalg.det(mirrored) == pytest.approx(np.ones(20))


def test_what_is_not_finite_has_no_nearest_rotation():
    found = nearest_rotation(
        np.array([np.eye(3), np.full((3, 3), np.inf), np.full((3, 3), np.nan)])
    )
    assert np.array_equal(found[0], np.eye(3))
    assert np.isnan(found[1:]).all()
