"""Node-by-node coupling of a flexible body to rigid bodies, eqs (53)-(54).

For a node with initial position X on the contact surface, xi are its constant coordinates in the
body frame, and

    Phi = phi + sum_i xi_i d_i - (X + u) = 0,

three equations with one Lagrange multiplier each. Phi is linear; its gradients are C = -S, where S
selects the contact nodes, and B = [I, xi_i I], twelve columns of the carrying body. A node that is
a vector leaves out phi: B = [h I, xi_i I] with h = 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.body_model import BodyModel


class CouplingBlock:
    """All couplings of one flexible body, as matrices.

    Args:
        first_coordinate: First coordinate of each rigid body in the vector r.
        rigid_size: Global size of r, which rank 0 owns.

    Attributes:
        nodes: Owned contact nodes, shape (n,).
        C: -(selection of the contact nodes), multipliers x displacements.
        B: Gradient with respect to r, multipliers x r.
        columns: Columns of r that belong to the parent bodies, shape (12 parent bodies,).
        B_local: Owned rows of B in these columns, shape (3 n, 12 parents).
    """

    def __init__(
        self,
        block: BodyModel,
        couplings: Sequence[Coupling],
        first_coordinate: Mapping[RigidBody, int],
        rigid_size: int,
    ) -> None:
        comm = block.comm
        self.couplings = tuple(couplings)
        found = [block.contact_nodes(c) for c in couplings]
        counts = comm.allreduce(np.array([n.size for n in found]))
        for coupling, count in zip(couplings, counts, strict=True):
            if count == 0:
                raise ModelError(
                    f"coupling {coupling.name!r} holds no node: its surface has no facets on "
                    f"{coupling.flexible.name!r}"
                )
        self.nodes = np.concatenate([np.zeros(0, np.int64), *found])
        shared = comm.allreduce(self.nodes.size - np.unique(self.nodes).size)
        if shared:
            raise ModelError(f"{shared} nodes of {block.body.name!r} belong to two couplings")
        self.slices: list[slice] = []
        for nodes in found:
            start = self.slices[-1].stop if self.slices else 0
            self.slices.append(slice(start, start + nodes.size))

        self.carriers = tuple(dict.fromkeys(c.rigid for c in couplings if c.rigid is not None))
        starts = [first_coordinate[body] for body in self.carriers]
        self.columns = np.concatenate([np.zeros(0, np.int64), *(s + np.arange(12) for s in starts)])
        self._weigh_carriers(block)
        self.dofs = (3 * self.nodes[:, None] + np.arange(3)).ravel()
        layout_c = (self.dofs.size, None)
        layout_u = (3 * block.n_owned, None)
        layout_r = (rigid_size if comm.rank == 0 else 0, rigid_size)
        first_dof = 3 * (comm.scan(block.n_owned) - block.n_owned)
        self.C = _make_matrix(
            comm,
            (layout_c, layout_u),
            np.ones(self.dofs.size, dtype=np.int64),
            first_dof + self.dofs,
            -np.ones(self.dofs.size),
        )
        rows_used, columns_used = np.nonzero(self.B_local)
        self.B = _make_matrix(
            comm,
            (layout_c, layout_r),
            np.bincount(rows_used, minlength=self.dofs.size),
            self.columns[columns_used],
            self.B_local[rows_used, columns_used],
        )

    def _weigh_carriers(self, block: BodyModel) -> None:
        """B of the owned rows, and what the gap starts from, -X with a parent body."""
        self._offset = np.zeros((self.nodes.size, 3))
        self.B_local = np.zeros((self.nodes.size, 3, 4 * len(self.carriers), 3))
        for coupling, rows in zip(self.couplings, self.slices, strict=True):
            if coupling.rigid is not None:
                nodes = self.nodes[rows]
                X = block.positions[nodes]
                self._offset[rows] = -X
                slots = 4 * self.carriers.index(coupling.rigid) + np.arange(4)
                weights = coupling.rigid.weights_of(X, block.is_point[nodes])
                for c in range(3):
                    self.B_local[rows, c, slots, c] = weights
        self.B_local = self.B_local.reshape(3 * self.nodes.size, self.columns.size)

    def rigid_extension(self, block: BodyModel) -> Array:
        """Motion of all owned nodes with the parent bodies, equal to B at the contact nodes.

        With one parent body (and no ground) the whole body moves with it; with several, only the
        contact nodes move.

        Returns: Shape (3 n_owned, 12 parents).
        """
        Y = np.zeros((3 * block.n_owned, self.columns.size))
        if len(self.carriers) == 1 and all(c.rigid is not None for c in self.couplings):
            weights = self.carriers[0].weights_of(block.positions, block.is_point)
            Y[:] = np.einsum("ns,ij->nisj", weights, np.eye(3)).reshape(Y.shape)
        Y[self.dofs] = self.B_local
        return Y

    def gap(self, coordinates: Mapping[RigidBody, Array], u: PETSc.Vec) -> Array:
        """Phi of the owned contact nodes, shape (3 n,) [m].

        Args:
            coordinates: q of each rigid body, shape (12,).
        """
        q = np.concatenate([np.zeros(0), *(coordinates[b] for b in self.carriers)])
        gap: Array = self._offset.ravel() + self.B_local @ q - u.array_r[self.dofs]
        return gap


def _make_matrix(
    comm: Any, layout: Any, row_lengths: npt.ArrayLike, columns: npt.ArrayLike, values: Array
) -> PETSc.Mat:
    """Distributed matrix from this rank's rows in compressed form, global column numbers."""
    indptr = np.concatenate([[0], np.cumsum(row_lengths)]).astype(PETSc.IntType)
    csr = (indptr, np.asarray(columns, dtype=PETSc.IntType), values)
    matrix = PETSc.Mat().createAIJ(layout, csr=csr, comm=comm)
    matrix.assemble()
    return matrix
