"""Shapes of modes as ``modes.xdmf``, one time for each."""

from __future__ import annotations

import os
from collections.abc import Mapping

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.analysis.mode import Modes
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.observers.field_grid import FieldGrid

AMPLITUDE_RATIO = 0.1
"""Largest displacement of a shape over the size of the model."""


def write_mode_shapes(
    path: str | os.PathLike[str],
    grid: FieldGrid,
    modes: Modes,
    information: Mapping[str, str] | None = None,
) -> None:
    """Write the shapes of modes. Collective.

    The times are the numbers of the modes, from 1. The points are where the equilibrium has them;
    ``mode_real`` and ``mode_imaginary`` are the parts a and b of a motion a cos(phase) - b
    sin(phase), so large that a model as a whole shows them.
    """
    state = modes.state
    displacement = grid.displacement(state.q, state.u)
    points = grid.positions + displacement
    ends = np.concatenate([p.max(axis=0, initial=-np.inf) for p in (points, -points)])
    grid.comm.Allreduce(MPI.IN_PLACE, ends, op=MPI.MAX)
    size = float(np.max(ends[:3] + ends[3:]))  # longest edge of the box around all points [m]
    series = grid.open(path, information=information)
    for number, mode in enumerate(modes.modes, start=1):
        a = grid.motion(mode.real.q, mode.real.u)
        b = np.zeros_like(a)
        if mode.imaginary is not None:
            b = grid.motion(mode.imaginary.q, mode.imaginary.u)
        factor = AMPLITUDE_RATIO * size / _find_largest(grid.comm, a, b)
        series.write(
            number,
            points,
            point_data={
                "displacement": displacement,
                "mode_real": factor * a,
                "mode_imaginary": factor * b,
            },
        )


def _find_largest(comm: MPI.Intracomm, a: Array, b: Array) -> float:
    """Largest distance |a cos(phase) - b sin(phase)| of any point at any phase."""
    # the long half axis of the ellipse that the point runs along
    aa, ab, bb = (np.sum(x * y, axis=1) for x, y in ((a, a), (a, b), (b, b)))
    longest = np.sqrt(0.5 * (aa + bb + np.hypot(aa - bb, 2.0 * ab)))
    return float(comm.allreduce(np.max(longest, initial=1e-300), op=MPI.MAX))
