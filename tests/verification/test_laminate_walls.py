"""Walls of laminate of ``demos/verification``: its strips and tubes, and its theories anew."""

import numpy as np
import pytest

from turbine_fenicsx.materials.laminate_theory import laminate_stiffness
from turbine_fenicsx.materials.wall_quadrature import gauss_quadrature

LAYUPS = ("[0]", "[90]", "[45, -45, -45, 45]", "[30]", "sandwich")


@pytest.fixture(scope="module")
def walls(published):
    """The benchmark."""
    return published.load("laminate_walls")


def test_there_is_a_row_for_each_strip_and_tube(published, walls):
    assert tuple(walls.LAYUPS) == LAYUPS
    expected = published.references("laminate_walls")
    strips = {f"{name} {load}" for name in LAYUPS for load in ("pull", "bend")}
    coupled = {"[30] pull, coupled", "[30] bend, coupled"}
    tubes = {*walls.TUBES, "twist", "oval", "vlasov"}
    assert set(expected) == strips | coupled | tubes


@pytest.mark.parametrize("bend", [False, True], ids=["pull", "bend"])
@pytest.mark.parametrize("name", LAYUPS)
def test_strips_stretch_bend_and_twist_as_lamination_theory_says(comm, walls, name, bend):
    """A strip with fibres at an angle shears when it is pulled and twists when it bends."""
    found, theory = walls.bend_strip(name, bend, comm)
    scale = np.max(np.abs(theory[bend]))
    assert np.allclose(found[bend], theory[bend], rtol=0, atol=0.005 * scale)


@pytest.mark.parametrize("bend", [False, True], ids=["pull", "bend"])
def test_lamination_theory_of_the_benchmark_is_that_of_the_package(walls, bend):
    laminate = walls.plies((walls.CARBON, 0.002, 30), (walls.FOAM, 0.01, 0), (walls.METAL, 1e-3, 5))
    A, B, D = laminate_stiffness(laminate)
    load = np.zeros(6)
    load[3 if bend else 0] = 7.0
    expected = np.split(np.linalg.solve(np.block([[A, B], [B, D]]), load), 2)
    assert np.allclose(walls.EXACT.strip(laminate, 7.0, bend), expected, rtol=1e-9, atol=1e-16)


@pytest.mark.parametrize("name", ["straight", "tapered"])
def test_tubes_bend_as_beams(comm, walls, name):
    assert walls.bend_tube(name, comm) == pytest.approx(1.0, abs=0.005)


def test_a_tube_twists_as_a_shaft(comm, walls):
    coarse, fine = (abs(walls.twist_tube(n, comm) - 1.0) for n in (6, 8))
    assert fine < 1e-3
    assert np.log(coarse / fine) / np.log(8 / 6) == pytest.approx(4.0, abs=0.3)


@pytest.mark.slow
def test_thin_tubes_become_oval(comm, walls):
    """With 16 cells around, as with 40; fully integrated the section is five times too stiff."""
    few = walls.pull_oval(16, comm)
    assert few == pytest.approx(0.997, abs=0.03)  # with 24 and more cells
    full = walls.pull_oval(16, comm, quadrature=gauss_quadrature(3, 3, 3))
    assert full < 0.3 * few
