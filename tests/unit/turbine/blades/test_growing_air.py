"""Claims about the air that a basis learns from: resultants of the line loads, on the skin."""

import numpy as np
import pytest
from dolfinx import mesh
from reduced_beams import beam
from scipy.integrate import trapezoid

from turbine_fenicsx import Coupling, MultibodySystem, SectionLoads, StationLine
from turbine_fenicsx.forces.section_loads import LineLoad, SectionMotion
from turbine_fenicsx.system.find_stations import find_stations
from turbine_fenicsx.turbine.blades.operating_points import GrowingAir

pytestmark = pytest.mark.parallel


def skin(body):
    """Facets around a beam."""
    return mesh.locate_entities_boundary(
        body.mesh, 2, lambda X: np.isclose(np.abs(X[0]), 0.1) | np.isclose(np.abs(X[1]), 0.15)
    )


def make_air(stations, function=lambda t: t):
    """Air with linear loads from 1 m to 5 m along the span, at places beside it."""
    along = np.linspace(1.0, 5.0, 41)
    places = np.column_stack([along, 0.1 + 0.0 * along, 0.05 * along])
    forces = np.column_stack([0.0 * along, 2.0 + along, 10.0 - along])
    moments = np.column_stack([0.3 * along, 0.0 * along, 0.0 * along])
    return GrowingAir(np.asarray(stations), along, places, forces, moments, function)


@pytest.mark.parametrize("stations", [(1.0, 3.0, 5.0), (1.5, 2.0, 4.0, 4.5), (0.2, 3.1, 5.7)])
def test_forces_and_moments_of_all_stations_are_those_of_the_line(stations):
    air = make_air(stations)
    assert isinstance(air, LineLoad)
    n, rng = len(stations), np.random.default_rng(2)
    centres = np.column_stack([stations, *rng.normal(0.0, 0.1, (2, n))])
    none = np.zeros((n, 3))
    motion = SectionMotion(centres, np.tile(np.eye(3), (n, 1, 1)), none, none, centres)
    F, M = air.loads(motion, 0.5)
    s = np.linspace(1.0, 5.0, 200_001)
    q = np.column_stack([0.0 * s, 2.0 + s, 10.0 - s])
    x = np.column_stack([s, 0.1 + 0.0 * s, 0.05 * s])
    m = np.column_stack([0.3 * s, 0.0 * s, 0.0 * s]) + np.cross(x, q)
    assert F.sum(axis=0) == pytest.approx(0.5 * trapezoid(q, s, axis=0), rel=1e-6)
    about_origin = (M + np.cross(centres, F)).sum(axis=0)
    assert about_origin == pytest.approx(0.5 * trapezoid(m, s, axis=0), rel=1e-3)
    assert np.all(F[:, 1:] > 0.0)


def test_no_station_rests_on_one_row_of_nodes():
    full = MultibodySystem(beam().mesh.comm, [beam()]).flexible_models[0]
    line = find_stations(full, skin(beam()), 40, axis=2)
    assert line.stations == pytest.approx(np.linspace(0.0, 4.0, line.size), abs=1e-12)
    rows = np.linspace(0.0, 4.0, 9)  # of eight cells along the beam
    spacing = line.stations[1]
    beside = np.abs(rows[:, None] - line.stations) < spacing - 1e-12
    assert beside.sum(axis=0).min() >= 2
    assert find_stations(full, skin(beam()), 5, axis=2).size == 5


def test_a_body_takes_the_air_at_the_stations_that_were_found():
    full = MultibodySystem(beam().mesh.comm, [beam()]).flexible_models[0]
    line = find_stations(full, skin(beam()), 40, axis=2)
    source = make_air(line.stations)
    clamp = Coupling("clamp", beam(), skin(beam())[:1], None)
    loads = SectionLoads("air", beam(), [line], source)
    system = MultibodySystem(beam().mesh.comm, [beam(), clamp, loads])
    assert isinstance(loads.lines[0], StationLine)
    assert list(system.section_loads) == ["air"]
