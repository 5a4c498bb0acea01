"""Claims about aerodynamic loads on rotors that move: balance, delay, damping, restart."""

from dataclasses import replace

import numpy as np
import pytest
from rosco_blades import iea_blade, nrel_blade
from turning_rotors import (
    CENTRE,
    DT,
    SHAFT,
    SPEED,
    TURN,
    aerodynamics,
    frames,
    line_loads,
    plain_blade,
    run,
    turning,
)

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.section_loads import LineLoad, SectionMotion
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.wind.aerodynamics import RotorAerodynamics
from turbine_fenicsx.wind.inflow import PlacedInflow, SteadyWind
from turbine_fenicsx.wind.rotor import Operation, Rotor, find_section_loads
from turbine_fenicsx.wind.skew import SkewedWake
from turbine_fenicsx.wind.stall import OeyeStall
from turbine_fenicsx.wind.tower_shadow import TowerShadow


@pytest.mark.parametrize("cone", [0.0, 0.06])
@pytest.mark.parametrize("name", ["plain", "nrel", "iea"])
def test_a_wake_in_balance_gives_the_loads_of_the_steady_rotor(name, cone):
    blade = {"plain": plain_blade, "nrel": nrel_blade, "iea": iea_blade}[name]()
    blade = replace(blade, prebend=None, reference=0.25)
    source = aerodynamics(blade, cone)
    steady = find_section_loads(
        Rotor(blade, 3, cone, hub_height=150.0), Operation(SPEED, TURN), np.zeros(1)
    )
    for steps in (0, 40):
        run(source, blade, steps, cone=cone)
        force, _ = source.loads(turning(blade, 0.0, cone), 0.0)
        for found, expected in zip(
            line_loads(source, blade, force, 0.0, cone),
            (steady.normal[0], steady.tangential[0]),
            strict=True,
        ):
            assert np.max(np.abs(found - expected)) <= 1e-9 * np.max(np.abs(expected))


@pytest.mark.parametrize("name", ["plain", "nrel"])
def test_the_wake_finds_its_balance_from_another(name):
    blade = plain_blade() if name == "plain" else replace(nrel_blade(), reference=0.25)
    source, steady = aerodynamics(blade), aerodynamics(blade)
    run(source, blade, 1, pitch=-0.08)
    run(source, blade, 500, first=1, dt=0.5)
    expected, _ = steady.loads(turning(blade, 0.0), 0.0)
    found, _ = source.loads(turning(blade, 0.0), 0.0)
    assert np.max(np.abs(found - expected)) <= 1e-6 * np.max(np.abs(expected))


def test_steps_that_are_far_too_long_do_not_let_the_wake_grow_without_end():
    source, blade = aerodynamics(nrel_blade()), nrel_blade()
    run(source, blade, 1, dt=2.0, pitch=-0.08)
    run(source, blade, 100, first=1, dt=2.0)
    V_y = TURN * np.tile(blade.radius, 3)
    assert np.all(np.abs(source._wake.velocity) <= 1.01 * np.stack([0.0 * V_y + SPEED, V_y], 1))


def test_a_stiff_section_that_flaps_is_damped_by_half_rho_c_v_times_the_lift_slope():
    blade = replace(plain_blade(), twist=np.zeros(20))
    source = aerodynamics(blade, wind=SteadyWind(0.0))
    forces = [source.loads(turning(blade, DT, flap=v), DT)[0] for v in (-0.01, 0.01)]
    normal, _ = line_loads(source, blade, (forces[1] - forces[0]) / 0.02, DT)
    expected = 0.5 * 1.225 * blade.chord * TURN * blade.radius * 2.0 * np.pi
    assert -normal == pytest.approx(expected, rel=0.01)


def test_lift_and_drag_act_at_the_aerodynamic_centre():
    blade = plain_blade()
    here, behind = aerodynamics(blade), aerodynamics(replace(blade, aerodynamic_centre=0.5))
    still = turning(blade, 0.0)
    (F, M), (F_b, M_b) = here.loads(still, 0.0), behind.loads(still, 0.0)
    assert np.max(np.abs(M)) <= 1e-9 * np.max(np.abs(F))
    # a quarter of the chord behind the line: what points to the suction side turns the nose down
    n, (span, way, normal) = len(blade.radius), frames()[0]
    c, s = np.cos(blade.twist)[:, None], np.sin(blade.twist)[:, None]
    lift = np.sum(F_b[:n] * (c * normal + s * way), axis=1)
    assert M_b[:n] @ span == pytest.approx(-0.25 * blade.chord * lift, rel=1e-9)


def test_wind_in_other_axes_is_the_same_wind():
    blade = plain_blade()
    turned = rotation_about((0.0, 1.0, 0.0), 0.4)
    # the model is turned and shifted against the ground
    placed = PlacedInflow(SteadyWind(SPEED, 150.0, shear=0.2), turned.T, (5.0, 6.0, 7.0))
    plain = aerodynamics(blade, wind=SteadyWind(SPEED, 150.0, shear=0.2))
    other = RotorAerodynamics(
        blade, frames() @ turned.T, turned @ SHAFT, turned @ CENTRE + [5.0, 6.0, 7.0], placed
    )
    m = turning(blade, 0.3)
    moved = SectionMotion(
        m.position @ turned.T + [5.0, 6.0, 7.0],
        turned @ m.axes @ turned.T,
        m.velocity @ turned.T,
        m.angular_velocity @ turned.T,
        m.initial @ turned.T + [5.0, 6.0, 7.0],
    )
    expected, _ = plain.loads(m, 0.0)
    found, _ = other.loads(moved, 0.0)
    assert found == pytest.approx(expected @ turned.T, abs=1e-8 * np.max(np.abs(expected)))


def test_a_rotor_at_rest_has_no_wake():
    blade = plain_blade()
    source = aerodynamics(blade)
    still = turning(blade, 0.0)._replace(
        velocity=np.zeros((60, 3)), angular_velocity=np.zeros((60, 3))
    )
    source.accept(still, StepTimes.from_start(0.0, DT))
    assert not np.any(source._wake.velocity)


@pytest.mark.parametrize("pitch", [0.0, 1.57])
def test_steady_wind_on_a_standing_rotor_gives_constant_loads(pitch):
    blade = iea_blade()
    source = aerodynamics(blade, wind=SteadyWind(47.5, 150.0, direction=np.radians(8.0)))
    still = turning(blade, 0.0, pitch=pitch)
    still = still._replace(velocity=0.0 * still.velocity, angular_velocity=0.0 * still.velocity)
    expected, _ = source.loads(still, 0.0)
    for k in range(20):
        source.accept(still, StepTimes.from_start(k * 0.5, 0.5))
    found, _ = source.loads(still, 10.0)
    assert np.array_equal(found, expected)
    # a flat plate of this chord has a drag coefficient of about two
    plates = np.tile(blade.chord, 3) * source._lengths
    assert np.all(np.linalg.norm(found, axis=1) <= 0.5 * 1.225 * 47.5**2 * 2.5 * plates)


def test_a_wake_without_induction_is_none():
    blade = plain_blade()
    source = aerodynamics(blade, induction=False)
    run(source, blade, 3)
    assert not np.any(source._wake.velocity)


EVERYTHING = {
    "stall": OeyeStall(),
    "skew": SkewedWake(),
    "tower": TowerShadow((8.0, 0.0, 0.0), (8.0, 0.0, 145.0), (0.0, 145.0), (5.0, 3.0), drag=0.5),
    "wind": SteadyWind(SPEED, 150.0, shear=0.2, direction=0.3),
}


@pytest.mark.parametrize("options", [{}, EVERYTHING], ids=["plain", "everything"])
def test_loads_go_on_bit_for_bit_from_saved_data(options):
    blade = iea_blade()
    whole, half = aerodynamics(blade, **options), aerodynamics(blade, **options)
    assert isinstance(whole, LineLoad)
    run(whole, blade, 8)
    run(half, blade, 4)
    again = aerodynamics(blade, **options)
    again.restore(half.save())
    run(again, blade, 4, first=4)
    motion = turning(blade, 0.4)
    assert np.array_equal(whole.loads(motion, 0.4), again.loads(motion, 0.4))
    again.restore(RestartData())
    assert not again.save()


def test_steps_that_are_not_accepted_leave_no_trace():
    blade = iea_blade()
    source, other = aerodynamics(blade, **EVERYTHING), aerodynamics(blade, **EVERYTHING)
    run(source, blade, 3)
    run(other, blade, 3)
    for dt in (DT, 0.5 * DT):  # a step that fails, and a shorter one in its place
        times = StepTimes.from_start(3 * DT, dt)
        other.start_step(times)
        other.loads(turning(blade, times.middle, flap=3.0), times.middle)
    run(source, blade, 1, first=3)
    run(other, blade, 1, first=3)
    for found, expected in zip(
        other.save().arrays.values(), source.save().arrays.values(), strict=True
    ):
        assert np.array_equal(found, expected)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"density": 0.0}, "density of the air must be positive, got 0.0"),
        ({"frames": np.zeros((2, 3, 3))}, "need three blades or more, got 2"),
        ({"centre": (1.0, 2.0)}, "centre of the rotor must be three numbers"),
    ],
)
def test_rotors_that_cannot_be_are_refused(change, words):
    given = {"frames": frames(), "shaft": SHAFT, "centre": CENTRE, "inflow": SteadyWind(1.0)}
    with pytest.raises(ModelError, match=words):
        RotorAerodynamics(plain_blade(), **{**given, **change})


def test_axes_of_wind_that_are_not_orthonormal_are_refused():
    with pytest.raises(ModelError, match="axes of the wind must be orthonormal"):
        PlacedInflow(SteadyWind(1.0), 2.0 * np.eye(3), (0, 0, 0))
