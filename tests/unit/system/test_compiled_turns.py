"""Claims about rotations of sections: compiled code does as NumPy does."""

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.errors import CompilationError
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.system.section_turns import (
    CompiledTurns,
    NumpyTurns,
    compile_section_turns,
)

COMM = MPI.COMM_WORLD
N = 40


@pytest.fixture(scope="module")
def compiled():
    found = compile_section_turns(COMM)
    assert isinstance(found, CompiledTurns)
    return found


def sections(flatness):
    """Turned and strained sections whose moments are 1, 0.04 and a small part of that."""
    rng, sums = np.random.default_rng(3), np.random.default_rng(4).standard_normal((N, 4, 6))
    for of_section in sums:
        A, B = (rotation_about(rng.standard_normal(3), rng.uniform(0.0, 3.0)) for _ in range(2))
        strain = np.eye(3) + 0.01 * rng.standard_normal((3, 3))
        moments = B @ np.diag([1.0, 0.04, 0.04 * flatness]) @ B.T
        of_section[1:, :3] = (A @ strain @ moments).T
    return sums


@pytest.mark.parametrize("flatness", [1.0, 0.3, 1e-3, 1e-9])
def test_rotations_and_spins_are_those_of_numpy(compiled, flatness):
    sums = sections(flatness)
    for found, wanted in zip(compiled.find(sums), NumpyTurns().find(sums), strict=True):
        assert np.allclose(found, wanted, rtol=0.0, atol=1e-11 * np.max(np.abs(wanted)))


def test_spins_of_frames_are_those_of_numpy_and_of_what_turns(compiled):
    sums, w = sections(0.5), np.array([0.3, -1.0, 2.0])
    for found, wanted in zip(compiled.find_spins(sums), NumpyTurns().find_spins(sums), strict=True):
        assert np.allclose(found, wanted, rtol=0.0, atol=1e-11 * np.max(np.abs(wanted)))
    sums[:, :, 3:] = np.cross(w, sums[:, :, :3])
    assert np.allclose(compiled.find_spins(sums)[1], w, rtol=0.0, atol=1e-10)


def test_rotations_are_orthonormal_and_not_reflections(compiled):
    sums = sections(0.1)
    sums[0, 1:, :3] *= np.array([1.0, -1.0, 1.0])
    for A in compiled.find(sums)[0]:
        assert np.allclose(A @ A.T, np.eye(3), rtol=0.0, atol=1e-14)
        assert np.linalg.det(A) > 0.0


def test_what_diverges_is_not_a_number(compiled):
    sums = sections(0.1)
    sums[3] = np.inf
    for found in compiled.find(sums):
        assert np.all(np.isnan(found[3]))
        assert np.all(np.isfinite(found[[2, 4]]))


def test_rows_of_loads_are_those_of_numpy_also_of_views(compiled):
    F, M = np.random.default_rng(5).standard_normal((2, 2 * N, 3))[:, ::2]
    A, inverse, _ = compiled.find(sections(0.1))
    rows = compiled.find_rows(F, M, A, inverse)
    wanted = NumpyTurns().find_rows(F, M, A, inverse)
    assert np.allclose(rows, wanted, rtol=0.0, atol=1e-13 * np.max(np.abs(wanted)))


def test_without_a_compiler_numpy_does_it(monkeypatch):
    def fail(*arguments):
        raise CompilationError("no compiler")

    monkeypatch.setattr(_compat, "compile_c", fail)
    assert isinstance(compile_section_turns(COMM), NumpyTurns)
