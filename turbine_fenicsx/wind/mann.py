"""Turbulence boxes of HAWC2 and of Mann's model: three binary files with u, v and w.

Each file holds 4-byte floats, plane after plane of the box in the order in which they reach the
turbine. In a plane z runs fastest, from below, and y from left to right, looking downwind. This is
how OpenFAST's InflowWind reads them. They are the fluctuations alone, to which the mean wind is
added. J. Mann, Wind field simulation, Probabilistic Engineering Mechanics 13 (1998) 269-282.
"""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.argument_checks import check_array
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.files import name_file_in_errors, open_regular, replace_file
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.inflow import FASTEST, SteadyWind
from turbine_fenicsx.wind.turbulence import MAX_BYTES, SPACING
from turbine_fenicsx.wind.turbulent_wind import TurbulentWind, carry_box


def read_mann_box(
    paths: Sequence[str | os.PathLike[str]],
    points: Sequence[int],
    spacing: Sequence[float],
    mean: SteadyWind,
    periodic: bool = False,
    scale: npt.ArrayLike = (1.0, 1.0, 1.0),
) -> TurbulentWind:
    """Read a turbulence box.

    Args:
        paths: The three files with u, v and w.
        points: Number of points along x, y and z, two or more each.
        spacing: Distances between points along x, y and z [m].
        mean: The mean wind, along x; the middle of the box is at its hub height.
        periodic: Whether the box restarts when it has passed, as those of Mann's model may; else it
            must last for the run.
        scale: Factors for u, v and w [-].

    Returns:
        The wind. One that is not periodic leads by the time that half its width takes, so that all
        of the rotor lies within it at t = 0.

    Raises:
        InputError: if sizes of files and box do not fit together, or numbers are not finite.
        FileError: if a file cannot be read.
        ModelError: if the mean wind does not blow along x, or the numbers do not make a box.
    """
    n_x, n_y, n_z, factors = _check_box(paths, points, spacing, mean, scale)
    values = np.empty((n_x, n_z, n_y, 3), dtype=np.float32)
    for k, path in enumerate(paths):
        box = _read_component(path, (n_x, n_y, n_z))
        # from (x, y to the right, z) to (x, z, y to the left)
        values[..., k] = box[:, ::-1, :].transpose(0, 2, 1) * np.float32(factors[k])
    return carry_box(values, spacing, mean, periodic)


def write_mann_box(paths: Sequence[str | os.PathLike[str]], box: TurbulentWind) -> None:
    """Write the fluctuations of a box in three files, as `read_mann_box` reads them.

    Args:
        paths: Files for u, v and w; old ones are replaced.
        box: The wind.
    """
    field = box.fluctuations
    for k, path in enumerate(paths):
        values = (field.values[..., k] - field.intercept[k]) / field.slope[k]
        # from (x, z, y to the left) to (x, y to the right, z)
        replace_file(path, values.transpose(0, 2, 1)[:, ::-1].astype("<f4").tobytes())


def _check_box(
    paths: Sequence[str | os.PathLike[str]],
    points: Sequence[int],
    spacing: Sequence[float],
    mean: SteadyWind,
    scale: npt.ArrayLike,
) -> tuple[int, int, int, Array]:
    """Numbers of points and factors, all checked."""
    if isinstance(paths, str | os.PathLike) or len(paths) != 3:
        raise ModelError(f"a turbulence box needs three files, of u, v and w, got {paths!r}")
    n = check_array("points of a turbulence box", points, (3,), "three whole numbers")
    if np.any(n != np.round(n)) or np.any(n < 2.0):
        raise ModelError(f"points of a turbulence box must be whole, two or more, got {points!r}")
    d = check_array("spacing of a turbulence box", spacing, (3,), "three distances")
    least, most, _ = SPACING
    if not np.all((d >= least) & (d <= most)):
        raise ModelError(
            f"spacing of a turbulence box must be between {least:g} and {most:g} m, got {spacing!r}"
        )
    factors = check_array("scale of a turbulence box", scale, (3,), "three factors")
    if not mean.speed > 0.0 or mean.direction != 0.0 or mean.inclination != 0.0:
        raise ModelError(
            "the mean wind of a turbulence box must blow along x with a positive speed; axes of "
            "PlacedInflow turn it"
        )
    size = 12.0 * float(np.prod(n))
    if size > MAX_BYTES:
        raise InputError(f"a turbulence box of {size / 2**30:.3g} GiB is too large, at most 4")
    n_x, n_y, n_z = (int(one) for one in n)
    return n_x, n_y, n_z, factors


def _read_component(
    path: str | os.PathLike[str], shape: tuple[int, int, int]
) -> npt.NDArray[np.float32]:
    """One component of the fluctuations, (n_x, n_y, n_z) [m/s]."""
    name, count = os.fspath(path), int(np.prod(shape))
    with name_file_in_errors("read", path), open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        if size != 4 * count:
            n_x, n_y, n_z = shape
            raise InputError(
                f"{name} has {size} bytes, but a turbulence box of {n_x} x {n_y} x {n_z} points "
                f"has {4 * count}"
            )
        values = np.fromfile(file, "<f4", count)
    if values.size != count or not np.all(np.isfinite(values)):
        raise InputError(f"{name} has values that are not finite, or ends too early")
    if max(values.max(), -values.min()) > FASTEST:
        raise InputError(
            f"{name} has fluctuations of {max(values.max(), -values.min()):g} m/s, at most "
            f"{FASTEST:g} m/s are taken"
        )
    return values.reshape(shape)
