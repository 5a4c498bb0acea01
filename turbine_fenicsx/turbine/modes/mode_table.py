"""The modes of a turbine, each in a row of numbers and words.

Each mode keeps the first of its titles if no other mode has it. If several do, names are assigned
so that the sum of the shares of the named motions is largest, with a preference for slower modes.
So a mode of the blades in which the tower moves too can be named after the tower.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count

import numpy as np
from scipy.optimize import linear_sum_assignment

from turbine_fenicsx.analysis.equal_modes import separate_equal_modes
from turbine_fenicsx.analysis.modal_sums import ModalSums
from turbine_fenicsx.analysis.mode import Mode, Modes
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.conventions import BLADES, TOWER
from turbine_fenicsx.turbine.components import mode_names
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.turbine.components.mode_names import BLADE_WAYS, TOWER_WAYS, Title
from turbine_fenicsx.turbine.modes.slender_parts import SlenderPart, find_slender_parts

MIN_SHARE = 0.2
"""A mode is called after a motion that is not its largest from this share on."""

SLOWER_WEIGHT = 0.1
"""A share counts by so much less for each slower mode that could have the same name."""

NUMBERED, NEVER = -2.0, -1e3
"""Weight of a name that only a number distinguishes, and of a name that does not belong to a
mode."""


def choose_names(titles: Sequence[Sequence[Title]]) -> list[str]:
    """A name for each mode.

    Args:
        titles: What each mode may be called, the best title first, at least one; of modes by rising
            frequency.

    Returns:
        The names: titles, or the first title with what else moves behind it, or with a number.
    """
    wanted = _weigh(titles)
    columns = list(dict.fromkeys(name for weights in wanted for name in weights))
    weights = np.full((len(titles), len(columns) + len(titles)), NEVER)
    for k, found in enumerate(wanted):
        for name, weight in found.items():
            weights[k, columns.index(name)] = weight
        weights[k, len(columns) + k] = NUMBERED
    _, chosen = linear_sum_assignment(weights, maximize=True)
    names = [columns[c] if c < len(columns) else "" for c in chosen]
    taken = set(names)
    for k, name in enumerate(names):
        if not name:
            numbered = (f"{titles[k][0].name} ({n})" for n in count(2))
            names[k] = next(name for name in numbered if name not in taken)
            taken.add(names[k])
    return names


def _weigh(titles: Sequence[Sequence[Title]]) -> list[dict[str, float]]:
    """How much each mode wants each name."""
    seen: Counter[str] = Counter()
    found = []
    for first, *others in titles:
        able = [first, *(t for t in others if t.share >= MIN_SHARE)]
        weights = {t.name: t.share - SLOWER_WEIGHT * seen[t.name] for t in able}
        seen.update(weights)
        beside = next((t for t in others if t.way != first.way), None)
        if beside is not None:
            weights[f"{first.name}, with {beside.way}"] = first.share + beside.share - 2.0
        found.append(weights)
    return found


REST = "nacelle_and_hub"
"""Name of the modal mass of nacelle, hub, rings and tower top together."""

ROUND_OFF = 1e-7
"""Rate of growth, relative to the eigenvalue, below which nothing grows."""

STIFF = 1e-4
"""Share of the modal mass in bending below which blades and tower do not bend."""


@dataclass(frozen=True)
class ModeRow:
    """Description of a mode.

    Args:
        frequency: With its damping [Hz]; zero for a motion that strains nothing.
        growth: Rate at which the motion grows [1/s], else zero.
        name: In words; no other mode at this speed has it.
        shares: Shares of the modal mass, by the names of blades and tower, and `REST`.
        ways: Shares of flap, edge, ... of the blades, as seen from what carries them, and of
            fore-aft, ... of the tower in the motion of all their sections, by these words.
    """

    frequency: float
    damping_ratio: float
    growth: float
    name: str
    shares: Mapping[str, float]
    ways: Mapping[str, float]


def describe_modes(turbine: Turbine, modes: Modes) -> tuple[Modes, list[ModeRow]]:
    """Distinguish equal modes, and describe all. Collective.

    Returns:
        The modes, and a row for each.
    """
    parts = find_slender_parts(turbine, modes.state)
    sums = ModalSums(turbine.system, modes.state, [part.piece for part in parts.values()])
    first = [name for name in (BLADES[1], *BLADES, TOWER) if name in parts]

    def features(mode: Mode) -> list[Array]:
        turned = mode.real.joint_coordinates + 0j
        if mode.imaginary is not None:
            turned += 1j * mode.imaginary.joint_coordinates
        found = [np.atleast_1d(x) for x in turned]
        if not mode.is_rigid:
            found = [*(parts[name].complex_shape(mode) for name in dict.fromkeys(first)), *found]
        return found if mode.imaginary else [f.real for f in found]

    try:
        modes = separate_equal_modes(modes, features, sums.inner_product)
        told = [_describe(turbine, mode, parts, sums, modes.speed) for mode in modes.modes]
    finally:
        sums.destroy()
    order = sorted(range(len(told)), key=lambda k: modes.modes[k].frequency)
    names = choose_names([told[k][1] for k in order])
    return modes, [replace(row, name=names[order.index(k)]) for k, (row, _) in enumerate(told)]


def _describe(
    turbine: Turbine, mode: Mode, parts: Mapping[str, SlenderPart], sums: ModalSums, speed: float
) -> tuple[ModeRow, list[Title]]:
    """The row of a mode, and what it may be called."""
    phases = [mode.real, *filter(None, [mode.imaginary])]
    masses = _add_tables(sums.modal_masses(phase) for phase in phases)
    energies = _add_tables(sums.strain_energies(phase) for phase in phases)
    shapes = {name: part.complex_shape(mode) for name, part in parts.items()}
    whole = sum(masses.values())
    own = [name for name in (*BLADES, TOWER) if name in masses]
    shares = {name: masses[name] / whole for name in own}
    squares: dict[str, float] = {}
    for names, words in ((BLADES, BLADE_WAYS), ((TOWER,), TOWER_WAYS)):
        found = [shapes[name] for name in names if name in shapes]
        if found:
            squares |= dict(zip(words, mode_names.sum_squares(found).tolist(), strict=True))
    moved = sum(squares.values())
    if mode.is_rigid or moved < STIFF * whole:
        needed = 0.1 * abs(mode.eigenvalue) ** 2 * whole  # of springs that drive the motion back
        springs = {} if mode.is_rigid else {k: x for k, x in energies.items() if k not in parts}
        moved, energies = 0.0, {k: x for k, x in springs.items() if x > needed}
    grows = mode.is_unstable and mode.eigenvalue.real > ROUND_OFF * abs(mode.eigenvalue)
    ways = {way: x / moved if moved else 0.0 for way, x in squares.items()}
    titles = _list_titles(turbine, mode, parts, shapes, energies, speed, ways)
    row = ModeRow(
        frequency=0.0 if mode.is_rigid else mode.frequency,
        damping_ratio=0.0 if grows and not mode.frequency else mode.damping_ratio + 0.0,
        growth=mode.eigenvalue.real if grows else 0.0,
        name=titles[0].name,
        shares={**shares, REST: 1.0 - sum(shares.values())},
        ways=ways,
    )
    return row, titles


def _list_titles(
    turbine: Turbine,
    mode: Mode,
    parts: Mapping[str, SlenderPart],
    shapes: Mapping[str, Array],
    energies: Mapping[str, float],
    sense: float,
    ways: Mapping[str, float],
) -> list[Title]:
    """Possible names of a mode, first after the strained part that moves most: means of shares."""
    families = mode_names.share_energies(energies)
    strongest = next(iter(families), None)
    if strongest not in ("blades", TOWER):
        coordinates = dict(
            zip(
                turbine.system.joint_coordinate_names,
                mode.real.joint_coordinates.tolist(),
                strict=True,
            )
        )
        name = mode_names.name_joints(coordinates, mode.is_rigid, strongest is not None)
        return [Title(name, "", 1.0)]
    metres = {name: shape / parts[name].sections.roots for name, shape in shapes.items()}
    titles: list[Title] = []
    for family, part in families.items():
        found: list[Title] = []
        if family == "blades":
            blades = [name for name in BLADES if name in shapes]
            together = None if mode.whirl is None else mode.whirl.name
            found = mode_names.name_blades(
                [shapes[b] for b in blades], [metres[b] for b in blades], together, sense
            )
        elif family == TOWER:
            found = mode_names.name_tower(
                shapes[TOWER], metres[TOWER], parts[TOWER].sections.stations
            )
        titles += [replace(t, share=0.5 * (part * t.share + ways[t.way])) for t in found]
    return sorted(titles, key=lambda t: -t.share)


def _add_tables(tables: Iterable[Mapping[str, float]]) -> dict[str, float]:
    """Sums of tables by their keys."""
    total: dict[str, float] = {}
    for table in tables:
        for name, value in table.items():
            total[name] = total.get(name, 0.0) + value
    return total
