"""Claims about the clearance of blade tips: distances from the yaw axis, which is the nacelle's."""

from types import SimpleNamespace

import numpy as np
import pytest

from turbine_fenicsx.foundation.rotations import E2, rotation_about
from turbine_fenicsx.simulation.observers.tips import Tip
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.flexible_blades import YawDistances
from turbine_fenicsx.turbine.components.model import build_turbine

CASE = {"mesh": {"elements": [1, 1, 2]}, "turbine": {"tilt": "-5 deg"}}


def find_at(distances, state):
    """Distances in a state."""
    return distances.at(SimpleNamespace(state=state))


@pytest.mark.parallel
def test_tips_below_the_bearing_are_as_far_as_the_axis_others_as_the_bearing(comm):
    turbine = build_turbine(Case.parse(CASE), comm)
    blades, state = turbine.part("blades"), turbine.system.initial_state()
    tips = [Tip(str(k), blades, x, None) for k, x in enumerate(turbine.rotor.tips)]
    distances = YawDistances(turbine, tips)
    x = np.array(turbine.rotor.tips)
    assert np.sum(x[:, 1] < 0.0) == 2
    expected = [np.hypot(p[0], p[2]) if p[1] < 0.0 else np.linalg.norm(p) for p in x]
    found = find_at(distances, state)
    assert found == pytest.approx(expected, rel=0.01)  # the node that is nearest to each tip
    # the tower bends, and all turns: nothing changes
    R, t = rotation_about(E2, 0.4) @ rotation_about((1.0, 0.0, 0.0), 0.1), np.array([3.0, -1, 2])
    for first in turbine.system.first_coordinate.values():
        q = state.q[first : first + 12].reshape(4, 3)
        q[:] = q @ R.T
        q[0] += t
    X = turbine.system.flexible_models[0].positions
    state.u[0].array[:] = (X @ R.T + t - X).ravel()
    assert find_at(distances, state) == pytest.approx(found, rel=1e-12)
