"""Places of the sections of a rotor and the loads of the air on them, in NumPy and in C.

`compile_section_air` gives the C code, which does the same in a tenth of the time.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from mpi4py import MPI

import numpy as np

from turbine_fenicsx import _compat
from turbine_fenicsx.forces.section_loads import SectionMotion
from turbine_fenicsx.foundation.c_code import CompiledCode
from turbine_fenicsx.foundation.rotations import cross_rows
from turbine_fenicsx.foundation.rotations import skew as cross_matrix
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind import pitch_rate, shed_wake, stall
from turbine_fenicsx.wind.pitch_rate import PitchRate
from turbine_fenicsx.wind.polar import AngleTable
from turbine_fenicsx.wind.shed_wake import ShedWake
from turbine_fenicsx.wind.stall import OeyeStall

DECLARATION = """
typedef struct {
  int sections, angles, columns;
  const double *starts, *widths, *lower, *change;
  const int *rows;
  const double *chord, *lengths, *area, *middle, *sigma;
  double density, lag, slowest, least, full, none, shares[3], rates[3];
} Air;
void place(const Air *, const double *, const double *, const double *, const double *,
           const double *, const double *, const double *, double, double *, double *);
void find_plane_loads(const Air *, const double *, const double *, const double *, double,
                      double *, double *, double *, double *);
void find_loads(const Air *, double **, const double *, const double *, const double *,
                const double *, const double *, double, double *, double *, double *, double *,
                double *, double *);
"""


class Places(NamedTuple):
    """Sections in a rotor; vectors have the shape (n, 3)."""

    lever: Array  # from the centre of the section to the aerodynamic centre [m]
    span: Array  # unit vector along the bent span, to the tip
    chordwise: Array  # unit vector to the leading edge
    suction: Array  # unit vector to the suction side
    normal: Array  # unit vector through the rotor, downwind
    way: Array  # unit vector along the way of the rotation
    outward: Array  # unit vector from the shaft to the section
    position: Array  # of the aerodynamic centre [m]
    velocity: Array  # of the aerodynamic centre [m/s]
    relative: Array  # angular velocity without the rotation of the rotor [rad/s]


class Rotation(NamedTuple):
    """How the rotor turns: its centre and shaft, shapes (3,), and its speed [rad/s]."""

    centre: Array
    shaft: Array
    speed: float


class AirState(NamedTuple):
    """States of the air at the start of a step, and where in it loads are asked for."""

    attached: Array | None = None  # attached part of the chord, shape (n,) [-]; None in balance
    shed: Array | None = None  # of `ShedWake`, shape (n, 3) [m/s]; None in balance
    duration: float = np.inf  # time since, infinite at rest [s]


class Loads(NamedTuple):
    """Loads on all sections at one moment, and what they follow from."""

    force: Array  # shape (n, 3) [N]
    moment: Array  # about the centre of the section, shape (n, 3) [N m]
    line: Array  # forces for each length of the span, shape (n, 3) [N/m]
    attached: Array  # attached part of the chord in balance, f_st, shape (n,) [-]
    speed: Array  # of the flow across the section, W, shape (n,) [m/s]
    across: Array  # flow across the chord at three quarters of it, v, shape (n,) [m/s]


class SectionFlow(NamedTuple):
    """Flow and line loads of all sections at one moment, each of shape (n,)."""

    attack: Array  # angle of attack [rad]
    inflow: Array  # angle of the flow with the plane of the rotor [rad]
    speed: Array  # of the flow across the section, W [m/s]
    lift: Array  # C_l, with dynamic stall and what turning adds [-]
    drag: Array  # C_d [-]
    normal: Array  # force for each length normal to the chord, to the suction side [N/m]
    tangential: Array  # along the chord, to the leading edge [N/m]
    axial: Array  # normal to the plane of the rotor, downwind [N/m]
    driving: Array  # in this plane, along the way of the section [N/m]
    induction: Array  # a [-]
    swirl: Array  # a' [-]


@dataclass(frozen=True)
class Properties:
    """Properties of sections and air that loads depend on.

    Args:
        table: C_l, C_d, C_m of all sections, and with stall f_st and C_l,inv - C_l,sep.
        chord: Shape (n,) [m].
        lengths: Of the span that each section carries, shape (n,) [m].
        density: Of the air [kg/m^3].
        stall: How long separation takes; None for the lift of the table.
        pitch_rate: Loads that sections have from turning; None for none.
        shed_wake: Vorticity that they shed; None for lift without a delay.
    """

    table: AngleTable
    chord: Array
    lengths: Array
    density: float
    stall: OeyeStall | None
    pitch_rate: PitchRate | None
    shed_wake: ShedWake | None


class SectionAir(Protocol):
    """Places of sections and loads on them, as functions that change nothing."""

    def place(self, motion: SectionMotion, local: Array, rotor: Rotation) -> tuple[Places, Array]:
        """Places of the sections, and their distances from the shaft, shape (n,) [m].

        Args:
            local: Lever, span, direction of the chord and to the suction side of each section in
                the initial configuration, as columns, shape (n, 3, 4).
        """

    def find_plane_loads(self, p: Array, state: AirState) -> tuple[Array, Array, Array, Array]:
        """Loads for each length along chord and suction side and about the span, f_st, W and v.

        Args:
            p: V_forward, V_up and the rate about the span, shape (3, n).
            state: Of the air.
        """

    def find_loads(self, s: Places, wind: Array, w: Array, state: AirState) -> Loads:
        """Loads on sections.

        Args:
            wind: Relative to the sections, without the wake, shape (n, 3) [m/s].
            w: Induced velocities along the normal and against the way, shape (n, 2) [m/s].
            state: Of the air.
        """


class NumpyAir:
    """`SectionAir` of NumPy."""

    def __init__(self, properties: Properties) -> None:
        self._properties = properties
        # times the chord [kg/m^2]
        self._half_density = 0.5 * properties.density * properties.chord

    def place(self, motion: SectionMotion, local: Array, rotor: Rotation) -> tuple[Places, Array]:
        """As of `SectionAir`."""
        centre, shaft, speed = rotor
        lever, span, chordwise, suction = (motion.axes @ local).transpose(2, 0, 1)
        position = motion.position + lever
        arm = position - centre
        arm = arm - (arm @ shaft)[:, None] * shaft
        radius = lengths_of(arm)
        outward = arm / radius[:, None]
        way = outward @ cross_matrix(shaft).T
        normal = cross_rows(span, way)
        normal /= lengths_of(normal)[:, None]
        omega = motion.angular_velocity
        velocity = motion.velocity + cross_rows(omega, lever)
        directions = (lever, span, chordwise, suction, normal, way, outward, position, velocity)
        return Places(*directions, omega - speed * shaft), radius

    def find_plane_loads(self, p: Array, state: AirState) -> tuple[Array, Array, Array, Array]:
        """As of `SectionAir`."""
        of = self._properties
        forward, up, rate = p
        W = np.hypot(forward, up)
        added = None if of.pitch_rate is None else of.pitch_rate.find(rate, forward, W)
        washed, turned, turning = (np.zeros(1),) * 3 if added is None else added
        v = up + washed
        if of.shed_wake is not None and state.shed is not None:
            z = of.shed_wake.follow(state.shed, v, state.duration, W)
            up = up + of.shed_wake.find_velocity(z, v, forward)
        C = of.table(np.arctan2(up + washed, forward)).T
        C_l, C_d, C_m = C[:3]
        f_st = np.ones_like(W)
        if of.stall is not None:  # C_l = C_l,st + (f - f_st)(C_l,inv - C_l,sep)
            f_st, difference = C[3:]
            before = f_st if state.attached is None else state.attached
            f = of.stall.follow(before, f_st, state.duration, of.chord, W)
            C_l = C_l + (f - f_st) * difference
        # q c W is the same for lift, along (up, forward) of the section, and drag, along V
        flow = np.hypot(forward, up)
        q = self._half_density * flow
        along_chord, along_suction = q * (C_l * up - C_d * forward), q * (C_l * forward + C_d * up)
        along_suction = along_suction + of.density * turned
        pitching = q * flow * of.chord * C_m + of.density * turning
        return np.stack([along_chord, along_suction, pitching]), f_st, W, v

    def find_loads(self, s: Places, wind: Array, w: Array, state: AirState) -> Loads:
        """As of `SectionAir`."""
        p = find_plane_flow(s, find_flow(s, wind, w))
        a, *rest = self.find_plane_loads(p, state)
        lengths = self._properties.lengths
        line = a[0][:, None] * s.chordwise + a[1][:, None] * s.suction
        force = lengths[:, None] * line
        moment = cross_rows(s.lever, force) + (lengths * a[2])[:, None] * s.span
        return Loads(force, moment, line, *rest)


class CompiledAir(CompiledCode):
    """`SectionAir` of C code; arguments as of `CompiledCode`."""

    def __init__(self, module: Any, properties: Properties) -> None:
        super().__init__(module)
        self._n = len(properties.chord)
        turning, separating = properties.pitch_rate, properties.stall
        shedding = properties.shed_wake
        table = properties.table
        kept = {
            **{name: getattr(table, name) for name in ("starts", "widths", "lower", "change")},
            "chord": properties.chord,
            "lengths": properties.lengths,
            **({} if turning is None else {"area": turning.area, "middle": turning.middle}),
            **({} if shedding is None else {"sigma": shedding.sigma}),
        }
        self._kept = {
            name: self._address(np.broadcast_to(values, np.shape(values) or (self._n,)))
            for name, values in kept.items()
        }
        self._rows = self._ffi.from_buffer("int[]", table.first.astype(np.int32))
        self._air = self._ffi.new("Air *", {**self._kept, "rows": self._rows})
        air = self._air
        air.sections, air.angles, air.columns = self._n, len(table.starts) + 1, table.columns
        air.density, air.least = properties.density, pitch_rate.MIN_SPEED
        air.slowest, air.full, air.none = stall.SLOWEST, stall.FULL, stall.NONE
        air.shares, air.rates = shed_wake.SHARES.tolist(), shed_wake.RATES.tolist()
        air.lag = 0.0 if separating is None else separating.lag

    def place(self, motion: SectionMotion, local: Array, rotor: Rotation) -> tuple[Places, Array]:
        """As of `SectionAir`."""
        places, radius = np.empty((10, self._n, 3)), np.empty(self._n)
        given = (motion.axes, local, motion.position, motion.velocity, motion.angular_velocity)
        of_all = map(self._address, (*given, rotor.centre, rotor.shaft))
        ends = self._address(places), self._address(radius)
        self._lib.place(self._air, *of_all, rotor.speed, *ends)
        return Places(*places), radius

    def find_plane_loads(self, p: Array, state: AirState) -> tuple[Array, Array, Array, Array]:
        """As of `SectionAir`."""
        loads, (f_st, W, v) = np.empty((3, self._n)), np.empty((3, self._n))
        ends = map(self._address, (loads, f_st, W, v))
        self._lib.find_plane_loads(self._air, self._address(p), *self._give(state), *ends)
        return loads, f_st, W, v

    def find_loads(self, s: Places, wind: Array, w: Array, state: AirState) -> Loads:
        """As of `SectionAir`."""
        found = Loads(*np.empty((3, self._n, 3)), *np.empty((3, self._n)))
        places = [self._address(x) for x in s]
        given = (self._ffi.new("double *[]", places), *map(self._address, (wind, *w.T)))
        ends = map(self._address, found)
        self._lib.find_loads(self._air, *given, *self._give(state), *ends)
        return found

    def _give(self, state: AirState) -> tuple[Any, Any, float]:
        """States as arguments in C."""
        attached, shed = (
            self._ffi.NULL if x is None else self._address(x) for x in (state.attached, state.shed)
        )
        return attached, shed, state.duration


def compile_section_air(properties: Properties) -> SectionAir:
    """Compiled air; that of NumPy where there is no compiler."""
    module = _compat.load_c(MPI.COMM_SELF, Path(__file__).with_suffix(".c"), DECLARATION)
    return NumpyAir(properties) if module is None else CompiledAir(module, properties)


def find_flow(s: Places, wind: Array, w: Array) -> Array:
    """Flow relative to sections, shape (n, 3) [m/s]; arguments as of `SectionAir.find_loads`."""
    return np.asarray(wind - w[:, :1] * s.normal - w[:, 1:] * s.way)


def find_plane_flow(s: Places, V: Array) -> Array:
    """V_forward, V_up and the rate about the span, shape (3, n), for the flow V."""
    return np.stack([-dot(V, s.chordwise), dot(V, s.suction), dot(s.relative, s.span)])


def dot(a: Array, b: Array) -> Array:
    """Scalar products of rows, shape (n,)."""
    return np.asarray(np.einsum("ni,ni->n", a, b))


def lengths_of(a: Array) -> Array:
    """Lengths of rows, shape (n,)."""
    return np.sqrt(dot(a, a))
