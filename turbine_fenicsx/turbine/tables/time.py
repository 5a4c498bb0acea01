"""The tables of time and solver."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import pi
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.quantities import Metres, Number, Seconds, Whole
from turbine_fenicsx.case.rules import AnyOf, Only, With
from turbine_fenicsx.case.section import NotNegative, Positive, Section
from turbine_fenicsx.turbine.tables.loads import HAS_TORQUE

MAX_STEPS = 1e9
"""Steps of a run; a million times as many as the paper's."""

LARGEST_TURN = 0.3
"""Angle of the rotor in a step, of which the midpoint rule misses nearly one per cent [rad]."""


class TimeCase(Section):
    """Time step and end of the run [s], and the integrator.

    ``scheme`` is the energy-momentum scheme of the paper, or the generalised-alpha method, which
    damps high frequencies but conserves neither energy nor momenta: ``spectral_radius`` is what a
    step leaves of a mode of infinite frequency.

    A run starts from the undeformed turbine, its static equilibrium, or the state in which it turns
    at ``turbine.rotor_speed``. ``ramp`` is the time in which all loads but weight set in.

    With a tolerance, steps whose estimated error exceeds it are halved, and grow again up to
    ``step``: of directions of rigid bodies [rad], of displacements [m].
    """

    step: Annotated[Seconds, Positive] = 0.02
    """Time step Δt."""
    end: Annotated[Seconds, NotNegative] = 12.0
    """End of the run; the last step is shortened to meet it."""
    start: Literal["undeformed", "equilibrium", "turning"] = "undeformed"
    """State at t = 0: undeformed, static equilibrium, or turning at ``turbine.rotor_speed``, see
    howto/start."""
    ramp: Annotated[
        Seconds,
        NotNegative,
        AnyOf(*HAS_TORQUE, With("loads.file"), say="without a torque"),
    ] = 0.0
    """Time in which torques set in smoothly; 0 for a sudden start."""
    angle_tolerance: Annotated[Number, Positive] | None = None
    """Largest error of a step in directions of rigid bodies, in rad; none: no limit."""
    displacement_tolerance: Annotated[Metres, Positive] | None = None
    """Largest error of a step in positions; none: no limit."""
    scheme: Literal["energy_momentum", "generalised_alpha"] = "energy_momentum"
    """Integrator: the energy-momentum scheme of the paper, or the generalised-alpha method for
    comparison."""
    spectral_radius: Annotated[
        Number, Field(ge=0.0, lt=1.0), Only("scheme", "generalised_alpha")
    ] = 0.9
    """Spectral radius of the generalised-alpha method: the factor by which one step reduces a mode
    of infinite frequency."""

    @check("step", "end")
    def _check_steps(self, case: Any) -> str:
        """The number of steps is not absurd."""
        if self.end <= MAX_STEPS * self.step:
            return ""
        return (
            f"time.step = {self.step:g}: takes more than {MAX_STEPS:.0e} steps to time.end = "
            f"{self.end:g} s"
        )

    @check("start", "turbine.rotor_speed")
    def _check_start(self, case: Any) -> str:
        """Static equilibrium does not turn."""
        speed = case.turbine.rotor_speed
        if self.start != "equilibrium" or speed == 0.0:
            return ""
        return (
            f'time.start = "equilibrium": expected turbine.rotor_speed = 0, got {speed:g}; '
            '"turning" is the equilibrium of a rotor that turns'
        )

    def find_doubts(self, case: Any) -> Iterator[str]:
        """Several steps must resolve a load, and the run starts as it should."""
        yield from self._doubt_loads(case)
        yield from self._doubt_start(case)
        turn = abs(case.turbine.rotor_speed) * self.step
        if turn > LARGEST_TURN:
            yield (
                f"time.step = {self.step:g} s is long: the rotor turns by "
                f"{turn * 180.0 / pi:.3g} degrees in a step"
            )

    def _doubt_loads(self, case: Any) -> Iterator[str]:
        """Each step looks at a load in its middle."""
        loads, pitch = case.loads, case.pitch
        acting = []
        if any((loads.rotor_torque, loads.yaw_torque, loads.pitch_torque)):
            acting.append(("loads.duration", loads.duration))
        if pitch.drive == "prescribed" and pitch.angle and pitch.file is None:
            acting.append(("pitch.duration", pitch.duration))
        for key, duration in acting:
            if 2.0 * self.step > duration:
                yield (
                    f"time.step = {self.step:g} s is too long to follow {key} = {duration:g} s; "
                    "loads are taken in the middle of each step"
                )

    def _doubt_start(self, case: Any) -> Iterator[str]:
        """Nothing rings at t = 0."""
        start, speed = self.start, case.turbine.rotor_speed
        if start == "turning" and speed == 0.0:
            yield 'time.start = "turning" is the same as "equilibrium" with turbine.rotor_speed = 0'
        if start == "undeformed" and speed and case.turbine.model == "hybrid":
            yield (
                f"turbine.rotor_speed = {speed:g} rad/s: the blades are not yet stretched by the "
                'rotation and begin to vibrate; time.start = "turning" starts without'
            )
        hollow = case.blade.wall is not None or case.turbine.file is not None
        gravity, hybrid = case.loads.gravity, case.turbine.model == "hybrid"
        if start == "undeformed" and gravity and hybrid and hollow:
            yield (
                f'time.start = "undeformed": loads.gravity = {gravity:g} m/s^2 acts on thin walls '
                "suddenly; they then move by their thickness in a step and take many iterations; "
                'time.start = "equilibrium" or "turning" starts without'
            )
        if start != "undeformed" and case.has_pitch_bearings and case.pitch.drive == "free":
            yield (
                f'time.start = "{start}": the pitch bearings are held while the start is found and '
                'let go then; pitch.drive = "lock" keeps them locked'
            )


MAX_TOLERANCE = 1e-5
"""Tolerance above which the energy of a run is not to be trusted."""


class SolverCase(Section):
    """Solver of the step."""

    renamed: ClassVar[Mapping[str, str]] = {"preconditioner": "linear_solver"}  # since 0.2

    linear_solver: Literal["frozen", "iterative", "lu", "monolithic"] = "frozen"
    """Linear solver, see howto/solver."""
    tolerance: Annotated[Number, Field(gt=0.0, lt=1.0)] = 1e-12
    """Relative residual at which an iteration ends."""
    max_iterations: Annotated[Whole, Field(ge=1, le=100_000)] = 30
    """Largest number of Newton iterations of an attempt."""

    def find_doubts(self, case: Any) -> Iterator[str]:
        """Loose steps lose energy, and the check of its balance must allow that."""
        if self.tolerance > MAX_TOLERANCE:
            yield (
                f"solver.tolerance = {self.tolerance:g} is loose: up to a thousandth of the energy "
                f"may be lost without a word; {MAX_TOLERANCE:g} and below keep the balance"
            )
