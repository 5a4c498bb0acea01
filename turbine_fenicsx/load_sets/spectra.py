"""Spectra of a load set: power spectral densities, means over the runs of a wind speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from scipy.signal import welch

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.records.output_folder import read_history

CHANNELS = (
    names.HUB_WIND(axis="x"),
    names.ROOT_MOMENT(blade=1, axis="y"),
    names.TOWER_BASE_MOMENT(axis="y"),
)
"""Channels whose spectra are found."""

SEGMENT = 0.25
"""Length of the segments of Welch's method, as a part of the run."""

Spectra = dict[str, dict[float, tuple[Array, Array]]]
"""Frequencies [Hz] and densities, in the square of the unit by Hz, by channel and wind speed."""


def find_spectra(folder: Path, runs: Mapping[float, Sequence[str]], begin: float) -> Spectra:
    """Spectra of channels, of runs that have all of one step and duration.

    Args:
        folder: Of the set.
        runs: Names by wind speed.
        begin: Time before which nothing counts [s].
    """
    found: Spectra = {}
    for speed, members in runs.items():
        parts: dict[str, list[tuple[Array, Array]]] = {}
        for name in members:
            try:
                history = read_history(folder / name / "history.csv")
            except InputError:  # a folder that was moved away
                continue
            time = history[names.TIME]
            there = time > begin
            for channel in CHANNELS:
                if channel in history.columns and np.count_nonzero(there) > 8:
                    values = history[channel][there]
                    step = float(np.diff(time[there]).mean())
                    length = max(8, int(SEGMENT * len(values)))
                    parts.setdefault(channel, []).append(welch(values, 1.0 / step, nperseg=length))
        for channel, spectra in parts.items():
            frequencies = spectra[0][0]
            same = [density for f, density in spectra if len(f) == len(frequencies)]
            found.setdefault(channel, {})[speed] = frequencies[1:], np.mean(same, axis=0)[1:]
    return found
