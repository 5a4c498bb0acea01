"""Turbulent wind in full-field files of TurbSim (.bts)."""

from __future__ import annotations

import os

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import name_file_in_errors, open_regular, replace_file
from turbine_fenicsx.wind.inflow import FASTEST
from turbine_fenicsx.wind.turbulence import MAX_BYTES, PLAUSIBLE, TurbulenceField
from turbine_fenicsx.wind.turbulent_wind import TurbulentWind

NOT_PERIODIC, PERIODIC = 7, 8
"""First number of a file."""

HEADER = np.dtype(
    [
        ("kind", "<i2"),
        *((name, "<i4") for name in ("n_z", "n_y", "n_tower", "n_t")),
        *((name, "<f4") for name in ("dz", "dy", "dt", "u_hub", "z_hub", "z_bottom")),
        ("scales", "<f4", (3, 2)),
        ("n_text", "<i4"),
    ]
)


def read_turbsim(path: str | os.PathLike[str]) -> TurbulenceField:
    """Read a full-field file of TurbSim; points below the grid (of the tower) are left out.

    Args:
        path: A file with the ending .bts.

    Returns:
        The field. One that is not periodic leads by the time that half its width takes, as in
        OpenFAST, so that all of the rotor lies within it at t = 0.

    Raises:
        InputError: if it is none, or too large.
        FileError: if it cannot be read.
    """
    name = os.fspath(path)
    with name_file_in_errors("read", path), open_regular(path) as file:
        start = file.read(HEADER.itemsize)
        if len(start) < HEADER.itemsize:
            raise InputError(f"{name} is no full-field file of TurbSim: it is too short")
        head = np.frombuffer(start, HEADER)[0]
        _check_header(name, head)
        n_t, n_z, n_y, n_tower = (int(head[k]) for k in ("n_t", "n_z", "n_y", "n_tower"))
        row = 3 * (n_z * n_y + n_tower)
        begin = HEADER.itemsize + int(head["n_text"])
        there = max(0, os.fstat(file.fileno()).st_size - begin) // (2 * row)
        if there < n_t:
            raise InputError(
                f"{name} is cut off: it has {there} of the {n_t} planes that it announces"
            )
        file.seek(begin)
        raw = np.fromfile(file, "<i2", n_t * row)
    # without the tower's points each lookup would copy the field to make it contiguous
    planes = np.ascontiguousarray(raw.reshape(n_t, row)[:, : 3 * n_z * n_y])
    planes = planes.reshape(n_t, n_z, n_y, 3)
    slope, intercept = head["scales"].astype(float).T
    ends = np.array([planes.min(axis=(0, 1, 2)), planes.max(axis=(0, 1, 2))])
    fastest = np.max(np.abs((ends - intercept) / slope))
    if not fastest <= FASTEST:
        raise InputError(f"{name} has a wind of {fastest:g} m/s, at most {FASTEST:g} m/s are taken")
    y = (np.arange(n_y) - 0.5 * (n_y - 1)) * float(head["dy"])
    z = float(head["z_bottom"]) + np.arange(n_z) * float(head["dz"])
    periodic, speed = int(head["kind"]) == PERIODIC, float(head["u_hub"])
    lead = 0.0 if periodic else float(y[-1]) / speed
    dt = float(head["dt"])
    return TurbulenceField(planes, slope, intercept, dt, y, z, speed, periodic, lead)


def write_turbsim(path: str | os.PathLike[str], wind: TurbulentWind, note: str = "") -> None:
    """Write a wind as a full-field file of TurbSim: the mean wind with what it carries along.

    Velocities have steps of 1/65535 of their range.

    Args:
        path: A file with the ending .bts; an old one is replaced.
        wind: The wind, whose mean is along x.
        note: Line in the head of the file.
    """
    field, mean = wind.fluctuations, wind.mean
    values = (field.values - field.intercept) / field.slope
    values[..., 0] += mean.at_heights(field.z)[:, None]
    low, high = values.min(axis=(0, 1, 2)), values.max(axis=(0, 1, 2))
    slope = 65535.0 / np.maximum(high - low, 1e-3)
    intercept = -32768.0 - slope * low
    text = note.encode("ascii", "replace")[:200]
    n_t, n_z, n_y, _ = values.shape
    head = np.zeros(1, HEADER)
    entries = {
        **{"kind": PERIODIC if field.periodic else NOT_PERIODIC, "n_z": n_z, "n_y": n_y},
        **{"n_t": n_t, "dz": field.z[1] - field.z[0], "dy": field.y[1] - field.y[0]},
        **{"dt": field.dt, "u_hub": mean.speed, "z_hub": mean.hub_height, "z_bottom": field.z[0]},
        **{"scales": np.stack([slope, intercept], axis=1), "n_text": len(text)},
    }
    for name, value in entries.items():
        head[name] = value
    # the file has slopes and intercepts of four bytes, by which readers go
    slope, intercept = head["scales"][0].astype(float).T
    numbers = np.clip(np.rint(values * slope + intercept), -32768, 32767).astype("<i2")
    replace_file(path, head.tobytes() + text + numbers.tobytes())


def read_turbsim_height(path: str | os.PathLike[str]) -> float:
    """Height of the hub that a full-field file was made for [m]."""
    with name_file_in_errors("read", path), open_regular(path) as file:
        start = file.read(HEADER.itemsize)
    if len(start) < HEADER.itemsize:
        raise InputError(f"{os.fspath(path)} is no full-field file of TurbSim: it is too short")
    return float(np.frombuffer(start, HEADER)[0]["z_hub"])


def _check_header(name: str, head: np.void) -> None:
    """Raise an InputError for numbers that no file of TurbSim has."""
    if int(head["kind"]) not in (NOT_PERIODIC, PERIODIC):
        raise InputError(
            f"{name} is no full-field file of TurbSim: it begins with {int(head['kind'])}, "
            f"expected {NOT_PERIODIC} or {PERIODIC}"
        )
    for word, fewest in (("n_z", 2), ("n_y", 2), ("n_tower", 0), ("n_t", 2), ("n_text", 0)):
        if int(head[word]) < fewest:
            raise InputError(f"{name}: {word} must be at least {fewest}, got {int(head[word])}")
    for word, (least, most, unit) in PLAUSIBLE.items():
        if not least <= float(head[word]) <= most:
            raise InputError(
                f"{name}: {word} must be between {least:g} and {most:g} {unit}, got "
                f"{float(head[word]):g}"
            )
    if not np.all(np.isfinite(head["scales"])) or not np.all(head["scales"][:, 0]):
        raise InputError(f"{name}: slopes of its velocities must be finite and not zero")
    size = 6 * int(head["n_t"]) * (int(head["n_z"]) * int(head["n_y"]) + int(head["n_tower"]))
    if size > MAX_BYTES:
        raise InputError(f"{name} needs {size / 2**30:.3g} GiB, at most 4 are read")
