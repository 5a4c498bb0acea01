"""HAWC2's files: a body of an htc file, and the structural file that it names.

HAWC2's axes of a section are x to the leading edge and y to the suction side, z along the span;
here x is to the suction side and y to the trailing edge, so that x = y_H, y = -x_H. Its twist turns
about z. The axis is a monotone cubic spline through the sections of ``c2_def``.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from turbine_fenicsx.beam_files.beam_blade import BeamBlade
from turbine_fenicsx.beam_files.section_matrices import make_inertia, move_stiffness
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.keyed_text import LARGEST, KeyedText
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.reduction.beam_sections import BeamSections

ALONG = 400
"""Points along the axis."""

TIMOSHENKO, FULL = 19, 30
"""Columns of a structural file: of a Timoshenko beam, and of fully populated matrices (FPM)."""

TURN = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""From HAWC2's axes to those of this package."""


@dataclass(frozen=True)
class Command:
    """A command of an htc file.

    Args:
        line: Index of its line.
        words: Its name, then its values.
    """

    line: int
    words: tuple[str, ...]


def read_hawc2(path: str | os.PathLike[str], body: str = "blade1") -> BeamBlade:
    """Read a main body of an htc file and its structural file.

    Args:
        path: The htc file; files in it are sought from its folder, and from those above.
        body: Name of the body.

    Raises:
        InputError: with the line or station, if something is missing or wrong.
        FileError: if a file cannot be read.
    """
    text = KeyedText.read(path, "HAWC2")
    commands = _read_body(text, body)
    line = _read_axis(text, commands)
    name = _find(text, commands, "filename", 1).words[1]
    choice = _find(text, commands, "set", 2)
    numbers = tuple(_whole(text, choice, k) for k in (1, 2))
    full = next((c for c in commands if c.words[0] == "fpm" and c.words[1:2] == ("1",)), None)
    table = _read_table(_find_file(Path(path), name), numbers, FULL if full else TIMOSHENKO)
    times, doubts = _read_damping(text, commands)
    make = _make_full if full else _make_timoshenko
    try:
        r = table[:, 0] * line.length / table[-1, 0]
        sections = BeamSections(r, *make(table), times)
    except ModelError as error:
        raise InputError(f"{name}: {error}") from None
    if abs(table[-1, 0] - line.length) > 0.01 * line.length:
        doubts.append(
            f"{Path(name).name}: its stations end at {table[-1, 0]:.5g} m, and the axis of {body} "
            f"at {line.length:.5g} m; they are stretched to it"
        )
    return BeamBlade(line, sections, tuple(doubts))


def list_parts(path: str | os.PathLike[str]) -> list[str]:
    """Structural files that an htc file names."""
    commands = _read_commands(KeyedText.read(path, "HAWC2"))
    named = [c.words[1] for c in commands if c.words[0] == "filename" and len(c.words) > 1]
    found = (_find_file(Path(path), name) for name in dict.fromkeys(named))
    return [str(file) for file in found if file.is_file()]


def _read_commands(text: KeyedText) -> Iterator[Command]:
    """The commands of a file, in lower case but for names of files."""
    for k, line in enumerate(text.lines):
        words = line.split(";")[0].split()
        if words:
            yield Command(k, (words[0].lower(), *words[1:]))


def _read_body(text: KeyedText, body: str) -> list[Command]:
    """The commands of a main body."""
    own: list[Command] | None = None
    names = []
    for command in _read_commands(text):
        words = tuple(word.lower() for word in command.words[:2])
        if words == ("begin", "main_body"):
            own = []
        elif words == ("end", "main_body") and own is not None:
            name = next((c.words[1] for c in own if c.words[0] == "name" and len(c.words) > 1), "")
            if name.lower() == body.lower():
                return own
            names.append(name)
            own = None
        elif own is not None:
            own.append(command)
    known = f"; it has {', '.join(names)}" if names else ""
    raise InputError(f"{text.path} has no main_body {body!r}{known}")


def _find(text: KeyedText, commands: list[Command], name: str, values: int) -> Command:
    """The first command of a name, with some values or more."""
    for command in commands:
        if command.words[0] == name:
            if len(command.words) <= values:
                text.fail(command.line, f"expected {values} values of {name}")
            return command
    raise InputError(f"{text.path}: the body has no {name}")


def _whole(text: KeyedText, command: Command, k: int) -> int:
    """A value that is a whole number."""
    word = command.words[k]
    if not re.fullmatch(r"\d{1,6}", word):
        text.fail(command.line, f"expected a whole number, got {word!r}")
    return int(word)


def _floats(text: KeyedText, command: Command, first: int, count: int) -> Array:
    """Some values that are numbers."""
    try:
        found = np.array([float(word) for word in command.words[first : first + count]])
    except ValueError:
        found = np.zeros(0)
    if len(found) < count or not np.all(np.abs(found) <= LARGEST):
        text.fail(command.line, f"expected {count} numbers, got {' '.join(command.words)!r}")
    return found


def _read_axis(text: KeyedText, commands: list[Command]) -> BeamLine:
    """The axis through the sections of ``c2_def``, with its twist [deg]."""
    count = _find(text, commands, "nsec", 1)
    rows = [_floats(text, c, 2, 4) for c in commands if c.words[0] == "sec"]
    if len(rows) != _whole(text, count, 1) or len(rows) < 2:
        text.fail(count.line, f"nsec must be the number of sections, two or more, got {len(rows)}")
    points = np.array(rows)
    steps = np.linalg.norm(np.diff(points[:, :3], axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(steps)])
    rises = np.minimum(np.diff(points[:, 2]), np.diff(at))
    if np.any(rises <= 0.0):
        raise InputError(
            f"{text.path}: z of sections must rise, it does not from {np.argmin(rises) + 1} on"
        )
    s = np.unique(np.concatenate([np.linspace(0.0, at[-1], ALONG), at]))
    spline = PchipInterpolator(at, points)
    X, t = spline(s)[:, :3], spline(s, 1)[:, :3]
    angle = np.radians(spline(s)[:, 3])
    c = np.column_stack([np.cos(angle), np.sin(angle)])
    # at a right angle to t, and seen along z at the angle of the twist
    x = np.column_stack([t[:, 2:] * c, -np.sum(t[:, :2] * c, axis=1)])
    directors = np.stack([np.cross(t, x), -x], axis=1)  # y_H and -x_H
    try:
        line = BeamLine(s, X @ TURN.T, directors @ TURN.T)
        line.at(s)
    except ModelError as error:
        raise InputError(f"{text.path}: {error}") from None
    return line


def _read_damping(text: KeyedText, commands: list[Command]) -> tuple[Array, list[str]]:
    """Times of the damping of each strain, and sentences about what is left out."""
    times, name = np.zeros(6), Path(text.path).name
    doubts = []
    for command in commands:
        if command.words[0] == "damping_posdef":
            mass, (of_x, of_y, of_z) = np.split(_floats(text, command, 1, 6), 2)
            times[3:] = of_y, of_x, of_z
            if np.any(mass):
                doubts.append(f"{name}: damping_posdef in proportion to the mass is left out")
        elif command.words[0].startswith("damping"):
            doubts.append(f"{name}: {command.words[0]} is left out; give blade.damping")
    return times, doubts


def _find_file(htc: Path, name: str) -> Path:
    """A file that an htc file names, relative to the folder in which HAWC2 runs: one above it."""
    parts = Path(name.replace("\\", "/"))
    places = [htc.parent / parts, htc.parent.parent / parts]
    return next((place for place in places if place.is_file()), places[0])


def _read_table(path: Path, numbers: tuple[int, ...], columns: int) -> Array:
    """Rows of a set and its subset."""
    text = KeyedText.read(path, "HAWC2")
    own = False
    for k, line in enumerate(text.lines):
        match = re.match(r"\s*([#$])\s*(\d+)(?:\s+(\d+))?", line)
        if match is None:
            continue
        if match[1] == "#":
            own = int(match[2]) == numbers[0]
        elif own and int(match[2]) == numbers[1]:
            if match[3] is None:
                text.fail(k, "expected the number of rows after that of the subset")
            last = k + int(match[3])
            if last >= len(text.lines):
                text.fail(k, f"expected {match[3]} rows, and the file ends before")
            rows = [text.read_numbers(i, columns) for i in range(k + 1, last + 1)]
            return _check_rows(text, k, np.array(rows))
    raise InputError(f"{path} has no set {numbers[0]} with subset {numbers[1]}")


def _check_rows(text: KeyedText, line: int, table: Array) -> Array:
    """Stations rise from zero."""
    if len(table) < 2 or table[0, 0] != 0.0 or np.any(np.diff(table[:, 0]) <= 0.0):
        text.fail(line, "expected two rows or more, whose first column rises from 0")
    return table


def _make_timoshenko(table: Array) -> tuple[Array, Array]:
    """Stiffness and inertia of a table of 19 columns, about ``c2_def``."""
    _, m, x_g, y_g, ri_x, ri_y, x_s, y_s, E, G, I_x, I_y, K, k_x, k_y, A, pitch, x_e, y_e = table.T
    angle = np.radians(pitch)
    stretch, shear = np.zeros((2, len(table), 6, 6))
    stretch[:, 2, 2], stretch[:, 3, 3], stretch[:, 4, 4] = E * A, E * I_x, E * I_y
    shear[:, 0, 0], shear[:, 1, 1], shear[:, 5, 5] = k_x * G * A, k_y * G * A, G * K
    C = move_stiffness(stretch, x_e, y_e, angle) + move_stiffness(shear, x_s, y_s, angle)
    M = make_inertia(m, x_g, y_g, np.column_stack([ri_x, ri_y]), angle)
    return _turn(C), _turn(M)


def _make_full(table: Array) -> tuple[Array, Array]:
    """Stiffness and inertia of a table of 30 columns, about ``c2_def``."""
    _, m, x_g, y_g, ri_x, ri_y, pitch, x_e, y_e = table[:, :9].T
    K = np.zeros((len(table), 6, 6))
    i, j = np.triu_indices(6)
    K[:, i, j] = K[:, j, i] = table[:, 9:30]
    C = move_stiffness(K, x_e, y_e, np.radians(pitch))
    M = make_inertia(m, x_g, y_g, np.column_stack([ri_x, ri_y]), np.radians(pitch))
    return _turn(C), _turn(M)


def _turn(matrices: Array) -> Array:
    """Matrices in the axes of this package."""
    R = np.kron(np.eye(2), TURN)
    return np.asarray(R @ matrices @ R.T)
