"""Surfaces of the rigid parts of a turbine, for pictures."""

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import build_turbine

NREL = {
    "turbine": {"model": "rigid"},
    "blade": {
        "hub_radius": 1.5,
        "length": 61.5,
        "chord": [3.5, 4.6, 1.4],
        "thickness": [3.5, 2, 1],
    },
}


@pytest.mark.parametrize("data", [{"turbine": {"model": "rigid"}}, NREL])
def test_roots_of_the_blades_are_inside_the_hub_which_touches_the_nacelle(data):
    case = Case.parse(data)
    nacelle, hub, *blades = build_turbine(case, MPI.COMM_SELF).surfaces()
    centre = np.asarray(plan_rotor(case).layout.centre)
    radius = np.linalg.norm((hub.points - centre)[:, :2], axis=1).max()
    for blade in blades:
        distance = np.linalg.norm(blade.points - centre, axis=1)
        root = distance < case.blade.hub_radius + 0.5 * case.blade.chord[0]
        assert distance[root].max() <= radius * (1.0 + 1e-3)
    assert nacelle.points[:, 2].min() < hub.points[:, 2].max()
    assert nacelle.points[:, 2].max() > 0.0  # behind the tower axis
