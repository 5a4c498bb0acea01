"""Aerodynamic loads on the blades of a rotor with any motion and deformation.

Blade elements see the wind, their own velocity and the induced velocity of the wake. The wake
follows the loads with a delay (`turbine_fenicsx.wind.wake`) and is skewed where the rotor does not
face the wind (`turbine_fenicsx.wind.skew`). Stall has a separate delay
(`turbine_fenicsx.wind.stall`), lift of attached flow has one
(`turbine_fenicsx.wind.shed_wake`), and sections that turn about the span have loads that dampen it
(`turbine_fenicsx.wind.pitch_rate`). Where nothing changes this is the balance of blade elements and
momentum of `turbine_fenicsx.wind.rotor`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.load_states import StateResponse
from turbine_fenicsx.forces.section_loads import SectionMotion
from turbine_fenicsx.foundation.argument_checks import check_array, check_positive
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.rotations import nearest_rotation
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind import plane_slopes
from turbine_fenicsx.wind.aero_blade import AeroBlade, place_blades
from turbine_fenicsx.wind.averaged_polar import average_polars
from turbine_fenicsx.wind.inflow import Inflow
from turbine_fenicsx.wind.momentum import (
    MAX_INDUCTION,
    Annuli,
    find_induction_share,
    induction_of_thrust,
    solve_momentum,
)
from turbine_fenicsx.wind.pitch_rate import PitchRate
from turbine_fenicsx.wind.polar import find_plate_share
from turbine_fenicsx.wind.section_air import (
    AirState,
    Loads,
    Places,
    Properties,
    Rotation,
    SectionAir,
    SectionFlow,
    compile_section_air,
    dot,
    find_flow,
    find_plane_flow,
)
from turbine_fenicsx.wind.section_states import SectionStates
from turbine_fenicsx.wind.shed_wake import ShedWake
from turbine_fenicsx.wind.skew import SkewedWake
from turbine_fenicsx.wind.stall import OeyeStall, tabulate_separation
from turbine_fenicsx.wind.tower_shadow import TowerShadow
from turbine_fenicsx.wind.wake import SHARE, Wake, find_rates, find_time_constants

STATES = ("attached", "shed")
"""States of the air at sections, by the names they are saved with."""

WAKE = "wake"
"""The model whose states are the first."""

MIN_WIND = 0.1
"""Minimum wind through the rotor that carries a wake away [m/s]."""


class _Sections(NamedTuple):
    """All sections at one moment; vectors have the shape (n, 3)."""

    places: Places
    radius: Array  # distance from the shaft, shape (n,) [m]
    shaft: Array  # unit vector along the shaft, downwind, shape (3,)
    wind: Array  # relative to the section, without the wake [m/s]
    speed: float  # of the rotor about the shaft [rad/s]
    omega: Array  # of the sections [rad/s]

    def find_inflow(self) -> tuple[npt.NDArray[np.bool_], Array, Array]:
        """Where there is a wake, V_x along the normals there, and V_y against the way [m/s]."""
        V_x, V_y = dot(self.wind, self.places.normal), -dot(self.wind, self.places.way)
        blown = V_x > MIN_WIND
        return blown, np.where(blown, V_x, 1.0), V_y


class RotorAerodynamics:
    """A `LineLoad` on stations of all blades, one blade after another.

    Wake and stall begin in balance with the loads of the first step.

    Args:
        blade: One of the blades, at its stations.
        frames: For each blade its span, the way of the rotation there, and span x way as rows, in
            the initial configuration without pitch, shape (B, 3, 3).
        shaft: Direction of the shaft there, downwind, shape (3,).
        centre: Rotor centre in the initial configuration, shape (3,) [m].
        inflow: The wind, in the axes of the model.
        density: Of the air [kg/m^3].
        stall: How long separation takes; None for the lift of the polars.
        skew: How much a skewed wake changes induction; None for not at all.
        tower: What the tower does to the wind, in the axes of the model; None for nothing.
        induction: Whether there is a wake. A rotor that hardly turns has none; see
            `turbine_fenicsx.wind.momentum.find_induction_share`.
        pitch_rate: Whether sections that turn about the span have loads from that.
        unsteady: Whether lift of attached flow takes time, by the vorticity that sections shed.

    Raises:
        ModelError: if there are fewer than three blades, whose roots do not define the rotor's
            position.
    """

    def __init__(
        self,
        blade: AeroBlade,
        frames: npt.ArrayLike,
        shaft: npt.ArrayLike,
        centre: npt.ArrayLike,
        inflow: Inflow,
        density: float = 1.225,
        stall: OeyeStall | None = None,
        skew: SkewedWake | None = None,
        tower: TowerShadow | None = None,
        induction: bool = True,
        pitch_rate: bool = True,
        unsteady: bool = True,
    ) -> None:
        B, n = len(np.asarray(frames)), len(blade.radius)
        F = check_array("frames of the blades", frames, (B, 3, 3), "three axes for each blade")
        if B < 3:
            raise ModelError(f"aerodynamics of a rotor need three blades or more, got {B}")
        self._shaft = check_array("shaft of the rotor", shaft, (3,), "three numbers")
        self._shaft = self._shaft / np.linalg.norm(self._shaft)
        self._centre = check_array("centre of the rotor", centre, (3,), "three numbers")
        self._blade, self._inflow, self._B = blade, inflow, B
        self._density = check_positive("density of the air", density)
        self._points, self._axes, stretch = place_blades(blade, F, self._centre)
        self._chord, radius = np.tile(blade.chord, B), np.tile(blade.radius, B)
        solidity = B * self._chord / (2.0 * np.pi * radius)
        self._annuli = Annuli(radius, solidity, B, blade.tip_radius, blade.hub_radius)
        self._lengths = np.tile(blade.parts, B) * stretch
        centre = np.tile(np.broadcast_to(blade.aerodynamic_centre, (n,)), B)
        sigma = np.tile(find_plate_share(blade.table), B)
        turning = PitchRate(sigma, self._chord, centre) if pitch_rate else None
        shedding = ShedWake(sigma, self._chord) if unsteady else None
        self._roots = n * np.arange(B)
        self._states = SectionStates(stall, shedding, self._chord)
        self._skew, self._tower = skew, tower
        self._induction = induction
        self._turning = turning
        self._air = self._compile()
        self._wake: Wake | None = None
        self._state = AirState()
        self._seen: tuple[SectionMotion, float, _Sections] | None = None
        self._local: tuple[Array, Array] | None = None

    def average_polars(self, amplitude: float) -> None:
        """Take polars that are averaged over an amplitude of the angle of attack [rad] from now on.

        Small vibrations of this amplitude see their slopes.
        """
        self._blade = average_polars(self._blade, amplitude)
        self._air = self._compile()

    def _compile(self) -> SectionAir:
        """The air on sections with the polars of the blade."""
        polars, stall, B = self._blade.table, self._states.stall, self._B
        table = (
            polars.tabulate(polars.values, B) if stall is None else tabulate_separation(polars, B)
        )
        of_all = self._chord, self._lengths, self._density, stall, self._turning
        return compile_section_air(Properties(table, *of_all, self._states.shed_wake))

    def start_step(self, times: StepTimes) -> None:
        """States continue to the middle of the step, where loads are asked for."""
        self._state = self._state._replace(duration=0.5 * times.dt)

    def loads(self, motion: SectionMotion, time: float) -> tuple[Array, Array]:
        """Lift, drag and their moments; see `LineLoad.loads`."""
        sections = self._find_sections(motion, time)
        found = self._find_loads(sections, self._find_wake(sections).velocity)
        return found.force, found.moment

    def accept(self, motion: SectionMotion, times: StepTimes) -> None:
        """The states move on by a step."""
        self.start_step(times)
        sections = self._find_sections(motion, times.middle)
        wake = self._find_wake(sections)
        found = self._find_loads(sections, wake.velocity)
        self._state = self._states.follow(self._state, found, times.dt)
        if self._wake is None:
            self._wake = wake
            return
        balanced, a = self._balance(sections, wake.velocity, found.line)
        R, speed = self._blade.tip_radius, self._find_mean_wind(sections)
        self._wake = wake.advance(balanced, times.dt, a, sections.radius, R, speed)

    @property
    def state_models(self) -> tuple[str, ...]:
        """The wake's z and w at each section, then `SectionStates.models`."""
        return (*(WAKE,) * (4 * self._induction), *self._states.models)

    def balance(self, motion: SectionMotion, time: float) -> Array:
        """States after this motion has lasted for long; see `StateLoad.balance`."""
        s = self._find_sections(motion, time)
        w = self._find_balance(s)
        found = self._air.find_loads(s.places, s.wind, self._skew_wake(s, w), AirState())
        of_wake = [(1.0 - SHARE) * w, w] if self._induction else []
        return np.hstack([*of_wake, self._states.balance(found)])

    def read_states(self) -> Array | None:
        """States after the last accepted step; see `StateLoad.read_states`."""
        wake, found = self._wake, self._states.write(self._state)
        if wake is None:
            return None
        z = wake.between - SHARE * wake.balanced
        return np.hstack([z, wake.velocity, *found] if self._induction else [*found])

    def respond(self, motion: SectionMotion, time: float, states: Array) -> StateResponse:
        """Loads and rates of states; see `StateLoad.respond`."""
        s, n = self._find_sections(motion, time), 4 * self._induction
        z, w = np.hsplit(states[:, :n], 2) if n else np.zeros((2, len(states), 2))
        now = self._states.read(states[:, n:])
        found = self._air.find_loads(s.places, s.wind, self._skew_wake(s, w), now)
        rates = [self._states.find_rates(now, found)]
        if n:
            w_qs, a = self._balance(s, w, found.line)
            R, speed = self._blade.tip_radius, self._find_mean_wind(s)
            taus = find_time_constants(a, s.radius, R, speed)
            rates = [*find_rates(z, w, w_qs, taus), *rates]
        return StateResponse(found.force, found.moment, np.hstack(rates))

    def _find_mean_wind(self, s: _Sections) -> float:
        """Mean wind along the normals [m/s]."""
        return abs(float(np.mean(dot(s.wind, s.places.normal))))

    def save(self) -> RestartData:
        """Wake, separation and shed vorticity; nothing before the first step."""
        data = RestartData()
        if self._wake is not None:
            data.add("wake", self._wake.save())
        for name in STATES:
            values = getattr(self._state, name)
            if values is not None:
                data.arrays[name] = values.copy()
        return data

    def restore(self, data: RestartData) -> None:
        """Restore a wake and states, or begin with new ones."""
        wake, found = data.part("wake"), (data.arrays.get(name) for name in STATES)
        self._wake = Wake.restore(wake) if wake else None
        attached, shed = (None if values is None else values.copy() for values in found)
        self._state = AirState(attached, shed, self._state.duration)

    def find_flow(self, motion: SectionMotion, time: float) -> SectionFlow:
        """Flow and line loads of all sections, as in `loads`."""
        s = self._find_sections(motion, time)
        w = self._skew_wake(s, self._find_wake(s).velocity)
        line = self._air.find_loads(s.places, s.wind, w, self._state).line
        V = find_flow(s.places, s.wind, w)
        forward, up, _ = find_plane_flow(s.places, V)
        W = np.hypot(forward, up)
        n, t = dot(line, s.places.suction), dot(line, s.places.chordwise)
        # with q = rho c W/2: t = q (C_l up - C_d forward), n = q (C_l forward + C_d up)
        pressure = 0.5 * self._density * self._chord * W**3
        V_x, V_y = dot(s.wind, s.places.normal), -dot(s.wind, s.places.way)
        return SectionFlow(
            attack=np.arctan2(up, forward),
            inflow=np.arctan2(dot(V, s.places.normal), -dot(V, s.places.way)),
            speed=W,
            lift=_divide(t * up + n * forward, pressure),
            drag=_divide(n * up - t * forward, pressure),
            normal=n,
            tangential=t,
            axial=dot(line, s.places.normal),
            driving=dot(line, s.places.way),
            induction=_divide(w[:, 0], V_x),
            swirl=_divide(w[:, 1], V_y),
        )

    def _find_sections(self, motion: SectionMotion, time: float) -> _Sections:
        """Geometry and wind of all sections; an accepted step asks as its last iteration did."""
        seen = self._seen
        if seen is None or seen[0] is not motion or seen[1] != time:
            self._seen = seen = (motion, time, self._place_sections(motion, time))
        return seen[2]

    def _place_sections(self, motion: SectionMotion, time: float) -> _Sections:
        """As `_find_sections`."""
        before, after = motion.initial[self._roots], motion.position[self._roots]
        turn = fit_rotation(before, after)
        centre = _mean(after) + turn @ (self._centre - _mean(before))
        shaft = turn @ self._shaft
        if self._local is None or self._local[0] is not motion.initial:
            levers = (self._points - motion.initial)[:, :, None]
            self._local = motion.initial, np.concatenate([levers, self._axes], axis=2)
        speed = float(_mean(motion.angular_velocity[self._roots]) @ shaft)
        places, radius = self._air.place(motion, self._local[1], Rotation(centre, shaft, speed))
        air = self._inflow.velocity(places.position, time)
        air = air if self._tower is None else self._tower.disturb(air, places.position)
        wind = air - places.velocity
        return _Sections(places, radius, shaft, wind, speed, motion.angular_velocity)

    def find_slopes(self, motion: SectionMotion, times: StepTimes) -> Array:
        """Derivatives of the loads by an increment of a step; see `SlopedLoad.find_slopes`."""
        s = self._find_sections(motion, times.middle)
        w, places = self._skew_wake(s, self._find_wake(s).velocity), s.places
        V = find_flow(places, s.wind, w)
        slopes = plane_slopes.differentiate(
            lambda p: self._air.find_plane_loads(p, self._state)[0],
            find_plane_flow(places, V),
            self._chord,
        )
        axes, lever = (places.chordwise, places.suction, places.span), places.lever
        spins = s.omega, places.relative
        changes = plane_slopes.find_changes(axes, V, lever, spins, times.dt)
        loads = self._air.find_loads(places, s.wind, w, self._state)
        of_lengths = self._lengths[:, None, None] * (slopes @ changes)
        return plane_slopes.spread(axes, of_lengths, lever, (loads.force, loads.moment))

    def _skew_wake(self, s: _Sections, w: Array) -> Array:
        """Induced velocities along normal and against way, (n, 2), of the wake as it is skewed."""
        if self._skew is None:
            return w
        mean, part = _mean(s.wind), s.radius / self._blade.tip_radius
        induced = float(_mean(w[:, 0]))
        factors = self._skew.find_factors(mean, s.shaft, induced, s.places.outward, part)
        return np.stack([w[:, 0] * factors, w[:, 1]], axis=1)

    def _find_loads(self, s: _Sections, w: Array) -> Loads:
        """Loads on the sections with induced velocities w along normal and against way, (n, 2)."""
        return self._air.find_loads(s.places, s.wind, self._skew_wake(s, w), self._state)

    def _find_wake(self, s: _Sections) -> Wake:
        """The wake as it is, or one in balance with the loads where there is none yet."""
        return Wake.in_balance(self._find_balance(s)) if self._wake is None else self._wake

    def _find_balance(self, s: _Sections) -> Array:
        """Induced velocities of a wake in balance with the loads, (n, 2)."""
        table, shape = self._blade.table, (self._B, -1)
        chordwise = s.places.chordwise
        setting = np.arctan2(-dot(chordwise, s.places.normal), dot(chordwise, s.places.way))

        def lift_and_drag(phi: Array) -> tuple[Array, Array]:
            found = table((phi - setting).reshape(shape))
            return found.lift.ravel(), found.drag.ravel()

        blown, V_x, V_y = s.find_inflow()
        share = self._find_share(s)
        _, a, a_prime = solve_momentum(self._annuli, V_x, V_y, lift_and_drag, share)
        w: Array = np.stack([a * V_x, a_prime * V_y], axis=1) * blown[:, None]
        return w

    def _find_share(self, s: _Sections) -> float:
        """Share of the loads that the wake balances."""
        if not self._induction:
            return 0.0
        wind = float(np.linalg.norm(_mean(s.wind)))
        return find_induction_share(s.speed * self._blade.tip_radius, wind)

    def _balance(self, s: _Sections, w: Array, line: Array) -> tuple[Array, Array]:
        """Induced velocities of a wake in balance with line loads, (n, 2), and a."""
        blown, V_x, V_y = s.find_inflow()
        share = self._find_share(s)
        f_n, f_t = (share * dot(line, axis) for axis in (s.places.normal, s.places.way))
        phi = np.arctan2(V_x - w[:, 0], V_y + w[:, 1])
        F = self._annuli.loss(np.where(np.abs(np.sin(phi)) > 1e-6, phi, 1e-6))
        # B f_n = rho pi r V_x^2 C_T, and B f_t = 4 pi r rho F V_x (1 - a) w_t
        density = self._density * np.pi * self._annuli.radius / self._B
        a: Array = induction_of_thrust(f_n / (density * V_x**2), F)
        a = np.clip(a, -MAX_INDUCTION, MAX_INDUCTION)
        through = np.maximum(V_x - w[:, 0], MIN_WIND)
        limit = MAX_INDUCTION * np.abs(V_y)
        w_t = np.clip(f_t / (4.0 * density * F * through), -limit, limit)
        return np.stack([a * V_x, w_t], axis=1) * blown[:, None], a * blown


def fit_rotation(before: Array, after: Array) -> Array:
    """The rotation that takes points to where they are now, in the mean, shape (3, 3)."""
    return nearest_rotation((after - _mean(after)).T @ (before - _mean(before)))


def _divide(a: Array, b: Array) -> Array:
    """Quotients; zero where nothing flows."""
    return np.divide(a, b, out=np.zeros_like(a), where=b != 0.0)


def _mean(a: Array) -> Array:
    """Mean of rows; quicker for few rows than numpy's."""
    return np.asarray(np.add.reduce(a) / len(a))
