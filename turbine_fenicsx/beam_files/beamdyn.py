"""BeamDyn's files: the primary one with key points of the axis, and the blade's matrices.

Coordinates are those of the blade root: x downwind, z along the span, y = z x x to the trailing
edge. A section with the twist phi has turned by -phi about z,

    d_1 = (cos phi, -sin phi, .),    at right angles to the axis.

Key points and their twist are joined by a cubic spline over z, and three of them by a parabola, as
in BeamDyn.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from turbine_fenicsx.beam_files.beam_blade import BeamBlade
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.keyed_text import KeyedText
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.reduction.beam_sections import BeamSections

ALONG = 400
"""Points of the spline that the axis is made of."""

ROWS = 13
"""Rows of a station: where it is, six of the stiffness, six of the mass."""


def read_beamdyn(path: str | os.PathLike[str]) -> BeamBlade:
    """Read a primary file of BeamDyn and the blade file that it names.

    Raises:
        InputError: with the line or station, if one of them is none or wrong.
        FileError: if one of them cannot be read.
    """
    text = KeyedText.read(path, "BeamDyn")
    count, first = text.find_count("kp_total")
    if count < 3:
        text.fail(first - 1, f"kp_total must be 3 or more, got {count}")
    points = text.read_table(_skip_members(text, first), count, 4)
    line = _make_line(text, points)
    named = text.find("BldFile")
    if named is None:
        raise InputError(f"{text.path} is no file of BeamDyn: it has no BldFile")
    blade = KeyedText.read(Path(path).parent / named[0], "BeamDyn")
    sections, doubts = _read_sections(blade, line.length)
    return BeamBlade(line, sections, (*_list_left_out(text), *doubts))


def list_parts(path: str | os.PathLike[str]) -> list[str]:
    """The blade file that a primary file names."""
    named = KeyedText.read(path).find("BldFile")
    return [] if named is None else [str(Path(path).parent / named[0])]


def _skip_members(text: KeyedText, first: int) -> int:
    """Index of the first line after those that give the key points of each member."""
    members, _ = text.find_count("member_total")
    return first + members


def _make_line(text: KeyedText, points: Array) -> BeamLine:
    """The axis through key points with their twist [deg]."""
    z = points[:, 2]
    if np.any(np.diff(z) <= 0.0):
        k = int(np.argmin(np.diff(z)))
        raise InputError(
            f"{text.path}: kp_zr of key points must rise, it is {z[k]:g} m at {k + 1} and "
            f"{z[k + 1]:g} m at {k + 2}"
        )
    spline = CubicSpline(z, points)
    s = np.unique(np.concatenate([np.linspace(z[0], z[-1], ALONG), z]))
    X, phi = np.split(spline(s), [3], axis=1)
    t = spline(s, 1)[:, :3]
    angle = np.radians(phi[:, 0])
    x, y = np.cos(angle), -np.sin(angle)
    d1 = np.column_stack([x, y, -(t[:, 0] * x + t[:, 1] * y)])  # t_z = 1
    try:
        line = BeamLine(s, X, np.stack([d1, np.cross(t, d1)], axis=1))
        line.at(np.array([0.0]))
    except ModelError as error:
        raise InputError(f"{text.path}: {error}") from None
    return line


def _read_sections(text: KeyedText, length: float) -> tuple[BeamSections, list[str]]:
    """The matrices of a blade file, and sentences about its damping."""
    count, _ = text.find_count("station_total")
    kind = text.find("damp_type") or text.find("damp_flag")
    damped = kind is not None and kind[0] == "1"
    mu = (0.0,) * 6
    if damped:
        mu = tuple(text.read_table(_find_line(text, "mu1"), 1, 6)[0, :6].tolist())
    stations, matrices = [], []
    for row in _read_numbers(text, _find_heading(text), count):
        stations.append(row[0])
        matrices.append(row[1:].reshape(2, 6, 6))
    C, M = np.array(matrices).swapaxes(0, 1)
    at = np.array(stations)
    if np.any(np.diff(at) <= 0.0) or abs(at[0]) > 1e-6 or abs(at[-1] - 1.0) > 1e-6:
        raise InputError(
            f"{text.path}: stations must rise from 0 to 1, got {at[0]:g} to {at[-1]:g}"
        )
    try:
        sections = BeamSections(at * length, C, M, mu)
    except ModelError as error:
        raise InputError(f"{text.path}: {error}") from None
    modal = kind is not None and kind[0] == "2"
    doubts = [f"{Path(text.path).name}: damping of modes (damp_type = 2) is left out"]
    return sections, doubts if modal else []


def _find_line(text: KeyedText, word: str) -> int:
    """Index of the line that begins with a word."""
    for k, line in enumerate(text.lines):
        if line.split()[:1] == [word]:
            return k
    raise InputError(f"{text.path} is no blade file of BeamDyn: it has no {word}")


def _find_heading(text: KeyedText) -> int:
    """Index of the line after the heading of the stations."""
    for k, line in enumerate(text.lines):
        if "distributed" in line.lower() and line.lstrip().startswith("-"):
            return k + 1
    raise InputError(f"{text.path} is no blade file of BeamDyn: it has no distributed properties")


def _read_numbers(text: KeyedText, first: int, count: int) -> Array:
    """The place and both matrices of each station, shape (count, 73)."""
    found: list[float] = []
    rows = 0
    for k in range(first, len(text.lines)):
        if not text.lines[k].strip():
            continue
        found += text.read_numbers(k, 1 if rows % ROWS == 0 else 6)
        rows += 1
        if rows == ROWS * count:
            return np.array(found).reshape(count, -1)
    raise InputError(
        f"{text.path}: expected {count} stations with two matrices of 6 rows each, and it ends in "
        f"station {rows // ROWS + 1}"
    )


def _list_left_out(text: KeyedText) -> list[str]:
    """Sentences about settings that are not followed."""
    found = text.find("UsePitchAct")
    if found is not None and found[0].lower() in ("true", "t"):
        return [f"{Path(text.path).name}: UsePitchAct is left out; [pitch] says how blades pitch"]
    return []
