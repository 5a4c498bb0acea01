"""Claims about the deflections of points."""

from types import SimpleNamespace

import numpy as np
import pytest

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.simulation.observers.tips import Tip, Tips, tip_channel
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel

CORNER = np.array([1.5, 0.25, -0.8])
AXES = rotation_about((1.0, 2.0, -1.0), 0.8)


def moved(m, system, R, shift, bend):
    """A state in which hub and beam have moved together, and the beam by ``bend`` more before."""
    state = system.initial_state()
    q = m.hub.coordinates.reshape(4, 3) @ R.T
    q[0] += shift
    state.q[system.first_coordinate[m.hub] :][:12] = q.ravel()
    X = system.flexible_models[0].positions
    state.u[0].array[:] = ((X + bend) @ R.T + shift - X).ravel()
    return SimpleNamespace(state=state)


def test_deflection_is_what_remains_without_the_motion_of_the_carrier(comm, machine):
    m = machine()
    system = m.system()
    bend = np.array([0.1, -0.2, 0.3])
    for axes in (None, AXES):
        tips = Tips(system, [Tip("1", m.beam, CORNER + 0.01, m.hub, axes)])
        R, shift = rotation_about((3.0, 1.0, 2.0), 2.5), np.array([1.0, -2.0, 0.5])
        still = moved(m, system, R, shift, 0.0 * bend)
        assert np.allclose(tips.at(still), 0.0, rtol=0, atol=1e-14)
        bent = moved(m, system, R, shift, bend)
        rows = np.asarray(m.hub.directors).T if axes is None else axes
        assert np.allclose(tips.at(bent), [rows @ bend], rtol=0, atol=1e-14)
        channel = tip_channel(tips)
        assert channel.columns == ("tip_deflection_1_[m]",)
        assert np.allclose(channel.values(bent), [np.linalg.norm(bend)], rtol=0, atol=1e-14)


def test_deflection_from_the_ground_is_the_displacement(comm, machine):
    m = machine()
    system = MultibodySystem(comm, [m.beam, Coupling("wall", m.beam, m.facets(0.5), None)])
    state = system.initial_state()
    bend = np.array([0.1, -0.2, 0.3])
    state.u[0].array[:] = np.tile(bend, state.u[0].local_size // 3)
    for axes in (None, AXES):
        tips = Tips(system, [Tip("1", m.beam, CORNER, None, axes)])
        expected = bend if axes is None else AXES @ bend
        assert np.allclose(tips.at(SimpleNamespace(state=state)), [expected], rtol=0, atol=1e-15)


def test_mistakes_are_refused_in_a_sentence(comm, machine):
    m = machine()
    system = MultibodySystem(comm, [m.beam, Coupling("wall", m.beam, m.facets(0.5), None)])
    with pytest.raises(ModelError, match="body 'hub' of tip '1' is not among the parts"):
        Tips(system, [Tip("1", m.beam, CORNER, m.hub)])
    with pytest.raises(ModelError, match="body 'beam' of tip '1' is not among the parts"):
        Tips(system, [Tip("1", machine().beam, CORNER, None)])
    with pytest.raises(ValueError, match="point of '1' must be three numbers"):
        Tip("1", m.beam, CORNER[:2], None)
    with pytest.raises(ValueError, match="axes of '1' must be three rows of three numbers"):
        Tip("1", m.beam, CORNER, None, [1, 0, 0])
