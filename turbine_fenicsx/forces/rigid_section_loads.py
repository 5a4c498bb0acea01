"""Forces and moments on the sections of rigid bodies, from the same sources as on flexible ones.

With the mean directors d_k of a step, not orthonormal, their increments over dt, and a section at
xi_k d_k from the centre of mass phi,

    x = phi + sum xi_k d_k,    v = phi' + sum xi_k d_k',
    J = sum (d_k.d_k 1 - d_k d_k),    omega = J^-1 sum d_k x d_k',

and the forces on the coordinates are the transpose of that,

    f_phi = sum F,    f_k = sum xi_k F + (J^-1 sum M) x d_k,

so that the power is F.v + M.omega and the moment sum d_k x f_k that of F and M, whatever these are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.body_checks import check_body
from turbine_fenicsx.forces.force import Kind, Layout, StepTimes
from turbine_fenicsx.forces.line_source import LineSource, StepLoads
from turbine_fenicsx.forces.section_loads import LineLoad, SectionMotion
from turbine_fenicsx.foundation.argument_checks import check_array, check_methods
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.memo import Memo
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.rotations import cross_rows, nearest_rotation
from turbine_fenicsx.foundation.types import Array

SMALL_CHANGE = 1e-4
"""Change of velocities in differences of the loads [m/s]."""

RENEWED = 10
"""Number of steps for which derivatives of the loads are kept."""


@dataclass(frozen=True, eq=False)
class RigidStations:
    """Stations on a rigid body.

    Args:
        body: The body.
        points: Centres of the sections in the initial configuration, shape (n, 3) [m].
    """

    body: RigidBody
    points: npt.ArrayLike


@dataclass(frozen=True, eq=False)
class RigidSectionLoads:
    """Loads on stations of rigid bodies, such as the wind on rigid blades.

    The work of a step is exactly force times increment. The tangent of a step has their derivative
    by the velocities of the sections, by differences every few steps.

    Args:
        name: Name under which their work is reported.
        lines: Where the stations are; the source counts them body after body.
        source: What knows the loads.

    Raises:
        ModelError: for points that are not positions, or a body that occurs twice.
        TypeError: if the source is not a `LineLoad`, or a body is not rigid.
    """

    name: str
    lines: Sequence[RigidStations]
    source: LineLoad
    kind: Kind = "external"

    def __post_init__(self) -> None:
        for line in self.lines:
            check_body(self.name, line.body)
            shape = (max(len(np.atleast_1d(np.asarray(line.points, dtype=object))), 1), 3)
            check_array(f"stations of {self.name!r}", line.points, shape, "positions")
        if not self.lines:
            raise ModelError(f"{self.name!r} needs stations on a body or more")
        if len({line.body.name for line in self.lines}) < len(self.lines):
            raise ModelError(f"{self.name!r} has a body twice")
        methods = ("start_step", "loads", "accept", "save", "restore")
        check_methods(f"source of {self.name!r}", self.source, methods)

    def bind(self, layout: Layout) -> BoundRigidLoads:
        """The loads with their coordinates numbered."""
        _, index = layout.frames(*(line.body for line in self.lines))
        return BoundRigidLoads(self, index)


class BoundRigidLoads(LineSource):
    """Loads on stations as generalised forces on the coordinates of rigid bodies.

    Args:
        index: Numbers of the coordinates of the bodies in the system, shape (12 bodies,).
    """

    def __init__(self, loads: RigidSectionLoads, index: npt.NDArray[np.int64]) -> None:
        points = [np.asarray(line.points, dtype=float) for line in loads.lines]
        counts = [len(p) for p in points]
        super().__init__(loads.name, sum(counts), loads.source)
        self.index = index
        self._checked = False
        self._step: StepTimes | None = None
        self._slopes: Array | None = None  # of the forces on sections, in their axes
        self._age = 0
        self._at = Memo(self._evaluate)
        self._initial = np.concatenate(points)
        coordinates = [
            line.body.body_coordinates(p) for line, p in zip(loads.lines, points, strict=True)
        ]
        self._body = np.repeat(np.arange(len(points)), counts)
        self._starts = np.cumsum(counts) - counts
        # a section is C (phi, d_1, d_2, d_3) of its body, c = (1, xi); all of them at once
        self._c = np.concatenate([np.ones((sum(counts), 1)), np.concatenate(coordinates)], axis=1)
        self._C = np.zeros((sum(counts), len(points), 4))
        self._C[np.arange(sum(counts)), self._body] = self._c
        self._C = self._C.reshape(sum(counts), -1)
        R = np.stack([np.asarray(line.body.directors, dtype=float) for line in loads.lines])
        self._R_T = R.swapaxes(1, 2)
        self._K: Array | None = None

    def force(self, y0: Array, y1: Array, step: StepTimes) -> tuple[Array, Array]:
        """Generalised force in the middle of a step, and nearly its derivative."""
        loads, arms = self._at(y0, y1, np.array([step.dt, step.middle, step.end]))
        motion, F, M, _ = loads
        force = self._find_forces(F, M, arms)
        if step != self._step:
            return force, np.zeros((self.index.size,) * 2)
        if self._K is None:  # one for all iterations of a step
            Q, Q_T = motion.axes, motion.axes.swapaxes(1, 2)
            if self._slopes is None or self._age >= RENEWED:
                slopes = self._find_slopes(motion, F, step.middle)
                self._slopes, self._age = Q_T @ slopes @ Q, 0
            self._K = self._assemble(Q @ self._slopes @ Q_T, step.dt)
        return force, self._K

    def energy(self, y: Array) -> float:
        """No energy [J]."""
        return 0.0

    def start_step_at(self, step: StepTimes, y: Array) -> None:
        """A step begins at y: the one before was accepted if this one follows it."""
        self.start_step(step)
        if not self._checked:  # an error in an iteration would become one of PETSc
            self.force(y, y, step)
            self._checked = True
        self._step, self._at, self._K = step, Memo(self._evaluate), None

    def finish_step(self, step: StepTimes, y0: Array, y1: Array) -> None:
        """The step from y0 to y1 is done, if none repeats it."""
        loads, _ = self._at(y0, y1, np.array([step.dt, step.middle, step.end]))
        self.finish(loads)
        self._age += 1

    def save(self) -> RestartData:
        """Data of the source after the last step, and the derivatives of the loads."""
        data = RestartData({"age": self._age})
        if self._slopes is not None:
            data.arrays["slopes"] = self._slopes.copy()
        data.add("source", super().save())
        return data

    def restore(self, data: RestartData) -> None:
        """Resume where the data were saved; start from scratch without any."""
        self._age, self._slopes = data.numbers.get("age", 0), data.arrays.get("slopes")
        self._at = Memo(self._evaluate)
        super().restore(data.part("source"))

    def loads_at(self, y: Array, y_dot: Array, time: float) -> StepLoads:
        """Loads in a configuration that moves, outside of a step."""
        motion, _ = self._find_motion(y, y_dot)
        times = StepTimes.from_start(time, 0.0)
        self.tell(times)
        return StepLoads(motion, *self.loads(motion, time), times)

    def _evaluate(
        self, y0: Array, y1: Array, times: Array
    ) -> tuple[StepLoads, tuple[Array, Array]]:
        """Loads in a step of (dt, middle, end); directors as rows and J^-1 of each body."""
        step = StepTimes(*times.tolist())
        motion, arms = self._find_motion(0.5 * (y0 + y1), (y1 - y0) / step.dt)
        if not np.isfinite(step.dt):
            self.tell(step)
        return StepLoads(motion, *self.loads(motion, step.middle), step), arms

    def _find_motion(self, y: Array, y_dot: Array) -> tuple[SectionMotion, tuple[Array, Array]]:
        """Motion of the sections; directors as rows and J^-1 of each body."""
        mean, rate = y.reshape(-1, 4, 3), y_dot.reshape(-1, 4, 3)
        d, d_dot = mean[:, 1:], rate[:, 1:]
        d_T = d.swapaxes(1, 2)
        S, A = d_T @ d, d_T @ d_dot
        inverse = np.linalg.inv(np.trace(S, axis1=1, axis2=2)[:, None, None] * np.eye(3) - S)
        # sum d_k x d_k' is twice the axial vector of A = sum d_k d_k'
        spin = np.stack([A[:, i, j] - A[:, j, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)
        omega = (inverse @ spin[:, :, None])[:, :, 0]
        motion = SectionMotion(
            self._C @ mean.reshape(-1, 3),
            nearest_rotation(d_T @ self._R_T)[self._body],
            self._C @ rate.reshape(-1, 3),
            omega[self._body],
            self._initial,
        )
        return motion, (d, inverse)

    def _find_slopes(self, motion: SectionMotion, F: Array, time: float) -> Array:
        """Derivatives of the forces on the sections by their velocities, shape (n, 3, 3)."""
        slopes = np.empty((len(F), 3, 3))
        for i in range(3):
            moved = motion._replace(velocity=motion.velocity + SMALL_CHANGE * np.eye(3)[i])
            slopes[:, :, i] = (self.loads(moved, time)[0] - F) / SMALL_CHANGE
        return slopes

    def _assemble(self, slopes: Array, dt: float) -> Array:
        """Derivative of the generalised force by the coordinates at the end of a step."""
        K = np.zeros((len(self._starts), 4, 3, len(self._starts), 4, 3))
        parts = np.einsum("nk,nij,nl->nkilj", self._c, slopes, self._c) / dt
        for body, part in enumerate(np.add.reduceat(parts, self._starts)):
            K[body, :, :, body] = part
        return K.reshape((self.index.size,) * 2)

    def _find_forces(self, F: Array, M: Array, arms: tuple[Array, Array]) -> Array:
        """Generalised forces of forces and moments on the sections, shape (12 bodies,)."""
        d, inverse = arms
        f = (self._C.T @ F).reshape(-1, 4, 3)
        turn = (inverse @ np.add.reduceat(M, self._starts)[:, :, None])[:, :, 0]
        f[:, 1:] += cross_rows(np.repeat(turn, 3, axis=0), d.reshape(-1, 3)).reshape(-1, 3, 3)
        return f.ravel()
