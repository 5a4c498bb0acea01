"""Claims about both forms of the augmented joint angle and their discrete gradients."""

import numpy as np
import pytest

from turbine_fenicsx.joints.augmented_angle import (
    FORMS,
    AngleTerms,
    on_right_branch,
    sinc,
    sinc_derivative,
)

FORM_NAMES = ("regular", "paper")
TURN = 2 * np.pi


@pytest.fixture
def rng():
    return np.random.default_rng(15)


def ends(rng, n, largest_step, revolutions=0.0):
    """Random angles at both ends, and c, s near but not on the manifold."""
    T0 = rng.uniform(-np.pi, np.pi, n) + TURN * np.round(rng.uniform(-1, 1, n) * revolutions)
    T1 = T0 + rng.uniform(-largest_step, largest_step, n)
    c0, c1, s0, s1 = rng.uniform(-1.5, 1.5, (4, n))
    return T0, T1, c0, c1, s0, s1


def on_manifold(T0, T1):
    return T0, T1, np.cos(T0), np.cos(T1), np.sin(T0), np.sin(T1)


def value(form, T, c, s):
    """Phi, written down independently."""
    if form == "regular":
        return np.sin(T) * c - np.cos(T) * s
    return c - np.cos(T) - s + np.sin(T)


def defect(form, T0, T1, c0, c1, s0, s1):
    """Left minus right side of the directionality of the discrete gradient."""
    a = FORMS[form](T0, T1, c0, c1, s0, s1)
    step = a.g_c * (c1 - c0) + a.g_s * (s1 - s0) + a.g_T * (T1 - T0)
    return step - (value(form, T1, c1, s1) - value(form, T0, c0, s0))


@pytest.mark.parametrize("form", FORM_NAMES)
@pytest.mark.parametrize("largest_step", [3.0, 1e-1, 1e-3, 1e-6, 1e-12, 0.0])
def test_angle_discrete_gradient_is_directional(rng, form, largest_step):
    # Ten products of numbers of order one: a few 1e-16, with D -> 0 as well as for large D.
    assert np.max(np.abs(defect(form, *ends(rng, 1000, largest_step)))) <= 3e-15


@pytest.mark.parametrize("form", FORM_NAMES)
def test_angle_discrete_gradient_is_directional_after_thousands_of_revolutions(rng, form):
    # The functions take the angle as it is stored, 2e4 rad with a spacing of 4e-12; the mean
    # angle is rounded to that spacing, which the increment times its derivative lets through.
    T0, T1, *_ = ends(rng, 1000, 0.5, revolutions=3000)
    assert np.max(np.abs(T0)) > 1.8e4
    assert np.max(np.abs(defect(form, *on_manifold(T0, T1)))) <= 0.5 * 4e-12


@pytest.mark.parametrize("form", FORM_NAMES)
def test_manifold_is_kept_over_thousands_of_revolutions(form):
    T = 0.3 + TURN * np.arange(0, 5000.0, 7)
    y = FORMS[form](T, T, *(np.full_like(T, f(0.3)) for f in (np.cos, np.cos, np.sin, np.sin)))
    # 2 pi k is stored with the spacing of T, up to 4e-12 at 3e4 rad, and so is the sum.
    assert np.max(np.abs(y.Phi)) <= 1e-11
    assert abs(y.Phi[0]) <= 1e-16


@pytest.mark.parametrize("form", FORM_NAMES)
def test_value_is_the_constraint_and_vanishes_on_the_manifold(rng, form):
    T0, T1, c0, c1, s0, s1 = ends(rng, 100, 1.0)
    a = FORMS[form](T0, T1, c0, c1, s0, s1)
    assert np.allclose(a.Phi, value(form, T1, c1, s1), rtol=0, atol=2e-15)
    assert np.max(np.abs(FORMS[form](*on_manifold(T0, T1)).Phi)) <= 1e-15


@pytest.mark.parametrize("form", FORM_NAMES)
def test_factors_reduce_to_the_gradient_for_no_step(rng, form):
    T, _, c, _, s, _ = ends(rng, 50, 0.0)
    a = FORMS[form](T, T, c, c, s, s)
    for factor, derivative in ((a.g_c, a.Phi_c), (a.g_s, a.Phi_s), (a.g_T, a.Phi_T)):
        assert np.allclose(factor, derivative, rtol=0, atol=1e-15)


@pytest.mark.parametrize("form", FORM_NAMES)
@pytest.mark.parametrize("largest_step", [2.0, 0.03, 1e-5])
@pytest.mark.parametrize(
    ("derivative", "of", "by"),
    [(name, *name.rsplit("_", 1)) for name in AngleTerms._fields if "_" in name[2:]],
)
def test_angle_derivatives_agree_with_finite_differences(
    rng, form, largest_step, derivative, of, by
):
    args = dict(zip(("T0", "T1", "c0", "c1", "s0", "s1"), ends(rng, 50, largest_step), strict=True))
    h, end = 1e-5, f"{by}1"
    plus, minus = (
        getattr(FORMS[form](**(args | {end: args[end] + sign * h})), of) for sign in (1, -1)
    )
    exact = getattr(FORMS[form](**args), derivative)
    # Central difference: h^2/6 times a third derivative of order one, and round-off 1e-16/h.
    assert np.allclose((plus - minus) / (2 * h), exact, rtol=0, atol=1e-10)


def test_regular_form_has_slope_one_everywhere_on_the_manifold():
    T = np.linspace(-10, 10, 2001)
    a = FORMS["regular"](*on_manifold(T, T))
    assert np.max(np.abs(a.Phi_T - 1)) <= 1e-15
    assert np.max(np.abs(a.g_T - 1)) <= 1e-15


def test_slope_of_a_step_is_the_same_at_every_angle_in_the_regular_form_only():
    """The equation of the angle is solved for its multiplier by 1/g_T: it must keep off zero."""
    T0, D = np.linspace(0, TURN, 721), 0.2
    slopes = {name: FORMS[name](*on_manifold(T0, T0 + D)).g_T for name in FORM_NAMES}
    expected = np.cos(D / 2) * np.sin(D / 2) / (D / 2)
    assert np.allclose(slopes["regular"], expected, rtol=0, atol=1e-15)
    assert np.min(np.abs(slopes["paper"])) < 0.01  # angles half a degree apart


def test_paper_form_is_singular_at_minus_45_and_135_degrees():
    T = np.deg2rad([-45.0, 135.0, 315.0, 495.0])
    a = FORMS["paper"](*on_manifold(T, T))
    assert np.max(np.abs(a.Phi_T)) <= 1e-15
    assert np.max(np.abs(a.g_T)) <= 1e-15
    other = np.deg2rad([0.0, 45.0, 90.0, -135.0, 180.0])
    assert np.min(np.abs(FORMS["paper"](*on_manifold(other, other)).Phi_T)) >= 1 - 1e-15


def test_wrong_branch_fulfils_the_constraint_but_is_not_accepted():
    """Roots of the regular form repeat every pi: Phi cannot tell them apart, the check must."""
    T = np.linspace(-3, 3, 25)
    c, s = np.cos(T), np.sin(T)
    for wrong in (T + np.pi, T - np.pi, T + 5 * np.pi):
        assert np.max(np.abs(FORMS["regular"](T, wrong, c, c, s, s).Phi)) <= 5e-15
        for k in range(T.size):
            assert not on_right_branch(np.zeros(1), wrong[k : k + 1], c[k : k + 1], s[k : k + 1])


def test_no_check_saves_the_paper_form_near_its_singular_angle():
    """Its second root 270 degrees - T lies as near to T as T lies to 135 degrees."""
    T = np.deg2rad([130.0])
    c, s, wrong = np.cos(T), np.sin(T), np.deg2rad([140.0])
    assert abs(FORMS["paper"](T, wrong, c, c, s, s).Phi[0]) <= 1e-15
    assert on_right_branch(wrong - T, wrong, c, s)
    assert abs(FORMS["regular"](T, wrong, c, c, s, s).Phi[0]) > 0.1


def test_right_branch_is_accepted_up_to_a_quarter_turn():
    T1, D = np.array([0.4, 1e4]), np.array([1.5, -1.5])
    assert on_right_branch(D, T1, np.cos(T1), np.sin(T1))
    for k in range(2):
        assert not on_right_branch(np.where(np.arange(2) == k, 1.6, 0), T1, np.cos(T1), np.sin(T1))
        assert not on_right_branch(-np.where(np.arange(2) == k, 1.6, 0), T1, np.cos(T1), np.sin(T1))
        flipped = np.where(np.arange(2) == k, -1, 1)
        assert not on_right_branch(0 * D, T1, flipped * np.cos(T1), flipped * np.sin(T1))


def test_no_angle_is_always_accepted_and_a_nan_never():
    none = np.zeros(0)
    assert on_right_branch(none, none, none, none)
    nan, one = np.array([np.nan]), np.ones(1)
    assert not on_right_branch(nan, one, one, one)
    assert not on_right_branch(0 * one, nan, one, one)


def test_sinc_and_its_derivative_are_smooth_through_zero():
    assert sinc(np.zeros(1))[0] == 1.0
    assert sinc_derivative(np.zeros(1))[0] == 0.0
    x = np.concatenate([np.geomspace(1e-12, 3.0, 200), [0.00999, 0.01, 0.01001]])
    x = np.concatenate([-x, x])
    assert np.allclose(sinc(x), np.sin(x) / x, rtol=4e-16, atol=0)
    # -x/3 (1 - x^2/10 + x^4/280 - ...): the power series, which suits all x up to three
    series = sum(
        (-1) ** k * 2 * k * x ** (2 * k - 1) / float(np.prod(np.arange(1.0, 2 * k + 2)))
        for k in range(1, 16)
    )
    # beyond |x| = 0.01 the two terms of the closed form cancel to x^2/3: 1e-16/x = 1e-14
    assert np.allclose(sinc_derivative(x), series, rtol=1e-11, atol=1e-14)
    assert np.allclose(sinc_derivative(-x), -sinc_derivative(x), rtol=1e-15, atol=0)
