"""A body as its nodes, and how these move the mesh of each of its copies.

A node has an initial value X_k and a displacement u_k, each a vector in space. It is a point
(h_k = 1) or a vector (h_k = 0): a rigid motion x -> t + R x takes it to

    h_k t + R X_k.

The nodes of a mesh are points. Other bodies move their mesh by sums of their nodes.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, Protocol

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
from scipy.sparse import csr_matrix

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.foundation.types import Array, IntArray


class BodyNodes(Protocol):
    """Nodes of a body.

    Attributes:
        body: The body.
        space: Space of the displacement of its mesh.
        comm: Communicator of its nodes.
        n_owned: Number of nodes owned by this rank.
        size_global: Number of nodes of all ranks.
        positions: Initial values X of the owned nodes, shape (n_owned, 3) [m].
        is_point: h of the owned nodes, 1 or 0, shape (n_owned,).
        dense_block: Rows of the blocks that make up its tangent if this is small and dense, so that
            every iteration has a new one; 0 for a large, sparse tangent.
    """

    body: DeformableBody
    space: Any
    comm: MPI.Intracomm
    n_owned: int
    size_global: int
    positions: Array
    is_point: Array
    dense_block: int

    @property
    @abstractmethod
    def full(self) -> Any:
        """The body on its mesh, a `FlexibleModel`, made where it is first asked for. Collective."""

    @abstractmethod
    def rows(self, copy: int, nodes: IntArray, weights: Array | csr_matrix) -> csr_matrix:
        """Weighted sums of nodes of the mesh as weighted sums of the owned nodes. Collective.

        Args:
            copy: Number of the copy.
            nodes: Numbers of the nodes of the mesh, counted over all ranks, shape (k,).
            weights: Those of each sum, shape (m, k), or (k,) for one sum.

        Returns:
            Shape (m, n_owned).
        """

    @abstractmethod
    def mesh_displacements(self, u: PETSc.Vec, copy: int) -> Array:
        """Displacements of a copy of the mesh, in its axes. Collective.

        Args:
            u: Those of the nodes, `State.u` of the body.
            copy: Number of the copy.

        Returns:
            Those of the nodes of the mesh that this rank owns, shape (k, 3) [m].
        """

    @property
    def mesh_masses(self) -> Array:
        """Weights of the owned nodes of the mesh in its mean motion, as their masses, shape (k,).

        They are equal unless a body has better ones. Collective.
        """
        return np.ones(self.space.dofmap.index_map.size_local)

    @abstractmethod
    def gather_forces(self, forces: Array, copy: int) -> Array:
        """Forces on a copy of the mesh as forces on the owned nodes. Collective.

        Args:
            forces: Those on the nodes of the mesh that this rank owns, in space, shape (k, 3) [N].
            copy: Number of the copy.

        Returns:
            Shape (n_owned, 3) [N].
        """
