"""Three flexible blades, one body, on the hub or on the rings of the pitch bearings (section 3).

The frame of a blade is that of OpenFAST, with the origin at the centre of the root. Its x points
downwind, without precone along the shaft, and z along the span to the tip. So y = z x x points to
the trailing edge of a rotor that turns clockwise, seen from upwind. It is fixed to what carries the
root: to the hub, or with pitch bearings to the ring, so that it pitches with the blade. Root loads
are those that the blade exerts on its parent body.

The yaw axis moves with the nacelle. Tips below the yaw bearing have their distance from the axis,
tips above it that from the bearing. Without the radius of the tower this is no gap yet.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from turbine_fenicsx.bodies.carrier import Carrier
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.frame_fields import frame_fields
from turbine_fenicsx.bodies.reduced_body import ReducedBody
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import BLADES, HUB, NACELLE
from turbine_fenicsx.simulation.observers.cell_values import CellValues
from turbine_fenicsx.simulation.observers.gauges import gauge_channel
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.ply_failure import failure_channel, failure_field
from turbine_fenicsx.simulation.observers.section_turns import Section, SectionTurns
from turbine_fenicsx.simulation.observers.tips import Tip, Tips, tip_channel
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.turbine.blades.beam_blades import BeamBlades
from turbine_fenicsx.turbine.blades.blade_basis import find_basis
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS, BladePlies
from turbine_fenicsx.turbine.blades.clamped_blade import (
    ROOT,
    ClampedBlade,
    SingleMesh,
    place_copies,
)
from turbine_fenicsx.turbine.blades.station_check import check_stations
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.axes import blade_axes
from turbine_fenicsx.turbine.components.component import Assembly, Channels, Component, Turbine
from turbine_fenicsx.turbine.components.gauges import make_gauges
from turbine_fenicsx.turbine.components.openfast_channel import in_openfast
from turbine_fenicsx.turbine.components.pitch import RINGS, find_angles
from turbine_fenicsx.turbine.components.root_channels import root_channels, unpitch
from turbine_fenicsx.turbine.components.slender_loads import HALF_WIDTH, blade_section_channels


class YawDistances:
    """Distances of tips from the yaw axis. Collective.

    Args:
        turbine: The turbine, whose yaw bearing starts in the origin and turns about e2.
    """

    def __init__(self, turbine: Turbine, tips: Sequence[Tip]) -> None:
        nacelle = turbine.part(NACELLE)
        seen = [replace(tip, carrier=nacelle, axes=np.eye(3)) for tip in tips]
        self._tips = Tips(turbine.system, seen)
        self._starts = self._tips.starts

    def at(self, snapshot: Snapshot) -> Array:
        """Distances at a snapshot [m], shape (tips,). Collective."""
        side, height, ahead = (self._starts + self._tips.at(snapshot)).T
        distances: Array = np.hypot(np.hypot(side, ahead), np.maximum(height, 0.0))
        return distances


def make_tips(turbine: Turbine) -> Tips:
    """Deflections of the tips of flexible blades in axes that pitch with them. Collective."""
    followed, layout = [], turbine.rotor.layout
    for k, (name, point) in enumerate(zip(ROOTS, turbine.rotor.tips, strict=True), start=1):
        coupling, axes = turbine.part(name), blade_axes(layout, k)
        followed.append(Tip(str(k), coupling.flexible, point, coupling.rigid, axes))
    return Tips(turbine.system, followed)


def make_twist_channel(turbine: Turbine) -> Channel | None:
    """Columns with the twist of each blade at ``output.twists``; None without any. Collective.

    Twist is positive towards feather, as that of the shape of a blade.
    """
    places = turbine.case.output.twists
    if not places:
        return None
    sections = [
        _make_section(turbine, k, place, names.TWIST(blade=k, place=f"{place:g}"))
        for k in range(1, len(BLADES) + 1)
        for place in places
    ]
    turns = SectionTurns(turbine.system, sections)
    return Channel(tuple(s.name for s in sections), lambda s: turns.at(s).tolist())


def make_tip_turns(turbine: Turbine) -> Callable[[Snapshot], Array]:
    """Function of the snapshot with the rotations of the outermost parts of all blades.

    Vectors of rotations in axes that pitch with the blade, shape (blades, 3) [rad]. Collective.
    """
    numbers, layout = range(1, len(BLADES) + 1), turbine.rotor.layout
    axes = np.array([blade_axes(layout, k) for k in numbers])

    @cache
    def make() -> SectionTurns:  # where somebody asks for it
        place = 1.0 - HALF_WIDTH
        sections = [_make_section(turbine, k, place, f"tip of blade {k}") for k in numbers]
        return SectionTurns(turbine.system, sections)

    def find(snapshot: Snapshot) -> Array:
        turns = Rotation.from_matrix(make().find_rotations(snapshot.state)).as_rotvec()
        found: Array = np.einsum("kij,kj->ki", axes, turns)
        return found

    return find


def _make_section(turbine: Turbine, blade: int, place: float, name: str) -> Section:
    """The section of a blade at a fraction of its length."""
    blades, coupling = turbine.rotor.blades, turbine.part(ROOTS[blade - 1])
    return Section(
        name,
        coupling.flexible,
        origin=turbine.rotor.layout.centre,
        axis=-turbine.rotor.layout.frame(blade)[0],
        distance=-(blades.hub_radius + place * blades.length),
        half_width=HALF_WIDTH * blades.length,
        carrier=coupling.rigid,
        copy=coupling.copy,
    )


BODY = "blades"
"""Name of the flexible body of all blades."""

Facets = npt.NDArray[np.int32]
"""Facets of a mesh, indices local to a rank."""


@dataclass(frozen=True)
class FlexibleBlades(Component):
    """The mesh of the blades as one flexible body, and a coupling of each root."""

    def parts(self, assembly: Assembly) -> list[Any]:
        """Body ``blades`` and couplings ``root_1`` ... to the rings or, without these, the hub."""
        body, roots = _choose_kind(assembly.case)(assembly)
        hub = assembly.part(HUB)
        carriers = [assembly.find(ring) or hub for ring in RINGS]
        return [body] + [
            Coupling(name, body, facets, carrier, copy=copy)
            for name, carrier, (facets, copy) in zip(ROOTS, carriers, roots, strict=True)
        ]

    def channels(self, turbine: Turbine) -> Channels:
        """Deflections and clearances of tips, root loads, strain gauges, failure of plies."""
        tips = make_tips(turbine)
        followed, numbers = tips.tips, [tip.name for tip in tips.tips]
        from_yaw = YawDistances(turbine, followed)
        bends = [f(tip=k) for k in numbers for f in (names.TIP_FLAP, names.TIP_EDGE)]
        gauges = make_gauges(turbine, turbine.part(BODY))
        twists, sections = make_twist_channel(turbine), blade_section_channels(turbine)
        plies = find_plies(turbine)
        failure = [failure_channel(plies.stresses, plies.panels, plies.place)] if plies else []
        clearances = tuple(names.TIP_CLEARANCE(tip=k) for k in numbers)
        motions = [f"TipD{axis}b{k}" for k in numbers for axis in "xyz"]
        fixed = [f"TipD{axis}c{k}" for k in numbers for axis in "xyz"]
        roots, angles = root_channels(turbine), find_angles(turbine)
        turns = make_tip_turns(turbine)
        return Channels(
            history=[
                tip_channel(tips),
                Channel(tuple(bends), lambda s: tips.at(s)[:, :2].ravel().tolist()),
                Channel(clearances, lambda s: from_yaw.at(s).tolist()),
                *roots.history,
                *([twists] if twists else []),
                *sections.history,
                *([gauge_channel(gauges)] if gauges else []),
                *failure,
            ],
            openfast=[
                in_openfast(motions, tips.at),
                in_openfast(fixed, lambda s: unpitch(tips.at(s), angles(s.state))),
                in_openfast([f"TipRD{axis}b{k}" for k in numbers for axis in "xyz"], turns),
                in_openfast([f"TipClrnc{k}" for k in numbers], from_yaw.at),
                *roots.openfast,
                *sections.openfast,
            ],
        )

    def fields(self, turbine: Turbine) -> list[CellValues]:
        """The failure index of plies, by Tsai and Wu."""
        plies = find_plies(turbine)
        if plies is None:
            return []
        return [failure_field(plies.stresses, leave_out=plies.made_up)]


Made = tuple[DeformableBody, list[tuple[Facets, int]]]
"""All blades, and the facets and copy of each root."""


def _choose_kind(case: Case) -> Callable[[Assembly], Made]:
    """The function that makes the blades of a case."""
    if case.has_beam_blades:
        return _make_beams
    return _make_reduced if case.has_reduced_blades else _make_full


def _make_full(assembly: Assembly) -> Made:
    """All blades on one mesh, and the facets and copy of each root. Collective."""
    rotor = assembly.rotor
    source, make = rotor.mesh_source()

    def examine(mesh: MeshArrays) -> tuple[str, ...]:
        mistakes = rotor.list_mistakes(mesh)
        if not mistakes:
            check_stations(assembly.case, mesh, rotor.layout, rotor.blades.degree)
        return mistakes

    mesh = assembly.load_mesh(BODY, source, make, examine)
    frames = {
        mesh.cell_names[name]: rotor.layout.frame(k) for k, name in enumerate(BLADES, start=1)
    }
    axes = frame_fields(mesh.mesh, mesh.cell_tags, frames)
    return rotor.blades.make_body(BODY, mesh, axes), [(mesh.facets(root), 0) for root in ROOTS]


def _make_reduced(assembly: Assembly) -> Made:
    """Copies of one reduced blade, and the facets and copy of each root. Collective."""
    rotor = assembly.rotor
    single = SingleMesh(rotor)
    mesh = assembly.load_mesh(BODY, single.source, single.make, single.examine)
    blade = ClampedBlade.of("blade", mesh, rotor)
    basis = find_basis(assembly.case, blade)
    body = ReducedBody(BODY, blade.body, basis, place_copies(rotor))
    return body, [(blade.root, copy) for copy in range(len(ROOTS))]


def _make_beams(assembly: Assembly) -> Made:
    """Copies of one beam, and the facets and copy of each root. Collective."""
    rotor = assembly.rotor
    single = SingleMesh(rotor)
    mesh = assembly.load_mesh(BODY, single.source, single.make, single.examine)
    assert isinstance(rotor.blades, BeamBlades)
    carrier, root = Carrier("blade", mesh.mesh, rotor.blades.degree), mesh.facets(ROOT)
    basis = rotor.blades.make_basis(carrier, root)
    body = ReducedBody(BODY, carrier, basis, place_copies(rotor))
    return body, [(root, copy) for copy in range(len(ROOTS))]


def find_plies(turbine: Turbine) -> BladePlies | None:
    """Plies of full blades; None for one material, and for other blades. Collective."""
    if not turbine.case.has_full_blades:
        return None
    return turbine.rotor.blades.make_plies(turbine.system, turbine.meshes[BODY])
