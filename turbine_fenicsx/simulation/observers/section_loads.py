"""Forces and moments in the sections of beams."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from turbine_fenicsx.bodies.beam_basis import BeamBasis
from turbine_fenicsx.bodies.reduced_body import ReducedBody
from turbine_fenicsx.foundation.argument_checks import check_among_parts
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import from_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.reduced_model import ReducedModel
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


class BeamLoads:
    """Elastic force and moment in sections of all copies of a beam.

    They are what the part behind a section, towards the end of the axis, exerts on the part before
    it, along x, y (the directors of the section as it is) and z (along the axis) [N, N m].

    Args:
        system: The system.
        body: A reduced body of it with a `turbine_fenicsx.BeamBasis`.
        places: Fractions of the length of the axis, from 0 to 1, shape (k,).

    Raises:
        ModelError: for other bodies than beams, and places beyond the ends.
    """

    def __init__(self, system: MultibodySystem, body: ReducedBody, places: Sequence[float]) -> None:
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

    def at(self, state: State) -> Array:
        """Loads in a state, shape (copies, k, 6), equal on all ranks. Collective."""
        z = self._model.vectors(state.u[self._index].array_r)
        found = self.evaluate(z) if len(z) else np.zeros((self._model.copies, *self.shape))
        return from_rank0(self._model.comm, found)

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
        found: Array = np.tensordot(of_gauss, self._weights, (1, 1)).swapaxes(1, 2)
        return found
