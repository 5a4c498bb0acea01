"""The flexible tower: a tube of hexahedra between the ground and the yaw bearing.

The frame of the tower is that of OpenFAST and does not move: x points downwind, z up, and y = z x x
to the left, looking downwind. Base loads are those that the tower exerts on the ground, about the
centre of its foot.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from turbine_fenicsx.bodies.carrier import Carrier
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.reduced_body import ReducedBasis, ReducedBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.lame import lame_constants
from turbine_fenicsx.materials.st_venant_kirchhoff import StVenantKirchhoff
from turbine_fenicsx.meshing import LoadedMesh, TowerGeometry, mesh_tower
from turbine_fenicsx.meshing.tower import BOTTOM, TOP
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import TOWER
from turbine_fenicsx.reduction.basis_file import read_basis
from turbine_fenicsx.reduction.reduce_body import reduce_body
from turbine_fenicsx.reduction.smooth_loads import smooth_loads
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.reactions import Reaction, Reactions
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.basis_store import name_file, take_basis
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.axes import TOWER_AXES
from turbine_fenicsx.turbine.components.beam_tower import make_tower_basis
from turbine_fenicsx.turbine.components.component import Assembly, Channels, Component, Turbine
from turbine_fenicsx.turbine.components.nacelle import SUPPORT
from turbine_fenicsx.turbine.components.openfast_channel import in_openfast
from turbine_fenicsx.turbine.components.slender_loads import tower_section_channels
from turbine_fenicsx.turbine.tables.tower import TowerCase

log = logging.getLogger(__name__)

FOOT, HEAD = "tower_foot", "tower_head"
"""Names of the couplings to the ground and to the rigid body that carries the yaw bearing."""

LARGEST_DEFLECTION = 0.03
"""Deflection of the head over the height for which a reduced tower is made."""


def tower_geometry(tower: TowerCase) -> TowerGeometry:
    """Shape of the tower of a case."""
    t = tower
    if t.stations is None:
        return TowerGeometry.cone(t.height, t.bottom_diameter, t.top_diameter, t.wall)
    return TowerGeometry(t.height, t.stations, t.diameters or (), t.walls or ())


@dataclass(frozen=True)
class Tower(Component):
    """The tube, the rigid body at its top, and a coupling at each end."""

    def parts(self, assembly: Assembly) -> list[Any]:
        """Cells are curved if the displacement is quadratic."""
        t = assembly.case.tower
        geometry = tower_geometry(t)
        mesh = assembly.load_mesh(
            TOWER, "mesh of the tower", lambda: mesh_tower(geometry, t.elements, t.degree)
        )
        if assembly.case.has_beam_tower:
            return _make_beam(t, geometry, mesh)
        material = StVenantKirchhoff(*lame_constants(t.young, t.poisson))
        body = FlexibleBody(TOWER, mesh.mesh, material, t.density, t.degree)
        top = RigidBody(SUPPORT, t.top_mass, t.top_euler)
        foot = Coupling(FOOT, body, mesh.facets(BOTTOM), None)
        head = Coupling(HEAD, body, mesh.facets(TOP), top)
        if not assembly.case.has_reduced_tower:
            return [top, body, foot, head]
        held = MultibodySystem(assembly.comm, [top, body, foot, head])
        reduced = ReducedBody(TOWER, body, _find_basis(assembly.case, held, body))
        ends = [replace(coupling, flexible=reduced) for coupling in (foot, head)]
        return [top, reduced, *ends]

    def channels(self, turbine: Turbine) -> Channels:
        """Displacement of the yaw bearing, force and moment at the base, in the tower's frame."""
        system, top = turbine.system, turbine.part(SUPPORT)
        first, start = system.first_coordinate[top], np.asarray(top.position, dtype=float)
        R = np.asarray(top.directors, dtype=float)
        base = find_tower_base(turbine)
        assert base is not None
        loads = [
            family(axis=axis)
            for family in (names.TOWER_BASE_FORCE, names.TOWER_BASE_MOMENT)
            for axis in "xyz"
        ]

        def move(s: Snapshot) -> Array:
            return np.asarray(TOWER_AXES @ (s.state.q[first : first + 3] - start))

        def turn(s: Snapshot) -> Array:
            directors = s.state.q[first + 3 : first + 12].reshape(3, 3)
            return np.asarray(TOWER_AXES @ Rotation.from_matrix(directors.T @ R.T).as_rotvec())

        motions = [names.TOWER_TOP_DISPLACEMENT(axis=axis) for axis in "xyz"]
        sections = tower_section_channels(turbine, turbine.part(HEAD))
        out = [f"TwrBs{kind}{axis}t" for kind in "FM" for axis in "xyz"]
        return Channels(
            history=[
                Channel(tuple(motions), lambda s: move(s).tolist()),
                Channel(tuple(loads), lambda s: base.mean_at(s).ravel().tolist(), base),
                *sections.history,
            ],
            openfast=[
                in_openfast(("TTDspFA", "TTDspSS", "TTDspAx"), move),
                in_openfast(("TTDspRoll", "TTDspPtch", "TTDspTwst"), turn),
                in_openfast(out, base.mean_at, base),
                *sections.openfast,
            ],
        )


def find_tower_base(turbine: Turbine) -> Reactions | None:
    """Loads of a flexible tower on the ground about the centre of its foot; None without one."""
    if not turbine.case.tower.flexible:
        return None
    centre = (0.0, -turbine.case.tower.height, 0.0)
    return Reactions(turbine.system, [Reaction(turbine.part(FOOT), centre, TOWER_AXES)])


def _make_beam(t: TowerCase, geometry: TowerGeometry, mesh: LoadedMesh) -> list[Any]:
    """The parts of a tower that is a beam. Collective."""
    carrier, top = Carrier(TOWER, mesh.mesh, t.degree), RigidBody(SUPPORT, t.top_mass, t.top_euler)
    foot, head = mesh.facets(BOTTOM), mesh.facets(TOP)
    body = ReducedBody(TOWER, carrier, make_tower_basis(t, geometry, carrier, foot, head))
    return [top, body, Coupling(FOOT, body, foot, None), Coupling(HEAD, body, head, top)]


def _find_basis(case: Case, held: MultibodySystem, body: FlexibleBody) -> ReducedBasis:
    """The basis of the tower of a case. Collective.

    Args:
        held: A system with the tower and what holds it.
    """
    r = case.tower.reduction
    if r.file is not None:
        return read_basis(r.file, body)

    def make() -> ReducedBasis:
        log.info("making the basis of the tower, from smooth loads along its height")
        loads = smooth_loads(held, body, LARGEST_DEFLECTION)
        return reduce_body(held, body, r.modes, r.functions, r.strains, loads)

    def name() -> Path | None:
        tower = case.tower.model_dump(mode="json", exclude={"damping", "model", "beam"})
        for key in ("file", "folder"):
            del tower["reduction"][key]
        return name_file(case, r.folder, TOWER, tower)

    return take_basis(on_rank0(held.comm, name), body, make)
