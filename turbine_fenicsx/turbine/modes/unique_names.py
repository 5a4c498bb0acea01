"""One name for each mode, and none twice.

Each mode keeps the first of its titles if no other mode has it. If several do, names are assigned
so that the sum of the shares of the named motions is largest, with a preference for slower modes.
So a mode of the blades in which the tower moves too can be named after the tower.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import count

import numpy as np
from scipy.optimize import linear_sum_assignment

from turbine_fenicsx.turbine.components.mode_names import Title

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
