"""Modes: small motions of a system about an equilibrium, y(t) = Re[(a + i b) exp(s t)]."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from petsc4py import PETSc

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.state import State

_MOST = 6
"""Modes that are printed at most."""

LEAST_GROWTH = 1e-10
"""Least part of an eigenvalue that is growth; a smaller one is round-off of undamped modes."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A small motion of all parts of a system.

    Args:
        q: Of the coordinates of the rigid bodies, shape (12 bodies,), the same on every rank.
        joint_coordinates: Of the joint coordinates, shape (n_T,), the same on every rank.
        u: Of the displacement of each flexible body, distributed.
    """

    q: Array
    joint_coordinates: Array
    u: tuple[PETSc.Vec, ...]

    def destroy(self) -> None:
        """Free the distributed vectors. Collective."""
        for vector in self.u:
            vector.destroy()


@dataclass(frozen=True)
class Whirl:
    """Parts of the modal mass of a rotor that go round with its rotation, against it, or not.

    Args:
        forward: Of the patterns that go round as the rotor turns.
        backward: Of those that go round against it.
        collective: Of what all blades do alike.
        others: Of patterns that do not reach what carries the rotor; none with three blades.
    """

    forward: float
    backward: float
    collective: float
    others: float = 0.0

    @property
    def name(self) -> str:
        """The largest part: forward, backward, collective, or reactionless for the others."""
        parts = (self.forward, self.backward, self.collective, self.others)
        return ("forward", "backward", "collective", "reactionless")[parts.index(max(parts))]


@dataclass(frozen=True, eq=False)
class Mode:
    """One mode, of unit modal mass: the sum of a.M a + b.M b is 1 kg m^2 (lengths in m).

    Args:
        eigenvalue: s with a positive or no imaginary part [rad/s].
        real: The part a.
        imaginary: The part b; None where all parts move in phase.
        is_rigid: Whether nothing is strained and nothing holds it: the frequency is zero.
        whirl: How the rotor goes round, seen from what carries it; None except in multiblade
            coordinates of a rotor that turns.
    """

    eigenvalue: complex
    real: Motion
    imaginary: Motion | None = None
    is_rigid: bool = False
    whirl: Whirl | None = None

    def __repr__(self) -> str:
        """Its frequency, its damping, and how the rotor goes round."""
        whirl = f", {self.whirl.name}" if self.whirl else ""
        kind = ", rigid" if self.is_rigid else ""
        return f"Mode: {self.frequency:.6g} Hz, damping ratio {self.damping_ratio:.3g}{kind}{whirl}"

    @property
    def frequency(self) -> float:
        """Frequency of the vibration [Hz], with its damping; zero where nothing vibrates."""
        return self.eigenvalue.imag / (2.0 * pi)

    @property
    def damping_ratio(self) -> float:
        """Part of critical damping; negative for a motion that grows."""
        size = abs(self.eigenvalue)
        return 0.0 if self.is_rigid or not size else -self.eigenvalue.real / size

    @property
    def is_unstable(self) -> bool:
        """Whether the motion grows, by more than the round-off of its frequency."""
        growth = self.eigenvalue.real
        return not self.is_rigid and growth > LEAST_GROWTH * abs(self.eigenvalue)

    def destroy(self) -> None:
        """Free the distributed vectors. Collective."""
        self.real.destroy()
        if self.imaginary is not None:
            self.imaginary.destroy()


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of a system about a state, by rising frequency.

    Args:
        state: The equilibrium, or the state of steady rotation.
        modes: The modes.
        joint: Joint about whose axis the system turns, None at rest.
        speed: Speed of that rotation [rad/s].
        blades: Number of blades of the rotor whose motion is in multiblade coordinates, as seen
            from what does not turn; None where all coordinates turn, and at rest.
    """

    state: State
    modes: tuple[Mode, ...]
    joint: str | None = None
    speed: float = 0.0
    blades: int | None = None

    def __repr__(self) -> str:
        """The first of its modes, one in a line."""
        turning = f", {self.joint!r} turning at {self.speed:.6g} rad/s" if self.joint else ""
        rest = len(self.modes) - _MOST
        lines = [f"  {number}. {mode!r}" for number, mode in enumerate(self.modes[:_MOST], 1)]
        lines += [f"  and {rest} more"] if rest > 0 else []
        return "\n".join([f"Modes: {len(self.modes)}{turning}", *lines])

    def destroy(self) -> None:
        """Free the modes, not the state. Collective."""
        for mode in self.modes:
            mode.destroy()
