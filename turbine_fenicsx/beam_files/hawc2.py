"""HAWC2's files: a body of an htc file, and the structural file that it names.

HAWC2's axes of a section are x to the leading edge and y to the suction side, z along the span;
here x is to the suction side and y to the trailing edge, so that x = y_H, y = -x_H. Its twist turns
about z. The axis is a monotone cubic spline through the sections of ``c2_def``.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from turbine_fenicsx.beam_files.beam_blade import BeamBlade
from turbine_fenicsx.beam_files.htc import Command, find_file, read_commands
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.keyed_text import KeyedText
from turbine_fenicsx.foundation.section_matrices import move_stiffness, place_inertia
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.reduction.beam_sections import BeamSections

ALONG = 400
"""Points along the axis."""

TIMOSHENKO, FULL = 19, 30
"""Columns of a structural file: of a Timoshenko beam, and of fully populated matrices (FPM)."""

TURN = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""From HAWC2's axes to those of this package."""


def read_hawc2(path: str | os.PathLike[str], body: str = "blade1") -> BeamBlade:
    """Read a main body of an htc file and its structural file.

    Args:
        path: The htc file; files in it are sought from its folder, then from those above.
        body: Name of the body.

    Raises:
        InputError: with the line or station, if something is missing or wrong.
        FileError: if a file cannot be read.
    """
    htc = Path(path)
    commands = _read_body(htc, body)
    line = _read_axis(htc, commands)
    name = _find(htc, commands, "filename", 1).value()
    choice = _find(htc, commands, "set", 2)
    numbers = (choice.whole(1), choice.whole(2))
    full = any(c.name == "fpm" and c.value() == "1" for c in commands)
    table = _read_table(find_file(htc, name), numbers, FULL if full else TIMOSHENKO)
    times, doubts = _read_damping(commands)
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
    """Files that an htc file names: those that continue it, and structural ones."""
    commands = list(read_commands(Path(path)))
    others = [c.text.path for c in commands if c.text.path != os.fspath(path)]
    named = [c.value() for c in commands if c.name == "filename" and c.value()]
    found = (find_file(Path(path), name) for name in dict.fromkeys(named))
    return [*dict.fromkeys(others), *(str(file) for file in found if file.is_file())]


def _read_body(path: Path, body: str) -> list[Command]:
    """The commands of a main body."""
    own: list[Command] | None = None
    names = []
    for command in read_commands(path):
        words = tuple(word.lower() for word in command.words[:2])
        if words == ("begin", "main_body"):
            own = []
        elif words == ("end", "main_body") and own is not None:
            name = next((c.value() for c in own if c.name == "name"), "")
            if name.lower() == body.lower():
                return own
            names.append(name)
            own = None
        elif own is not None:
            own.append(command)
    known = f"; it has {', '.join(names)}" if names else ""
    raise InputError(f"{path} has no main_body {body!r}{known}")


def _find(path: Path, commands: list[Command], name: str, values: int) -> Command:
    """The first command of a name, with some values or more."""
    for command in commands:
        if command.name == name:
            if len(command.words) <= values:
                command.fail(f"expected {values} values of {name}")
            return command
    raise InputError(f"{path}: the body has no {name}")


def _read_axis(path: Path, commands: list[Command]) -> BeamLine:
    """The axis through the sections of ``c2_def``, with its twist [deg]."""
    count = _find(path, commands, "nsec", 1)
    rows = [c.numbers(2, 4) for c in commands if c.name == "sec"]
    if len(rows) != count.whole(1) or len(rows) < 2:
        count.fail(f"nsec must be the number of sections, two or more, got {len(rows)}")
    points = np.array(rows)
    steps = np.linalg.norm(np.diff(points[:, :3], axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(steps)])
    rises = np.minimum(np.diff(points[:, 2]), np.diff(at))
    if np.any(rises <= 0.0):
        count.fail(f"z of sections must rise, it does not from {np.argmin(rises) + 1} on")
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
        raise InputError(f"{count.text.path}: {error}") from None
    return line


def _read_damping(commands: list[Command]) -> tuple[Array, list[str]]:
    """Times of the damping of each strain, and sentences about what is left out."""
    times, doubts = np.zeros(6), []
    for command in commands:
        name = Path(command.text.path).name
        if command.name in ("damping_posdef", "damping_aniso"):
            mass, (of_x, of_y, of_z) = np.split(command.numbers(1, 6), 2)
            times[3:] = of_y, of_x, of_z
            if np.any(mass):
                doubts.append(f"{name}: {command.name} in proportion to the mass is left out")
        elif command.name.startswith("damping"):
            doubts.append(f"{name}: {command.name} is left out; give blade.damping")
    return times, doubts


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
    x_s, y_s, E, G, I_x, I_y, K, k_x, k_y, A, pitch, x_e, y_e = table[:, 6:19].T
    angle = np.radians(pitch)
    stretch, shear = np.zeros((2, len(table), 6, 6))
    stretch[:, 2, 2], stretch[:, 3, 3], stretch[:, 4, 4] = E * A, E * I_x, E * I_y
    shear[:, 0, 0], shear[:, 1, 1], shear[:, 5, 5] = k_x * G * A, k_y * G * A, G * K
    C = move_stiffness(stretch, x_e, y_e, angle) + move_stiffness(shear, x_s, y_s, angle)
    M = _make_mass(table, x_e, y_e, angle)
    return _turn(C), _turn(M)


def _make_full(table: Array) -> tuple[Array, Array]:
    """Stiffness and inertia of a table of 30 columns, about ``c2_def``."""
    pitch, x_e, y_e = table[:, 6:9].T
    K = np.zeros((len(table), 6, 6))
    i, j = np.triu_indices(6)
    K[:, i, j] = K[:, j, i] = table[:, 9:30]
    angle = np.radians(pitch)
    C = move_stiffness(K, x_e, y_e, angle)
    M = _make_mass(table, x_e, y_e, angle)
    return _turn(C), _turn(M)


def _make_mass(table: Array, x_e: Array, y_e: Array, angle: Array) -> Array:
    """Inertia by the first columns of a table, about ``c2_def``.

    Radii of gyration are about the axes of bending through the elastic centre.
    """
    m, x_g, y_g, ri_x, ri_y = table[:, 1:6].T
    c, s = np.cos(angle), np.sin(angle)
    # from the elastic centre to that of mass, in the axes of bending
    x, y = c * (x_g - x_e) + s * (y_g - y_e), -s * (x_g - x_e) + c * (y_g - y_e)
    squares = np.column_stack([ri_x**2 - y**2, ri_y**2 - x**2])
    return place_inertia(m, np.column_stack([x_g, y_g]), squares, angle)


def _turn(matrices: Array) -> Array:
    """Matrices in the axes of this package."""
    R = np.kron(np.eye(2), TURN)
    return np.asarray(R @ matrices @ R.T)
