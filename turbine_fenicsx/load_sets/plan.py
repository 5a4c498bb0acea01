"""Runs of a load set: each situation with its winds, yaw errors, variants and seeds."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import degrees, nan
from typing import Any

from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.load_sets.load_set import LoadSet
from turbine_fenicsx.load_sets.situation import Situation
from turbine_fenicsx.study.plan import MOST_RUNS, Run, as_overrides, make_runs
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.steady.operating_states import Schedule, find_schedule

FINENESS = 0.05
"""Rated wind speeds are found to this [m/s]."""

LIGHT = {"output.fields_every": 0}
"""Changes that all runs have unless the set has others: fields would fill the disk."""

Place = tuple[float, float, str, int | None]
"""Wind speed, yaw error, variant and seed of a run."""


@dataclass(frozen=True, eq=False)
class SetRun:
    """A run of a load set.

    Args:
        run: The run of the study that the set is.
        situation: Name of its situation.
        wind: Speed at the hub [m/s].
        yaw_error: Angle of the wind [rad].
        variant: Name of its variant.
        seed: Of the turbulence; None without one.
    """

    run: Run
    situation: str
    wind: float
    yaw_error: float
    variant: str
    seed: int | None


def plan_set(load_set: LoadSet, overrides: Iterable[str] = ()) -> list[SetRun]:
    """All runs of a set, in the order of its situations.

    Args:
        overrides: More changes of all runs, such as ``"time.step=0.1"``, in place of those of the
            set; those of a situation are stronger.

    Raises:
        InputError: with one sentence for every mistake.
    """
    given = [*as_overrides(load_set.set), *overrides]
    common = [*as_overrides(LIGHT), *given]
    case = Case.load(load_set.case, common)
    chosen = load_set.chosen
    needs = [name for name, s in chosen.items() if _needs_controller(s, load_set)]
    if needs and case.control.kind == "none":
        raise InputError(
            f'situation "{needs[0]}" needs a controller, but the case has control.kind = "none"'
        )
    schedule = find_schedule(case) if needs else None
    starts: dict[float, dict[str, Any]] = {}
    rated = load_set.rated or (nan if schedule is None else _find_rated(schedule, load_set))
    planned: dict[str, tuple[dict[str, Any], str, Place]] = {}
    for name, situation in chosen.items():
        if situation.uses is not None:
            continue
        for place, changes in _vary(load_set, situation, rated):
            wind, yaw, variant, seed = place
            if situation.start == "turning" and schedule is not None and wind not in starts:
                starts[wind] = _find_start(schedule, wind)
            own = starts[wind] if situation.start == "turning" else {}
            folder = f"{name}/{_name(wind, yaw, variant, seed)}"
            if folder in planned:
                raise InputError(f"situation {name!r} has the run {folder!r} twice")
            if len(planned) == MOST_RUNS:
                raise InputError(f"the set has more than {MOST_RUNS} runs")
            planned[folder] = {**own, **changes}, name, place
    for key in (each.partition("=")[0].strip() for each in given):
        if planned and all(key in own for own, *_ in planned.values()):
            raise InputError(f"{key!r} has no effect: each situation has its own")
    runs = make_runs(load_set.case, common, {key: own for key, (own, *_) in planned.items()})
    return [SetRun(run, planned[run.name][1], *planned[run.name][2]) for run in runs]


def _vary(
    load_set: LoadSet, situation: Situation, rated: float
) -> Iterator[tuple[Place, dict[str, Any]]]:
    """Places of a situation and their changes by dotted key."""
    turbulent = situation.turbulence != "none"
    site: dict[str, Any] = {"wind.turbine_class": load_set.turbine_class}
    if turbulent:
        site["wind.turbulence.model"] = load_set.turbulence
    number = situation.seeds or load_set.seeds
    first = 1
    for wind in load_set.find_winds(situation, rated):
        for yaw in situation.yaw_errors:
            seeds: list[int | None] = [None]
            if turbulent and isinstance(number, int):
                seeds = [*range(first, first + number)]
                first += number
            elif turbulent:
                assert isinstance(number, tuple)
                seeds = [*number]
            for variant, own in situation.variants.items():
                for seed in seeds:
                    changes = {"wind.speed": wind, "wind.direction": yaw, **site}
                    if seed is not None:
                        changes["wind.turbulence.seed"] = seed
                    yield (wind, yaw, variant, seed), {**changes, **situation.changes, **own}


def _name(wind: float, yaw: float, variant: str, seed: int | None) -> str:
    """Folder of a run, for example ``v12_y-8_left_s3``."""
    parts = [f"v{wind:.6g}", f"y{degrees(yaw):.4g}" if yaw else "", variant]
    return "_".join(filter(None, [*parts, "" if seed is None else f"s{seed}"]))


def _find_start(schedule: Schedule, wind: float) -> dict[str, Any]:
    """Keys of a case for the speed and the pitch at a wind speed."""
    try:
        state = schedule.at(wind)
    except ModelError as error:
        raise InputError(f"there is no steady state at {wind:g} m/s: {error}") from None
    # rounded, so that the last digits of a search make no other runs
    return {
        "turbine.rotor_speed": round(state.rotor_speed, 6),
        "pitch.initial": round(state.pitch, 6),
    }


def _needs_controller(situation: Situation, load_set: LoadSet) -> bool:
    """Whether the controller says how runs begin, or where the rated wind is."""
    uses_rated = load_set.rated is None and any("rated" in str(x) for x in situation.winds)
    return situation.uses is None and (situation.start == "turning" or uses_rated)


def _find_rated(schedule: Schedule, load_set: LoadSet) -> float:
    """Least wind speed at which blades pitch to keep the power [m/s], to `FINENESS`."""
    low, high = load_set.cut_in, load_set.cut_out
    while high - low > FINENESS:
        middle = 0.5 * (low + high)
        state = schedule.at(middle)
        low, high = (low, middle) if state.pitch > state.least_pitch else (middle, high)
    return round(high, 1)
