"""The nodes of the mesh of a piece of a flexible body, whatever moves them."""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.modal_sums import Piece
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.mesh_areas import positions_of
from turbine_fenicsx.system.system import MultibodySystem


class PieceNodes:
    """Nodes of a piece that this rank owns: those of a copy if the body is reduced.

    Attributes:
        positions: Initial positions, shape (n, 3) [m].
        masses: Shape (n,) [kg].
    """

    def __init__(self, system: MultibodySystem, piece: Piece) -> None:
        """Collective."""
        self._model, self._copy = system.flexible_models[piece.body], piece.copy
        X = positions_of(self._model.space)
        self._nodes = np.arange(len(X)) if self._model.is_small else piece.nodes
        self._rotation, at = self._model.body.placements[piece.copy].frame()
        self.positions: Array = at + X[self._nodes] @ self._rotation.T
        self.masses: Array = self._model.mesh_masses[self._nodes]

    def displacements(self, u: PETSc.Vec) -> Array:
        """Displacements of the nodes, shape (n, 3) [m]. Collective.

        Args:
            u: Those of the body.
        """
        own = self._model.mesh_displacements(u, self._copy)[self._nodes]
        found: Array = own @ self._rotation.T
        return found
