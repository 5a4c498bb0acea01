"""Fatigue over the life of a turbine: how often each run happens, and equivalent loads of all.

Runs of situations that evaluate fatigue stand for winds or events. The speeds of those that last as
long as the wind blows divide all winds among them, from middle to middle of neighbours. With the
probability p of the winds of a speed (Weibull) and a life L, its n runs of duration T happen

    w = p L/(n T)

times each. Events happen as often as `Situation.per_year` says. With the cycles n_i of ranges S_i,

    S_eq = (sum_runs w sum_i n_i S_i^m / N)^(1/m)

is the range that does the same damage in N cycles. Means count, by Goodman's correction, for loads
whose ultimate load the set gives.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import exp, gamma

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote, suggest
from turbine_fenicsx.load_sets.load_set import LoadSet
from turbine_fenicsx.load_sets.plan import SetRun
from turbine_fenicsx.postprocessing.cycles import (
    Cycles,
    correct_means,
    equivalent_range,
    join_cycles,
)
from turbine_fenicsx.postprocessing.fatigue import find_slope
from turbine_fenicsx.records.mode_tables import format_rows
from turbine_fenicsx.turbine.life.weighted_run import YEAR

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


def make_bins(load_set: LoadSet, situations: Collection[str], runs: Sequence[SetRun]) -> WindBins:
    """Winds that the speeds of situations stand for, which last as long as their wind blows."""
    life = load_set.lifetime
    speeds = sorted({each.wind for each in runs if each.situation in situations})
    return WindBins(speeds, life.shape, life.mean_wind or MEAN_WIND * load_set.reference)


def weigh_runs(
    load_set: LoadSet, runs: Sequence[SetRun], finished: Collection[str]
) -> dict[str, float]:
    """How often the finished runs that count for fatigue happen in the life, by name.

    Runs of one speed, or event, share what the others of it leave.
    """
    situations, life = load_set.chosen, load_set.lifetime
    counted = {name: s for name, s in situations.items() if s.evaluates == "fatigue"}
    bins = make_bins(load_set, [n for n, s in counted.items() if not s.per_year], runs)
    done = [each for each in runs if each.situation in counted and each.run.name in finished]
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


@dataclass(frozen=True, eq=False)
class SetFatigue:
    """Fatigue of a load set.

    Attributes:
        slopes: Of the S-N curves of all loads, by their names.
        of_runs: Equivalent ranges in cycles of 1 Hz, by run and load.
        of_life: Those in the equivalent cycles of the life, by load.
        cycles: All cycles of the life by load, as they were counted.
        times: How often each run happens in the life.
    """

    slopes: dict[str, float]
    of_runs: dict[str, dict[str, float]]
    of_life: dict[str, float]
    cycles: dict[str, Cycles]
    times: dict[str, float]


def find_fatigue_of_set(
    load_set: LoadSet, runs: Sequence[SetRun], counted: Mapping[str, Mapping[str, Cycles]]
) -> SetFatigue:
    """Equivalent ranges of runs and of the life.

    Args:
        runs: All runs of the set.
        counted: Cycles of finished runs by run and load.

    Raises:
        InputError: for ultimate loads that no run has, or that a cycle reaches.
    """
    life, times = load_set.lifetime, weigh_runs(load_set, runs, counted)
    durations = {each.run.name: load_set.chosen[each.situation].duration for each in runs}
    loads = list(dict.fromkeys(load for run in times for load in counted[run]))
    for load in life.ultimate:
        if loads and load not in loads:
            raise InputError(
                f"lifetime.ultimate: {quote(load)} is no load of these runs{suggest(load, loads)}"
            )
    slopes = {load: find_slope(load) for load in loads}
    of_runs: dict[str, dict[str, float]] = {run: {} for run in times}
    of_life, cycles = {}, {}
    for load, m in slopes.items():
        parts = {run: counted[run][load] for run in times if load in counted[run]}
        cycles[load] = join_cycles([part.weigh(times[run]) for run, part in parts.items()])
        if load in life.ultimate:
            parts = {
                run: correct_means(part, life.ultimate[load], load) for run, part in parts.items()
            }
        for run, part in parts.items():
            of_runs[run][load] = equivalent_range(part, m, durations[run])
        every = join_cycles([part.weigh(times[run]) for run, part in parts.items()])
        of_life[load] = equivalent_range(every, m, life.cycles)
    return SetFatigue(slopes, of_runs, of_life, cycles, times)


def format_fatigue_of_set(found: SetFatigue) -> str:
    """``fatigue.csv``: equivalent ranges of each run in cycles of 1 Hz, and of the life."""
    rows: list[dict[str, float | str]] = []
    for run, ranges in [*found.of_runs.items(), (LIFE, found.of_life)]:
        for load, equivalent in ranges.items():
            rows.append(
                {
                    "run": run,
                    "column": load,
                    "slope": found.slopes[load],
                    "equivalent_range": equivalent,
                    "times_in_life": found.times.get(run, 1.0),
                }
            )
    return format_rows(rows) if rows else ""
