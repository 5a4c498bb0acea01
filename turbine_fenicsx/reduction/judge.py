"""A basis judged by the full body: frequencies, compliance, and equilibria under unseen loads."""

from __future__ import annotations

import logging
from collections.abc import Sequence

import numpy as np

from turbine_fenicsx.analysis.modes import modes
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.reduced_body import ReducedBasis, ReducedBody
from turbine_fenicsx.foundation.checks import check_among_parts
from turbine_fenicsx.reduction.load_path import LoadPath, check_loads
from turbine_fenicsx.reduction.reduced_states import ReducedStates
from turbine_fenicsx.reduction.smooth_loads import smooth_loads
from turbine_fenicsx.reduction.static_body import check_held
from turbine_fenicsx.reduction.static_states import find_states
from turbine_fenicsx.reduction.verdict import StateVerdict, Verdict
from turbine_fenicsx.system.system import MultibodySystem

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
