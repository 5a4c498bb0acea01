"""Claims about the strain coordinates that are chosen from states."""

import numpy as np
import pytest

from turbine_fenicsx.reduction.strain_coordinates import choose_strains, keep_all_strains

M = 7  # vectors, three of them directors
PAIRS = M * (M + 1) // 2
FIRST = np.triu_indices(M)[0] < 3


@pytest.fixture(params=[PAIRS, PAIRS - 6], ids=["full", "singular"])
def stiffness(request):
    """K over many decades, and a viscosity that is zero where K is."""
    rng = np.random.default_rng(0)
    A = rng.standard_normal((PAIRS, request.param)) * np.logspace(0, 4, PAIRS)[:, None]
    B = A @ rng.standard_normal((request.param, request.param))
    return A @ A.T, 1e-3 * B @ B.T


@pytest.fixture
def states():
    return np.random.default_rng(1).standard_normal((9, PAIRS)) / np.logspace(0, 4, PAIRS)


@pytest.mark.parametrize("wanted", [0, 4, 25])
def test_stiffness_and_viscosity_of_small_motions_are_exact(stiffness, states, wanted):
    K, V = stiffness
    W, Z = choose_strains(K, V, states, wanted)
    assert W.shape[1] <= FIRST.sum() + min(wanted, len(states))
    first = np.ix_(FIRST, FIRST)
    size = np.sqrt(np.outer(np.diag(K), np.diag(K)))
    assert np.max(np.abs(W @ W.T - K)[first] / size[first]) < 1e-10
    size = np.sqrt(np.outer(np.diag(V), np.diag(V)))
    assert np.max(np.abs((W * Z) @ W.T - V)[first] / size[first]) < 1e-8


@pytest.mark.parametrize("wanted", [0, 4, 25])
def test_the_energy_is_never_more_than_that_of_all_pairs(stiffness, states, wanted):
    K, _ = stiffness
    W, _ = choose_strains(K, None, states, wanted)
    scale = 1.0 / np.sqrt(np.diag(K))
    left = (K - W @ W.T) * scale * scale[:, None]
    squares = np.linalg.eigvalsh(left)
    assert squares[0] > -1e-10
    if not wanted:
        assert squares[-1] > 1e-3


def test_energies_and_losses_of_the_states_are_exact_if_all_are_kept(stiffness, states):
    """Viscosity too, for rates of strain that the coordinates can make."""
    K, V = stiffness
    W, Z = choose_strains(K, V, states, 25)
    for e in states:
        assert np.sum((W.T @ e) ** 2) == pytest.approx(e @ K @ e, rel=1e-9)
    c = np.random.default_rng(2).standard_normal(W.shape[1])
    e = np.linalg.lstsq(K, W @ c, rcond=1e-13)[0]  # the rate of least energy with these
    assert np.allclose(W.T @ e, c, atol=1e-6)
    assert np.sum(Z * c * c) == pytest.approx(e @ V @ e, rel=1e-5)


def test_all_pairs_make_the_whole_stiffness(stiffness):
    K, V = stiffness
    W, Z = keep_all_strains(K, V)
    scale = 1.0 / np.sqrt(np.diag(K))
    for wanted, found in ((K, W @ W.T), (V, (W * Z) @ W.T)):
        gap = (found - wanted) * scale * scale[:, None]
        assert np.max(np.abs(gap)) < 1e-8 * np.max(np.abs(wanted * scale * scale[:, None]))
