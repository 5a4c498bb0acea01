"""Stiff rotors that turn about x, for tests of aerodynamic loads."""

import numpy as np

from turbine_fenicsx import SectionMotion, StepTimes
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.wind.aero_blade import AeroBlade
from turbine_fenicsx.wind.aerodynamics import RotorAerodynamics
from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.polar import Polar

CENTRE, SHAFT = np.array([0.0, 0.0, 150.0]), np.array([1.0, 0.0, 0.0])
SPEED, TURN, DT = 10.0, 0.75, 0.05
ANGLES = np.radians(np.linspace(-180.0, 180.0, 361))


def plain_blade(n=20):
    """A blade of attached flow, C_l = 2 pi sin(alpha) cos(alpha)."""
    lift = 2.0 * np.pi * np.sin(ANGLES) * np.cos(ANGLES)
    polar = Polar("p", ANGLES, lift, 0.01 + 0.0 * ANGLES, 0.0 * ANGLES)
    radius = np.linspace(6.0, 59.0, n)
    twist = np.radians(12.0 * (1.0 - radius / 60.0))
    return AeroBlade(3.0, 60.0, radius, 4.0 - 0.05 * radius, twist, (polar,) * n)


def frames(cone=0.0):
    """Span, way and normal of three blades; the rotor turns about x, downwind."""
    found = []
    for azimuth in 2.0 * np.pi * np.arange(3) / 3.0:
        outward = np.array([0.0, -np.sin(azimuth), np.cos(azimuth)])
        span, way = np.cos(cone) * outward - np.sin(cone) * SHAFT, np.cross(SHAFT, outward)
        found.append([span, way, np.cross(span, way)])
    return np.array(found)


def aerodynamics(blade, cone=0.0, wind=None, **options):
    """Loads on three blades; by default in uniform wind along the shaft."""
    wind = wind or SteadyWind(SPEED, 150.0)
    return RotorAerodynamics(blade, frames(cone), SHAFT, CENTRE, wind, **options)


def turning(blade, time, cone=0.0, pitch=0.0, flap=0.0):
    """Motion of a stiff rotor at 0.75 rad/s; flap is a velocity along the normal [m/s]."""
    F, n = frames(cone), len(blade.radius)
    bend = np.zeros(n) if blade.prebend is None else blade.prebend
    initial = np.concatenate(
        [CENTRE + f[0] * blade.radius[:, None] + f[2] * bend[:, None] for f in F]
    )
    turn = rotation_about(SHAFT, TURN * time)
    position = (initial - CENTRE) @ turn.T + CENTRE
    axes = np.concatenate(
        [np.repeat((turn @ rotation_about(f[0], pitch))[None], n, axis=0) for f in F]
    )
    omega = np.tile(TURN * SHAFT, (3 * n, 1))
    normal = np.repeat(F[:, 2] @ turn.T, n, axis=0)
    velocity = np.cross(omega, position - CENTRE) + flap * normal
    return SectionMotion(position, axes, velocity, omega, initial)


def line_loads(source, blade, force, time, cone=0.0):
    """Along normal and way of the first blade [N/m]."""
    n, turn = len(blade.radius), rotation_about(SHAFT, TURN * time)
    _, way, normal = frames(cone)[0] @ turn.T
    line = force[:n] / source._lengths[:n, None]
    return line @ normal, line @ way


def run(source, blade, steps, first=0, dt=DT, **motion):
    """Accept steps of a turning rotor."""
    for k in range(first, first + steps):
        times = StepTimes.from_start(k * dt, dt)
        source.start_step(times)
        source.accept(turning(blade, times.middle, **motion), times)
