"""Root loads of the blades against d'Alembert: they are what changes the blades' momenta."""

import numpy as np
import pytest
from runs import comm

from turbine_fenicsx.simulation.observers.reactions import Reaction, Reactions
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.axes import blade_axes
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run.run import make_stepper, turbine_channels

LOADS = {"rotor_torque": -3.6e7, "yaw_torque": -3.6e6, "duration": 0.12, "gravity": 9.81}
CASES = {
    "stiff": {"mesh": {"elements": [2, 2, 12]}, "material": {"law": "transversely_isotropic"}},
    "neo-Hooke, quadratic tetrahedra": {
        "mesh": {"cell": "tetrahedron", "elements": [1, 1, 2], "degree": 2},
        "material": {"law": "neo_hooke"},
        "blade": {"length": 20.0, "chord": [2.5, 2.5, 2.0], "thickness": [2.5, 2.5, 2.0]},
    },
}
# The solver leaves residuals of 1e-12 of the terms of its equations; these are sums over nodes.
TOLERANCE = 1e-11
# A rotation from an SVD is a product of some 30 reflections and plane rotations of three terms
# each, and it enters twice: 180 roundings. Found: 14 to 48.
ROUND_OFF = 180 * np.finfo(float).eps
GRAVITY = np.array([0.0, -9.81, 0.0])


class Blades:
    """Momenta of each blade, moments of its nodes' masses, and the root loads; an observer."""

    def __init__(self, case, turbine):
        system, self.layout = turbine.system, plan_rotor(case).layout
        layout = self.layout
        self.system, self.hub = system, system.rigid_bodies[1]
        (self.block,) = system.flexible_models
        spans = np.array([layout.frame(k)[0] for k in (1, 2, 3)])
        self.nearest = np.argmax((self.block.positions - layout.centre) @ spans.T, axis=1)
        self.roots = np.asarray(layout.centre) + case.blade.hub_radius * spans
        pairs = list(zip(system.couplings, self.roots, strict=True))
        self.reactions = Reactions(system, [Reaction(c, r) for c, r in pairs])
        channels = turbine_channels(
            turbine, make_stepper(turbine.case, turbine.system), stress=False
        ).history
        (self.root,) = (c for c in channels if c.columns[0] == "root_force_1_x_[N]")
        self.p, self.L, self.x, self.arms, self.loads, self.in_blade = [], [], [], [], [], []
        self.times, self.directors = [], []
        self.mass = self.per_blade(self.block.nodal_mass)

    def per_blade(self, values):
        """Sums of nodal values over the nodes of each blade."""
        return comm.allreduce(np.array([values[self.nearest == k].sum(axis=0) for k in range(3)]))

    def start(self, snapshot, resumed):
        self.observe(snapshot)

    def observe(self, s):
        momentum = self.block.new_vector()
        self.block.momentum(s.state.v[0], momentum)
        p = momentum.array_r.reshape(-1, 3).copy()
        momentum.destroy()
        x = self.block.positions + s.state.u[0].array_r.reshape(-1, 3)
        self.p.append(self.per_blade(p))
        self.L.append(self.per_blade(np.cross(x, p)))
        self.x.append(self.per_blade(self.block.nodal_mass[:, None] * x))
        phi, *d = self.system.coordinates_of(s.state.q)[self.hub].reshape(4, 3)
        self.arms.append(phi + self.hub.body_coordinates(self.roots) @ np.array(d))
        self.directors.append(np.array(d))
        self.loads.append(self.reactions.at(s).copy())
        self.in_blade.append(np.reshape(self.root.values(s), (3, 2, 3)))
        self.times.append(s.state.time)

    def finish(self):
        self.dt = np.diff(self.times)[:, None, None]
        for name in ("p", "L", "x", "arms", "loads", "in_blade", "directors"):
            setattr(self, name, np.array(getattr(self, name)))


def mean(x):
    """Means over the steps."""
    return 0.5 * (x[1:] + x[:-1])


def size_of_inertia(blades, momentum):
    """Largest of the inertia terms M (x_{n+1} - x_n - dt v_n) 2/dt^2 of the equations of motion."""
    return 2.0 * np.max(np.abs(momentum[1:]) / blades.dt)


@pytest.fixture(scope="module", params=CASES)
def blades(request):
    """Steps during the torques and after, the last one shorter."""
    case = Case.parse({"loads": LOADS, **CASES[request.param]})
    turbine = build_turbine(case, comm)
    blades = Blades(case, turbine)
    stepper = make_stepper(case, turbine.system)
    simulation = Simulation(turbine.system, 0.02, 0.15, [blades], stepper)
    simulation.run()
    stepper.destroy()
    assert len(blades.dt) == 8 and blades.dt[-1] == pytest.approx(0.01)
    return blades


def test_root_force_and_weight_change_the_momentum(blades):
    force = -blades.loads[1:, :, 0]  # on the blade
    weight = blades.mass[:, None] * GRAVITY
    change = np.diff(blades.p, axis=0) / blades.dt
    assert np.max(np.abs(force)) > np.max(np.abs(weight))
    scale = np.max(np.abs(force)) + size_of_inertia(blades, blades.p)
    # measured 1.6e-12 and 7e-14
    assert np.max(np.abs(force + weight - change)) <= TOLERANCE * scale


def test_root_moment_and_weight_change_the_angular_momentum(blades):
    """About the origin, a fixed point: the root force has the lever arm of the root's mean."""
    force, moment = -blades.loads[1:, :, 0], -blades.loads[1:, :, 1]
    weight = np.cross(mean(blades.x), GRAVITY)
    change = np.diff(blades.L, axis=0) / blades.dt
    assert np.max(np.abs(change)) > 0.1 * np.max(np.abs(moment))
    scale = np.max(np.abs(moment)) + size_of_inertia(blades, blades.L)
    error = moment + np.cross(mean(blades.arms), force) + weight - change
    # measured 1.2e-12 and 3e-14
    assert np.max(np.abs(error)) <= TOLERANCE * scale


def test_loads_in_the_frame_of_the_blade_are_the_same_vectors(blades):
    """Turned by the hub's rotation half way between both ends of the step; means of two steps."""
    R0, R1 = blades.directors[:-1], blades.directors[1:]  # directors as rows
    U, _, V = np.linalg.svd(mean(blades.directors))
    R = U @ V
    first_half = R @ R0.transpose(0, 2, 1)
    assert np.max(np.abs(R1 - first_half @ R)) < ROUND_OFF
    for k in range(3):
        A = blade_axes(blades.layout, k + 1)
        assert np.allclose(A @ A.T, np.eye(3), atol=1e-15) and np.linalg.det(A) > 0
        expected = np.einsum("sld,sid,ai->sla", blades.loads[1:, k], R, A)
        h = blades.dt
        expected[1:] = (h[:-1] * expected[:-1] + h[1:] * expected[1:]) / (h[:-1] + h[1:])
        scale = np.max(np.abs(blades.loads[1:, k]), axis=(0, 2))[:, None]
        assert np.max(np.abs(blades.in_blade[1:, k] - expected) / scale) < ROUND_OFF


def test_loads_are_zero_before_the_first_step(blades):
    assert not np.any(blades.loads[0]) and not np.any(blades.in_blade[0])
