"""The Campbell diagram of ``demos/verification/iea22_campbell``: its beam, and what is kept."""

from dataclasses import dataclass

import numpy as np
import pytest
from windio_files import IEA_22, find_turbine


@pytest.fixture(scope="module")
def script(published):
    find_turbine(IEA_22)
    return published.load("iea22_campbell")


@dataclass(frozen=True)
class Uniform:
    """A straight rod along z with stiffness and inertia per length of 1, stiff against stretch."""

    def frames(self, s):
        return np.outer(s, [0.0, 0.0, 1.0]), np.tile(np.eye(3), (len(s), 1, 1))

    def cut(self, s):
        n = len(s)
        K = np.tile(np.diag([1e6, 1e6, 1e6, 100.0, 1.0, 100.0]), (n, 1, 1))
        M = np.tile(np.diag([1.0, 1.0, 1.0, 1e-6, 1e-6, 1e-6]), (n, 1, 1))
        return self.frames(s)[0], np.ones(n), K, M


@pytest.mark.parametrize("speed", [0.0, 4.0, 12.0])
def test_a_uniform_rod_flaps_as_the_ritz_solution_says(published, speed):
    """Bending about y is soft, and moves the rod along x, the axis of the rotor without precone."""
    beam = published.load("iea22_blade", "exact").make_beam(Uniform(), 30)
    rod = published.load("iea22_campbell", "exact").TurningBeam(beam, 0.0, 0.0)
    expected = published.load("rotating_cantilever", "exact").flap(speed)[0]
    assert 2.0 * np.pi * rod.frequencies(speed, 1)[0] == pytest.approx(expected, rel=3e-3)


def test_references_are_those_of_the_turning_beam(published, script):
    found = script.solve_beam(30)
    for name, reference in published.references("iea22_campbell").items():
        assert found[name] == pytest.approx(reference.value, rel=5e-3), name


def test_the_kept_diagram_of_the_solid_agrees_with_the_beam(script):
    kept = script.read_result()
    assert len(kept) == 10 * len({rpm for rpm, _, _ in kept}) >= 60
    assert [row.quantity for row in script.main() if not row.holds] == []
