"""A reduced body under the forces of equilibria of the full one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.reduced_body import ReducedBody
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.reduction.long_axis import LongAxis
from turbine_fenicsx.reduction.span_meter import SpanMeter
from turbine_fenicsx.reduction.static_body import StaticBody
from turbine_fenicsx.reduction.static_states import PathStates
from turbine_fenicsx.reduction.verdict import StateVerdict
from turbine_fenicsx.system.reduced_model import ReducedModel
from turbine_fenicsx.system.system import MultibodySystem

STATIONS = np.linspace(0.1, 1.0, 10)
"""Places along the span where motions are compared."""

PARTS = (1, 2, 4, 8)
"""Numbers of steps that the way to the next state is tried in."""


class ReducedStates:
    """Both bodies at rest. Collective, like all methods.

    Args:
        system: A system with all couplings of the full body.

    Attributes:
        points: X of all nodes in the order of their numbers, shape (N, 3) [m].
    """

    def __init__(self, system: MultibodySystem, full: FlexibleBody, reduced: ReducedBody) -> None:
        basis, self.stations = reduced.basis, STATIONS
        self._full = StaticBody(system, full, full)
        self._reduced = StaticBody(system, full, reduced)
        self.points = X = self._full.gather(self._full.model.positions)
        # nodes of a basis from a file may stand in another order
        rows = cKDTree(basis.points).query(X)[1]
        self._F, self._order = basis.functions[rows], np.argsort(rows)
        self._axis = LongAxis(X, basis.masses[rows], basis.origins[0])
        self._meter = SpanMeter(X, basis.masses[rows], self._axis, tuple(STATIONS))

    def destroy(self) -> None:
        """Free both."""
        self._full.destroy()
        self._reduced.destroy()

    def compare_compliances(self) -> dict[str, float]:
        """Largest error of the compliance by kind of smooth load, relative to its largest one."""
        axis, points, body = self._axis, self.points, self._full
        across, along = axis.axes.T[:2], axis.axes[:, 2]
        fields = [
            *(("forces across", np.broadcast_to(a, points.shape)) for a in across),
            ("forces along", np.broadcast_to(along, points.shape)),
            ("twisting moments", np.cross(along, axis.arms(points))),
        ]
        worst, largest = (dict.fromkeys((kind for kind, _ in fields), 0.0) for _ in range(2))
        polynomials = axis.polynomials(points).T[..., None]
        loads = [self._load(field * p) for _, field in fields for p in polynomials]
        projected = [self._project(load) for load in loads]
        pairs = zip(body.respond(loads), self._reduced.respond(projected), strict=True)
        for k, (u, z) in enumerate(pairs):
            kind = fields[k // len(polynomials)][0]
            compliance = body.multiply(loads[k], u)
            error = compliance - self._reduced.multiply(projected[k], z)
            worst[kind] = max(worst[kind], error)
            largest[kind] = max(largest[kind], compliance)
        return {kind: worst[kind] / largest[kind] for kind in worst}

    def _load(self, accelerations: Array) -> Array:
        """Forces of accelerations on the owned nodes, shape (3 n_owned,) [N]."""
        model = self._full.model
        a, f = model.new_vector(), model.new_vector()
        a.array[:] = self._full.take_own(accelerations)
        model.momentum(a, f)
        forces: Array = f.array_r.copy()
        a.destroy()
        f.destroy()
        return forces

    def compare(self, path: PathStates) -> Iterator[StateVerdict]:
        """Verdicts on the states of a path, from an undeformed body on."""
        self._reduced.relax()
        before = np.zeros(3 * self._reduced.model.n_owned)
        for time, u in zip(path.times, path.displacements, strict=True):
            forces = self._full.find_forces(u)
            load = self._project(forces)
            found = self._reach(before, load) or self._reach_from(u, load)
            before = load if found else 0.0 * load
            yield self._compare_one(path.name, float(time), u, forces, found)

    def _reach(self, before: Array, load: Array) -> bool:
        """Find the reduced equilibrium from that under the load before; whether there is one."""
        body = self._reduced
        for parts in PARTS:
            start = body.state.copy()
            if all(
                body.solve(0.0, before + k / parts * (load - before)) for k in range(1, parts + 1)
            ):
                start.destroy()
                return True
            body.restore(start)
        return False

    def _reach_from(self, u: Array, load: Array) -> bool:
        """Find the reduced equilibrium from the nearest displacement on."""
        body, model = self._reduced, self._reduced.model
        assert isinstance(model, ReducedModel)
        body.relax()
        free = np.ones(model.mass.shape[:1], dtype=bool)
        free[: 4 * len(model.body.basis.origins)] = False
        body.state.u[0].array[:] = model.find_nearest(u[self._order], free[None]).ravel()
        return body.solve(0.0, load)

    def _compare_one(
        self, name: str, time: float, u: Array, forces: Array, found: bool
    ) -> StateVerdict:
        """The verdict on a state; without numbers if the reduced body has none."""
        displacements, twists = self._meter.displacements(u), np.degrees(self._meter.twists(u))
        tip = float(np.linalg.norm(displacements[-1]))
        if not found:
            nothing = np.full(len(STATIONS), np.nan)
            self._reduced.relax()
            return StateVerdict(name, time, tip, nothing, twists, nothing, np.nan)
        z = self._reduced.gather(self._reduced.displacement())
        other = self._F @ z
        apart = np.linalg.norm(self._meter.displacements(other) - displacements, axis=1)
        turned = np.degrees(self._meter.twists_between(u, other))
        lack = self._full.find_forces(other) - forces
        responses = self._full.respond([lack, forces])
        lacking, applied = map(self._full.multiply, (lack, forces), responses)
        residual = float(np.sqrt(abs(lacking / applied)))
        return StateVerdict(name, time, tip, apart, twists, turned, residual)

    def _project(self, forces: Array) -> Array:
        """F^T f, shape (3 n_owned,) of the reduced body [N]."""
        of_vectors = self._F.T @ self._full.gather(forces)
        return self._reduced.take_own(of_vectors)
