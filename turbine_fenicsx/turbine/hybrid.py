"""The hybrid turbine: rigid nacelle and hub, three flexible blades (sections 3 and 4.2)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.frame_fields import Frame, frame_fields
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.base import Material
from turbine_fenicsx.turbine.case.parameters import TurbineParameters
from turbine_fenicsx.turbine.pitch import RootRings
from turbine_fenicsx.turbine.rigid import nacelle_and_hub


def hybrid_turbine(
    p: TurbineParameters,
    mesh: Any,
    cell_tags: Any,
    facet_tags: Any,
    blades: Sequence[tuple[int, int, Array]],
    material: Callable[[Frame], Material],
    density: float,
    degree: int = 1,
    rings: RootRings | None = None,
    support: RigidBody | None = None,
) -> list[Any]:
    """Parts of the hybrid turbine.

    Args:
        p: Parameters of the rigid parts.
        mesh: Mesh of all blades.
        cell_tags: Cell tags of the blades.
        facet_tags: Facet tags of the blade roots.
        blades: For each blade its cell tag, the facet tag of its root, and its frame (span,
            chord, thickness) as rows, shape (3, 3).
        material: Makes the material from the frame fields.
        density: Density of the blades [kg/m^3].
        degree: Polynomial degree of the displacement.
        rings: Rings at the blade roots that turn in pitch bearings; None fixes the blades to the
            hub.
        support: What carries the yaw bearing; None for the ground.

    Returns:
        Nacelle, hub, rings, their bearings, one flexible body with all blades, and one coupling
        per blade; loads are the caller's.
    """
    nacelle, hub, bearings = nacelle_and_hub(p, support)
    ring_bodies, pitch_bearings = rings.on(hub) if rings else ([], [])
    carriers = ring_bodies or [hub] * len(blades)
    frame = frame_fields(mesh, cell_tags, {tag: axes for tag, _, axes in blades})
    body = FlexibleBody("blades", mesh, material(frame), density, degree, fibre=frame[0])
    couplings = [
        Coupling(
            f"root_{k}",
            body,
            facet_tags.indices[facet_tags.values == root].astype(np.int32),
            carrier,
        )
        for k, ((_, root, _), carrier) in enumerate(zip(blades, carriers, strict=True), start=1)
    ]
    return [nacelle, hub, *ring_bodies, *bearings, *pitch_bearings, body, *couplings]
