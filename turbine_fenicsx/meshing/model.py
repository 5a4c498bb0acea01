"""A mesh with named groups as plain arrays, and its export to gmsh."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.cells import ReferenceCell
from turbine_fenicsx.meshing.quality import MeshReport, examine


@dataclass(frozen=True)
class MeshArrays:
    """A mesh of one cell type with physical volumes and surfaces.

    Attributes:
        reference: Element type of the cells.
        points: Node coordinates, shape (n_points, 3) [m].
        cells: Nodes of each cell in gmsh's order, shape (n_cells, n).
        cell_groups: Number of the physical volume of each cell, shape (n_cells,).
        facets: Nodes of each grouped face in gmsh's order, shape (n_facets, m).
        facet_groups: Number of the physical surface of each face, shape (n_facets,).
        volumes: Numbers of the physical volumes by name.
        surfaces: Numbers of the physical surfaces by name.
        cell_data: What is known of each cell by name, shape (n_cells,) each.
    """

    reference: ReferenceCell
    points: Array
    cells: IntArray
    cell_groups: IntArray
    facets: IntArray
    facet_groups: IntArray
    volumes: dict[str, int]
    surfaces: dict[str, int]
    cell_data: dict[str, Array] = field(default_factory=dict)

    @classmethod
    def empty(cls, reference: ReferenceCell) -> "MeshArrays":
        """No cells of a type: the share of a rank that holds nothing."""
        none = np.empty(0, dtype=np.int64)
        sizes = len(reference.nodes), reference.faces.shape[1]
        cells, facets = (none.reshape(0, size) for size in sizes)
        return cls(reference, np.empty((0, 3)), cells, none, facets, none, {}, {})

    def examine(self) -> MeshReport:
        """Measure volumes and quality."""
        return examine(self.points, self.cells, self.reference, self.volumes, self.cell_groups)

    def add_to(self, model: Any) -> None:
        """Put the mesh into an empty gmsh model as discrete entities, one per group.

        Args:
            model: ``gmsh.model``.
        """
        surface_entities = {
            tag: model.addDiscreteEntity(2) for tag in sorted(self.surfaces.values())
        }
        volume_entities = {
            tag: model.addDiscreteEntity(3, -1, self._find_boundary(tag, surface_entities))
            for tag in sorted(self.volumes.values())
        }
        self._add_nodes(model, surface_entities, volume_entities)
        parts = (
            (2, surface_entities, self.facets, self.facet_groups, self.surfaces),
            (3, volume_entities, self.cells, self.cell_groups, self.volumes),
        )
        first = 1
        for dimension, entities, elements, groups, names in parts:
            element_type = self.reference.gmsh_type
            if dimension == 2:
                element_type = self.reference.gmsh_facet_type
            element_tags = np.arange(first, first + len(elements))
            first += len(elements)
            for tag, entity in entities.items():
                own, nodes = element_tags[groups == tag], elements[groups == tag] + 1
                model.mesh.addElementsByType(entity, element_type, own, nodes.ravel())
                model.addPhysicalGroup(dimension, [entity], tag)
            for name, tag in names.items():
                model.setPhysicalName(dimension, tag, name)

    def _find_boundary(self, volume: int, surface_entities: dict[int, int]) -> list[int]:
        """Return the surface entities that touch the cells of a physical volume."""
        inside = np.zeros(len(self.points), dtype=bool)
        inside[self.cells[self.cell_groups == volume]] = True
        touching = np.unique(self.facet_groups[inside[self.facets].all(axis=1)])
        return [surface_entities[tag] for tag in touching]

    def _add_nodes(
        self, model: Any, surface_entities: dict[int, int], volume_entities: dict[int, int]
    ) -> None:
        """Give every node to one entity: to a surface if it lies on one, else to its volume."""
        owner = np.zeros(len(self.points), dtype=np.int64)
        parts = (
            (3, volume_entities, self.cells, self.cell_groups),
            (2, surface_entities, self.facets, self.facet_groups),
        )
        for dimension, entities, elements, groups in parts:
            for tag in entities:
                owner[elements[groups == tag]] = 10 * tag + dimension
        for dimension, entities, _, _ in reversed(parts):
            for tag, entity in entities.items():
                nodes = np.flatnonzero(owner == 10 * tag + dimension)
                model.mesh.addNodes(dimension, entity, nodes + 1, self.points[nodes].ravel())
