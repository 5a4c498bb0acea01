"""Aerodynamic loads on the blades of a rotor with any motion and deformation.

Blade elements see the wind, their own velocity and the induced velocity of the wake. The wake
follows the loads with a delay (`turbine_fenicsx.wind.wake`) and is skewed where the rotor does not
face the wind (`turbine_fenicsx.wind.skew`). Stall has a separate delay
(`turbine_fenicsx.wind.stall`), and sections that turn about the span have loads that dampen it
(`turbine_fenicsx.wind.pitch_rate`). Where nothing changes this is the balance of blade elements and
momentum of `turbine_fenicsx.wind.rotor`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.section_loads import SectionMotion
from turbine_fenicsx.foundation.argument_checks import check_array, check_positive
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.rotations import cross_rows, nearest_rotation
from turbine_fenicsx.foundation.rotations import skew as cross_matrix
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind import plane_slopes
from turbine_fenicsx.wind.aero_blade import AeroBlade
from turbine_fenicsx.wind.inflow import Inflow
from turbine_fenicsx.wind.momentum import (
    MAX_INDUCTION,
    Annuli,
    find_induction_share,
    induction_of_thrust,
    solve_momentum,
)
from turbine_fenicsx.wind.pitch_rate import PitchRate
from turbine_fenicsx.wind.skew import SkewedWake
from turbine_fenicsx.wind.stall import OeyeStall, tabulate_separation
from turbine_fenicsx.wind.tower_shadow import TowerShadow
from turbine_fenicsx.wind.wake import Wake

MIN_WIND = 0.1
"""Minimum wind through the rotor that carries a wake away [m/s]."""


class _Sections(NamedTuple):
    """All sections at one moment; vectors have the shape (n, 3)."""

    lever: Array  # from the centre of the section to the aerodynamic centre [m]
    span: Array  # unit vector along the bent span, to the tip
    chordwise: Array  # unit vector to the leading edge
    suction: Array  # unit vector to the suction side
    normal: Array  # unit vector through the rotor, downwind
    way: Array  # unit vector along the way of the rotation
    shaft: Array  # unit vector along the shaft, downwind, shape (3,)
    outward: Array  # unit vector from the shaft to the section
    radius: Array  # distance from the shaft, shape (n,) [m]
    wind: Array  # relative to the section, without the wake [m/s]
    speed: float  # of the rotor about the shaft [rad/s]
    omega: Array  # of the sections [rad/s]
    relative: Array  # the same without the rotation of the rotor [rad/s]

    @property
    def axes(self) -> tuple[Array, Array, Array]:
        """Along the chord, to the suction side, and along the span."""
        return self.chordwise, self.suction, self.span

    def find_inflow(self) -> tuple[npt.NDArray[np.bool_], Array, Array]:
        """Where there is a wake, V_x along the normals there, and V_y against the way [m/s]."""
        V_x, V_y = _dot(self.wind, self.normal), -_dot(self.wind, self.way)
        blown = V_x > MIN_WIND
        return blown, np.where(blown, V_x, 1.0), V_y


class _Loads(NamedTuple):
    """Loads on all sections at one moment, and what they follow from."""

    force: Array  # shape (n, 3) [N]
    moment: Array  # about the centre of the section, shape (n, 3) [N m]
    line: Array  # forces for each length of the span, shape (n, 3) [N/m]
    attached: Array  # attached part of the chord in balance, f_st, shape (n,) [-]
    speed: Array  # of the flow across the section, W, shape (n,) [m/s]


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
        span, way, normal = np.repeat(F, n, axis=0).swapaxes(0, 1)
        prebend = np.zeros(n) if blade.prebend is None else blade.prebend
        radius, bend = np.tile(blade.radius, B), np.tile(prebend, B)[:, None]
        points = self._centre + radius[:, None] * span + bend * normal
        # sections stand at right angles to the bent span
        slope = np.tile(np.gradient(prebend, blade.radius), B)[:, None]
        stretch = np.sqrt(1.0 + slope * slope)
        span, normal = (span + slope * normal) / stretch, (normal - slope * span) / stretch
        c, s = (f(np.tile(blade.twist, B))[:, None] for f in (np.cos, np.sin))
        chordwise, suction = c * way - s * normal, c * normal + s * way
        self._axes = np.stack([span, chordwise, suction], axis=2)
        self._chord = np.tile(blade.chord, B)
        back = np.broadcast_to(np.subtract(blade.aerodynamic_centre, blade.reference), (n,))
        self._points = points - np.tile(back * blade.chord, B)[:, None] * chordwise
        solidity = B * self._chord / (2.0 * np.pi * radius)
        self._annuli = Annuli(radius, solidity, B, blade.tip_radius, blade.hub_radius)
        self._lengths = np.tile(blade.parts, B) * stretch[:, 0]
        centre = np.tile(np.broadcast_to(blade.aerodynamic_centre, (n,)), B)
        self._pitch_rate = PitchRate(blade.table, self._chord, centre) if pitch_rate else None
        self._half_density = 0.5 * self._density * self._chord  # times the chord [kg/m^2]
        self._roots = n * np.arange(B)
        self._stall, self._skew, self._tower = stall, skew, tower
        self._induction = induction
        polars = blade.table
        self._coefficients = (
            polars.tabulate(polars.values, B) if stall is None else tabulate_separation(polars, B)
        )
        self._wake: Wake | None = None
        self._attached: Array | None = None
        self._half_step = np.inf
        self._seen: tuple[SectionMotion, float, _Sections] | None = None
        self._local: tuple[Array, Array] | None = None

    def start_step(self, times: StepTimes) -> None:
        """Separation continues to the middle of the step, where loads are asked for."""
        self._half_step = 0.5 * times.dt

    def loads(self, motion: SectionMotion, time: float) -> tuple[Array, Array]:
        """Lift, drag and their moments; see `LineLoad.loads`."""
        sections = self._find_sections(motion, time)
        found = self._find_loads(sections, self._find_wake(sections).velocity)
        return found.force, found.moment

    def accept(self, motion: SectionMotion, times: StepTimes) -> None:
        """Wake and separation move on by a step."""
        self._half_step = 0.5 * times.dt
        sections = self._find_sections(motion, times.middle)
        wake = self._find_wake(sections)
        found = self._find_loads(sections, wake.velocity)
        if self._stall is not None:
            before = found.attached if self._attached is None else self._attached
            f_st, W = found.attached, found.speed
            self._attached = self._stall.follow(before, f_st, times.dt, self._chord, W)
        if self._wake is None:
            self._wake = wake
            return
        balanced, a = self._balance(sections, wake.velocity, found.line)
        speed = abs(float(np.mean(_dot(sections.wind, sections.normal))))
        R = self._blade.tip_radius
        self._wake = wake.advance(balanced, times.dt, a, sections.radius, R, speed)

    def save(self) -> RestartData:
        """Wake and separation; nothing before the first step."""
        data = RestartData()
        if self._wake is not None:
            data.add("wake", self._wake.save())
        if self._attached is not None:
            data.arrays["attached"] = self._attached.copy()
        return data

    def restore(self, data: RestartData) -> None:
        """Restore a wake and a separation, or begin with new ones."""
        wake, attached = data.part("wake"), data.arrays.get("attached")
        self._wake = Wake.restore(wake) if wake else None
        self._attached = None if attached is None else attached.copy()

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
        turned = motion.axes @ self._local[1]
        lever, span, chordwise, suction = turned.transpose(2, 0, 1)
        place = motion.position + lever
        arm = place - centre
        arm = arm - (arm @ shaft)[:, None] * shaft
        radius = _lengths(arm)
        outward = arm / radius[:, None]
        way = outward @ cross_matrix(shaft).T
        normal = cross_rows(span, way)
        normal /= _lengths(normal)[:, None]
        velocity = motion.velocity + cross_rows(motion.angular_velocity, lever)
        air = self._inflow.velocity(place, time)
        wind = (air if self._tower is None else self._tower.disturb(air, place)) - velocity
        speed = float(_mean(motion.angular_velocity[self._roots]) @ shaft)
        directions = (lever, span, chordwise, suction, normal, way, shaft, outward)
        omega = motion.angular_velocity
        return _Sections(*directions, radius, wind, speed, omega, omega - speed * shaft)

    def find_slopes(self, motion: SectionMotion, times: StepTimes) -> Array:
        """Derivatives of the loads by an increment of a step; see `SlopedLoad.find_slopes`."""
        s = self._find_sections(motion, times.middle)
        V = self._find_flow(s, self._find_wake(s).velocity)
        a, slopes = plane_slopes.differentiate(
            lambda p: self._find_plane_loads(p)[0], _find_plane_flow(s, V), self._chord
        )
        changes = plane_slopes.find_changes(s.axes, V, s.lever, (s.omega, s.relative), times.dt)
        loads = self._place_loads(s, a)
        return plane_slopes.spread(
            s.axes, self._lengths[:, None, None] * (slopes @ changes), s.lever, loads[:2]
        )

    def _find_flow(self, s: _Sections, w: Array) -> Array:
        """Flow relative to sections, with induced velocities w along normal and against way."""
        axial = w[:, 0]
        if self._skew is not None:
            mean, part = _mean(s.wind), s.radius / self._blade.tip_radius
            induced = float(_mean(axial))
            axial = axial * self._skew.find_factors(mean, s.shaft, induced, s.outward, part)
        return np.asarray(s.wind - axial[:, None] * s.normal - w[:, 1:] * s.way)

    def _find_loads(self, s: _Sections, w: Array) -> _Loads:
        """Loads on the sections with induced velocities w along normal and against way, (n, 2)."""
        a, f_st, W = self._find_plane_loads(_find_plane_flow(s, self._find_flow(s, w)))
        return _Loads(*self._place_loads(s, a), f_st, W)

    def _place_loads(self, s: _Sections, a: Array) -> tuple[Array, Array, Array]:
        """Forces, moments about the centres, and line loads of loads as of `_find_plane_loads`."""
        line = a[0][:, None] * s.chordwise + a[1][:, None] * s.suction
        force = self._lengths[:, None] * line
        moment = cross_rows(s.lever, force) + (self._lengths * a[2])[:, None] * s.span
        return force, moment, line

    def _find_plane_loads(self, p: Array) -> tuple[Array, Array, Array]:
        """Loads for each length along chord and suction side and about the span, f_st and W.

        Args:
            p: V_forward, V_up and the rate about the span, shape (3, n).
        """
        forward, up, rate = p
        W = np.hypot(forward, up)
        added = None if self._pitch_rate is None else self._pitch_rate.find(rate, forward, W)
        washed, turned, turning = (np.zeros(1),) * 3 if added is None else added
        C = self._coefficients(np.arctan2(up + washed, forward)).T
        C_l, C_d, C_m = C[:3]
        if self._stall is None:
            f_st = np.ones_like(W)
        else:  # C_l = C_l,st + (f - f_st)(C_l,inv - C_l,sep)
            f_st, difference = C[3:]
            before = f_st if self._attached is None else self._attached
            f = self._stall.follow(before, f_st, self._half_step, self._chord, W)
            C_l = C_l + (f - f_st) * difference
        # q c W is the same for lift, along (up, forward) of the section, and drag, along V
        q = self._half_density * W
        along_chord, along_suction = q * (C_l * up - C_d * forward), q * (C_l * forward + C_d * up)
        along_suction = along_suction + self._density * turned
        pitching = q * W * self._chord * C_m + self._density * turning
        return np.stack([along_chord, along_suction, pitching]), f_st, W

    def _find_wake(self, s: _Sections) -> Wake:
        """The wake as it is, or one in balance with the loads where there is none yet."""
        if self._wake is not None:
            return self._wake
        table, shape = self._blade.table, (self._B, -1)
        setting = np.arctan2(-_dot(s.chordwise, s.normal), _dot(s.chordwise, s.way))

        def lift_and_drag(phi: Array) -> tuple[Array, Array]:
            found = table((phi - setting).reshape(shape))
            return found.lift.ravel(), found.drag.ravel()

        blown, V_x, V_y = s.find_inflow()
        share = self._find_share(s)
        _, a, a_prime = solve_momentum(self._annuli, V_x, V_y, lift_and_drag, share)
        w = np.stack([a * V_x, a_prime * V_y], axis=1) * blown[:, None]
        return Wake.in_balance(w)

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
        f_n, f_t = share * _dot(line, s.normal), share * _dot(line, s.way)
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


def _find_plane_flow(s: _Sections, V: Array) -> Array:
    """V_forward, V_up and the rate about the span, shape (3, n)."""
    return np.stack([-_dot(V, s.chordwise), _dot(V, s.suction), _dot(s.relative, s.span)])


def _mean(a: Array) -> Array:
    """Mean of rows; quicker for few rows than numpy's."""
    return np.asarray(np.add.reduce(a) / len(a))


def _dot(a: Array, b: Array) -> Array:
    """Scalar products of rows, shape (n,)."""
    return np.asarray(np.einsum("ni,ni->n", a, b))


def _lengths(a: Array) -> Array:
    """Lengths of rows, shape (n,)."""
    return np.sqrt(_dot(a, a))
