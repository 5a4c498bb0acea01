"""Fatigue over the life of a turbine: how often each run happens, and equivalent loads of all.

Runs of situations that evaluate fatigue stand for winds or events. The speeds of those that last as
long as the wind blows divide all winds among them, from middle to middle of neighbours. With the
probability p of the winds of a speed (Weibull) and a life L, its n runs of duration T happen

    w = p L/(n T)

times each. Events happen as often as `Situation.per_year` says. With the cycles n_i of ranges S_i,

    S_eq = (sum_runs w sum_i n_i S_i^m / N)^(1/m)

is the range that does the same damage in N cycles.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from math import exp, gamma

from turbine_fenicsx.load_sets.load_set import LoadSet
from turbine_fenicsx.load_sets.plan import SetRun
from turbine_fenicsx.postprocessing.fatigue import Fatigue
from turbine_fenicsx.records.mode_tables import format_rows

YEAR = 365.25 * 24.0 * 3600.0
"""Seconds of a year."""

MEAN_WIND = 0.2
"""Mean wind of the year over V_ref, IEC 61400-1, section 6.3.1.1."""

LIFE = "lifetime"
"""Row of a channel over the life."""


@dataclass(frozen=True)
class WindBins:
    """Which winds each speed stands for.

    Args:
        speeds: Rising [m/s].
        shape: Exponent of Weibull's distribution [-].
        mean: Of the wind over the year [m/s].
    """

    speeds: Sequence[float]
    shape: float
    mean: float

    def share(self, speed: float) -> float:
        """Part of the time in which the wind is nearest to a speed [-]."""
        k = list(self.speeds).index(speed)
        low = 0.5 * (self.speeds[k - 1] + speed) if k else 0.0
        last = k + 1 == len(self.speeds)
        above = 0.0 if last else self._exceed(0.5 * (speed + self.speeds[k + 1]))
        return self._exceed(low) - above

    def _exceed(self, speed: float) -> float:
        """Probability of larger speeds."""
        scale = self.mean / gamma(1.0 + 1.0 / self.shape)
        return exp(-((speed / scale) ** self.shape))


def weigh_runs(
    load_set: LoadSet, runs: Sequence[SetRun], finished: Collection[str]
) -> dict[str, float]:
    """How often the finished runs that count for fatigue happen in the life, by name.

    Runs of one speed, or event, share what the others of it leave.
    """
    situations, life = load_set.chosen, load_set.lifetime
    counted = [each for each in runs if situations[each.situation].evaluates == "fatigue"]
    lasting = [each for each in counted if not situations[each.situation].per_year]
    speeds = sorted({each.wind for each in lasting})
    bins = WindBins(speeds, life.shape, life.mean_wind or MEAN_WIND * load_set.reference)
    done = [each for each in counted if each.run.name in finished]
    at_event = Counter((each.situation, each.wind) for each in done)
    at_speed = Counter(x.wind for x in done if not situations[x.situation].per_year)
    weights = {}
    for each in done:
        situation = situations[each.situation]
        if situation.per_year:
            winds = list(dict.fromkeys(x.wind for x in runs if x.situation == each.situation))
            times = situation.per_year[winds.index(each.wind)] * life.years
            weights[each.run.name] = times / at_event[each.situation, each.wind]
        else:
            times = bins.share(each.wind) * life.years * YEAR / situation.duration
            weights[each.run.name] = times / at_speed[each.wind]
    return weights


def format_fatigue_of_set(
    load_set: LoadSet,
    runs: Sequence[SetRun],
    finished: Collection[str],
    find: Callable[[str, float], Sequence[Fatigue]],
) -> str:
    """``fatigue.csv``: equivalent ranges of each run in cycles of 1 Hz, and of the life.

    Empty if no run counts.

    Args:
        runs: All runs of the set.
        finished: Names of the finished ones.
        find: Finds the fatigue of a run by its name from a time on, in cycles of 1 Hz.
    """
    weights, situations = weigh_runs(load_set, runs, finished), load_set.chosen
    rows: list[dict[str, float | str]] = []
    damages: dict[tuple[str, float], float] = {}
    for each in runs:
        if (weight := weights.get(each.run.name)) is None:
            continue
        situation = situations[each.situation]
        for found in find(each.run.name, situation.transient):
            for m, equivalent in found.equivalent.items():
                key = found.column, m
                damage = weight * situation.duration * equivalent**m
                damages[key] = damages.get(key, 0.0) + damage
                rows.append(_make_row(each.run.name, key, equivalent, weight))
    for key, damage in damages.items():
        equivalent = (damage / load_set.lifetime.cycles) ** (1.0 / key[1])
        rows.append(_make_row(LIFE, key, equivalent, 1.0))
    return format_rows(rows) if rows else ""


def _make_row(
    run: str, key: tuple[str, float], equivalent: float, times: float
) -> dict[str, float | str]:
    """A row of the table."""
    column, slope = key
    return {
        "run": run,
        "column": column,
        "slope": slope,
        "equivalent_range": equivalent,
        "times_in_life": times,
    }
