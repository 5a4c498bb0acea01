"""Strain gauges on the surface of flexible bodies.

A gauge is a short fibre along a unit vector t in the surface. The motion takes it to

    F t = sum_a x_a (grad N_a . t),

and it reads |F t| - 1, which knows nothing of rotations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from math import cos, inf, sin

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.foundation.argument_checks import check_vectors
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.probe import Probe, find_model
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.surface_rays import Crossing, Skin
from turbine_fenicsx.system.system import MultibodySystem


@dataclass(frozen=True, eq=False)
class Gauge:
    """A strain gauge, where a half-line leaves the body for good.

    Args:
        name: Column ``strain_NAME_[-]``.
        body: Flexible body that it is glued to.
        point: Where the half-line begins, in the initial configuration, shape (3,) [m].
        outward: Direction of the half-line, shape (3,).
        along: Direction of the gauge, which is turned into the surface, shape (3,).
        angle: By which it is turned from there, positive about the outward normal [rad].

    Raises:
        ModelError: if a vector is not three numbers or zero, or the angle is not a number.
    """

    name: str
    body: DeformableBody
    _: KW_ONLY
    point: npt.ArrayLike
    outward: npt.ArrayLike
    along: npt.ArrayLike
    angle: float = 0.0

    def __post_init__(self) -> None:
        vectors = {"outward": self.outward, "along": self.along}
        check_vectors(self.name, point=self.point, **vectors)
        for name, vector in vectors.items():
            if not np.any(vector):
                raise ModelError(f"{name} of gauge {self.name!r} must not be zero")
        if not -inf < self.angle < inf:
            raise ModelError(f"angle of gauge {self.name!r} must be a finite number")


class Gauges:
    """Strains that gauges read.

    Args:
        system: The system.
        gauges: The gauges.

    Raises:
        ModelError: for a body that is not part of the system, a half-line that misses its body, or
            a direction across the surface.

    Note:
        Collective.
    """

    def __init__(self, system: MultibodySystem, gauges: Sequence[Gauge]) -> None:
        self.gauges, sums, skins = tuple(gauges), [], {}
        for gauge in self.gauges:
            model = find_model(system, gauge.body, f"gauge {gauge.name!r}")
            if model not in skins:
                skins[model] = Skin(model)
            copy, crossings = _find_surface(gauge, skins[model])
            nodes, weights = _place(gauge, crossings, gauge.body.placements[copy].frame()[0])
            sums.append((gauge.body, model.rows(copy, nodes, weights)))
        self._probe = Probe(system, sums)

    def at(self, snapshot: Snapshot) -> Array:
        """Strains at a snapshot, shape (n,), equal on all ranks. Collective."""
        return self.strains(snapshot.state)

    def strains(self, state: State) -> Array:
        """Strains in a state, as of `at`. Collective."""
        strains: Array = np.linalg.norm(self._probe.values(state), axis=1) - 1.0
        return strains


def gauge_channel(gauges: Gauges) -> Channel:
    """A column for each gauge."""
    columns = tuple(names.STRAIN(gauge=gauge.name) for gauge in gauges.gauges)
    return Channel(columns, lambda s: gauges.at(s).tolist())


def _find_surface(gauge: Gauge, skin: Skin) -> tuple[int, list[Crossing]]:
    """Copy of the body, and where a half-line leaves it for good, at its first copy. Collective."""
    point, outward = (np.asarray(x, dtype=float) for x in (gauge.point, gauge.outward))
    frames = [place.frame() for place in gauge.body.placements]
    found = [skin.leave((point - t) @ R, outward @ R) for R, t in frames]
    hit = [(crossings[0].distance, copy) for copy, crossings in enumerate(found) if crossings]
    if not hit:
        raise ModelError(
            f"gauge {gauge.name!r}: from {np.asarray(gauge.point).tolist()} along "
            f"{np.asarray(gauge.outward).tolist()} there is no surface of {gauge.body.name!r}"
        )
    copy = min(hit)[1]
    return copy, found[copy]


def _place(
    gauge: Gauge, crossings: Sequence[Crossing], R: Array
) -> tuple[npt.NDArray[np.int64], Array]:
    """Nodes and weights of a gauge; where cells meet, the mean over them.

    Args:
        R: Rotation of the copy that it is glued to, shape (3, 3).
    """
    normal = np.sum([crossing.normal for crossing in crossings], axis=0)
    normal /= np.linalg.norm(normal)
    along = np.asarray(gauge.along, dtype=float) @ R
    t = along - (along @ normal) * normal
    if np.linalg.norm(t) < 1e-6 * np.linalg.norm(along):
        given = np.asarray(gauge.along, dtype=float).tolist()
        raise ModelError(f"gauge {gauge.name!r}: along = {given} is across the surface")
    t /= np.linalg.norm(t)
    t = cos(gauge.angle) * t + sin(gauge.angle) * np.cross(normal, t)
    nodes = np.concatenate([crossing.nodes for crossing in crossings])
    weights = np.concatenate([crossing.gradients @ t for crossing in crossings])
    return nodes, weights / len(crossings)
