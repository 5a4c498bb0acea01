"""Modes of a quadratic problem by rising frequency, of unit modal mass, rigid ones first."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.equal_modes import choose_phase
from turbine_fenicsx.analysis.linear_system import LinearSystem, entry_sizes
from turbine_fenicsx.analysis.mode import Mode
from turbine_fenicsx.analysis.quadratic_problem import QuadraticProblem
from turbine_fenicsx.analysis.slepc import Pair
from turbine_fenicsx.analysis.squared_frequencies import square_of_swelling
from turbine_fenicsx.analysis.strain_meter import StrainMeter, warn_of_round_off
from turbine_fenicsx.analysis.whirl import WhirlMeter
from turbine_fenicsx.foundation.errors import ModelError, StepFailure

RIGID_EIGENVALUE_RATIO = 1e-3
"""Eigenvalue relative to the shift below which an unstrained motion is rigid. Eigenvalues of rigid
motions are double, and round-off moves such ones by the root of its size. In thin walls it
moves them farther, see `_is_slow`."""

STRAIN_ROUND_OFF = 1e-13
"""Round-off of y.K y, relative to the sum of K_ii y_i^2; a motion is rigid below it ..."""

FREQUENCY_ROUND_OFF = 1e-6
"""... or below that of a frequency, relative to the highest that is found."""

MIN_NEW_SHARE = 1e-4
"""Minimum share of the modal mass of a rigid motion that is normal to the others."""

IN_PHASE_TOLERANCE = 1e-12
"""Share of the modal mass in the part b below which all parts of a mode move in phase."""

GROWING_FIRST = 1e-6
"""Relative difference of sizes within which a motion that grows comes before one that decays."""

MIN_SHIFT_RATIO = 0.05
"""Shift and lowest frequency may differ by a factor of one over this; digits are lost beyond."""

BALANCE_TOLERANCE = 0.5
"""Maximum sum of inertia and forces of the velocity that balance each other, relative to the larger
one."""

SHIFT_OF_LOWEST = 0.7
"""Next shift over the lowest frequency. A motion that diverges has a real eigenvalue, at which
nothing can be inverted."""

MAX_ATTEMPTS = 8

ADDITIONAL_EIGENVALUES = 8
"""Number of additional eigenvalues: those of one frequency come together."""

SHIFT_RATIO = 0.02
"""First shift relative to the frequency at which the softest body would swell and shrink. Slender
bodies bend at that frequency over their slenderness."""

RANDOM_SHIFT_RATIO = 1e-3
"""First shift without flexible bodies, relative to the frequency of a motion by random forces."""


def check_count(linear: LinearSystem, count: int) -> None:
    """Raise a ModelError unless a system has as many modes."""
    if not isinstance(count, int | np.integer) or isinstance(count, bool) or count < 1:
        raise ModelError(f"the number of modes must be a positive whole number, got {count!r}")
    if count > linear.degrees_of_freedom:
        raise ModelError(
            f"{count} modes are more than the {linear.degrees_of_freedom} degrees of freedom of "
            "the system"
        )


def complex_modes(
    problem: QuadraticProblem,
    count: int,
    shift: float | None = None,
    meter: WhirlMeter | None = None,
) -> tuple[tuple[Mode, ...], float]:
    """The modes with the lowest eigenvalues. Collective.

    Args:
        count: How many; at most the degrees of freedom.
        shift: First guess of the size of the lowest frequency [rad/s]; None makes one.
        meter: Measures how the rotor whirls; None for modes without.

    Returns:
        The modes by rising frequency, rigid ones first, and the lowest frequency for the next guess
        [rad/s].
    """
    free = problem.linear.degrees_of_freedom
    number = min(2 * count + ADDITIONAL_EIGENVALUES, 2 * free)
    shift = _guess(problem) if shift is None else shift
    strain = StrainMeter(problem.linear)
    for _ in range(MAX_ATTEMPTS):
        pairs = problem.pairs(number, shift)
        rigid, elastic = _separate_rigid(problem, pairs, shift, strain)
        lowest = min((abs(p.eigenvalue) for p in elastic), default=shift)
        if MIN_SHIFT_RATIO <= lowest / shift <= 1.0 / MIN_SHIFT_RATIO:
            break
        for pair in (*rigid, *elastic):
            pair.destroy()
        shift = SHIFT_OF_LOWEST * lowest
    else:
        raise StepFailure(f"no shift was found for modes, the last one was {shift:.3g} rad/s")
    elastic.sort(key=_rank)
    chosen = [*rigid, *elastic][:count]
    squares = [(abs(pair.eigenvalue) ** 2, pair.round_off) for pair in chosen[len(rigid) :]]
    warn_of_round_off(problem.linear.system.comm, squares)
    modes = [make_mode(problem, pair, k < len(rigid), meter) for k, pair in enumerate(chosen)]
    for pair in (*rigid, *elastic):
        pair.destroy()
    if len(modes) < count:
        for mode in modes:
            mode.destroy()
        raise StepFailure(f"only {len(modes)} of {count} modes were found; fewer may help")
    modes.sort(key=lambda mode: (not mode.is_rigid, mode.eigenvalue.imag, abs(mode.eigenvalue)))
    return tuple(modes), lowest


def _rank(pair: Pair) -> float:
    """Size of the eigenvalue, for one that grows a little less."""
    size = abs(pair.eigenvalue)
    return size * (1.0 - GROWING_FIRST * (pair.eigenvalue.real > GROWING_FIRST * size))


def _guess(problem: QuadraticProblem) -> float:
    """A first shift [rad/s]. Collective.

    Random forces would shake thin walls a million times as fast as a blade bends.
    """
    swelling = square_of_swelling(problem.linear)
    if swelling > 0.0:
        return SHIFT_RATIO * float(np.sqrt(swelling))
    solver = problem.linear.solver(problem.mass, "modes_")
    solver.factorise()
    x, y, image = (problem.linear.vectors.new_vector() for _ in range(3))
    x.setRandom()
    solver.solve(x, y)
    solver.destroy()
    energy, size = _strain(problem, [y])
    problem.mass.mult(y, image)
    square = energy / image.dot(y)
    for vector in (x, y, image):
        vector.destroy()
    return RANDOM_SHIFT_RATIO * float(np.sqrt(square)) if energy > STRAIN_ROUND_OFF * size else 1.0


def _separate_rigid(
    problem: QuadraticProblem, pairs: Sequence[Pair], shift: float, strain: StrainMeter
) -> tuple[list[Pair], list[Pair]]:
    """Rigid motions, one for each independent shape, and all others; the rest is destroyed."""
    rigid: list[Pair] = []
    elastic: list[Pair] = []
    image = problem.linear.vectors.new_vector()
    highest = max((abs(pair.eigenvalue) for pair in pairs), default=0.0)
    slow = RIGID_EIGENVALUE_RATIO * shift
    for pair in pairs:
        energy, size = _strain(problem, pair.parts)
        round_off = max(STRAIN_ROUND_OFF * size, (FREQUENCY_ROUND_OFF * highest) ** 2)
        held = energy > round_off or strain.is_strained(pair.parts, energy)
        if held or not _is_slow(problem, pair, slow, round_off):
            elastic.append(replace(pair, round_off=float(np.finfo(float).eps) * size))
            continue
        for x in pair.parts:
            if _make_normal(problem.mass, x, [p.parts[0] for p in rigid], image):
                zero = x.duplicate()
                zero.set(0.0)
                rigid.append(Pair(0j, (x.copy(), zero)))
        pair.destroy()
    image.destroy()
    return rigid, elastic


def _is_slow(problem: QuadraticProblem, pair: Pair, slow: float, round_off: float) -> bool:
    """Whether the eigenvalue of an unstrained motion is zero but for round-off. Collective.

    With y* . M y = 1, s^2 + s d + y* . K y = 0, d = y* . D y. Both terms of a rigid motion are
    round-off of the third; those of one that a damper slows down, or that precesses, balance each
    other.

    Args:
        pair: The eigenvalue and the motion, of unit modal mass.
        slow: Any eigenvalue below this is zero [rad/s].
        round_off: Round-off of y* . K y [rad^2/s^2].
    """
    s, d = pair.eigenvalue, 0j
    if abs(s) <= slow:
        return True
    if problem.damping is not None:
        a, b = pair.parts
        image = a.duplicate()
        for part, factor in ((a, 1.0), (b, 1j)):
            problem.damping.mult(part, image)
            d += factor * complex(a.dot(image), -b.dot(image))
        image.destroy()
    largest = max(abs(s), abs(d))
    return abs(s) * largest <= round_off and abs(s + d) > BALANCE_TOLERANCE * largest


def _strain(problem: QuadraticProblem, parts: Iterable[PETSc.Vec]) -> tuple[float, float]:
    """The sums of |y.K y|, and of |K_i| y_i^2, over the parts y of a motion. Collective."""
    energy = size = 0.0
    sizes = entry_sizes(problem.linear.vectors, problem.stiffness)
    image, squares = sizes.duplicate(), sizes.duplicate()
    for y in parts:
        problem.stiffness.mult(y, image)
        energy += abs(image.dot(y))
        squares.pointwiseMult(y, y)
        size += squares.dot(sizes)
    for vector in (image, squares, sizes):
        vector.destroy()
    return energy, size


def _make_normal(
    mass: PETSc.Mat, x: PETSc.Vec, others: Sequence[PETSc.Vec], image: PETSc.Vec
) -> bool:
    """Make a part of a pair normal to others and of unit modal mass; False if little is left."""
    for _ in range(2):
        for y in others:
            mass.mult(y, image)
            x.axpy(-image.dot(x), y)
    mass.mult(x, image)
    left = image.dot(x)
    if not left > MIN_NEW_SHARE:
        return False
    x.scale(left**-0.5)
    return True


def make_mode(
    problem: QuadraticProblem, pair: Pair, is_rigid: bool, meter: WhirlMeter | None
) -> Mode:
    """The mode of unit modal mass and a phase that does not depend on the iteration."""
    vectors, (a, b) = problem.linear.vectors, pair.parts
    choose_phase(vectors, a, b)
    image = a.duplicate()
    total = 0.0
    for part in (a, b):
        problem.mass.mult(part, image)
        share = image.dot(part)
        total += share
    for part in (a, b):
        part.scale(total**-0.5)
    image.destroy()
    return Mode(
        pair.eigenvalue,
        vectors.motion(a),
        None if share <= IN_PHASE_TOLERANCE * total else vectors.motion(b),
        is_rigid,
        None if meter is None else meter.measure(a, b),
    )
