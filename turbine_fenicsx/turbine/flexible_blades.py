"""Three flexible blades, one body, on the hub or on the rings of the pitch bearings (section 3).

The frame of a blade is that of OpenFAST, with the origin at the centre of the root: x points
downwind along the shaft, z along the span to the tip, and y = z x x to the trailing edge of a rotor
that turns clockwise, seen from upwind. It is fixed to what carries the root: to the hub, or with
pitch bearings to the ring, so that it pitches with the blade. Root loads are those that the blade
exerts on its carrier.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.frame_fields import frame_fields
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.postprocessing import names
from turbine_fenicsx.postprocessing.conventions import BLADES, HUB
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.reactions import Reaction, Reactions
from turbine_fenicsx.simulation.observers.shared_sum import SharedSum
from turbine_fenicsx.simulation.observers.tips import Tip, Tips, tip_channel
from turbine_fenicsx.turbine.component import Assembly, Channels, Component, Turbine
from turbine_fenicsx.turbine.pitch import RINGS
from turbine_fenicsx.turbine.rotor_plan import ROOTS

BODY = "blades"
"""Name of the flexible body of all blades."""


@dataclass(frozen=True)
class FlexibleBlades(Component):
    """The mesh of the blades as one flexible body, and a coupling of each root."""

    def parts(self, assembly: Assembly) -> list[Any]:
        """Body ``blades`` and couplings ``root_1`` ... to the rings or, without these, the hub."""
        case, rotor = assembly.case, assembly.rotor
        source, make = rotor.mesh_source(assembly.comm)
        mesh = assembly.load_mesh(BODY, source, make, rotor.list_mistakes)
        frames = {
            mesh.cell_names[name]: rotor.layout.frame(k) for k, name in enumerate(BLADES, start=1)
        }
        axes = frame_fields(mesh.mesh, mesh.cell_tags, frames)
        material = case.material.make(axes)
        body = FlexibleBody(
            BODY, mesh.mesh, material, case.material.density, rotor.degree, fibre=axes[0]
        )
        hub = assembly.part(HUB)
        return [body] + [
            Coupling(root, body, mesh.facets(root), assembly.find(ring) or hub)
            for root, ring in zip(ROOTS, RINGS, strict=True)
        ]

    def channels(self, turbine: Turbine) -> Channels:
        """Tip deflections, whole, flapwise and edgewise; root forces and moments."""
        system, layout, blade = turbine.system, turbine.rotor.layout, turbine.rotor.blade
        numbers = [str(k) for k in range(1, len(ROOTS) + 1)]
        reactions, followed = [], []
        for k, name, point in zip(numbers, ROOTS, turbine.rotor.tips, strict=True):
            coupling = turbine.part(name)
            axes = blade_axes(layout.frame(int(k))[0], np.asarray(layout.axis))
            root = np.asarray(layout.centre) + blade.hub_radius * axes[2]
            reactions.append(Reaction(coupling, root, axes))
            followed.append(Tip(k, coupling.flexible, point, coupling.rigid, axes))
        sums = SharedSum(system.comm)
        loads, tips = Reactions(system, reactions, sums), Tips(system, followed, sums)
        bends = [f(tip=k) for k in numbers for f in (names.TIP_FLAP, names.TIP_EDGE)]
        columns = [
            family(blade=k, axis=axis)
            for k in numbers
            for family in (names.ROOT_FORCE, names.ROOT_MOMENT)
            for axis in "xyz"
        ]
        motions = [f"TipD{axis}b{k}_[m]" for k in numbers for axis in "xyz"]
        roots = [
            f"Root{kind}{axis}b{k}_[{unit}]"
            for k in numbers
            for kind, unit in (("F", "kN"), ("M", "kN-m"))
            for axis in "xyz"
        ]
        return Channels(
            history=[
                tip_channel(tips),
                Channel(tuple(bends), lambda s: tips.at(s)[:, :2].ravel().tolist()),
                Channel(tuple(columns), lambda s: loads.at(s).ravel().tolist()),
            ],
            openfast=[
                Channel(tuple(motions), lambda s: tips.at(s).ravel().tolist()),
                Channel(tuple(roots), lambda s: (1e-3 * loads.at(s)).ravel().tolist()),
            ],
        )


def blade_axes(span: Array, axis: Array) -> Array:
    """Axes x, y, z of the frame of a blade as rows, shape (3, 3).

    Args:
        span: Direction of the span, shape (3,).
        axis: Direction of the shaft, downwind, shape (3,).
    """
    x = axis / np.linalg.norm(axis)
    return np.array([x, np.cross(span, x), span])
