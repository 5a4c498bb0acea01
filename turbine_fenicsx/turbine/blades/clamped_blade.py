"""One blade of a case, clamped at its root: what a basis is made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Generic, TypeVar

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.frame_fields import frame_fields
from turbine_fenicsx.bodies.placement import Placement
from turbine_fenicsx.meshing import LoadedMesh
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.rotor_plan import RotorPlan
from turbine_fenicsx.turbine.blades.single_blade import list_unequal_blades, take_blade

B = TypeVar("B", bound=DeformableBody)

BLADE, ROOT, SKIN = "blade_1", "root_1", "skin_1"
"""Groups of the mesh of a blade, which is the first one of the rotor."""


@dataclass
class SingleMesh:
    """Makes the mesh of one blade on rank 0 and looks at that of the rotor, whose part it is."""

    rotor: RotorPlan
    _whole: list[MeshArrays] = field(default_factory=list, init=False)

    @property
    def source(self) -> str:
        """Name of the mesh."""
        return self.rotor.mesh_source()[0]

    def make(self) -> MeshArrays:
        """The mesh of the blade."""
        make: Callable[[], MeshArrays] = self.rotor.mesh_source()[1]
        self._whole[:] = [make()]
        return take_blade(self._whole[0], self.rotor.layout)

    def examine(self, blade: MeshArrays) -> tuple[str, ...]:
        """One sentence for everything that keeps the mesh from being these blades."""
        mesh, rotor = self._whole.pop(), self.rotor
        mistakes = rotor.list_mistakes(mesh)
        if not mistakes:
            mistakes = tuple(list_unequal_blades(mesh, rotor.layout))
        return mistakes


@dataclass(frozen=True, eq=False)
class ClampedBlade(Generic[B]):
    """A blade in its own axes from the rotor centre.

    Args:
        body: The blade, on its mesh or as one copy of a reduced body.
        root: Facets of its root, indices local to this rank.
    """

    body: B
    root: npt.NDArray[np.int32]
    skin: npt.NDArray[np.int32]
    system: MultibodySystem

    @staticmethod
    def of(name: str, mesh: LoadedMesh, rotor: RotorPlan) -> ClampedBlade[FlexibleBody]:
        """The blade of a material on a mesh of `SingleMesh`. Collective."""
        axes = frame_fields(mesh.mesh, mesh.cell_tags, {mesh.cell_names[BLADE]: np.eye(3)})
        return clamp(rotor.blades.make_body(name, mesh, axes), mesh)


def clamp(body: B, mesh: LoadedMesh) -> ClampedBlade[B]:
    """A blade that the ground holds. Collective."""
    root = mesh.facets(ROOT)
    system = MultibodySystem(mesh.mesh.comm, [body, Coupling("clamp", body, root, None)])
    return ClampedBlade(body, root, mesh.facets(SKIN), system)


def place_copies(rotor: RotorPlan) -> list[Placement]:
    """Where the blades of a rotor stand, as copies of one in its own axes."""
    layout = rotor.layout
    return [
        Placement(position=layout.centre, rotation=layout.frame(k).T)
        for k in range(1, layout.n_blades + 1)
    ]
