"""Forces and moments in sections of slender bodies: sums of all that acts beyond them.

With the momenta p and L of the part beyond a section, about the origin, it exerts on the rest

    F = weight + loads on stations + forces of couplings - dp/dt,
    M = moments of these - dL/dt - r x F,

where r is a point of the section. In a step from t_n to t_{n+1} the forces are those in its middle,
and the rates differences of momenta over its length. So F and M at the end that is held are what
`Reactions` finds there. Viscous and other inner forces are part of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.analysis.turning_frame import TurningFrame
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.forces.section_loads import SectionLoads
from turbine_fenicsx.foundation.argument_checks import check_among_parts
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.rotations import cross_rows, nearest_rotation
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.observers.cuts import Cut, find_rows, find_shares
from turbine_fenicsx.simulation.observers.outboard_parts import FullParts, ReducedParts
from turbine_fenicsx.simulation.observers.outboard_stations import share_stations
from turbine_fenicsx.simulation.observers.probe import Probe, find_model
from turbine_fenicsx.simulation.observers.station_loads import find_loads
from turbine_fenicsx.simulation.observers.step_loads import StepLoads
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.reduced_model import ReducedModel
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


class _Sums(NamedTuple):
    """Sums over what lies beyond n sections, in a state.

    Attributes:
        linear: p, shape (n, 3) [kg m/s].
        angular: L, shape (n, 3) [kg m^2/s].
        static: sum w_a m_a x_a, shape (n, 3) [kg m].
        points: r, shape (n, 3) [m].
        directors: A^T of the rotations A of the sections, shape (n, 3, 3).
        u: Displacements of the owned nodes of the body, shape (k, 3) [m].
    """

    linear: Array
    angular: Array
    static: Array
    points: Array
    directors: Array
    u: Array


class OutboardLoads(StepLoads):
    """Loads that the parts of a body beyond sections exert on its parts before them.

    Args:
        system: The system.
        cuts: Sections of one body, on its mesh or reduced.

    Raises:
        ModelError: for bodies that the system does not have, for beams, which know the loads in
            their sections (`BeamLoads`), and for forces on the body besides loads on stations.

    Note:
        Collective, as are all methods.
    """

    def __init__(self, system: MultibodySystem, cuts: Sequence[Cut]) -> None:
        super().__init__([cut.axes for cut in cuts], [cut.section for cut in cuts])
        self._system, body = system, cuts[0].section.body
        model = find_model(system, body, f"section {cuts[0].section.name!r}")
        if not isinstance(model, FlexibleModel | ReducedModel) or not isinstance(
            body.full, FlexibleBody
        ):
            raise ModelError(f"masses beyond sections are those of solids, not of {body.name!r}")
        others = [force.name for force in model.forces if not isinstance(force, SectionLoads)]
        if others:
            raise ModelError(
                f"loads in sections of {body.name!r} count weight and loads on stations, not the "
                f"force {others[0]!r}"
            )
        self._index, self._model = system.flexible_bodies.index(body), model
        shares = np.array([find_shares(model, cut) for cut in cuts])
        self._parts: FullParts | ReducedParts
        if isinstance(model, ReducedModel):
            self._parts = ReducedParts(model, [cut.section.copy for cut in cuts], shares)
        else:
            self._parts = FullParts(model, shares)
        self._stations = [
            (x.name, share_stations(x.lines, cuts))
            for x in model.forces
            if isinstance(x, SectionLoads)
        ]
        self._held = [self._find_held(cut) for cut in cuts]
        self._probe = Probe(system, [(body, find_rows(model, cut)) for cut in cuts])
        # arms of the points from the centres, in the initial configuration
        starts = self._probe.start.reshape(-1, 4, 3)[:, 0]
        self._arms = np.array([np.asarray(cut.point, dtype=float) for cut in cuts]) - starts

    def at_rest(self, state: State, frame: TurningFrame | None = None) -> Array:
        """Loads in an equilibrium, shape (n, 2, 3), as in `at`.

        Args:
            frame: The frame that the body turns with; None is the ground.
        """
        sums = self._remember(state)
        rates = np.zeros((2, len(self._arms), 3))
        if frame is not None:
            rates = np.array(frame.momentum_rates(sums.linear, sums.angular))
        return self._in_axes(*self._loads_of(state, sums, rates))

    def _remember(self, state: State) -> _Sums:
        """The sums in a state."""
        u, v = (x[self._index].array_r.reshape(-1, 3).copy() for x in (state.u, state.v))
        p, L, s = sum_over_ranks(self._system.comm, self._parts.sum_up(u, v))
        # centres and B^T of the sections, see `SectionTurns`
        sections = self._probe.values(state).reshape(-1, 4, 3)
        A = nearest_rotation(sections[:, 1:].swapaxes(1, 2))
        r = sections[:, 0] + np.einsum("nij,nj->ni", A, self._arms)
        return _Sums(p, L, s, r, A.swapaxes(1, 2), u)

    def _evaluate(self, start: _Sums, end: _Sums, snapshot: Snapshot) -> tuple[Array, Array]:
        """Loads of the parts beyond, and directors of the sections."""
        if snapshot.stepper.forces_at != 0.5:
            raise ModelError("loads in sections need steps with their forces in the middle")
        state = snapshot.state
        rates = np.array([end.linear - start.linear, end.angular - start.angular])
        middle = _Sums._make(0.5 * (a + b) for a, b in zip(start, end, strict=True))
        return self._loads_of(state, middle, rates / (state.time - self._time))

    def _loads_of(self, state: State, sums: _Sums, rates: Array) -> tuple[Array, Array]:
        """Loads for rates of the momenta, shape (2, n, 3), and directors of the sections."""
        g = self._system.gravity
        F, M = -rates
        F += np.outer(self._parts.masses, g)
        M += np.cross(sums.static, g)
        held = sum_over_ranks(self._system.comm, self._sum_held(state, sums.u))
        F, M = F + held[0], M + held[1]
        for name, shares in self._stations:
            of_stations = shares.sum_up(find_loads(self._system, name, state))
            F, M = F + of_stations[0], M + of_stations[1]
        return np.stack([F, M - cross_rows(sums.points, F)], axis=1), sums.directors

    def _find_held(self, cut: Cut) -> list[tuple[slice, npt.NDArray[np.int64]]]:
        """Rows of the forces of the couplings beyond a section, and the nodes that they act on."""
        found, block = [], self._system.coupling_blocks[self._index]
        for coupling in cut.beyond:
            check_among_parts("coupling", coupling, block.couplings)
            rows = block.slices[block.couplings.index(coupling)]
            found.append((rows, block.nodes[rows]))
        return found

    def _sum_held(self, state: State, u: Array) -> Array:
        """Forces of couplings beyond sections, and their moments, of this rank, (2, n, 3)."""
        found, model = np.zeros((2, len(self._held), 3)), self._model
        forces = state.coupling[self._index].array_r.reshape(-1, 3)
        for k, couplings in enumerate(self._held):
            for rows, nodes in couplings:
                f, x = forces[rows], model.positions[nodes] + u[nodes]
                found[0, k] += model.is_point[nodes] @ f
                found[1, k] += cross_rows(x, f).sum(axis=0)
        return found
