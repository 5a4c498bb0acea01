"""Claims about the motion of material points."""

import numpy as np
import pytest
from seen import Seen

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import E3, rotation_about
from turbine_fenicsx.simulation.observers.history import History
from turbine_fenicsx.simulation.observers.points import Point, Points, point_channel
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.start import initial_motion

pytestmark = pytest.mark.parallel

INSIDE = [(0.93, 0.11, -1.05), (1.5, 0.25, -0.8), (1.0, 0.0, -1.0), (0.5, -0.25, -0.9)]
"""Points of the beam: in a cell, a corner, between two cells, on an edge."""

SPIN = 3.0


def followed(m, where=INSIDE):
    points = [Point(f"p{k}", m.beam, X) for k, X in enumerate(where)]
    return [*points, Point("hub", m.hub, (0.3, 0.2, 0.1)), Point("mass", m.nacelle, (0, 0, 0))]


def places(points):
    return np.array([p.position for p in points])


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
@pytest.mark.parametrize("degree", [1, 2])
def test_points_start_where_they_are_and_move_with_the_rotor(machine, cell, degree):
    m = machine(cell=cell, degree=degree)
    system = m.system()
    state = initial_motion(system, {"rotor": SPIN, "yaw": 0.0})
    points = followed(m)
    motion = Points(system, points).motion(state)
    X = places(points)
    v = np.cross(SPIN * E3, X)
    v[-1] = 0.0
    assert np.allclose(motion[:, 0], X, rtol=0, atol=1e-14)
    assert np.allclose(motion[:, 1], v, rtol=0, atol=1e-13)


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
@pytest.mark.parametrize("degree", [1, 2])
def test_fields_are_interpolated_in_the_cell_of_a_point(machine, cell, degree):
    """A polynomial of the degree of the body is met everywhere, not at nodes only."""
    m = machine(cell=cell, degree=degree)
    system = m.system()
    state = system.initial_state()
    A = np.random.default_rng(3).normal(size=(3, 3, 3))

    def field(X):
        return np.einsum("ijk,nj,nk->ni", A, X, X) if degree == 2 else X @ A[0].T + 0.3

    X = system.flexible_models[0].positions
    state.u[0].array[:], state.v[0].array[:] = field(X).ravel(), -2.0 * field(X).ravel()
    motion = Points(system, followed(m)).motion(state)[: len(INSIDE)]
    expected = field(np.array(INSIDE))
    assert np.allclose(motion[:, 0] - INSIDE, expected, rtol=0, atol=1e-13)
    assert np.allclose(motion[:, 1], -2.0 * expected, rtol=0, atol=1e-13)


def test_a_point_of_a_rigid_body_turns_with_it(machine):
    m = machine()
    system = m.system()
    state = system.initial_state()
    R, shift = rotation_about((3.0, 1.0, 2.0), 2.5), np.array([1.0, -2.0, 0.5])
    q = m.hub.coordinates.reshape(4, 3) @ R.T
    q[0] += shift
    state.q[system.first_coordinate[m.hub] :][:12] = q.ravel()
    (motion,) = Points(system, [Point("p", m.hub, (0.3, 0.2, 0.1))]).motion(state)
    assert np.allclose(motion[0], R @ (0.3, 0.2, 0.1) + shift, rtol=0, atol=1e-14)


def test_velocities_are_those_of_the_positions(machine, shared_tmp_path, comm):
    """In a step x_1 - x_0 = dt (v_0 + v_1)/2, for rigid and flexible bodies."""
    m = machine()
    system = m.system()
    points = Points(system, followed(m))
    seen = Seen(lambda snapshot: points.at(snapshot).copy())
    path = shared_tmp_path / "history.csv"
    observers = [seen, History(comm, path, [point_channel(points)])]
    start = initial_motion(system, {"rotor": SPIN})
    Simulation(system, 0.01, 0.05, observers, start=start).run()
    x, v = np.array(seen.values).transpose(2, 0, 1, 3)
    # the sizes are one, and the increments are divided by dt
    assert np.allclose(np.diff(x, axis=0) / 0.01, 0.5 * (v[1:] + v[:-1]), rtol=0, atol=1e-12)
    names, *rows = path.read_text().split()
    assert names.split(",")[:6] == [
        *(f"position_p0_{i}_[m]" for i in (1, 2, 3)),
        *(f"velocity_p0_{i}_[m/s]" for i in (1, 2, 3)),
    ]
    table = np.array([row.split(",") for row in rows], dtype=float)
    assert np.array_equal(table, np.array(seen.values).reshape(6, -1))


def test_a_point_outside_its_body_is_refused(machine):
    m = machine()
    system = m.system()
    words = (
        r"point 'p' at \[1.6, 0.25, -0.8\] is outside flexible body 'beam', whose nearest node is "
        r"0.1 m away"
    )
    with pytest.raises(ValueError, match=words):
        Points(system, [Point("p", m.beam, (1.6, 0.25, -0.8))])


def test_mistakes_are_refused_in_a_sentence(machine):
    m = machine()
    with pytest.raises(ValueError, match="position of 'p' must be three numbers, got"):
        Point("p", m.beam, (1.0, np.nan, 0.0))
    with pytest.raises(TypeError, match="'p' needs a rigid or flexible body, got None"):
        Point("p", None, (1.0, 0.0, 0.0))
    with pytest.raises(ModelError, match="body 'beam' of point 'p' is not among the parts"):
        Points(m.system(), [Point("p", machine().beam, (1.0, 0.0, -1.0))])
