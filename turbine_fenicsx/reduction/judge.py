"""A basis judged by the full body: frequencies, compliance, and equilibria under unseen loads."""

from __future__ import annotations

import logging
import os
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.analysis.modes import modes
from turbine_fenicsx.analysis.turning_modes import turning_modes
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.reduced_body import ReducedBasis, ReducedBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.checks import check_among_parts, check_number, check_vectors
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.joints.prescribed_motion import PrescribedMotion
from turbine_fenicsx.joints.revolute import Revolute
from turbine_fenicsx.reduction.load_path import LoadPath, check_loads
from turbine_fenicsx.reduction.reduced_states import ReducedStates
from turbine_fenicsx.reduction.smooth_loads import smooth_loads
from turbine_fenicsx.reduction.static_body import check_held
from turbine_fenicsx.reduction.static_states import find_states
from turbine_fenicsx.reduction.verdict import StateVerdict, Verdict
from turbine_fenicsx.system.system import MultibodySystem

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class SteadyRotation:
    """A rotation in which frequencies are compared.

    Args:
        speed: Angular velocity [rad/s].
        point: A point of the axis [m], shape (3,).
        axis: Its direction, shape (3,).

    Raises:
        ModelError: for values that are not numbers.
    """

    speed: float
    _: KW_ONLY
    point: npt.ArrayLike
    axis: npt.ArrayLike

    def __post_init__(self) -> None:
        check_number("speed of a rotation", self.speed)
        check_vectors("a rotation", point=self.point, axis=self.axis)


def judge(
    system: MultibodySystem,
    body: FlexibleBody,
    basis: ReducedBasis,
    loads: Sequence[LoadPath] | None = None,
    count: int = 6,
    rotation: SteadyRotation | None = None,
    keep: str | os.PathLike[str] | None = None,
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
        rotation: A rotation of the first interface in which frequencies are compared too.
        keep: File in which finished load paths are kept, as of `reduce_body`.

    Raises:
        ModelError: for a body that is not in the system, or a basis or loads that are not its.
        InputError, FileError: as of `reduce_body`; InputError too if slepc4py is not installed.

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
    turning = [_turn(system, x, couplings, count, rotation) for x in pair]
    try:
        compliances, states = dict[str, float](), tuple[StateVerdict, ...]()
        if couplings:
            loads = smooth_loads(system, body, unseen=True) if loads is None else loads
            paths = find_states(system, body, loads, both.points, keep)
            compliances = both.compare_compliances()
            states = tuple(state for path in paths for state in both.compare(path))
    finally:
        both.destroy()
    return Verdict(
        name=body.name,
        functions=basis.size,
        strains=basis.strain_factor.shape[1],
        frequencies=np.array(resting),
        turning_frequencies=None if rotation is None else np.array(turning),
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


def _turn(
    system: MultibodySystem,
    body: DeformableBody,
    couplings: Sequence[Coupling],
    count: int,
    rotation: SteadyRotation | None,
) -> list[float]:
    """Frequencies of a body on a hub that turns steadily [Hz]; none without a rotation."""
    if rotation is None:
        return []
    if len(couplings) != 1:
        raise ModelError(
            f"a rotation needs a body with one coupling, and {body.name!r} has {len(couplings)}"
        )
    speed = rotation.speed
    hub = RigidBody("hub", 1.0, (1.0, 1.0, 1.0), position=rotation.point)
    axle = Revolute("axle", None, hub, point=rotation.point, axis=rotation.axis)
    drive = PrescribedMotion("axle", lambda t: speed * t)
    held = Coupling(couplings[0].name, body, couplings[0].facets, hub)
    found = turning_modes(
        MultibodySystem(system.comm, [hub, axle, drive, body, held]), "axle", speed, count
    )
    frequencies = [mode.frequency for mode in found.modes]
    found.state.destroy()
    return frequencies
