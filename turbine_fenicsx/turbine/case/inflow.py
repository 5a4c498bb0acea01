"""The wind of a case, in the axes of the turbine."""

from __future__ import annotations

from dataclasses import replace

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.case.files import read_if_changed
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.rotations import E1, E2, E3
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.turbine.case.turbulence import outline_turbulence, take_turbulence
from turbine_fenicsx.turbine.tables.tables import Tables
from turbine_fenicsx.turbine.tables.wind import BoxCase, WindCase
from turbine_fenicsx.turbine.tables.wind_table import FALLBACKS, load_wind_table
from turbine_fenicsx.wind.compiled_turbulence import compile_turbulence
from turbine_fenicsx.wind.gusts import (
    CoherentGust,
    DirectionChange,
    OperatingGust,
    TurbineClass,
    WindShear,
)
from turbine_fenicsx.wind.inflow import Inflow, PlacedInflow, RampedInflow, SteadyWind, turn
from turbine_fenicsx.wind.mann import read_mann_box
from turbine_fenicsx.wind.tabulated_wind import TabulatedWind
from turbine_fenicsx.wind.turbsim import read_turbsim
from turbine_fenicsx.wind.turbulence import TurbulenceField
from turbine_fenicsx.wind.turbulent_wind import TurbulentWind

AXES = np.array([E3, E1, E2])
"""Axes x, y, z of the wind as rows: downwind, to the left looking downwind, up."""


def make_inflow(case: Tables, comm: MPI.Intracomm = MPI.COMM_SELF) -> PlacedInflow | None:
    """The wind of a case; None without one. Collective.

    Args:
        comm: Whose rank 0 reads the file of the wind, if it has one.
    """
    w = case.wind
    if not w.blows:
        return None
    if w.table is not None:
        inflow: Inflow = on_rank0(comm, lambda: make_tabulated_wind(case))
    elif w.file is not None or w.has_box:
        inflow = _compile(on_rank0(comm, lambda: load_turbulence(case)))
    else:
        inflow = _make_wind(case)
    if w.ramp:
        inflow = RampedInflow(inflow, w.ramp)
    return place_inflow(case, inflow, turned=w.table is None and (w.file is not None or w.has_box))


def place_inflow(case: Tables, inflow: Inflow, turned: bool = False) -> PlacedInflow:
    """A wind over the ground in the axes of the turbine.

    Args:
        turned: Whether the wind is turned as a whole about the axis of the tower at the height of
            the hub; else it has its direction and inclination by itself.
    """
    axes = _turn_axes(case) if turned else AXES
    return PlacedInflow(inflow, axes, case.turbine.hub_rise * E2 - case.hub_height * axes[2])


def _turn_axes(case: Tables) -> Array:
    """Axes x, y, z of a wind that blows in a direction and upwards, as rows."""
    along = turn(case.wind.direction, case.wind.inclination)
    across = turn(case.wind.direction + 0.5 * np.pi)
    return np.asarray(np.array([along, across, np.cross(along, across)]) @ AXES)


def make_tabulated_wind(case: Tables) -> TabulatedWind:
    """The wind of a table; shear, direction and inclination that it lacks are those of the case."""
    w = case.wind
    assert w.table is not None
    table = load_wind_table(w.table)
    columns = {key: np.full(len(table.times), getattr(w, key)) for key in FALLBACKS}
    diameter = 2.0 * (case.blade.hub_radius + case.blade.length)
    return TabulatedWind(table.times, {**columns, **table.columns}, case.hub_height, diameter)


def load_turbulence(case: Tables) -> TurbulenceField | TurbulentWind:
    """The turbulence of a case; files that have not changed are read once."""
    file = case.wind.file
    return load_box(case) if file is None else _load_field(file)


def load_box(case: Tables) -> TurbulentWind:
    """The wind of a case that carries a box along, which is read or made. Called on rank 0."""
    w = case.wind
    if w.turbulence.is_made:
        return take_turbulence(case)
    assert w.speed is not None and w.box.files is not None
    mean = SteadyWind(w.speed, case.hub_height, w.shear)
    return _read_box(w.box.files, w.box, mean)


def _compile(wind: TurbulenceField | TurbulentWind) -> TurbulenceField | TurbulentWind:
    """A turbulence with C code to look it up, which a rank cannot send to others."""
    if isinstance(wind, TurbulentWind):
        return replace(wind, fluctuations=compile_turbulence(wind.fluctuations))
    return compile_turbulence(wind)


@read_if_changed(size=1)
def _load_field(path: str) -> TurbulenceField:
    """The turbulence of a file."""
    return read_turbsim(path)


@read_if_changed(size=1)
def _read_box(files: tuple[str, str, str], box: BoxCase, mean: SteadyWind) -> TurbulentWind:
    """The turbulence of a box."""
    assert box.points is not None and box.spacing is not None
    return read_mann_box(files, box.points, box.spacing, mean, box.periodic, box.scale)


def list_field_mistakes(case: Tables) -> list[str]:
    """Mistakes of a case's turbulence, one sentence each; it is not made for that."""
    made = case.wind.turbulence.is_made
    wind = outline_turbulence(case) if made else load_turbulence(case)
    radius = case.blade.hub_radius + case.blade.length
    centre = np.array([-case.turbine.hub_distance, 0.0, 0.0]) @ (AXES @ _turn_axes(case).T)
    centre[2] += case.hub_height
    return wind.list_mistakes(case.time.end, centre, radius)


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
    kind = TurbineClass(*w.class_and_category)
    assert w.speed is not None
    common = (w.speed, height, diameter, w.gust_start, kind, w.shear, w.direction)
    if w.gust == "EOG":
        return OperatingGust(*common)
    if w.gust == "EDC":
        return DirectionChange(*common, sign=w.gust_sign)
    if w.gust == "ECD":
        return CoherentGust(*common, sign=w.gust_sign)
    return WindShear(*common, sign=w.gust_sign, horizontal=w.gust == "EWSH")
