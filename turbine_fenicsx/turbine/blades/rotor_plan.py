"""Where the blades of a case stand, and what they are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, sin

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing import RotorLayout
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.turbine.blades.blade_plan import BladePlan
from turbine_fenicsx.turbine.blades.solid_blades import SolidBlades
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.turbine_file import load_turbine
from turbine_fenicsx.turbine.tables.turbine import TurbineCase

AZIMUTHS = (-2.0 * np.pi / 3.0, 0.0, 2.0 * np.pi / 3.0)
"""Azimuths of blades 1, 2, 3 (bodies 3, 4, 5) about the shaft from the top [rad]."""

PITCH_SIGNS = (1.0, -1.0, 1.0)
"""The paper counts the pitch of the upright blade negative about its outward axis."""


@dataclass(frozen=True)
class RotorPlan:
    """Blades before they are built."""

    layout: RotorLayout
    blades: BladePlan

    @property
    def tips(self) -> list[Array]:
        """Initial positions of the tips, each of shape (3,) [m]."""
        numbers = range(1, self.layout.n_blades + 1)
        return [self.layout.place(self.blades.tip[None], k)[0] for k in numbers]

    def mesh_source(self) -> tuple[str, Callable[[], MeshArrays]]:
        """Name of the blade mesh, and the function that makes it on rank 0."""
        return self.blades.mesh_source(self.layout)

    def list_mistakes(self, mesh: MeshArrays) -> tuple[str, ...]:
        """One sentence for everything that keeps a mesh from being these blades."""
        return self.blades.list_mistakes(mesh, self.layout)


def plan_layout(turbine: TurbineCase) -> RotorLayout:
    """Where the blades of a case stand; tilt and cone count positive as in OpenFAST."""
    t = turbine
    return RotorLayout(
        centre=(0.0, t.hub_rise, -t.hub_distance),
        axis=(0.0, sin(t.tilt), cos(t.tilt)),
        azimuths=AZIMUTHS,
        cone=t.precone,
    )


def plan_rotor(case: Case, comm: MPI.Intracomm = MPI.COMM_SELF) -> RotorPlan:
    """The blades of a case. Collective.

    Args:
        case: The case.
        comm: Whose rank 0 reads the windIO file of the case, if it has one.

    Raises:
        ModelError: if stations and widths do not fit together.
        InputError: if the file cannot be read, on all ranks.
    """
    layout = plan_layout(case.turbine)
    if case.turbine.file is None and not case.has_beam_blades:
        return RotorPlan(layout, SolidBlades.of(case))
    if _are_beams(case, comm):
        from turbine_fenicsx.turbine.blades.beam_blades import BeamBlades

        return RotorPlan(layout, BeamBlades.of(case, comm))
    from turbine_fenicsx.turbine.blades.hollow_blades import HollowBlades  # takes long to load

    return RotorPlan(layout, HollowBlades.of(case, comm))


def _are_beams(case: Case, comm: MPI.Intracomm) -> bool:
    """Whether blades of a file are beams, or rigid ones of a file without a layup. Collective."""
    file = case.turbine.file
    if case.turbine.model == "hybrid" or file is None:
        return case.has_beam_blades
    return not on_rank0(comm, lambda: load_turbine(file).blade.has_layup)
