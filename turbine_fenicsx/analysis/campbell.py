"""Campbell diagram: frequencies and damping over the speed of rotation, mode by mode.

From one speed to the next, a mode is followed by the modal assurance criterion of its shape,

    MAC = |z_i* . M z_k|^2

for modes of unit modal mass, so that frequencies may cross. Modes of one frequency are any
combinations of each other; what counts is the sum over them. Modes whose frequencies differ by less
than the speed changes mix as well: whirl takes two motions of a rotor at rest apart by 1P to each
side. They count by their sum, and each continues as the mode of which it has most.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import numpy.typing as npt
from scipy.optimize import linear_sum_assignment

from turbine_fenicsx.analysis.mode import Mode, Modes, Motion
from turbine_fenicsx.analysis.turning_modes import turning_modes_near
from turbine_fenicsx.foundation.argument_checks import check_number
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

log = logging.getLogger(__name__)

FOLLOWED = 0.6
"""A mode is followed if its MAC with those of one frequency at the next speed is at least this."""

EQUAL_TOLERANCE = 1e-5
"""Relative difference of eigenvalues below which they count as one."""

HALVINGS = 2
"""Steps of the speed are halved at most so often to follow the modes, which takes seven times as
long as without."""

RPM = 30.0 / np.pi
"""Revolutions per minute of one rad/s."""

ADDITIONAL_MODES = 6
"""Number of additional modes at the next speed: others may have become slower."""


@dataclass(frozen=True, eq=False)
class Campbell:
    """Modes that are followed from speed to speed, by their shapes and not by their order.

    Args:
        joint: Joint about whose axis the system turns.
        speeds: Omega, shape (speeds,) [rad/s].
        frequencies: Frequency of each mode at each speed, shape (speeds, modes) [Hz].
        damping_ratios: Part of critical damping, shape (speeds, modes).
        names: A name for each mode.
        modes: The modes at each speed; the k-th of each is the k-th mode here.
    """

    joint: str
    speeds: Array
    frequencies: Array
    damping_ratios: Array
    names: tuple[str, ...]
    modes: tuple[Modes, ...]

    def destroy(self) -> None:
        """Free all modes and their states. Collective."""
        for modes in self.modes:
            modes.destroy()
            modes.state.destroy()


def campbell(
    system: MultibodySystem,
    joint: str,
    speeds: Iterable[float],
    count: int = 12,
    blades: int | None = None,
    state: State | None = None,
    held: Iterable[str] = (),
) -> Campbell:
    """Modes of a turning system over its speed.

    Args:
        system: The system.
        joint: As in `turning_modes`.
        speeds: Speeds in the order in which modes are followed, at least one [rad/s].
        count: Number of modes at the first speed, all of which are followed.
        blades: As in `turning_modes`.
        state: As in `turning_modes`.
        held: As in `turning_modes`.

    Returns:
        The modes; the caller frees them.

    Raises:
        InputError, ModelError, StepFailure: as `turning_modes` does.

    Note:
        Collective.
    """
    wanted = [check_number(f"speed of {joint!r}", speed) for speed in speeds]
    if not wanted:
        raise ModelError("a Campbell diagram needs at least one speed")
    followed = ModeFollower(system, joint, count, blades, state, held)
    found: list[Modes] = []
    try:
        for speed in wanted:
            follow = partial(followed.continue_at, found[-1]) if found else followed.start
            found.append(follow(speed))
    except BaseException:
        for modes in found:
            modes.destroy()
            modes.state.destroy()
        raise
    return Campbell(
        joint,
        np.array(wanted),
        np.array([[mode.frequency for mode in modes.modes] for modes in found]),
        np.array([[mode.damping_ratio for mode in modes.modes] for modes in found]),
        _names(found),
        tuple(found),
    )


class ModeFollower:
    """Finds modes at one speed after the other."""

    def __init__(
        self,
        system: MultibodySystem,
        joint: str,
        count: int,
        blades: int | None,
        state: State | None,
        held: Iterable[str] = (),
    ) -> None:
        self._system, self._joint, self._count = system, joint, count
        self._blades, self._state, self._held = blades, state, tuple(held)
        self._lowest: float | None = None

    def start(self, speed: float) -> Modes:
        """The modes at the first speed."""
        return self._find(speed, more=0)

    def _find(self, speed: float, more: int) -> Modes:
        """Modes at a speed, some more than wanted; the lowest frequency so far is the shift."""
        modes, self._lowest = turning_modes_near(
            self._system,
            self._joint,
            speed,
            self._count,
            self._blades,
            self._state,
            self._held,
            self._lowest,
            more,
        )
        return modes

    def continue_at(self, before: Modes, speed: float, halvings: int = HALVINGS) -> Modes:
        """Those modes at another speed, in the same order."""
        modes = self._find(speed, ADDITIONAL_MODES)
        partners, quality = find_partners(self._system, before, modes)
        if quality.min() < FOLLOWED and halvings:
            modes.destroy()
            modes.state.destroy()
            self._warn(
                "%d modes cannot be followed from %.4g to %.4g rpm: the speed between is looked at",
                np.count_nonzero(quality < FOLLOWED),
                before.speed * RPM,
                speed * RPM,
            )
            between = self.continue_at(before, 0.5 * (before.speed + speed), halvings - 1)
            try:
                return self.continue_at(between, speed, halvings - 1)
            finally:
                between.destroy()
                between.state.destroy()
        for k in np.flatnonzero(quality < FOLLOWED):
            self._warn(
                "mode %d can hardly be followed from %.4g to %.4g rpm: its MAC is %.2f",
                k + 1,
                before.speed * RPM,
                speed * RPM,
                quality[k],
            )
        return choose(modes, partners)

    def _warn(self, sentence: str, *values: float) -> None:
        """Log a warning once."""
        if self._system.comm.rank == 0:
            log.warning(sentence, *values)


def choose(modes: Modes, numbers: IntArray) -> Modes:
    """Some modes in an order; the others are freed. Collective."""
    chosen = set(numbers.tolist())
    for k, mode in enumerate(modes.modes):
        if k not in chosen:
            mode.destroy()
    return replace(modes, modes=tuple(modes.modes[k] for k in numbers))


def find_partners(system: MultibodySystem, before: Modes, after: Modes) -> tuple[IntArray, Array]:
    """Which mode follows each of those before, and its MAC with all of its frequency. Collective.

    Args:
        after: Modes at another place, at least as many.
    """
    criteria = find_criteria(system, before, after)
    return _match(criteria, before.modes, after.modes, abs(after.speed - before.speed))


def find_criteria(system: MultibodySystem, before: Modes, after: Modes) -> Array:
    """MAC of each mode before and after, shape (modes before, modes after). Collective."""
    masses = system.rigid_model.masses
    products = [m.new_vector() for m in system.flexible_models]
    criteria = np.zeros((len(before.modes), len(after.modes)))
    first = [_parts(mode) for mode in before.modes]
    for k, mode in enumerate(after.modes):
        sums = np.zeros((len(first), 2, 2))
        for c, motion in enumerate(_parts(mode)):
            for body, model in enumerate(system.flexible_models):
                model.momentum(motion.u[body], products[body])
            for i, parts in enumerate(first):
                for r, other in enumerate(parts):
                    sums[i, r, c] = sum(p.dot(u) for p, u in zip(products, other.u, strict=True))
                    sums[i, r, c] += other.q @ (masses * motion.q)
        # (a - i b) . M (a' + i b')
        real = sums[:, 0, 0] + sums[:, 1, 1]
        imaginary = sums[:, 0, 1] - sums[:, 1, 0]
        criteria[:, k] = real**2 + imaginary**2
    for vector in products:
        vector.destroy()
    return criteria


def _parts(mode: Mode) -> list[Motion]:
    """The parts a and, if there is one, b of a mode."""
    return [mode.real] if mode.imaginary is None else [mode.real, mode.imaginary]


def _match(
    criteria: Array, before: Sequence[Mode], after: Sequence[Mode], change: float = 0.0
) -> tuple[IntArray, Array]:
    """Which mode follows each, and how surely.

    Args:
        criteria: MAC, shape (modes before, modes after).
        change: Difference of the speeds [rad/s].

    Returns:
        Number of the mode after for each mode before, and the mean MAC between groups of equal
        eigenvalues. Eigenvalues nearer than the change of speed count as equal.
    """
    groups, images = _equal(before, change), _equal(after)
    _, partners = linear_sum_assignment(-criteria @ images)
    quality = np.zeros(len(before))
    for k, group in enumerate(groups):
        image = np.any(images[partners[group]], axis=0)
        quality[k] = criteria[np.ix_(group, image)].sum() / np.count_nonzero(group)
    return partners, quality


def _equal(modes: Sequence[Mode], apart: float = 0.0) -> npt.NDArray[np.bool_]:
    """Which modes have the same eigenvalue, or are not far apart [rad/s], shape (modes, modes)."""
    s = np.array([mode.eigenvalue for mode in modes])
    size = np.maximum(np.abs(s)[:, None], np.abs(s))
    return np.asarray(np.abs(s[:, None] - s) <= np.maximum(EQUAL_TOLERANCE * size, apart))


def _names(found: Sequence[Modes]) -> tuple[str, ...]:
    """Names by number, and by how the rotor whirls at the highest speed."""
    fastest = max(found, key=lambda modes: abs(modes.speed)).modes
    return tuple(
        f"mode {k}" + ("" if mode.whirl is None else f", {mode.whirl.name}")
        for k, mode in enumerate(fastest, start=1)
    )
