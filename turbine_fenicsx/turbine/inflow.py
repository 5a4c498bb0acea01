"""The wind of a case, in the axes of the turbine."""

from __future__ import annotations

import os
from functools import lru_cache

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.rotations import E1, E2, E3
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.turbine.case.tables import Tables
from turbine_fenicsx.turbine.case.wind import WindCase
from turbine_fenicsx.wind.gusts import (
    CoherentGust,
    DirectionChange,
    OperatingGust,
    TurbineClass,
    WindShear,
)
from turbine_fenicsx.wind.inflow import Inflow, PlacedInflow, SteadyWind
from turbine_fenicsx.wind.ramped_inflow import RampedInflow
from turbine_fenicsx.wind.turbsim import read_turbsim
from turbine_fenicsx.wind.turbulence import TurbulenceField

AXES = np.array([E3, E1, E2])
"""Axes x, y, z of the wind as rows: downwind, to the left looking downwind, up."""


def make_inflow(case: Tables, comm: MPI.Intracomm = MPI.COMM_SELF) -> PlacedInflow | None:
    """The wind of a case; None without one. Collective.

    Args:
        case: The case.
        comm: Whose rank 0 reads the file of the wind, if it has one.

    Raises:
        InputError: if it cannot be read, on all ranks.
    """
    w = case.wind
    if not w.blows:
        return None
    file = w.file
    inflow: Inflow = on_rank0(comm, lambda: load_field(file)) if file else _make_wind(case)
    if w.ramp:
        inflow = RampedInflow(inflow, w.ramp)
    return PlacedInflow(inflow, AXES, (0.0, case.turbine.hub_rise - case.hub_height, 0.0))


def load_field(path: str) -> TurbulenceField:
    """The turbulence of a file; a file that has not changed is read once.

    Raises:
        InputError: if it cannot be read, or is no file of TurbSim.
    """
    try:
        status = os.stat(path)
    except (OSError, ValueError) as error:
        raise InputError(f"cannot read {quote(path)}: {error}") from None
    return _load(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=1)
def _load(path: str, changed: int, size: int) -> TurbulenceField:
    """The turbulence of a file as it is now."""
    return read_turbsim(path)


def list_field_mistakes(case: Tables) -> list[str]:
    """What keeps the file of the wind from being that of a case, one sentence each.

    Raises:
        InputError: if it cannot be read.
    """
    assert case.wind.file is not None
    radius = case.blade.hub_radius + case.blade.length
    centre = np.array([-case.turbine.hub_distance, 0.0, case.hub_height])
    return load_field(case.wind.file).list_mistakes(case.time.end, centre, radius)


def _make_wind(case: Tables) -> Inflow:
    """The steady wind of a case, or its gust."""
    w, height = case.wind, case.hub_height
    assert w.speed is not None
    if w.gust == "none":
        return SteadyWind(w.speed, height, w.shear, w.direction, w.inclination)
    diameter = 2.0 * (case.blade.hub_radius + case.blade.length)
    return _make_gust(w, height, diameter)


def _make_gust(w: WindCase, height: float, diameter: float) -> Inflow:
    """A transient of IEC 61400-1."""
    kind = TurbineClass(w.turbine_class, w.turbulence)
    assert w.speed is not None
    common = (w.speed, height, diameter, w.gust_start, kind, w.shear, w.direction)
    if w.gust == "EOG":
        return OperatingGust(*common)
    if w.gust == "EDC":
        return DirectionChange(*common, sign=w.gust_sign)
    if w.gust == "ECD":
        return CoherentGust(*common, sign=w.gust_sign)
    return WindShear(*common, sign=w.gust_sign, horizontal=w.gust == "EWSH")
