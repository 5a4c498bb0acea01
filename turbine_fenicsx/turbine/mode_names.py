"""Names of the modes of a turbine in words, from the shapes of its slender parts.

Shapes are those of `SlenderPart`: a row for each station, columns along x, y, z and about z.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.postprocessing.conventions import BLADES

BLADE_WAYS = ("flap", "edge", "blade stretch", "blade twist")
TOWER_WAYS = ("fore-aft", "side-side", "tower stretch", "tower twist")
"""What blades and tower do along x, y, z and about z of their frames."""

ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth")

STILL = 0.2
"""A blade that moves by less than this part of the one that moves most stands still."""

OUT_OF_PHASE = 0.4
"""Blades go round if one of them has more than this part of its motion when another is at rest."""

TORSION = 0.5
"""A tower counts as twisted if it twists twice as far as it bends: a rotor in front of it twists it
in every motion to the side."""

FLAT = 0.05
"""Slopes below this part of the largest have no sign."""


def sum_squares(shapes: Sequence[Array]) -> Array:
    """Parts of the modal mass in each way of motion of some parts together, shape (4,) [kg m^2]."""
    found: Array = sum((np.sum(np.abs(s) ** 2, axis=0) for s in shapes), np.zeros(4))
    return found


def find_order(shape: Array) -> int:
    """Which bending, torsional or longitudinal mode of a rod a shape looks like, from 1.

    The slope of the n-th has n - 1 changes of sign, whatever the rod carries at its end.

    Args:
        shape: Displacement or rotation at each station, root first, real, shape (stations,).
    """
    slope = np.diff(np.concatenate([np.zeros(1), shape]))
    signs = np.sign(slope[np.abs(slope) > FLAT * np.max(np.abs(slope), initial=0.0)])
    return 1 + int(np.count_nonzero(np.diff(signs)))


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
    moving = [k + 1 for k in np.flatnonzero(size > STILL * size.max())]
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
    """A motion in which joints move, but no flexible part bends.

    Args:
        coordinates: What each joint coordinate does.
        rigid: Whether nothing drives it back.
        sprung: Whether springs do.
    """
    largest = max(map(abs, coordinates.values()), default=0.0)
    moving = [n for n, x in coordinates.items() if abs(x) > STILL * largest and largest > 1e-9]
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
) -> str:
    """A motion of the blades.

    Args:
        shapes: Complex shapes of all blades.
        metres: The same in metres and radians.
        together: How the blades go together, as `Whirl.name`; found from the shapes if None.
        sense: As in `describe_pattern`.
    """
    way = int(np.argmax(sum_squares(shapes)))
    amplitudes = find_amplitudes(shapes, way)
    most = int(np.abs(amplitudes).argmax())
    word = BLADE_WAYS[way].removeprefix("blade ")
    if together is None:
        together = describe_pattern(amplitudes, sense)
    elif together in ("forward", "backward"):
        together = f"{together} whirl"
    return f"{_describe_order(metres[most], way)} {word}, {together}"


def name_tower(shape: Array, metres: Array, stations: Array) -> str:
    """A motion of the tower.

    Bending and torsion are compared by the largest rotations of its sections, as both then have
    energies of one size in a tube; the mass that moves says nothing of its torsion.

    Args:
        shape: Its complex shape.
        metres: The same in metres and radians.
        stations: Heights of its stations, shape (stations,) [m].
    """
    way = int(np.argmax(sum_squares([shape])))
    if TOWER_WAYS[way] != "tower stretch":
        slopes = np.abs(np.diff(metres[:, :2], axis=0) / np.diff(stations)[:, None]).max(axis=0)
        turns = [*slopes, 0.0, TORSION * np.abs(metres[:, 3]).max()]
        way = int(np.argmax(turns))
    return f"{_describe_order(metres, way)} {TOWER_WAYS[way].removeprefix('tower ')} of the tower"


def _describe_order(metres: Array, way: int) -> str:
    """In words, of the phase at which the motion is largest."""
    column = metres[:, way]
    turned = column / np.exp(1j * np.angle(column[np.abs(column).argmax()]))
    return word_ordinal(find_order(turned.real))


def find_strongest(energies: Mapping[str, float]) -> str | None:
    """Which family is strained most: blades, tower, or a spring by its name; None for nothing.

    Args:
        energies: Strain energies of blades, tower and springs by their names.
    """
    families: dict[str, float] = {}
    for name, energy in energies.items():
        family = "blades" if name in BLADES else name
        families[family] = families.get(family, 0.0) + energy
    strained = [name for name, energy in families.items() if energy > 0.0]
    return max(strained, key=lambda name: families[name], default=None)
