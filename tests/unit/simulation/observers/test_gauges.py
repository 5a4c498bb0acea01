"""Strain gauges read the stretch of fibres in the surface."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.simulation.observers.gauges import Gauge, Gauges, gauge_channel
from turbine_fenicsx.simulation.snapshot import Snapshot

pytestmark = pytest.mark.parallel

KINDS = [("hexahedron", 1), ("hexahedron", 2), ("tetrahedron", 1), ("tetrahedron", 2)]
INSIDE = np.array([0.93, 0.11, -1.05])
"""A point of the beam, which is 1 m x 0.5 m x 0.4 m."""


def look(system, state):
    """A snapshot that holds no more than a state."""
    return Snapshot(0, state, None, None, None, 0.0, 0.0, None, 0.0, None)


def read(m, gauges, motion):
    """What gauges read when each X of the beam is at motion(X)."""
    system = m.system()
    state = system.initial_state()
    X = system.flexible_models[0].positions
    state.u[0].array[:] = (motion(X) - X).ravel()
    return Gauges(system, gauges).at(look(system, state))


@pytest.mark.parametrize(("cell", "degree"), KINDS)
def test_homogeneous_deformation_is_read_exactly(machine, cell, degree):
    m = machine(cell=cell, degree=degree)
    F = np.eye(3) + 0.1 * np.random.default_rng(4).normal(size=(3, 3))
    outwards = np.array([(0, 0, 1), (0, 1, 0), (0, 0, -1), (0, 0, 1)], dtype=float)
    along = np.array([(1, 0, 0), (1, 0, 0), (1, 2, 0), (1, 0, 5)], dtype=float)
    gauges = [
        Gauge(f"g{k}", m.beam, point=INSIDE, outward=o, along=a)
        for k, (o, a) in enumerate(zip(outwards, along, strict=True))
    ]
    t = along - np.sum(along * outwards, axis=1)[:, None] * outwards  # turned into the surface
    t /= np.linalg.norm(t, axis=1)[:, None]
    expected = np.linalg.norm(t @ F.T, axis=1) - 1.0
    assert read(m, gauges, lambda X: X @ F.T) == pytest.approx(expected, abs=1e-13)


def test_angle_is_positive_about_the_outward_normal(machine):
    m = machine()
    F = np.array([[1.0, 0.02, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    up, down = (0, 0, 1), (0, 0, -1)
    gauges = [
        Gauge(f"{side}{a}", m.beam, point=INSIDE, outward=side, along=(1, 0, 0), angle=a)
        for side in (up, down)
        for a in (np.pi / 4, -np.pi / 4)
    ]
    found = read(m, gauges, lambda X: X @ F.T)
    stretched = np.hypot(1.02, 1.0) / np.sqrt(2.0) - 1.0
    squeezed = np.hypot(0.98, 1.0) / np.sqrt(2.0) - 1.0
    assert found == pytest.approx([stretched, squeezed, squeezed, stretched], abs=1e-13)


def test_rotations_are_not_read(machine):
    m, R = machine(), rotation_about((1.0, -2.0, 0.5), 2.0)
    gauge = Gauge("g", m.beam, point=INSIDE, outward=(0, 0, 1), along=(1, 0, 0), angle=0.3)
    assert read(m, [gauge], lambda X: X @ R.T + [3, 4, 5]) == pytest.approx([0.0], abs=1e-14)


def test_bending_is_read_on_both_sides(machine):
    """A beam rolled up around e2 with the curvature k is stretched by -k z."""
    m, k = machine(cell="hexahedron", degree=2), 1e-4
    gauges = [
        Gauge(str(d), m.beam, point=INSIDE, outward=(0, 0, d), along=(1, 0, 0)) for d in (1.0, -1.0)
    ]

    def roll(X):
        return X + k * np.stack([-X[:, 0] * X[:, 2], 0.0 * X[:, 0], 0.5 * X[:, 0] ** 2], axis=1)

    top, bottom = read(m, gauges, roll)
    assert top - bottom == pytest.approx(-0.4 * k, rel=1e-3)


def test_where_cells_meet_the_mean_is_read(machine):
    """Strains of linear cells jump: between two of them the gauge does not depend on the ranks."""
    m = machine(cell="hexahedron", degree=1)
    edge = [1.0, 0.07, -1.05]
    gauges = [
        Gauge(f"g{x}", m.beam, point=[x, *edge[1:]], outward=(0, 0, 1), along=(1, 0, 0))
        for x in (0.9, 1.0, 1.1)
    ]

    def bend(X):
        return X + np.stack([0.01 * X[:, 0] ** 2, 0.0 * X[:, 0], 0.0 * X[:, 0]], axis=1)

    left, between, right = read(m, gauges, bend)
    assert left < right - 1e-4
    assert between == pytest.approx(0.5 * (left + right), rel=1e-12)


def test_columns_are_named_after_the_gauges(machine):
    m = machine()
    system = m.system()
    gauges = Gauges(
        system, [Gauge("flap", m.beam, point=INSIDE, outward=(0, 0, 1), along=(1, 0, 0))]
    )
    channel = gauge_channel(gauges)
    assert channel.columns == ("strain_flap_[-]",)
    assert channel.row(look(system, system.initial_state())) == pytest.approx([0.0], abs=1e-14)


def test_what_cannot_be_placed_is_told(machine):
    m = machine()
    system = m.system()
    with pytest.raises(ModelError, match=r"gauge 'g': from .* there is no surface of 'beam'"):
        Gauges(
            system, [Gauge("g", m.beam, point=(0.0, 9.0, 0.0), outward=(0, 1, 0), along=(1, 0, 0))]
        )
    with pytest.raises(ModelError, match=r"along = \[0\.0, 0\.0, 2\.0\] is across the surface"):
        Gauges(system, [Gauge("g", m.beam, point=INSIDE, outward=(0, 0, 1), along=(0, 0, 2))])
    with pytest.raises(ModelError, match="outward of gauge 'g' must not be zero"):
        Gauge("g", m.beam, point=INSIDE, outward=(0, 0, 0), along=(1, 0, 0))
    with pytest.raises(ModelError, match="angle of gauge 'g' must be a finite number"):
        Gauge("g", m.beam, point=INSIDE, outward=(0, 0, 1), along=(1, 0, 0), angle=np.nan)
    with pytest.raises(ModelError, match="gauge 'g'"):
        Gauges(
            machine().system(),
            [Gauge("g", m.beam, point=INSIDE, outward=(0, 0, 1), along=(1, 0, 0))],
        )
