"""Claims about loads of sections that turn about their span: thin aerofoils, damping, cylinders."""

from dataclasses import replace

import numpy as np
import pytest
from turning_rotors import (
    ANGLES,
    TURN,
    aerodynamics,
    frames,
    plain_blade,
    run,
    turning,
)

from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.polar import Polar

RATE, DENSITY = 1e-4, 1.225
STILL = {"wind": SteadyWind(0.0), "induction": False}


def straight_blade(**changes):
    """Flat plates of 2 m without twist and drag."""
    blade, none = plain_blade(), 0.0 * ANGLES
    plate = Polar("plate", ANGLES, blade.polars[0].lift, none, none)
    given = {"polars": (plate,) * 20, **changes}
    return replace(blade, twist=np.zeros(20), chord=np.full(20, 2.0), **given)


def loads_per_rate(blade, pitch=0.0, **options):
    """Lift along the suction side [N s/m] and moment about the span [N m s/m] per length and rate.

    Sections turn about their reference, in flow from their rotation alone.
    """
    source = aerodynamics(blade, **STILL, **options)
    motion, n = turning(blade, 0.0, pitch=pitch), len(blade.radius)
    span, way, normal = frames()[0]
    suction = np.cos(pitch) * normal - np.sin(pitch) * way
    found = []
    for rate in (-RATE, RATE):
        spin = np.repeat(rate * frames()[:, 0], n, axis=0)
        F, M = source.loads(motion._replace(angular_velocity=motion.angular_velocity + spin), 0.0)
        lengths = source._lengths[:n]
        found.append(((F[:n] @ suction) / lengths, (M[:n] @ span) / lengths))
    return tuple((after - before) / (2.0 * RATE) for before, after in zip(*found, strict=True))


@pytest.mark.parametrize("centre", [0.25, 0.31])
@pytest.mark.parametrize("axis", [0.2, 0.35, 0.5])
@pytest.mark.parametrize("behind", [False, True])
def test_a_flat_plate_that_turns_has_the_loads_of_thin_aerofoils(axis, centre, behind):
    blade = straight_blade(reference=axis, aerodynamic_centre=centre)
    if behind:  # the flow comes from behind, where a plate has its centre too
        blade = replace(blade, aerodynamic_centre=1.0 - centre)
    lift, moment = loads_per_rate(blade, pitch=np.pi if behind else 0.0)
    V, b = TURN * blade.radius, 0.5 * blade.chord
    a = (-1.0 if behind else 1.0) * (2.0 * axis - 1.0)
    # 2 pi rho V b (b (1/2 - a)) of circulation at the aerodynamic centre, pi rho V b^2 behind it
    circulation = 2.0 * np.pi * DENSITY * V * b**2 * (0.5 - a)
    turned = np.pi * DENSITY * V * b**2
    side = -1.0 if behind else 1.0
    assert lift == pytest.approx(side * (circulation + turned), rel=1e-3)
    to_centre = a + (1.0 - 2.0 * centre)
    expected = b * (circulation * to_centre - turned * (0.5 - a))
    assert moment == pytest.approx(expected, rel=1e-3, abs=1e-3 * np.max(b * turned))
    if centre == 0.25 and axis < 0.5 and not behind:
        theodorsen = 2.0 * np.pi * DENSITY * V * b**3 * a * (0.5 - a)
        assert moment == pytest.approx(theodorsen, rel=1e-3)
        assert np.all(moment < 0.0)


def test_without_pitch_rate_a_plate_turns_about_its_aerodynamic_centre_without_any_load():
    lift, moment = loads_per_rate(straight_blade(), pitch_rate=False)
    assert np.max(np.abs(lift)) < 1e-6
    assert np.max(np.abs(moment)) < 1e-6


def test_a_cylinder_that_turns_has_no_load_from_it():
    polar = Polar("c", ANGLES, 0.0 * ANGLES, 0.5 + 0.0 * ANGLES, 0.0 * ANGLES)
    blade = straight_blade(reference=0.5, aerodynamic_centre=0.5, polars=(polar,) * 20)
    for found in loads_per_rate(blade):
        assert np.max(np.abs(found)) < 1e-6


def test_a_bent_rotor_that_turns_steadily_has_no_load_from_it():
    bent = replace(plain_blade(), prebend=np.linspace(0.0, -3.0, 20) ** 2 / 3.0)
    found = []
    for pitch_rate in (True, False):
        source = aerodynamics(bent, cone=0.06, pitch_rate=pitch_rate)
        run(source, bent, 3, cone=0.06)
        found.append(source.loads(turning(bent, 0.3, 0.06), 0.3)[0])
    assert np.max(np.abs(found[0] - found[1])) < 1e-10 * np.max(np.abs(found[1]))


def test_the_wind_takes_energy_from_torsion():
    # of any small rate about 35 % of the chord, in a rotor that turns in wind
    blade = replace(plain_blade(), reference=0.35)
    n, spans = len(blade.radius), frames()[:, 0]
    motion = turning(blade, 0.0)
    source = aerodynamics(blade)
    run(source, blade, 1)
    powers = []
    for rate in (-1e-3, 1e-3):
        spin = np.repeat(rate * spans, n, axis=0)
        moved = motion._replace(angular_velocity=motion.angular_velocity + spin)
        _, M = source.loads(moved, 0.0)
        powers.append(np.sum(M * spin, axis=1))
    assert np.all(np.sum(powers, axis=0) < 0.0)
