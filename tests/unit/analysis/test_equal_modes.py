"""Claims about modes of equal eigenvalues: what comes out does not depend on what was found."""

from dataclasses import replace

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx import MultibodySystem, RigidBody
from turbine_fenicsx.analysis.equal_modes import separate_equal_modes
from turbine_fenicsx.analysis.mode import Mode, Modes, Motion

pytestmark = pytest.mark.parallel

MASSES = np.array([2.0, 1.0, 1.0, 4.0])


def inner(a, b):
    return float(a.q @ (MASSES * b.q))


def motion(q):
    return Motion(np.asarray(q, dtype=float), np.zeros(0), ())


def a_mode(s, a, b=None, **more):
    return Mode(s, motion(a), None if b is None else motion(b), **more)


def modes_of(*found):
    system = MultibodySystem(MPI.COMM_WORLD, [RigidBody("b", 1.0, (1.0, 1.0, 1.0))])
    return Modes(system.initial_state(), tuple(found))


def features(mode):
    """Entries 1, 2, 3, 0, one after the other."""
    b = 0.0 if mode.imaginary is None else 1j * mode.imaginary.q
    q = mode.real.q + b
    return [q[k : k + 1] for k in (1, 2, 3, 0)]


def unit(k):
    q = np.zeros(4)
    q[k] = 1.0 / np.sqrt(MASSES[k])
    return q


@pytest.mark.parametrize("seed", range(4))
def test_equal_modes_are_told_apart_by_their_features(seed):
    rng = np.random.default_rng(seed)
    Q, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    basis = np.array([unit(0), unit(1), unit(3)])
    noise = 1e-10 * rng.standard_normal(3)
    found = [a_mode(5j * (1 + n), row @ basis) for row, n in zip(Q, noise, strict=True)]
    told = separate_equal_modes(modes_of(a_mode(2j, unit(2)), *found), features, inner).modes
    for mode, k in zip(told, (2, 1, 3, 0), strict=True):
        assert mode.real.q == pytest.approx(unit(k), abs=1e-12)
        assert mode.imaginary is None


def test_what_one_feature_does_not_tell_apart_the_next_one_does():
    both = (unit(2) + unit(1)) / np.sqrt(2), (unit(2) - unit(1)) / np.sqrt(2)
    found = modes_of(*(a_mode(5j, q) for q in both))

    def equal_first(mode):
        return [mode.real.q[1:3], mode.real.q[2:3]]

    told = separate_equal_modes(found, equal_first, inner).modes
    assert [m.real.q for m in told] == [pytest.approx(unit(k), abs=1e-12) for k in (2, 1)]


def test_round_off_in_a_feature_tells_nothing_apart():
    both = (unit(2) + unit(1)) / np.sqrt(2), (unit(2) - unit(1)) / np.sqrt(2)
    found = modes_of(*(a_mode(5j, q) for q in both))
    noise = iter([np.array([3e-10]), np.array([-7e-10])])
    told = separate_equal_modes(
        found, lambda mode: [next(noise), mode.real.q[2:3], mode.real.q[1:2]], inner
    ).modes
    assert [m.real.q for m in told] == [pytest.approx(unit(k), abs=1e-12) for k in (2, 1)]


def test_modes_of_unequal_eigenvalues_only_get_a_sign():
    q = 0.6 * unit(1) - 0.8 * unit(3)
    told = separate_equal_modes(modes_of(a_mode(5j, -q), a_mode(5.001j, q)), features, inner).modes
    assert [m.real.q for m in told] == [pytest.approx(q, abs=1e-14)] * 2


def test_rigid_modes_are_one_group_whatever_round_off_makes_of_their_eigenvalues():
    both = (unit(2) + unit(1)) / np.sqrt(2), (unit(2) - unit(1)) / np.sqrt(2)
    found = modes_of(*(a_mode(s, q, is_rigid=True) for s, q in zip((1e-5, 2e-5j), both)))  # noqa: B905
    told = separate_equal_modes(found, features, inner).modes
    assert [m.real.q for m in told] == [pytest.approx(unit(k), abs=1e-12) for k in (1, 2)]
    assert all(m.is_rigid for m in told)


@pytest.mark.parametrize("phase", [0.3, 2.0, -1.1])
def test_a_motion_of_two_parts_gets_the_phase_at_which_its_feature_is_largest(phase):
    z = np.exp(1j * phase) * (0.6 * unit(1) + 0.8j * unit(3))
    (told,) = separate_equal_modes(modes_of(a_mode(5j, z.real, z.imag)), features, inner).modes
    assert told.real.q == pytest.approx(0.6 * unit(1), abs=1e-14)
    assert told.imaginary.q == pytest.approx(0.8 * unit(3), abs=1e-14)


def test_equal_motions_of_two_parts_are_told_apart():
    rng = np.random.default_rng(1)
    A = rng.standard_normal((2, 2)) + 1j * rng.standard_normal((2, 2))
    Q, _ = np.linalg.qr(A)
    whirls = np.array([unit(1) + 1j * unit(0), unit(2) + 1j * unit(3)]) / np.sqrt(2)
    found = [a_mode(-0.1 + 5j, (row @ whirls).real, (row @ whirls).imag) for row in Q]
    told = separate_equal_modes(modes_of(*found), features, inner).modes
    for mode, z in zip(told, whirls, strict=True):
        assert mode.real.q + 1j * mode.imaginary.q == pytest.approx(z, abs=1e-12)
        assert inner(mode.real, mode.real) + inner(mode.imaginary, mode.imaginary) == pytest.approx(
            1
        )


def test_state_and_speed_stay():
    modes = replace(modes_of(a_mode(5j, unit(1))), joint="rotor", speed=1.2)
    told = separate_equal_modes(modes, features, inner)
    assert (told.state, told.joint, told.speed) == (modes.state, "rotor", 1.2)
