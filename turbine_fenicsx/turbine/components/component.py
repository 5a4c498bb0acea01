"""Components of a turbine, each of which brings its parts, columns and pictures."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.bodies.rigid_surface import RigidSurface
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing import LoadedMesh, load_arrays
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.records.conventions import BLADES
from turbine_fenicsx.simulation.observer import Observer
from turbine_fenicsx.simulation.observers.cell_values import CellValues
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.rotor_plan import RotorPlan
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.wind.inflow import PlacedInflow


@dataclass(frozen=True, eq=False)
class Assembly:
    """The turbine during assembly, while components are added.

    Args:
        case: The case.
        comm: Communicator.
        rotor: Where the blades stand, and their shape.
        parts: Bodies, joints and forces of the components that stand already.
        meshes: Mesh of each flexible body that has named groups, by the name of the body.
        inflow: The wind where there is no turbine, in its axes; None without wind.
    """

    case: Case
    comm: MPI.Intracomm
    rotor: RotorPlan
    parts: list[Any] = field(default_factory=list)
    meshes: dict[str, LoadedMesh] = field(default_factory=dict)
    inflow: PlacedInflow | None = None

    def find(self, name: str) -> Any | None:
        """The part of a name; None if there is none."""
        return next((p for p in self.parts if getattr(p, "name", None) == name), None)

    def part(self, name: str) -> Any:
        """The part of a name, for example the body ``"nacelle"`` or the joint ``"rotor"``.

        Raises:
            ModelError: if there is none.
        """
        found = self.find(name)
        if found is None:
            known = ", ".join(p.name for p in self.parts if hasattr(p, "name"))
            raise ModelError(f"the turbine has no part {name!r}; it has {known or 'none yet'}")
        return found

    def load_mesh(
        self,
        body: str,
        source: str,
        make: Callable[[], MeshArrays],
        check: Callable[[MeshArrays], Sequence[str]] | None = None,
    ) -> LoadedMesh:
        """Make the mesh of a flexible body on rank 0 and distribute it. Collective.

        Args:
            body: Name of the body.
            source: What the mesh is called in errors.
            make: Makes it; called on rank 0.
            check: Finds what else is wrong with it, one sentence each; called on rank 0.

        Raises:
            ModelError: if the mesh cannot be made or does not pass the check.
            InputError: if a file cannot be read or written.
        """
        try:
            mesh = load_arrays(self.comm, make, source, check)
        except OSError as error:
            raise InputError(str(error)) from None
        self.meshes[body] = mesh
        return mesh


@dataclass(frozen=True, eq=False, kw_only=True)
class Turbine(Assembly):
    """A turbine ready to run.

    Args:
        components: What it is made of, in the order of its columns.
        system: Its system.
        numbers: Number in the field output of each part by its name; bodies have one always.
    """

    components: tuple[Component, ...]
    system: MultibodySystem
    numbers: dict[str, int]

    @property
    def component_names(self) -> str:
        """Description of its parts."""
        return ", ".join(type(component).__name__ for component in self.components)

    def surfaces(self) -> list[RigidSurface]:
        """Surfaces of all rigid parts, for pictures."""
        return [surface for c in self.components for surface in c.surfaces(self)]

    def fields(self) -> list[CellValues]:
        """More fields of flexible bodies. Collective."""
        return [field for c in self.components for field in c.fields(self)]

    def part_names(self) -> dict[int, str]:
        """Name of each part in the field output by its number."""
        return {number: name for name, number in self.numbers.items()}

    def parts_of_cells(self) -> list[Array]:
        """Number of the part of each local cell, ghosts included; one array for each copy."""
        found = []
        for body in self.system.flexible_bodies:
            cells, copies = body.full.mesh.topology.index_map(3), len(body.placements)
            own = np.full(cells.size_local + cells.num_ghosts, float(self.numbers[body.name]))
            mesh = self.meshes.get(body.name)
            if copies == len(BLADES):
                found += [np.full_like(own, self.numbers[name]) for name in BLADES]
                continue
            for name in mesh.cell_names if mesh else ():
                assert mesh is not None
                own[mesh.cells(name)] = self.numbers[name]
            found += [own] * copies
        return found


@dataclass(frozen=True)
class Channels:
    """Columns that a component adds to the time series.

    Args:
        history: Those of ``history.csv``.
        openfast: Those of ``history.out``; each column is called ``Name_[unit]``.
    """

    history: Sequence[Channel] = ()
    openfast: Sequence[Channel] = ()


@runtime_checkable
class Component(Protocol):
    """A component of a turbine: tower, pitch bearings, drivetrain.

    A class that inherits from this one has to say its parts; for the rest there are defaults.
    Components are built from the ground up, each on what stands already.
    """

    def mistakes(self, case: Case) -> Iterable[str]:
        """One sentence for everything in a case or in itself that keeps it from being built.

        Called on rank 0, which reads files, before anything is built.
        """
        return ()

    @abstractmethod
    def parts(self, assembly: Assembly) -> Iterable[Any]:
        """Bodies, joints, couplings, forces and motions that it adds to what stands. Collective."""

    def channels(self, turbine: Turbine) -> Channels:
        """Columns of the time series; called once per run. Collective."""
        return Channels()

    def surfaces(self, turbine: Turbine) -> Iterable[RigidSurface]:
        """Surfaces of its rigid parts, for pictures."""
        return ()

    def fields(self, turbine: Turbine) -> Iterable[CellValues]:
        """More fields of its flexible bodies; called once per run. Collective."""
        return ()

    def observers(self, turbine: Turbine, folder: Path) -> Iterable[Observer]:
        """Its observers, such as a controller; called once per run. Collective.

        They see each state before the files are written. One that has a name, `save` and `restore`
        keeps its state over a restart.

        Args:
            turbine: The turbine.
            folder: Output folder of the run, which is there.
        """
        return ()
