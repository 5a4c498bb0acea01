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


def choose_channels(channels: Sequence[Channel], patterns: Sequence[str]) -> list[Channel]:
    """The channels that patterns choose; the others are never evaluated.

    Channels that the table does not have are those of components of users, and stay.

    Args:
        patterns: Such as ``"default"`` and ``"RootM*"``, of which each chooses something.

    Raises:
        InputError: for a pattern that chooses nothing.
    """
    known = {name for c in channels for column in c.columns for name in list_names(column)}
    for pattern in patterns:
        if pattern != DEFAULT and not any(matches(name, [pattern]) for name in known):
            raise InputError(
                f"output.channels: this turbine has no channel {pattern!r}, of a part, a load or a "
                "place (output.sections, output.tower_sections) that it lacks"
            )
    return _choose(channels, lambda name, _: find_row(name) is None or matches(name, patterns))


def choose_columns(channels: Sequence[Channel], columns: Sequence[str]) -> list[Channel]:
    """The channels of the columns that a file already has."""
    return _choose(channels, lambda _, column: column in columns)


def list_names(column: str) -> tuple[str, ...]:
    """All names of a column, without the unit."""
    return list_equal(split_unit(column)[0])


def _choose(channels: Iterable[Channel], takes: Callable[[str, str], bool]) -> list[Channel]:
    """Channels with the columns, under any of their names, that a function of both takes."""
    found = []
    for channel in channels:
        chosen = [
            (place, named)
            for place, column in enumerate(channel.columns)
            for name in list_names(column)
            for named in (f"{name}_[{split_unit(column)[1]}]",)
            if takes(name, named)
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
