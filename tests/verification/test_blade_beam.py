"""The beam that hollow blades are compared with, against closed forms."""

import sys
from pathlib import Path

import numpy as np
import pytest

from turbine_fenicsx.windio.curves import Curve
from turbine_fenicsx.windio.section_properties import SectionProperties

FOLDER = Path(__file__).parents[2] / "demos" / "verification"
LENGTH, MASS = 40.0, 300.0  # [m], [kg/m]
EA, EI_X, EI_Y, GJ = 2e9, 8e8, 2e8, 3e8  # about x is edgewise [N, N m^2]
RIGID = 1e13  # shear stiffness without shear [N]


@pytest.fixture(scope="module")
def beams():
    """The module under test."""
    sys.path.insert(0, str(FOLDER))
    import published

    yield published.load("iea22_blade", "exact")
    sys.path.remove(str(FOLDER))


def section(shear=RIGID, offset=(0.0, 0.0)):
    """Stiffness and inertia about a point from which the centre of everything is ``offset``."""
    x, y = offset
    K = np.diag([shear, shear, EA, EI_X, EI_Y, GJ])
    M = np.diag([MASS, MASS, MASS, 0.5, 0.3, 0.8])
    # the strain at the centre of a section with the strains e about the other point
    move = np.eye(6)
    move[0, 5], move[1, 5], move[2, 3], move[2, 4] = -y, x, y, -x
    return move.T @ K @ move, move.T @ M @ move


def make_blade(beams, K, M, axis=None, twist=0.0):
    ends = np.array([0.0, 1.0])
    if axis is None:
        axis = [Curve(ends, ends * length) for length in (0.0, 0.0, LENGTH)]
    sections = SectionProperties(ends, np.stack([K, K]), np.stack([M, M]))
    return beams.Blade(tuple(axis), Curve(ends, np.full(2, np.degrees(twist))), sections)


def tip_force(elements, *components):
    force = np.zeros((elements + 1, 6))
    force[-1, : len(components)] = components
    return force


def test_uniform_cantilever_has_the_textbook_frequencies(beams):
    found, _ = beams.make_beam(make_blade(beams, *section()), 200).frequencies(5)
    roots = np.array([1.8751041, 4.6940911, 7.8547574])
    flap, edge = (roots**2 / LENGTH**2 * np.sqrt(EI / MASS) for EI in (EI_Y, EI_X))
    torsion = np.pi / 2.0 / LENGTH * np.sqrt(GJ / 0.8)
    stretch = np.pi / 2.0 / LENGTH * np.sqrt(EA / MASS)
    expected = np.sort([*flap, *edge, torsion, stretch])[:5] / (2.0 * np.pi)
    # rotary inertia takes away up to 4e-5
    assert found == pytest.approx(expected, rel=1e-4)


def test_forces_at_the_tip_bend_one_element_exactly(beams):
    shear = 5e7
    beam = beams.make_beam(make_blade(beams, *section(shear)), 1)
    flap, edge, pull, turn = (beam.bend(tip_force(1, *np.eye(6)[k]))[-1] for k in (0, 1, 2, 5))
    assert flap[0] == pytest.approx(LENGTH**3 / (3.0 * EI_Y) + LENGTH / shear, rel=1e-10)
    assert flap[4] == pytest.approx(LENGTH**2 / (2.0 * EI_Y), rel=1e-10)
    assert edge[1] == pytest.approx(LENGTH**3 / (3.0 * EI_X) + LENGTH / shear, rel=1e-10)
    assert edge[3] == pytest.approx(-(LENGTH**2) / (2.0 * EI_X), rel=1e-10)
    assert pull[2] == pytest.approx(LENGTH / EA, rel=1e-10)
    assert turn[5] == pytest.approx(LENGTH / GJ, rel=1e-10)


def test_a_prebent_axis_bends_like_a_circular_arch(beams):
    """A quarter of a circle in the plane x z; u = F R^3 / E I (pi/4, 1/2) without stretch."""
    radius = LENGTH
    s = np.linspace(0.0, 1.0, 401)
    turned = 0.5 * np.pi * s
    places = (radius * (np.cos(turned) - 1.0), 0.0 * s, radius * np.sin(turned))
    K, M = section()
    K[2, 2] = RIGID
    blade = make_blade(beams, K, M, [Curve(s, place) for place in places])
    beam = beams.make_beam(blade, 40)
    u = beam.bend(tip_force(40, 0.0, 0.0, 1.0))[-1]
    # a force along z at the tip has the lever R (cos a - cos pi/2) at a
    size = radius**3 / EI_Y
    assert u[2] == pytest.approx(np.pi / 4.0 * size, rel=1e-5)
    assert u[0] == pytest.approx(0.5 * size, rel=1e-5)
    # out of the plane it bends and twists
    across = beam.bend(tip_force(40, 0.0, 1.0))[-1, 1]
    bend, twist = np.pi / 4.0 / EI_X, (0.75 * np.pi - 2.0) / GJ
    assert across == pytest.approx(radius**3 * (bend + twist), rel=1e-4)
    assert beam.mass == pytest.approx(MASS * 0.5 * np.pi * radius, rel=1e-5)
    centre = np.array([2.0 / np.pi - 1.0, 0.0, 2.0 / np.pi]) * radius
    assert beam.centre == pytest.approx(centre, abs=1e-4 * radius)


def test_twist_turns_the_weak_axis_towards_the_leading_edge(beams):
    angle = np.radians(20.0)
    beam = beams.make_beam(make_blade(beams, *section(), twist=angle), 2)
    u = beam.bend(tip_force(2, 1.0))[-1]
    weak, stiff = LENGTH**3 / (3.0 * EI_Y), LENGTH**3 / (3.0 * EI_X)
    c, s = np.cos(angle), np.sin(angle)
    assert u[0] == pytest.approx(weak * c**2 + stiff * s**2, rel=1e-6)
    assert u[1] == pytest.approx(-(weak - stiff) * c * s, rel=1e-6)


def test_matrices_about_another_point_describe_the_same_beam(beams):
    shift = np.array([0.3, -0.7])
    here = beams.make_beam(make_blade(beams, *section(5e7)), 20)
    ends = np.array([0.0, 1.0])
    axis = [Curve(ends, np.full(2, -a)) for a in shift]
    axis.append(Curve(ends, np.array([0.0, LENGTH])))
    there = beams.make_beam(make_blade(beams, *section(5e7, shift), axis), 20)
    assert there.mass == pytest.approx(here.mass)
    assert there.centre == pytest.approx(here.centre, abs=1e-9)
    assert there.frequencies(6)[0] == pytest.approx(here.frequencies(6)[0], rel=1e-7)
    sag, moved = (beam.bend(beam.weight(1))[-1] for beam in (here, there))
    assert moved[3:] == pytest.approx(sag[3:], rel=1e-8, abs=1e-9)
    uniform = MASS * beams.GRAVITY
    bending = uniform * LENGTH**4 / (8.0 * EI_X) + uniform * LENGTH**2 / (2.0 * 5e7)
    assert sag[1] == pytest.approx(bending, rel=2e-3)
