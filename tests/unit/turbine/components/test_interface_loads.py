"""Loads at yaw bearing and shaft against free bodies, and in directions that are known."""

from itertools import pairwise

import numpy as np
import pytest

from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.forces.point_force import PointForce
from turbine_fenicsx.forces.torque import Torque
from turbine_fenicsx.foundation.rotations import E1, E2, E3
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.axes import TOWER_AXES, hub_axes, shaft_axes
from turbine_fenicsx.turbine.components.component import Component
from turbine_fenicsx.turbine.components.interface_loads import InterfaceLoads
from turbine_fenicsx.turbine.components.model import build_turbine, list_components
from turbine_fenicsx.turbine.run.run import make_stepper
from turbine_fenicsx.turbine.run.start import list_held, make_start

GRAVITY = -9.81 * E2


class Pull(Component):
    """A force on the hub at the rotor centre, or a torque."""

    def __init__(self, force=(0, 0, 0), torque=(0, 0, 0)):
        self.force, self.torque = force, torque

    def parts(self, assembly):
        hub, centre = assembly.part("hub"), assembly.rotor.layout.centre
        return [
            PointForce("pull", hub, point=centre, force=self.force),
            Torque("twist", hub, torque=self.torque),
        ]


def make_case(**tables):
    tables["turbine"] = {"model": "rigid", **tables.get("turbine", {})}
    return Case.parse({"loads": {"gravity": 0.0}, **tables})


def load(comm, pull, azimuth=0.0):
    """Loads at rest under a pull, and height and distance of the rotor centre."""
    case = make_case(turbine={"azimuth": azimuth})
    turbine = build_turbine(case, comm, [*list_components(case), pull])
    state = make_start(case, turbine.system) or turbine.system.initial_state()
    state = equilibrium(turbine.system, state=state, held=list_held(case, turbine.system))
    _, height, ahead = turbine.rotor.layout.centre
    loads = [InterfaceLoads(turbine, turning).at_rest(state) for turning in (False, True)]
    return np.array(loads), height, -ahead


@pytest.mark.parametrize("frame", [0, 1])
def test_forces_on_the_hub_reach_the_yaw_bearing_as_openfast_counts_them(comm, frame):
    """x downwind, y left, z up; the hub is upwind of the bearing: its weight tips it upwind."""
    cases = {
        (0, 0, 1e3): lambda h, L: ([1e3, 0, 0], [0, 1e3 * h, 0]),
        (1e3, 0, 0): lambda h, L: ([0, 1e3, 0], [-1e3 * h, 0, -1e3 * L]),
        (0, -1e3, 0): lambda h, L: ([0, 0, -1e3], [0, -1e3 * L, 0]),
    }
    for force, expected in cases.items():
        loads, height, ahead = load(comm, Pull(force))
        assert ahead > 0.0
        assert np.allclose(loads[frame, 0], expected(height, ahead), atol=1e-6)


def test_forces_on_the_hub_reach_the_shaft_as_openfast_counts_them(comm):
    """Blade 1 points up at 120 degrees of the joint, and to the right a quarter turn later."""
    up, right = np.radians(120.0), np.radians(210.0)
    for force, fixed in {(0, 0, 1e3): E1, (1e3, 0, 0): E2, (0, -1e3, 0): -E3}.items():
        for azimuth in (up, right):
            loads, _, _ = load(comm, Pull(force), azimuth)
            assert np.allclose(loads[0, 1, 0], 1e3 * fixed, atol=1e-6)
            turning = [fixed[0], *(fixed[1:] if azimuth == up else (fixed[2], -fixed[1]))]
            assert np.allclose(loads[1, 1, 0], 1e3 * np.array(turning), atol=1e-6)
            assert np.allclose(loads[:, 1, 1], 0.0, atol=1e-6)
    for torque, row in ((E3, 0), (E1, 1), (E2, 2)):  # torque, then bending about y and z
        loads, _, _ = load(comm, Pull(torque=1e3 * torque), up)
        assert np.allclose(loads[:, 1, 1], 1e3 * np.eye(3)[row], atol=1e-6)


class Recorder:
    """Momenta, weights and loads of a run; an observer."""

    def __init__(self, turbine):
        self.turbine, self.rows = turbine, []
        self.interfaces = [InterfaceLoads(turbine, turning) for turning in (False, True)]

    def start(self, snapshot, resumed):
        self.observe(snapshot)

    def observe(self, s):
        bodies = {}
        for body in self.turbine.system.rigid_bodies:
            q, v = (
                self.turbine.system.coordinates_of(x)[body].reshape(4, 3)
                for x in (s.state.q, s.state.q_dot)
            )
            p = body.mass * v[0]
            L = np.cross(q[0], p) + np.cross(q[1:].T, body.euler * v[1:].T, axis=0).sum(axis=1)
            bodies[body.name] = (p.copy(), L, q.copy())
        loads = np.array([x.pass_on(x.loads.at(s)) for x in self.interfaces])
        self.rows.append((s.state.time, bodies, loads))

    def finish(self):
        pass


@pytest.fixture(scope="module")
def recorded():
    """A tilted rotor with a shaft that twists, on a nacelle that yaws, under its weight."""
    from mpi4py import MPI

    case = make_case(
        turbine={"tilt": "-6 deg", "rotor_speed": 1.2},
        drivetrain={"model": "two_mass", "ratio": 50.0, "generator_inertia": 500.0}
        | {"stiffness": 8e8, "damping": 6e6, "mass": 1e4},
        loads={"gravity": 9.81, "yaw_torque": 3e7, "rotor_torque": 4e6, "duration": 0.3},
    )
    turbine = build_turbine(case, MPI.COMM_WORLD)
    recorder = Recorder(turbine)
    stepper = make_stepper(case, turbine.system)
    start = make_start(case, turbine.system)
    Simulation(turbine.system, 0.02, 0.3, [recorder], stepper, start=start).run()
    return turbine, recorder.rows


def test_interfaces_carry_what_changes_the_momenta_behind_them(recorded):
    """Weight and momenta of free bodies; the rotor without its shaft, all above the bearing."""
    turbine, rows = recorded
    layout = turbine.rotor.layout
    hub, nacelle = turbine.part("hub"), turbine.part("nacelle")
    rotor = ("hub", "blade_1", "blade_2", "blade_3")
    everything = (*rotor, "nacelle", "generator_rotor")
    cases = [
        (everything, (0, 0), np.zeros(3), TOWER_AXES, None),
        (everything, (1, 0), np.zeros(3), TOWER_AXES, nacelle),
        (rotor, (0, 1), layout.centre, shaft_axes(layout), nacelle),
        (rotor, (1, 1), layout.centre, hub_axes(layout), hub),
    ]
    mass = {body.name: body.mass for body in turbine.system.rigid_bodies}
    for names, k, point, axes, carrier in cases:
        worst = scale = 0.0
        for (t0, first, _), (t1, last, loads) in pairwise(rows):
            middle = {n: 0.5 * (first[n][2] + last[n][2]) for n in (*names, "nacelle")}
            p, L = (sum(last[n][i] - first[n][i] for n in names) / (t1 - t0) for i in (0, 1))
            weights = {n: mass[n] * GRAVITY for n in names}
            force = sum(weights.values()) - p
            moment = sum(np.cross(middle[n][0], weights[n]) for n in names) - L
            r, R = point, axes
            if carrier is not None:
                q = middle[carrier.name]
                r = q[0] + carrier.body_coordinates(point) @ q[1:]
                U, _, V = np.linalg.svd(np.asarray(carrier.directors) @ q[1:])
                R = axes @ U @ V
            expected = np.array([force, moment - np.cross(r, force)]) @ R.T
            worst = max(worst, np.abs(loads[k] - expected).max())
            scale = max(scale, np.abs(expected).max())
        assert worst < 1e-10 * scale > 1e-4, (k, worst / scale)
