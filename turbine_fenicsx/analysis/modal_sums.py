"""Sums over the parts of a system in small motions: what moves, and what is strained."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.mode import Motion
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import IntArray
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


@dataclass(frozen=True, eq=False)
class Piece:
    """Some nodes of a flexible body.

    Args:
        body: Number of the flexible body in the system.
        nodes: Owned nodes, shape (n,); of a reduced body the vectors of a copy.
        copy: Number of the copy.
    """

    name: str
    body: int
    nodes: IntArray
    copy: int = 0


class ModalSums:
    """Quadratic forms of small motions about a state, part by part.

    Args:
        pieces: Pieces of the flexible bodies that are distinguished.

    Note:
        Collective, also all methods.
    """

    def __init__(self, system: MultibodySystem, state: State, pieces: Sequence[Piece]) -> None:
        self._system, self._pieces = system, tuple(pieces)
        self._stiffness = []
        for model, u in zip(system.flexible_models, state.u, strict=True):
            K = model.new_stiffness()
            model.assemble_stiffness(u, state.time, K)
            self._stiffness.append(K)
        self._products = [model.new_vector() for model in system.flexible_models]
        y = np.concatenate([state.q, state.joint_coordinates])
        at_rest = StepTimes.at_rest(state.time)
        springs = zip(system.motion_forces, system.rigid_model.forces, strict=True)
        self._springs = {
            force.name: (i, -2.0 * bound.force(y[i], y[i], at_rest)[1])
            for force, bound in springs
            if force.kind == "conservative" and (i := bound.index).size
        }

    def inner_product(self, a: Motion, b: Motion) -> float:
        """Product a . M b [kg m^2]."""
        flexible = np.zeros(1)
        for model, u, v, p in self._pair_bodies(a, b):
            model.momentum(v, p)
            flexible += u.array_r @ p.array_r
        return float(sum_over_ranks(self._system.comm, flexible)[0]) + float(
            a.q @ (self._system.rigid_model.masses * b.q)
        )

    def modal_masses(self, a: Motion) -> dict[str, float]:
        """Products a . M a of each rigid body and of each piece [kg m^2]."""
        for model, u, _, p in self._pair_bodies(a, a):
            model.momentum(u, p)
        rigid = (self._system.rigid_model.masses * a.q**2).reshape(-1, 12).sum(axis=1)
        names = [body.name for body in self._system.rigid_bodies]
        return dict(zip(names, rigid.tolist(), strict=True)) | self._sum_over_pieces(a)

    def strain_energies(self, a: Motion) -> dict[str, float]:
        """Products a . K a of each piece and of each spring, twice their energies [J]."""
        for k, (_, u, _, p) in enumerate(self._pair_bodies(a, a)):
            self._stiffness[k].mult(u, p)
        y = np.concatenate([a.q, a.joint_coordinates])
        return self._sum_over_pieces(a) | {
            name: float(y[index] @ K @ y[index]) for name, (index, K) in self._springs.items()
        }

    def destroy(self) -> None:
        """Free the matrices and vectors."""
        for thing in (*self._stiffness, *self._products):
            thing.destroy()

    def _pair_bodies(
        self, a: Motion, b: Motion
    ) -> zip[tuple[BodyModel, PETSc.Vec, PETSc.Vec, PETSc.Vec]]:
        """Each flexible body with its two motions and a vector for a product."""
        return zip(self._system.flexible_models, a.u, b.u, self._products, strict=True)

    def _sum_over_pieces(self, a: Motion) -> dict[str, float]:
        """Sum over the nodes of each piece of its motion times the product."""
        sums = np.zeros(len(self._pieces))
        for k, piece in enumerate(self._pieces):
            u, p = (x.array_r.reshape(-1, 3) for x in (a.u[piece.body], self._products[piece.body]))
            sums[k] = np.sum(u[piece.nodes] * p[piece.nodes])
        total = sum_over_ranks(self._system.comm, sums)
        return {piece.name: float(x) for piece, x in zip(self._pieces, total, strict=True)}
