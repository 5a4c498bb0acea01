"""Section loads on a flexible body: evaluated for any motion, moved on once per accepted step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.line_source import LineSource, StepLoads
from turbine_fenicsx.forces.section_loads import SectionLoads, SectionMotion
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.body_nodes import BodyNodes
from turbine_fenicsx.system.section_transfer import SectionTransfer


class _Evaluation(NamedTuple):
    """Loads for displacements and velocities at a time, and the motion that they belong to."""

    u: Array
    v: Array
    time: float
    motion: SectionMotion
    force: Array
    moment: Array

    def is_of(self, u: Array, v: Array, time: float) -> bool:
        """Whether it is that of a motion."""
        return time == self.time and np.array_equal(u, self.u) and np.array_equal(v, self.v)


class BoundSectionLoads(LineSource):
    """Loads on stations as forces on the nodes of a body.

    Args:
        loads: The loads.
        model: The body.
    """

    def __init__(self, loads: SectionLoads, model: BodyNodes) -> None:
        super().__init__(loads.name, sum(line.size for line in loads.lines), loads.source)
        self.transfer = SectionTransfer(model, loads)
        nodes = self.transfer.nodes
        # ranks alone know whether a motion is the last one; several would have to agree
        self._keeps = model.comm.size == 1
        self._kept: _Evaluation | None = None
        self._X = model.positions[nodes]
        self._dofs = (3 * nodes[:, None] + np.arange(3)).ravel()
        self._checked = False

    def start_step_at(self, times: StepTimes, u: Array) -> None:
        """A step begins: the one before was accepted if this one follows it. Collective.

        Args:
            u: Displacements of the owned nodes at its start, shape (3 n,) [m].
        """
        self._kept = None
        self.start_step(times)
        if not self._checked:  # an error in an iteration would become one of PETSc
            self.loads(self.find_motion(u, np.zeros_like(u)), times.middle)
            self._checked = True

    def add_forces(self, u: Array, v: Array, time: float, factor: float, out: Array) -> None:
        """Add the forces on the nodes times a factor. Collective.

        Args:
            u: Displacements of the owned nodes, shape (3 n,) [m].
            v: Their velocities, shape (3 n,) [m/s].
            time: Time [s].
            out: What the forces are added to, shape (3 n,).
        """
        _, F, M = self._evaluate(u, v, time)
        out[self._dofs] += factor * self._spread(F, M)

    def work(self, u: Array, v: Array, times: StepTimes, du: Array) -> float:
        """This rank's part of the work in a step [J], which is then done. Collective.

        Args:
            u: Displacements in the middle of the step, shape (3 n,) [m].
            v: Velocities there, du/dt, shape (3 n,) [m/s].
            du: Increments, shape (3 n,) [m].
        """
        motion, F, M = self._evaluate(u, v, times.middle)
        self.finish(StepLoads(motion, F, M, times))
        return float(self._spread(F, M) @ du[self._dofs])

    def find_slopes(self, u: Array, v: Array, times: StepTimes) -> Array:
        """Derivatives of the loads by increments of a step, see `SlopedLoad.find_slopes`.

        Args:
            u: Displacements of the owned nodes in the middle of the step, shape (3 n,) [m].
            v: Their velocities there, shape (3 n,) [m/s].

        Returns:
            Shape (stations, 6, 6).

        Note:
            Collective.
        """
        return self.slopes(self._evaluate(u, v, times.middle)[0], times)

    def respond(self, u: Array, v: Array, time: float, states: Array) -> tuple[Array, Array]:
        """Forces on the nodes, shape (3 n,) [N], and rates of states of the source. Collective.

        Args:
            u: Displacements of the owned nodes, shape (3 n,) [m].
            v: Their velocities, shape (3 n,) [m/s].
            time: Time [s].
            states: Of the source, shape (stations, k).
        """
        found, forces = self.states.respond(self.find_motion(u, v), time, states), np.zeros_like(u)
        forces[self._dofs] = self._spread(found.force, found.moment)
        return forces, found.rates

    def loads_at(self, u: Array, v: Array, time: float) -> StepLoads:
        """Loads for displacements and velocities outside of a step. Collective."""
        self._kept = None
        motion = self.find_motion(u, v)
        times = StepTimes.from_start(time, 0.0)
        self.tell(times)
        return StepLoads(motion, *self.loads(motion, time), times)

    def _evaluate(self, u: Array, v: Array, time: float) -> tuple[SectionMotion, Array, Array]:
        """Motion of the sections and loads on them; those of the last call for the same again."""
        kept = self._kept
        if kept is None or not kept.is_of(u, v, time):
            motion = self.find_motion(u, v)
            kept = _Evaluation(u.copy(), v.copy(), time, motion, *self.loads(motion, time))
            self._kept = kept if self._keeps else None
        return kept.motion, kept.force, kept.moment

    def find_motion(self, u: Array, v: Array) -> SectionMotion:
        """How the sections move with displacements and velocities, shapes (3 n,). Collective."""
        u, v = (values[self._dofs].reshape(-1, 3) for values in (u, v))
        return self.transfer.motion(self._X + u, v)

    def _spread(self, F: Array, M: Array) -> Array:
        """Forces on the degrees of freedom of these nodes for loads on the sections [N]."""
        return self.transfer.forces(F, M).ravel()
