"""Blades and tower as slender parts, described by the motion of their cross-sections."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.analysis.cross_sections import CrossSections
from turbine_fenicsx.analysis.modal_sums import Piece
from turbine_fenicsx.analysis.mode import Mode, Motion
from turbine_fenicsx.bodies.owned_nodes import nodes_of_cells
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.conventions import BLADES, TOWER
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS
from turbine_fenicsx.turbine.components.axes import TOWER_AXES, blade_axes
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.turbine.components.flexible_blades import BODY


@dataclass(frozen=True, eq=False)
class SlenderPart:
    """A blade as seen from what carries its root, or the tower as seen from the ground.

    Args:
        arms: Where its nodes are in that state, along the directors of the body that carries its
            root, shape (n, 3) [m]; None on the ground.
        first: First coordinate of that body.
    """

    piece: Piece
    sections: CrossSections
    arms: Array | None = None
    first: int = 0

    def shape(self, motion: Motion) -> Array:
        """Motion of the cross-sections relative to the parent body, see `CrossSections.motion`.

        Returns:
            Motion along x, y, z and about z, shape (stations, 4). Collective.
        """
        own = self.sections.nodes.displacements(motion.u[self.piece.body])
        if self.arms is not None:
            carried = motion.q[self.first : self.first + 12].reshape(4, 3)
            own = own - carried[0] - self.arms @ carried[1:]
        return self.sections.motion(own)

    def complex_shape(self, mode: Mode) -> Array:
        """That of both parts of a mode, a + i b, complex, shape (stations, 4). Collective."""
        b = 0.0 if mode.imaginary is None else self.shape(mode.imaginary)
        found: Array = self.shape(mode.real) + 1j * b
        return found


def find_slender_parts(turbine: Turbine, state: State) -> dict[str, SlenderPart]:
    """Flexible blades and tower of a turbine by their names. Collective."""
    system, found = turbine.system, {}
    bodies = [body.name for body in system.flexible_bodies]
    if BODY in bodies:
        layout = turbine.rotor.layout
        for k, (name, root) in enumerate(zip(BLADES, ROOTS, strict=True), start=1):
            piece = _find_blade(turbine, bodies.index(BODY), k)
            axes = blade_axes(layout, k)
            carrier = turbine.part(root).rigid
            found[name] = _make_part(system, state, piece, axes, carrier)
    if TOWER in bodies:
        nodes = np.arange(system.flexible_models[bodies.index(TOWER)].n_owned)
        piece = Piece(TOWER, bodies.index(TOWER), nodes)
        found[TOWER] = _make_part(system, state, piece, TOWER_AXES, None)
    return found


def _make_part(
    system: MultibodySystem, state: State, piece: Piece, axes: Array, carrier: RigidBody | None
) -> SlenderPart:
    """A part with axes that have turned with its parent body."""
    if carrier is None:
        return SlenderPart(piece, CrossSections(system, state, piece, axes, axes[2]))
    first = system.first_coordinate[carrier]
    place = state.q[first : first + 12].reshape(4, 3)  # its centre, then its directors
    turned = axes @ np.asarray(carrier.directors) @ place[1:]
    sections = CrossSections(system, state, piece, turned, axes[2])
    arms = (sections.positions - place[0]) @ place[1:].T
    return SlenderPart(piece, sections, arms, first)


def _find_blade(turbine: Turbine, body: int, blade: int) -> Piece:
    """Nodes in the cells of a blade, or vectors of a copy.

    Args:
        body: Number of the body of all blades in the system.
        blade: Number of the blade, from 1.
    """
    model, name = turbine.system.flexible_models[body], BLADES[blade - 1]
    if model.is_small:
        size = model.dense_block // 3
        every = np.arange((blade - 1) * size, blade * size)
        return Piece(name, body, every[: model.n_owned], blade - 1)
    return Piece(name, body, nodes_of_cells(model.space, turbine.meshes[BODY].cells(name)))
