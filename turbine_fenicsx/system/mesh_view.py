"""The mesh of a body, and how the nodes of its model move it.

The nodes of a full body are those of its mesh. The vectors z of a reduced body move the mesh of
each copy, which stands at t + R X, by x = sum_k F_k(X) z_k.
"""

from __future__ import annotations

from functools import cached_property

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from turbine_fenicsx.bodies.nearest_node import nearest_node
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.reduced_model import ReducedModel


class MeshView:
    """The mesh of a body.

    Attributes:
        placements: R and t of each copy, shapes (3, 3) and (3,) [m].
    """

    def __init__(self, model: BodyModel) -> None:
        if not isinstance(model, FlexibleModel | ReducedModel):
            raise ModelError(f"{model.body.name!r} has no mesh")
        self._model = model
        self.placements = [(np.eye(3), np.zeros(3))]
        if isinstance(model, ReducedModel):
            self.placements = [
                (np.asarray(p.rotation, dtype=float), np.asarray(p.position, dtype=float))
                for p in model.body.placements
            ]

    @cached_property
    def mesh(self) -> FlexibleModel:
        """The body on its mesh, made where it is first asked for. Collective."""
        model = self._model
        return FlexibleModel(model.body.full) if isinstance(model, ReducedModel) else model

    def find_node(self, point: npt.ArrayLike) -> tuple[IntArray, Array] | None:
        """The node of the mesh that is nearest to a point, where the body stands. Collective.

        Args:
            point: The point, shape (3,) [m].

        Returns:
            Nodes of the model that move it and how much, shapes (k,); None on all ranks but one.
        """
        model = self._model
        if isinstance(model, FlexibleModel):
            node = nearest_node(model.comm, model.positions, point)
            return None if node is None else (np.array([node]), np.ones(1))
        if model.comm.rank:
            return None
        distance = np.linalg.norm(model.body.points - np.asarray(point, dtype=float), axis=2)
        copy, row = divmod(int(np.argmin(distance)), distance.shape[1])
        return self._take_rows(copy, np.array([row]), np.ones(1))

    def take(self, copy: int, nodes: IntArray, weights: Array) -> tuple[IntArray, Array]:
        """Weights of the nodes of the model for a weighted sum of nodes of the mesh. Collective.

        Args:
            copy: Number of the copy.
            nodes: Numbers of the nodes, counted over all ranks, shape (m,).

        Returns:
            Owned nodes of the model and their weights, shapes (k,).
        """
        if isinstance(self._model, FlexibleModel):
            first, end = self._model.space.dofmap.index_map.local_range
            own = (nodes >= first) & (nodes < end)
            return nodes[own] - first, weights[own]
        return self._take_rows(copy, self._rows[nodes], weights)

    def find_displacements(self, values: PETSc.Vec, copy: int) -> Array:
        """Displacements of a copy, in the axes of the mesh. Collective.

        Args:
            values: Those of the nodes of the model, `State.u` of the body.
            copy: Number of the copy.

        Returns:
            Those of the nodes of the mesh that this rank owns, shape (n_owned, 3) [m].
        """
        model = self._model
        if isinstance(model, FlexibleModel):
            return np.array(values.array_r).reshape(-1, 3)
        assert isinstance(model, ReducedModel)
        moved = model.expand(values)[copy] @ self.placements[copy][0]
        first, end = self.mesh.space.dofmap.index_map.local_range
        own: Array = moved[self._rows[first:end]]
        return own

    def _take_rows(self, copy: int, rows: IntArray, weights: Array) -> tuple[IntArray, Array]:
        """As `take` for rows of the functions of a basis."""
        assert isinstance(self._model, ReducedModel)
        F = self._model.body.basis.functions
        own = np.arange(F.shape[1] if self._model.n_owned else 0)
        return own + copy * F.shape[1], (weights @ F[rows])[own]

    @cached_property
    def _rows(self) -> IntArray:
        """Row of the functions of a basis for each node of the mesh. Collective."""
        assert isinstance(self._model, ReducedModel)
        positions = np.concatenate(self.mesh.comm.allgather(self.mesh.positions))
        rows: IntArray = cKDTree(self._model.body.basis.points).query(positions)[1]
        return rows
