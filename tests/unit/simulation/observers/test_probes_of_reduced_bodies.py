"""Claims about tips and gauges of reduced bodies: they read what the mesh does."""

import numpy as np
import pytest
from reduced_beams import beam, clamped, on_hub, rotor, tip_of

from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.simulation.observers.gauges import Gauge, Gauges
from turbine_fenicsx.simulation.observers.tips import Tip, Tips

pytestmark = pytest.mark.parallel


class Seen:
    """A snapshot of a state alone."""

    def __init__(self, state):
        self.state = state


def bend(state, seed=3):
    """Random vectors, the same on any number of ranks."""
    u, rng = state.u[0], np.random.default_rng(seed)
    values = 0.02 * rng.standard_normal(u.getSize())
    u.array[:] = values[: u.getLocalSize()]
    return state


def on_mesh(system, state, copy):
    """The motion of a copy as that of the full body, in the axes of its mesh."""
    body = system.flexible_bodies[0]
    R = np.asarray(body.placements[copy].rotation)
    u = system.flexible_models[0].expand(state.u[0])[copy] @ R
    full = clamped(beam())
    found, model = full.initial_state(), full.flexible_models[0]
    nearest = np.argmin(
        np.linalg.norm(model.positions[:, None] - body.basis.points[None], axis=2), axis=1
    )
    found.u[0].array[:] = u[nearest].ravel()
    return full, found


@pytest.mark.parametrize("copy", [0, 1, 2])
def test_gauges_read_the_strain_of_the_mesh(copy):
    body = rotor()
    system = on_hub([body])
    state = bend(system.initial_state())
    place = body.placements[copy]
    R, t = np.asarray(place.rotation), np.asarray(place.position)
    where = {"point": (0.0, 0.02, 1.3), "outward": (1.0, 0.1, 0.0), "along": (0.0, 0.3, 1.0)}
    placed = {"point": t + R @ where["point"]}
    placed |= {key: R @ where[key] for key in ("outward", "along")}
    found = Gauges(system, [Gauge("g", body, angle=0.4, **placed)]).at(Seen(state))
    full, of_full = on_mesh(system, state, copy)
    wanted = Gauges(full, [Gauge("g", full.flexible_bodies[0], angle=0.4, **where)])
    assert found == pytest.approx(wanted.at(Seen(of_full)), rel=1e-9)
    assert abs(found[0]) > 1e-3


def test_tips_are_those_of_the_mesh_in_the_frame_of_the_hub():
    body = rotor()
    system = on_hub([body])
    (hub,) = system.rigid_bodies
    state = bend(system.initial_state())
    Q = rotation_about((1.0, 0.0, 0.0), 0.6)
    state.q[3:12] = (np.asarray(hub.directors) @ Q.T).ravel()
    tips = [Tip(str(k), body, tip_of(p), hub) for k, p in enumerate(body.placements)]
    found = Tips(system, tips).at(Seen(state))
    x = body.points + system.flexible_models[0].expand(state.u[0])
    for k, place in enumerate(body.placements):
        row = np.argmin(np.linalg.norm(body.points[k] - tip_of(place), axis=1))
        wanted = (
            np.asarray(hub.directors) @ Q.T @ x[k, row]
            - np.asarray(hub.directors) @ (body.points[k, row])
        )
        assert found[k] == pytest.approx(wanted, abs=1e-12)


def test_a_gauge_that_misses_all_copies_is_refused():
    body = rotor()
    system = on_hub([body])
    gauge = Gauge("g", body, point=(50.0, 0.0, 0.0), outward=(1.0, 0.0, 0.0), along=(0.0, 0.0, 1.0))
    with pytest.raises(ValueError, match=r"gauge 'g': from .* there is no surface of 'blades'"):
        Gauges(system, [gauge])
