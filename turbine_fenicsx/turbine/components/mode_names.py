"""Names of the modes of a turbine in words, from the shapes of its slender parts.

Shapes are those of `SlenderPart`: a row for each station, columns along x, y, z and about z. A mode
in which parts move in several ways may be called after each of them; `unique_names` chooses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.conventions import BLADES

BLADE_WAYS = ("flap", "edge", "blade stretch", "blade twist")
TOWER_WAYS = ("fore-aft", "side-side", "tower stretch", "tower twist")
"""Motions of blades and tower along x, y, z and about z of their frames."""

ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth")

MAX_REST_RATIO = 0.2
"""Motion of a blade, relative to the one that moves most, below which it stands still."""

OUT_OF_PHASE = 0.4
"""Minimum share of its motion that a blade has when another is at rest, if they go round."""

TORSION = 0.5
"""A tower counts as twisted if it twists twice as far as it bends: a rotor in front of it twists it
in every motion to the side."""

FLAT = 0.05
"""Slope relative to the largest below which it has no sign."""

STRAIGHT = 0.015
"""Motion of a blade relative to the largest below which it has no sign. The second flapwise mode of
a blade on a tower that moves with it has -0.03 on one side of its node, and 1 on the other."""


@dataclass(frozen=True)
class Title:
    """Possible name of a mode.

    Args:
        way: What moves so, of `BLADE_WAYS` and `TOWER_WAYS`; empty for joints.
        share: How much of the mode this is, from 0 to 1.
    """

    name: str
    way: str
    share: float


def sum_squares(shapes: Sequence[Array]) -> Array:
    """Parts of the modal mass in each way of motion of some parts together, shape (4,) [kg m^2]."""
    found: Array = sum((np.sum(np.abs(s) ** 2, axis=0) for s in shapes), np.zeros(4))
    return found


def find_order(shape: Array, ends_free: bool = False) -> int:
    """Which bending, torsional or longitudinal mode of a rod a shape looks like, from 1.

    The slope of the n-th has n - 1 changes of sign, whatever the rod carries at its end. With a
    free end, the rod also crosses its place at rest n - 1 times; whichever of the two is more
    counts, since a root that moves adds to the shape and may hide some. Then the motion of the end
    itself bends nothing.

    Args:
        shape: Displacement or rotation at each station, root first, real, shape (stations,).
    """
    slopes = np.diff(np.concatenate([np.zeros(1), shape]))
    if not ends_free:
        return 1 + _count_changes(slopes, FLAT)
    return 1 + max(_count_changes(slopes[:-1], FLAT), _count_changes(shape, STRAIGHT))


def _count_changes(values: Array, least: float) -> int:
    """Changes of sign between values above a part of the largest."""
    signs = np.sign(values[np.abs(values) > least * np.max(np.abs(values), initial=0.0)])
    return int(np.count_nonzero(np.diff(signs)))


def word_ordinal(n: int) -> str:
    """A number in words."""
    return ORDINALS[n - 1] if n <= len(ORDINALS) else f"{n}th"


def describe_pattern(amplitudes: Array, sense: float = 1.0) -> str:
    """How equal blades, evenly spaced round the rotor, move together.

    Args:
        amplitudes: Of each blade, complex where they are not in phase, shape (blades,); a motion is
            Re[amplitude exp(i w t)].
        sense: Positive if the rotor turns from blade 1 to 2 to 3, else negative.
    """
    size = np.abs(amplitudes)
    moving = [k + 1 for k in np.flatnonzero(size > MAX_REST_RATIO * size.max())]
    if len(moving) == 1:
        return f"blade {moving[0]} alone"
    leading = amplitudes / amplitudes[size.argmax()]
    if np.max(np.abs(leading.imag)) > OUT_OF_PHASE:
        steps = 2j * np.pi * np.arange(len(size)) / len(size)
        rising, falling = (abs(amplitudes @ np.exp(sign * steps)) for sign in (1, -1))
        return f"{'forward' if (rising > falling) == (sense > 0.0) else 'backward'} whirl"
    ahead, against = ([k for k in moving if sign * leading[k - 1].real > 0.0] for sign in (1, -1))
    if not against:
        return "collective" if len(moving) == len(size) else f"{_list_blades(moving)} together"
    if len(against) > len(ahead) or (len(against) == len(ahead) and against < ahead):
        ahead, against = against, ahead
    return f"{_list_blades(ahead)} against {against[0]}"


def _list_blades(numbers: Sequence[int]) -> str:
    """Some blades by their numbers."""
    return f"blade{'s' * (len(numbers) > 1)} {_join(list(map(str, numbers)))}"


def _join(words: Sequence[str]) -> str:
    """A list as it is said aloud."""
    return " and ".join(filter(None, [", ".join(words[:-1]), *words[-1:]]))


def find_amplitudes(shapes: Sequence[Array], way: int) -> Array:
    """How much each blade takes part in the shape of the one that moves most, shape (blades,)."""
    columns = np.array([s[:, way] for s in shapes])
    reference = columns[np.linalg.norm(columns, axis=1).argmax()]
    found: Array = columns @ reference.conj() / np.linalg.norm(reference)
    return found


def name_joints(coordinates: Mapping[str, float], rigid: bool, sprung: bool = False) -> str:
    """A motion in which joints move, but no flexible part bends."""
    largest = max(map(abs, coordinates.values()), default=0.0)
    moving = [
        n for n, x in coordinates.items() if abs(x) > MAX_REST_RATIO * largest and largest > 1e-9
    ]
    words = _join([name.replace("_", " ") for name in moving])
    if not moving:
        return "rigid body"
    if sprung:
        return f"{words} on springs"
    return f"free {words}" if rigid else f"swinging {words}"


def name_blades(
    shapes: Sequence[Array],
    metres: Sequence[Array],
    together: str | None = None,
    sense: float = 1.0,
) -> list[Title]:
    """A motion of the blades, after each way in which they move; the largest share first.

    Args:
        shapes: Complex shapes of all blades.
        together: How the blades go together, as `Whirl.name`; found from the shapes if None.
    """
    squares = sum_squares(shapes)
    if together in ("forward", "backward"):
        together = f"{together} whirl"
    found = []
    for way in _sort(squares):
        amplitudes = find_amplitudes(shapes, way)
        most = metres[int(np.abs(amplitudes).argmax())]
        order = find_order(_at_its_largest(most[:, way]), ends_free=True)
        word = BLADE_WAYS[way].removeprefix("blade ")
        pattern = together or describe_pattern(amplitudes, sense)
        name = f"{word_ordinal(order)} {word}, {pattern}"
        found.append(Title(name, BLADE_WAYS[way], float(squares[way] / squares.sum())))
    return found


def name_tower(shape: Array, metres: Array, stations: Array) -> list[Title]:
    """A motion of the tower, after each way in which it moves; the largest share first.

    Bending and torsion are compared by the largest rotations of its sections, as both then have
    energies of one size in a tube; the mass that moves says nothing of its torsion.

    Args:
        shape: Its complex shape.
        stations: Heights of its stations, shape (stations,) [m].
    """
    squares = sum_squares([shape])
    sizes: Array = squares
    if TOWER_WAYS[int(squares.argmax())] != "tower stretch":
        steps = np.diff(stations)
        rises = steps > 1e-9 * np.ptp(stations)  # one ring of nodes may make two stations
        slopes = np.abs(np.diff(metres[:, :2], axis=0)[rises] / steps[rises, None]).max(axis=0)
        turns: Array = np.array([*slopes, 0.0, TORSION * np.abs(metres[:, 3]).max()])
        sizes = turns * turns
    found = []
    for way in _sort(sizes):
        word = TOWER_WAYS[way].removeprefix("tower ")
        order = word_ordinal(find_order(_at_its_largest(metres[:, way])))
        share = float(sizes[way] / sizes.sum())
        found.append(Title(f"{order} {word} of the tower", TOWER_WAYS[way], share))
    return found


def _sort(sizes: Array) -> list[int]:
    """Numbers of the ways in which something moves, the largest first."""
    return [int(way) for way in np.argsort(-sizes, kind="stable") if sizes[way] > 0.0]


def _at_its_largest(column: Array) -> Array:
    """A complex motion of stations at the phase at which it is largest."""
    turned: Array = (column / np.exp(1j * np.angle(column[np.abs(column).argmax()]))).real
    return turned


def share_energies(energies: Mapping[str, float]) -> dict[str, float]:
    """Shares of the strain energy of blades, tower, and springs by their names; the largest first.

    Args:
        energies: Strain energies of each blade, the tower and springs by their names.
    """
    families: dict[str, float] = {}
    for name, energy in energies.items():
        family = "blades" if name in BLADES else name
        families[family] = families.get(family, 0.0) + energy
    strained = {name: energy for name, energy in families.items() if energy > 0.0}
    whole = sum(strained.values())
    order = sorted(strained, key=lambda name: -strained[name])
    return {name: strained[name] / whole for name in order}
