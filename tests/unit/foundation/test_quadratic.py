"""Claims about affine vectors and quadratic functions of the coordinates.

Oracle: functions written with numpy dot products, and dense matrices built independently.
"""

import numpy as np
import pytest

from turbine_fenicsx.foundation.quadratic import AffineVector, Quadratic, QuadraticMap, dot

SLOTS, SIZE = 5, 15
ROUND_OFF = 2e-14
"""Sums of some dozen products of numbers of order one to three: a hundred times 1.1e-16."""


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def affine(rng, terms=3):
    """An affine vector, and the same as a function of q that knows nothing of the class."""
    constant = rng.normal(size=3)
    slots, factors = rng.integers(0, SLOTS, size=terms), rng.normal(size=terms)  # may repeat
    vector = AffineVector.fixed(constant)
    for k, a in zip(slots, factors, strict=True):
        vector = vector + a * AffineVector.slot(int(k))

    def evaluate(q):
        return constant + sum(a * q[3 * k : 3 * k + 3] for k, a in zip(slots, factors, strict=True))

    return vector, evaluate


def random_map(rng, rows=6):
    """Products of affine vectors, constants, linear and repeated terms; and their oracles."""
    functions, oracles = [], []
    for k in range(rows):
        (v, v_of), (w, w_of) = affine(rng), affine(rng)
        f = dot(v, w)
        if k % 3 == 1:  # a square, whose terms fall on the diagonal
            f, w_of = dot(v, v), v_of
        if k % 3 == 2:  # every operation at once
            f = 2.0 * (f - dot(v, v) * 0.5) + 1.5 - v.components()[1]
            functions.append(f)
            oracles.append(
                lambda q, a=v_of, b=w_of: 2 * (a(q) @ b(q)) - a(q) @ a(q) + 1.5 - a(q)[1]
            )
            continue
        functions.append(f)
        oracles.append(lambda q, a=v_of, b=w_of: a(q) @ b(q))
    return QuadraticMap(functions, SIZE), lambda q: np.array([f(q) for f in oracles])


def test_affine_arithmetic_agrees_with_arithmetic_of_the_vectors(rng):
    (v, v_of), (w, w_of) = affine(rng), affine(rng)
    q = rng.normal(size=SIZE)
    for vector, expected in (
        (v + w, v_of(q) + w_of(q)),
        (v - w, v_of(q) - w_of(q)),
        (v * -2.5, -2.5 * v_of(q)),
        (-2.5 * v, -2.5 * v_of(q)),
    ):
        value = QuadraticMap(vector.components(), SIZE).value(q)
        assert np.allclose(value, expected, rtol=0, atol=ROUND_OFF)


def test_slots_that_cancel_leave_no_trace(rng):
    v = AffineVector.slot(2) - AffineVector.slot(2)
    f = QuadraticMap([dot(v, AffineVector.slot(1))], SIZE)
    assert np.array_equal(f.value(rng.normal(size=SIZE)), [0.0])


def test_values_agree_with_numpy(rng):
    f, oracle = random_map(rng)
    q = rng.normal(size=SIZE)
    assert np.allclose(f.value(q), oracle(q), rtol=0, atol=ROUND_OFF)
    assert np.allclose(f.value(q, f.jacobian(q)), oracle(q), rtol=0, atol=ROUND_OFF)
    assert np.allclose(f.constant, oracle(np.zeros(SIZE)), rtol=0, atol=ROUND_OFF)


def test_jacobian_agrees_with_the_complex_step(rng):
    f, oracle = random_map(rng)
    q, h = rng.normal(size=SIZE), 1e-30  # no subtraction, so no error but round-off
    expected = np.column_stack([oracle(q + 1j * h * e).imag / h for e in np.eye(SIZE)])
    assert np.allclose(f.jacobian(q), expected, rtol=0, atol=ROUND_OFF)


def test_hessian_is_the_derivative_of_the_jacobian(rng):
    f, _ = random_map(rng)
    q, weights = rng.normal(size=SIZE), rng.normal(size=f.shape[0])
    # The Jacobian is affine in q: a difference over a step of one has no truncation error.
    columns = [weights @ (f.jacobian(q + e) - f.jacobian(q)) for e in np.eye(SIZE)]
    H = f.hessian(weights)
    assert np.allclose(H, np.column_stack(columns), rtol=0, atol=10 * ROUND_OFF)
    assert np.allclose(H, H.T, rtol=0, atol=ROUND_OFF)


def test_jacobian_at_the_midpoint_is_an_exact_discrete_gradient(rng):
    f, oracle = random_map(rng)
    for size in (1e-6, 1.0, 1e3):
        q0, q1 = rng.normal(size=(2, SIZE)) * size
        step = f.jacobian(0.5 * (q0 + q1)) @ (q1 - q0)
        scale = np.abs(oracle(q0)) + np.abs(oracle(q1)) + size**2 + 1.0
        assert np.all(np.abs(step - (oracle(q1) - oracle(q0))) <= 5 * ROUND_OFF * scale)


def test_midpoint_jacobian_is_the_mean_of_the_jacobians_at_the_ends(rng):
    f, _ = random_map(rng)
    q0, q1 = rng.normal(size=(2, SIZE))
    mean = 0.5 * (f.jacobian(q0) + f.jacobian(q1))
    assert np.allclose(f.jacobian(0.5 * (q0 + q1)), mean, rtol=0, atol=ROUND_OFF)


def test_a_map_may_have_no_rows_or_no_quadratic_terms(rng):
    q = rng.normal(size=SIZE)
    empty = QuadraticMap([], SIZE)
    assert empty.value(q).shape == (0,) and empty.jacobian(q).shape == (0, SIZE)
    assert np.array_equal(empty.hessian(np.zeros(0)), np.zeros((SIZE, SIZE)))
    linear = QuadraticMap([Quadratic(2.0, ((4, 3.0),))], SIZE)
    assert linear.value(q) == pytest.approx([2.0 + 3.0 * q[4]], rel=1e-15)
    assert np.array_equal(linear.hessian(np.ones(1)), np.zeros((SIZE, SIZE)))
    assert QuadraticMap([Quadratic(2.0)], 0).value(np.zeros(0)) == [2.0]


def test_evaluation_does_not_change_the_coordinates(rng):
    f, _ = random_map(rng)
    q = rng.normal(size=SIZE)
    before = q.copy()
    f.value(q), f.jacobian(q), f.hessian(np.ones(f.shape[0]))
    assert np.array_equal(q, before)
