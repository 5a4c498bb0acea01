"""The motion of a recorded run on the full meshes of its bodies."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from turbine_fenicsx.bodies.reduced_body import SAME_PLACE, ReducedBody
from turbine_fenicsx.foundation.errors import ModelError, ModelWarning
from turbine_fenicsx.foundation.parallel import raise_together
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run.recorded_run import RecordedRun
from turbine_fenicsx.turbine.run.resume import BASES

TOWER_LEFT_OUT = (
    'the motion of a tower with tower.model = "full" is not stored: it is no part of the fields'
)
"""The warning about it."""


class FullMotion:
    """States of the turbine of a run with full bodies, which move as its reduced ones did.

    A node X of the mesh is at x = sum_k F_k(X) z_k, with the functions and vectors of the run.
    Beams have no other body, and remain as they are.

    Args:
        run: The run. A tower that is not reduced is left out, as its motion is not stored.

    Attributes:
        turbine: Its turbine with full bodies.

    Raises:
        ModelError: if a mesh has other nodes than the basis.

    Warns:
        ModelWarning: if the tower is left out.

    Note:
        Making it, and all methods, are collective.
    """

    def __init__(self, run: RecordedRun) -> None:
        self._motion, comm = run.motion, run.turbine.comm
        case = run.turbine.case
        tables: dict[str, Any] = {"output": type(case.output)(gauges=case.output.gauges)}
        for name in BASES:
            table = getattr(case, name)
            full = {"model": "full", "reduction": type(table.reduction)()}
            stays = case.has_beam_blades if name == "blade" else case.has_beam_tower
            tables[name] = table if stays else table.model_copy(update=full)
        if case.tower.flexible and not case.has_reduced_tower:
            tables["tower"] = type(case.tower)()
            if comm.rank == 0:
                warnings.warn(TOWER_LEFT_OUT, ModelWarning, stacklevel=2)
        self.turbine: Turbine = build_turbine(case.model_copy(update=tables), comm)
        system, names = self.turbine.system, list(self._motion.rigid)
        numbers = [names.index(body.name) for body in system.rigid_bodies]
        self._columns = (12 * np.array(numbers)[:, None] + np.arange(12)).ravel()
        self._expanded = {
            m.body.name: _make_expanded(run.reduced[m.body.name].body, m)
            for m in system.flexible_models
        }
        self._state = system.initial_state()

    def find_state(self, row: int) -> State:
        """The state of a row of the motion: positions and velocities, without forces.

        The next call changes it.
        """
        motion, state = self._motion, self._state
        state.time = float(motion.times[row])
        state.q, state.q_dot = (x[row, self._columns] for x in (motion.q, motion.q_dot))
        for (name, body), u, v in zip(self._expanded.items(), state.u, state.v, strict=True):
            u.array[:] = body.expand(motion.vectors[name][row] - body.starts).ravel()
            v.array[:] = body.expand(motion.velocities[name][row]).ravel()
        return state


def _make_expanded(reduced: ReducedBody, model: BodyModel) -> _Expanded | _Vectors:
    """How the motion of a reduced body moves the nodes of a model. Collective."""
    return _Vectors(reduced, model) if model.is_small else _Expanded(reduced, model)


class _Vectors:
    """The vectors of a body that are its own nodes.

    Attributes:
        starts: As of `_Expanded`.
    """

    def __init__(self, reduced: ReducedBody, model: BodyModel) -> None:
        self._owned = model.n_owned
        self.starts = _find_starts(reduced)

    def expand(self, vectors: Array) -> Array:
        """Those that this rank owns, shape (vectors, 3)."""
        return vectors.reshape(-1, 3)[: self._owned]


def _find_starts(reduced: ReducedBody) -> Array:
    """Vectors of each copy before the motion, shape (copies, n, 3) [m]."""
    basis = reduced.basis
    return np.array([p.place(basis.vectors, basis.is_point) for p in reduced.placements])


class _Expanded:
    """The functions of a reduced body at the nodes of the same body on its full mesh.

    Attributes:
        starts: Vectors of each copy before the motion, shape (copies, n, 3) [m].
    """

    def __init__(self, reduced: ReducedBody, full: BodyModel) -> None:
        points, basis = reduced.points, reduced.basis
        size = float(np.max(np.ptp(basis.points, axis=0)))
        distance, place = cKDTree(points.reshape(-1, 3)).query(full.positions)
        error = None
        if np.max(distance, initial=0.0) > SAME_PLACE * size:
            error = ModelError(
                f"the mesh of {reduced.name!r} has a node {np.max(distance):.2g} m away from all "
                "those of the basis"
            )
        raise_together(full.comm, error)
        copies, rows = np.divmod(place, len(basis.points))
        self._nodes: list[IntArray] = [
            np.flatnonzero(copies == copy) for copy in range(len(points))
        ]
        self._functions = [basis.functions[rows[nodes]] for nodes in self._nodes]
        self.starts = _find_starts(reduced)

    def expand(self, vectors: Array) -> Array:
        """Sums of the functions at the nodes that this rank owns, shape (nodes, 3).

        Args:
            vectors: Shape (copies, n, 3).
        """
        found = np.zeros((sum(map(len, self._nodes)), 3))
        for nodes, functions, z in zip(self._nodes, self._functions, vectors, strict=True):
            found[nodes] = functions @ z
        return found
