"""Turbulence that a case asks for: planned by its keys, made once, kept beside the case."""

from __future__ import annotations

import hashlib
import json
import logging
import os
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.array_file import read_arrays, write_arrays
from turbine_fenicsx.foundation.errors import FileError, InputError
from turbine_fenicsx.foundation.files import name_file_in_errors
from turbine_fenicsx.turbine.tables.tables import Tables
from turbine_fenicsx.turbine.tables.turbulence import FOLDER
from turbine_fenicsx.wind.box_grid import BoxGrid
from turbine_fenicsx.wind.gusts import TurbineClass
from turbine_fenicsx.wind.inflow import FASTEST, SteadyWind
from turbine_fenicsx.wind.kaimal import KaimalModel
from turbine_fenicsx.wind.mann_model import MannModel
from turbine_fenicsx.wind.turbulent_wind import TurbulentWind, carry_box

log = logging.getLogger(__name__)

MODELS: dict[str, type[KaimalModel] | type[MannModel]] = {"kaimal": KaimalModel, "mann": MannModel}
"""Models of turbulence by their names in a case."""

VERSION = 1
"""Grows when the same plan gives another wind."""

WIDTH = 1.15
"""Width of a box over the diameter of the rotor, unless the ground is nearer."""

LENGTH, GROWTH, HIGH = 42.0, 0.7, 60.0
"""Lambda_1 of hubs above 60 m, and its growth with the height below, IEC 61400-1 [m]."""


@dataclass(frozen=True)
class TurbulencePlan:
    """All that the numbers of a box depend on.

    Attributes:
        model: "kaimal" or "mann".
        speed: Mean wind [m/s].
        deviation: Standard deviation along the wind [m/s].
        length: Lambda_1 [m].
        grid: The points.
        seed: Of the random numbers.
    """

    model: str
    speed: float
    deviation: float
    length: float
    grid: BoxGrid
    seed: int

    @staticmethod
    def of(case: Tables) -> TurbulencePlan:
        """The plan of a case whose wind has a model of turbulence and a speed.

        Raises:
            ModelError: if the box is too large.
        """
        w, height = case.wind, case.hub_height
        t, V = w.turbulence, w.speed
        assert t.is_made and V is not None
        kind = TurbineClass(*w.class_and_category)
        extreme = t.level == "extreme"
        deviation = kind.extreme_deviation(V) if extreme else kind.normal_deviation(V)
        if t.intensity is not None:
            deviation = t.intensity * V
        radius = case.blade.hub_radius + case.blade.length
        width = 2.0 * min(WIDTH * radius, height) if t.width is None else t.width
        duration = t.find_duration(case.time.end)
        grid = BoxGrid.covering(duration, t.time_step, V, width, t.points)
        length = min(GROWTH * height, GROWTH * HIGH)
        return TurbulencePlan(t.model, V, deviation, length, grid, t.seed)

    @property
    def name(self) -> str:
        """Name of its file, which follows from all numbers."""
        text = json.dumps([VERSION, asdict(self)], sort_keys=True)
        return f"{self.model}-{hashlib.sha256(text.encode()).hexdigest()[:12]}.npz"

    def make(self) -> npt.NDArray[np.float32]:
        """The fluctuations, shape (n_x, n_z, n_y, 3) [m/s]."""
        model = MODELS[self.model](self.speed, self.deviation, self.length)
        return model.make(self.grid, self.seed)

    def carry(self, values: npt.NDArray[np.float32], case: Tables) -> TurbulentWind:
        """The wind with the fluctuations; numbers of no memory do for a look at its size."""
        mean = SteadyWind(self.speed, case.hub_height, case.wind.shear)
        return carry_box(values, self.grid.spacing, mean)

    def describe(self) -> str:
        """The plan in words."""
        n_x, n_y, n_z = self.grid.points
        dx, dy, _ = self.grid.spacing
        intensity = 100.0 * self.deviation / self.speed
        duration = n_x * dx / self.speed
        return (
            f"turbulence by {self.model.capitalize()}'s model, intensity {intensity:.3g} %, seed "
            f"{self.seed}: {n_x} x {n_y} x {n_z} points, {duration:.5g} s, "
            f"{(n_y - 1) * dy:.4g} m wide"
        )


def outline_turbulence(case: Tables) -> TurbulentWind:
    """The turbulence of a case without its numbers, to look at its size."""
    plan = TurbulencePlan.of(case)
    n_x, n_y, n_z = plan.grid.points
    nothing = np.broadcast_to(np.float32(0.0), (n_x, n_z, n_y, 3))
    return plan.carry(nothing, case)


def take_turbulence(case: Tables) -> TurbulentWind:
    """The turbulence of a case, from its file or made and kept there. Called on rank 0."""
    plan = TurbulencePlan.of(case)
    folder = _find_folder(case)
    return plan.carry(_take(plan, None if folder is None else folder / plan.name), case)


@lru_cache(maxsize=1)
def _take(plan: TurbulencePlan, path: Path | None) -> npt.NDArray[np.float32]:
    """Fluctuations of a plan, from a file if it has them."""
    if path is not None and path.is_file():
        try:
            return _read(path, plan)
        except (InputError, FileError) as error:
            log.info("%s; it is made again", error)
    log.info("%s", plan.describe())
    values = plan.make()
    if path is not None:
        try:
            with name_file_in_errors("write", path.parent):
                path.parent.mkdir(exist_ok=True)
            write_arrays(path, {"velocities": values})
            log.info("the turbulence is kept in %s", path)
        except FileError as error:  # it is made again in as many seconds
            log.warning("the turbulence is not kept: %s", error)
    return values


def _read(path: Path, plan: TurbulencePlan) -> npt.NDArray[np.float32]:
    """Fluctuations of a file."""
    what = "a turbulence box of this case"
    values: Any = read_arrays(path, what).get("velocities")
    n_x, n_y, n_z = plan.grid.points
    if (
        values is None
        or values.dtype != np.float32
        or values.shape != (n_x, n_z, n_y, 3)
        or not np.all(np.abs(values) <= FASTEST)
    ):
        raise InputError(f"{str(path)!r} is not {what}, or damaged")
    return np.asarray(values, dtype=np.float32)


def _find_folder(case: Tables) -> Path | None:
    """Folder for boxes of a case that may be written; None without one."""
    named, beside = case.wind.turbulence.folder, getattr(case, "folder", None)
    if named is not None:
        folder = Path(named)
    elif beside is not None:
        folder = Path(beside) / FOLDER
    else:
        return None
    nearest = folder if folder.exists() else folder.parent
    if not (nearest.is_dir() and os.access(nearest, os.W_OK)):
        log.warning("turbulence cannot be kept in %s, which is no folder for writing", folder)
        return None
    return folder
