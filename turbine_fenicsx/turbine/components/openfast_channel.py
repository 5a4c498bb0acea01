"""Channels of ``history.out``: made from values in SI units, and chosen by patterns."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.names import split_unit
from turbine_fenicsx.records.openfast_names import (
    DEFAULT,
    find_row,
    list_equal,
    matches,
)
from turbine_fenicsx.simulation.observers.history import Channel, Restartable
from turbine_fenicsx.simulation.snapshot import Snapshot


def in_openfast(
    columns: Sequence[str],
    values: Callable[[Snapshot], Sequence[float] | Array],
    memory: Restartable | None = None,
) -> Channel:
    """A channel of ``history.out`` from values in SI units.

    Args:
        columns: First names of rows of the table of channels, without units.
        values: One number per name in the order of the names; an array of any shape.
        memory: As of `Channel`.
    """
    rows = [find_row(name) for name in columns]
    factors = np.array([row.factor for row in rows if row is not None])
    units = [row.unit for row in rows if row is not None]
    named = tuple(f"{name}_[{unit}]" for name, unit in zip(columns, units, strict=True))
    return Channel(named, lambda s: (factors * np.ravel(values(s))).tolist(), memory)


def choose_channels(channels: Iterable[Channel], patterns: Sequence[str]) -> list[Channel]:
    """The channels that patterns choose; the others are never evaluated.

    Channels that the table does not have are those of components of users, and stay.

    Args:
        patterns: Such as ``"default"`` and ``"RootM*"``, of which each chooses something.

    Raises:
        InputError: for a pattern that chooses nothing.
    """
    found, idle = [], [p for p in patterns if p != DEFAULT]
    for channel in channels:
        chosen: list[tuple[int, str]] = []
        for place, column in enumerate(channel.columns):
            name, unit = split_unit(column)
            for other in list_equal(name):
                if find_row(name) is None or matches(other, patterns):
                    chosen.append((place, f"{other}_[{unit}]"))
                    idle = [p for p in idle if not matches(other, [p])]
        if chosen:
            found.append(_pick(channel, chosen))
    if idle:
        raise InputError(
            f"output.channels: this turbine has no channel {idle[0]!r}, of a part or a load that "
            "it lacks"
        )
    return found


def choose_columns(channels: Iterable[Channel], columns: Sequence[str]) -> list[Channel]:
    """The channels of the columns that a file already has."""
    found = []
    for channel in channels:
        chosen = [
            (place, f"{other}_[{unit}]")
            for place, (name, unit) in enumerate(map(split_unit, channel.columns))
            for other in list_equal(name)
            if f"{other}_[{unit}]" in columns
        ]
        if chosen:
            found.append(_pick(channel, chosen))
    return found


def _pick(channel: Channel, chosen: Sequence[tuple[int, str]]) -> Channel:
    """Some columns of a channel, by their places and names."""
    if [name for _, name in chosen] == list(channel.columns):
        return channel
    places = [place for place, _ in chosen]

    def values(snapshot: Snapshot) -> list[float]:
        row = channel.row(snapshot)
        return [row[place] for place in places]

    return Channel(tuple(name for _, name in chosen), values, channel.memory)
