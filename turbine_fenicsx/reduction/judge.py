"""A basis judged by the full body: frequencies, compliance, and equilibria under unseen loads."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from turbine_fenicsx.analysis.modes import modes
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.reduced_body import ReducedBasis, ReducedBody
from turbine_fenicsx.foundation.argument_checks import check_among_parts
from turbine_fenicsx.foundation.rotations import nearest_rotation
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.reduction.load_path import LoadPath, check_loads
from turbine_fenicsx.reduction.long_axis import LongAxis
from turbine_fenicsx.reduction.smooth_loads import smooth_loads
from turbine_fenicsx.reduction.static_body import StaticBody, check_held
from turbine_fenicsx.reduction.static_states import PathStates, find_states
from turbine_fenicsx.reduction.verdict import StateVerdict, Verdict
from turbine_fenicsx.system.nearest_vectors import find_nearest_vectors
from turbine_fenicsx.system.reduced_model import ReducedModel
from turbine_fenicsx.system.system import MultibodySystem

HALF_WIDTH = 0.02
"""Half of the part of the length that a section is made of."""

FEWEST = 12
"""Minimum number of nodes of a section."""


class SpanMeter:
    """Sections at some places along a body.

    Args:
        positions: X of all nodes, shape (N, 3) [m].
        masses: Masses of the nodes, positive, shape (N,) [kg].
        axis: Its long axis.
        places: Places along the axis, from 0 to 1.
    """

    def __init__(
        self, positions: Array, masses: Array, axis: LongAxis, places: Sequence[float]
    ) -> None:
        self._X, self._masses, self._along = positions, masses, axis.axes[:, 2]
        span = axis.span(positions)
        self._sections = []
        for place in places:
            distance = np.abs(span - place)
            least = np.partition(distance, FEWEST)[FEWEST] if len(span) > FEWEST else np.inf
            self._sections.append(np.flatnonzero(distance <= max(HALF_WIDTH, 1.001 * least)))

    def displacements(self, u: Array) -> Array:
        """Mean displacements of the sections, shape (places, 3) [m].

        Args:
            u: Displacements of all nodes, shape (N, 3) [m].
        """
        means = [self._masses[n] @ u[n] / self._masses[n].sum() for n in self._sections]
        return np.array(means)

    def twists(self, u: Array) -> Array:
        """Angles by which the sections have turned about the axis where it is now, (places,) [rad].

        Args:
            u: Displacements of all nodes, shape (N, 3) [m].
        """
        return self._angles(self._X, self._X + u, self._along)

    def twists_between(self, u: Array, other: Array) -> Array:
        """Angles about the axis from one motion to another, shape (places,) [rad].

        Args:
            u: Displacements of all nodes, shape (N, 3) [m].
            other: Those of the other motion, of the same shape.
        """
        x = self._X + u
        turned = [self._turn(self._X, x, nodes) @ self._along for nodes in self._sections]
        return self._angles(x, self._X + other, turned)

    def _angles(self, x: Array, y: Array, axes: Array | Sequence[Array]) -> Array:
        """Turns of the sections from x to y about axes."""
        axes = np.broadcast_to(axes, (len(self._sections), 3))
        found = []
        for nodes, axis in zip(self._sections, axes, strict=True):
            *v, w = Rotation.from_matrix(self._turn(x, y, nodes)).as_quat()
            angle = 2.0 * np.arctan2(v @ axis, w)
            found.append((angle + np.pi) % (2.0 * np.pi) - np.pi)
        return np.array(found)

    def _turn(self, x: Array, y: Array, nodes: IntArray) -> Array:
        """The rotation of a section that is nearest to its motion from x to y."""
        m = self._masses[nodes, None]
        a, b = (p[nodes] - (m * p[nodes]).sum(axis=0) / m.sum() for p in (x, y))
        return nearest_rotation(b.T @ (m * a))


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
        nearest = find_nearest_vectors(model.body.basis, u[self._order], free[None])
        body.state.u[0].array[:] = nearest.ravel()
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


log = logging.getLogger(__name__)


def judge(
    system: MultibodySystem,
    body: FlexibleBody,
    basis: ReducedBasis,
    loads: Sequence[LoadPath] | None = None,
    count: int = 6,
) -> Verdict:
    """Compare a basis with its body by frequencies, compliance under smooth loads, and equilibria.

    Loads must be others than those of training. The reduced body is loaded by the forces that hold
    the full one in equilibrium. Print the verdict for a table with warnings, or draw it.

    Args:
        system: The system that the basis was made in.
        body: The body.
        basis: The basis.
        loads: Load paths; those of `smooth_loads` with ``unseen=True`` if None.
        count: Number of frequencies.

    Raises:
        ModelError: for a body that is not in the system, or a basis or loads that are not its.
        InputError: if slepc4py is not installed.

    Note:
        Collective.
    """
    check_among_parts("flexible body", body, system.flexible_bodies)
    reduced = ReducedBody(f"reduced {body.name}", body, basis)
    if loads:
        check_loads(loads)
        check_held(system, body)
    couplings = [c for c in system.couplings if c.flexible is body]
    log.info("judging %r", basis)
    pair, both = (body, reduced), ReducedStates(system, body, reduced)
    resting = [_list_frequencies(system, x, couplings, count) for x in pair]
    try:
        compliances, states = dict[str, float](), tuple[StateVerdict, ...]()
        if couplings:
            loads = smooth_loads(system, body, unseen=True) if loads is None else loads
            paths = find_states(system, body, loads)
            compliances = both.compare_compliances()
            states = tuple(state for path in paths for state in both.compare(path))
    finally:
        both.destroy()
    return Verdict(
        name=body.name,
        functions=basis.size,
        strains=basis.strain_factor.shape[1],
        frequencies=np.array(resting),
        compliances=compliances,
        stations=both.stations,
        states=states,
        singular_values=basis.singular_values,
    )


def _list_frequencies(
    system: MultibodySystem, body: DeformableBody, couplings: Sequence[Coupling], count: int
) -> list[float]:
    """Frequencies of a body with all interfaces at rest [Hz]."""
    held = [Coupling(c.name, body, c.facets, None) for c in couplings]
    free = 0 if held else 6  # rigid motions
    found = modes(MultibodySystem(system.comm, [body, *held]), count=count + free)
    return [mode.frequency for mode in found.modes][free:]
