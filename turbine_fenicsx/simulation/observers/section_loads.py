"""Forces and moments in the sections of beams."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.analysis.turning_frame import TurningFrame
from turbine_fenicsx.bodies.beam_basis import BeamBasis
from turbine_fenicsx.bodies.reduced_body import ReducedBody
from turbine_fenicsx.foundation.argument_checks import check_among_parts
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import from_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.observers.step_loads import StepLoads
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.reduced_model import ReducedModel
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


class BeamLoads:
    """Elastic force and moment in sections of all copies of a beam.

    They are what the part behind a section, towards the end of the axis, exerts on the part before
    it, about the axis [N, N m].

    Args:
        system: The system.
        body: A reduced body of it with a `turbine_fenicsx.BeamBasis`.
        places: Fractions of the length of the axis, from 0 to 1, shape (k,).
        axes: Axes of the components, which turn with the section; initial directions on the first
            copy as rows, shape (3, 3). The directors x and y of the section, and z along the axis,
            if None.

    Raises:
        ModelError: for other bodies than beams, and places beyond the ends.
    """

    def __init__(
        self,
        system: MultibodySystem,
        body: ReducedBody,
        places: Sequence[float],
        axes: npt.ArrayLike | None = None,
    ) -> None:
        check_among_parts("flexible body", body, system.flexible_bodies)
        self._index = system.flexible_bodies.index(body)
        model, basis = system.flexible_models[self._index], getattr(body, "basis", None)
        if not isinstance(model, ReducedModel) or not isinstance(basis, BeamBasis):
            raise ModelError(f"loads on sections need a beam, and {body.name!r} is none")
        at = np.asarray(places, dtype=float)
        if at.ndim != 1 or np.any((at < 0.0) | (at > 1.0)):
            raise ModelError(
                f"places of sections of {body.name!r} must be fractions from 0 to 1, got {places!r}"
            )
        self._model, self._basis = model, basis
        self._weights = basis.find_weights(at * basis.length)
        self._turns = np.tile(np.eye(3), (len(at), 1, 1))
        if axes is not None:
            R, _ = body.placements[0].frame()
            own = basis.find_axes(at * basis.length)
            self._turns = np.asarray(axes, dtype=float) @ R @ own.swapaxes(1, 2)

    def at(self, state: State) -> Array:
        """Loads in a state, shape (copies, k, 6), equal on all ranks. Collective."""
        z = self._model.vectors(state.u[self._index].array_r)
        found = self.evaluate(z) if len(z) else np.zeros((self._model.copies, *self.shape))
        return from_rank0(self._model.comm, found)

    @property
    def copies(self) -> int:
        """Number of copies."""
        return self._model.copies

    @property
    def shape(self) -> tuple[int, int]:
        """Number of sections, and 6."""
        return len(self._weights), 6

    def evaluate(self, vectors: Array) -> Array:
        """Loads for vectors z, shape (copies, k, 6).

        Args:
            vectors: Shape (copies, n, 3); any number of copies, such as those of many times.
        """
        y = self._model.strain.vectors(vectors)
        of_gauss = self._basis.find_section_loads(y, self._model.strain.strain(y))
        found = np.tensordot(of_gauss, self._weights, (1, 1)).swapaxes(1, 2)
        turned: Array = np.einsum(
            "kij,ckaj->ckai", self._turns, found.reshape(*found.shape[:2], 2, 3)
        )
        turned = turned.reshape(found.shape)
        return turned


class BeamStepLoads(StepLoads):
    """Those of `BeamLoads` in the steps of a run, means of both ends.

    The scheme has the mean of the stresses at both ends in a step. So these balance the other loads
    of the step, but for viscosity.

    Args:
        beams: The loads; n are those of all copies, one copy after another.
    """

    def __init__(self, beams: BeamLoads) -> None:
        n = beams.copies * beams.shape[0]
        super().__init__([None] * n, [None] * n)
        self._beams, self._directors = beams, np.tile(np.eye(3), (n, 1, 1))

    def at_rest(self, state: State, frame: TurningFrame | None = None) -> Array:
        """Loads in an equilibrium in any frame, shape (n, 2, 3). Collective."""
        return self._remember(state)

    def _remember(self, state: State) -> Array:
        """Loads in a state, along the axes of the sections."""
        return self._beams.at(state).reshape(-1, 2, 3)

    def _evaluate(self, start: Array, end: Array, snapshot: Snapshot) -> tuple[Array, Array]:
        """Means of both ends."""
        return 0.5 * (start + end), self._directors
