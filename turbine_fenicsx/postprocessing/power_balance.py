"""Where the power of a run comes from and where it goes: works, losses and stored energy."""

from collections.abc import Sequence
from itertools import cycle
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.diagram_style import PALETTE
from turbine_fenicsx.postprocessing.plot_style import Look, draw_line
from turbine_fenicsx.records import names
from turbine_fenicsx.records.output_folder import TimeSeries

WINDOWS = 200
"""Maximum number of parts of a run over which means of power are taken."""

SHOWN = 4
"""Terms shown under their names; the smaller ones are added up as "other"."""

MIN_SHARE = 1e-3
"""Minimum size of a term relative to the largest one; smaller terms are too thin to be seen."""

STORED = "stored energy"


OTHER = "other"


def has_power_balance(run: TimeSeries) -> bool:
    """Whether there is more than one way in or out, so that a chart is useful."""
    return len(choose_terms([run])) > 2


def choose_terms(runs: Sequence[TimeSeries]) -> tuple[str, ...]:
    """Names of the terms that all runs show, those that are largest in any run first."""
    shares: dict[str, float] = {}
    for run in runs:
        sizes = {k: float(np.nanmax(np.abs(x))) for k, x in _find_energies(run).items()}
        largest = max(sizes.values()) or 1.0
        for name, size in sizes.items():
            shares[name] = max(shares.get(name, 0.0), size / largest)
    order = sorted(shares, key=lambda name: -shares[name])
    order = [name for name in order if shares[name] > MIN_SHARE]
    return (*order[:SHOWN], *([OTHER] if order[SHOWN:] else []))


def _find_energies(run: TimeSeries) -> dict[str, NDArray[np.float64]]:
    """Energy [J] that each way has brought in since the start: works, minus losses, minus H.

    At all times their sum is the error of the energy, which is round-off.
    """
    found = {STORED: -run[names.TOTAL_ENERGY]}
    found |= {_say(name): work for name, work in run.of(names.WORK).items()}
    found |= {_say(name): -lost for name, lost in run.of(names.DISSIPATION).items()}
    return {name: energy - energy[0] for name, energy in found.items()}


def _pick(run: TimeSeries, terms: Sequence[str]) -> dict[str, NDArray[np.float64]]:
    """The terms of a run, zero where it has none of that name; all others together."""
    energies = _find_energies(run)
    nothing = np.zeros(len(run[names.TIME]))
    rest = sum((energy for name, energy in energies.items() if name not in terms), nothing)
    return {name: rest if name == OTHER else energies.get(name, nothing) for name in terms}


def _say(name: str) -> str:
    """A name of a column as words."""
    return name.replace("_", " ")


def powers(axes: Any, run: TimeSeries, look: Look, terms: Sequence[str]) -> None:
    """Mean powers: what comes in stands above zero, what goes out below; both are equal."""
    rows = np.unique(np.linspace(0, len(run[names.TIME]) - 1, WINDOWS + 1).astype(int))
    t = run[names.TIME][rows]
    ends = np.repeat(t, 2)[1:-1]  # each mean as a step
    above, below = np.zeros(len(ends)), np.zeros(len(ends))
    for (name, energy), color in zip(_pick(run, terms).items(), cycle(PALETTE), strict=False):
        power = np.repeat(np.diff(energy[rows]) / np.diff(t), 2)
        if not look.alone:
            axes.plot(ends, power, color=color, linestyle=look.style, label=name)
            continue
        for base, part in ((above, np.maximum(power, 0.0)), (below, np.minimum(power, 0.0))):
            axes.fill_between(ends, base, base + part, color=color, lw=0.0, alpha=0.85)
            base += part
        axes.plot([], [], color=color, label=name)
    axes.axhline(0.0, color="#333333", lw=0.8)
    axes.set(title="Power", ylabel="in and out [W]")


def works(axes: Any, run: TimeSeries, look: Look, terms: Sequence[str]) -> None:
    """Energy that each path has brought in since the start."""
    for (name, energy), color in zip(_pick(run, terms).items(), cycle(PALETTE), strict=False):
        draw_line(axes, run, energy, look, color=color, label=name)
    axes.set(title="Since the start", ylabel="energy [J]")
