"""Claims about twists of sections: they are seen from the carrier, in reduced bodies as in full."""

from types import SimpleNamespace

import numpy as np
import pytest
from reduced_beams import beam, clamped, on_hub, rotor

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.simulation.observers.section_turns import Section, SectionTurns

pytestmark = pytest.mark.parallel

PLACES = (0.7, 2.6)


def sections(body, carrier=None, copy=0, R=None, t=(0.0, 0.0, 0.0)):
    """Two sections of a beam, or of a copy that stands at t + R X."""
    axis = np.array([0.0, 0.0, 1.0]) if R is None else np.asarray(R)[:, 2]
    where = {"origin": t, "axis": 2.0 * axis, "half_width": 0.1, "carrier": carrier, "copy": copy}
    return [Section(f"at {s}", body, distance=s, **where) for s in PLACES]


def at(turns, state):
    """Angles in a state."""
    return turns.at(SimpleNamespace(state=state))


def test_a_beam_that_is_twisted_evenly_has_the_twist_of_each_place():
    system = clamped(beam())
    turns, state = SectionTurns(system, sections(beam())), system.initial_state()
    assert at(turns, state) == pytest.approx(0.0, abs=1e-12)
    rate, X = 0.2, system.flexible_models[0].positions
    angle = rate * X[:, 2]
    x, y = X[:, 0], X[:, 1]
    turned = [np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y, X[:, 2]]
    state.u[0].array[:] = (np.array(turned).T - X).ravel()
    # nodes stand half a metre apart, so that a section lies a little beside its place
    assert at(turns, state) == pytest.approx(rate * np.array(PLACES), abs=0.25 * rate)
    bent = rotation_about((1.0, 0.0, 0.0), 0.3)
    state.u[0].array[:] = (X @ bent.T - X).ravel()
    assert at(turns, state) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("copy", [0, 2])
def test_reduced_bodies_have_the_twist_of_their_mesh_seen_from_their_carrier(copy):
    body = rotor()
    system = on_hub([body])
    place, state = body.placements[copy], system.initial_state()
    hub = system.rigid_bodies[0]
    seen = sections(body, hub, copy, place.rotation, place.position)
    turns = SectionTurns(system, seen)
    values = 0.02 * np.random.default_rng(3).standard_normal(state.u[0].getSize())
    state.u[0].array[:] = values[: state.u[0].getLocalSize()]
    found = at(turns, state)
    u = system.flexible_models[0].expand(state.u[0])[copy] @ np.asarray(place.rotation)
    full = clamped(beam())
    positions = full.flexible_models[0].positions
    nearest = np.argmin(
        np.linalg.norm(positions[:, None] - body.basis.points[None], axis=2), axis=1
    )
    of_full = full.initial_state()
    of_full.u[0].array[:] = u[nearest].ravel()
    assert found == pytest.approx(at(SectionTurns(full, sections(beam())), of_full), abs=1e-9)
    assert np.all(np.abs(found) > 1e-5)
    # all turns with the hub: the twist stays
    R = rotation_about((0.3, -0.5, 0.8), 0.6)
    q = state.q[:12].reshape(4, 3)
    q[:] = q @ R.T
    z = system.flexible_models[0].vectors(state.u[0].array_r).reshape(-1, 3)
    state.u[0].array[:] = (z @ R.T - system.flexible_models[0].positions).ravel()
    assert at(turns, state) == pytest.approx(found, abs=1e-9)


def test_a_body_of_another_system_is_refused():
    with pytest.raises(ModelError, match=r"section 'at 0\.7'"):
        SectionTurns(on_hub([rotor()]), sections(beam()))
