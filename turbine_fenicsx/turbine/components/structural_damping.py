"""Structural damping of blades and tower, Rayleigh's with the ratios of named modes."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.analysis.cross_sections import CrossSections
from turbine_fenicsx.analysis.held_modes import HeldMode, Rider, held_modes
from turbine_fenicsx.analysis.linear_system import quadratic_form
from turbine_fenicsx.analysis.modal_sums import Piece
from turbine_fenicsx.analysis.turning import turning_equilibrium
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.owned_nodes import nodes_of_cells, nodes_of_facets
from turbine_fenicsx.bodies.placement import Placement
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.rayleigh_damping import HeldPart, RayleighDamping
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.rotations import E2, skew
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.joints.revolute import Revolute
from turbine_fenicsx.meshing.tower import BOTTOM, TOP
from turbine_fenicsx.records.conventions import BLADES, TOWER
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.make_model import make_model
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS
from turbine_fenicsx.turbine.components.component import Assembly, Component
from turbine_fenicsx.turbine.components.flexible_blades import BODY, blade_axes
from turbine_fenicsx.turbine.components.mode_names import (
    BLADE_WAYS,
    name_tower,
    sum_squares,
)
from turbine_fenicsx.turbine.components.tower import AXES
from turbine_fenicsx.turbine.tables.damping import DampingCase

log = logging.getLogger(__name__)

COUNT = 10
"""Number of modes among which the named ones are looked for."""


@dataclass(frozen=True)
class StructuralDamping(Component):
    """Rayleigh damping of the flexible blades and of the tower, as far as the case asks for it."""

    def parts(self, assembly: Assembly) -> list[RayleighDamping]:
        """Parts ``damping_of_blades`` and ``damping_of_tower``."""
        case, found = assembly.case, []
        blades, tower = assembly.find(BODY), assembly.find(TOWER)
        if blades is not None and case.blade.damping.acts:
            found.append(_damp_blades(assembly, blades, case.blade.damping))
        if tower is not None and case.tower.damping.acts:
            found.append(_damp_tower(assembly, tower, case.tower.damping))
        return found


def _damp_blades(
    assembly: Assembly, blades: DeformableBody, wanted: DampingCase
) -> RayleighDamping:
    """The damping of all blades, found from the first one: they are equal."""
    mesh = assembly.meshes[BODY]
    held = [
        HeldPart(mesh.facets(root), mesh.cells(blade))
        for root, blade in zip(ROOTS, BLADES, strict=True)
        if blade in mesh.cell_names
    ]
    damping = RayleighDamping(
        f"damping_of_{BODY}", blades.full, stiffness=wanted.stiffness_time or 0.0, held=held
    )
    if wanted.ratios:
        damping = _meet_ratios(assembly, damping, blades.placements[0], wanted)
    return replace(damping, flexible=blades)


def _meet_ratios(
    assembly: Assembly, damping: RayleighDamping, place: Placement, wanted: DampingCase
) -> RayleighDamping:
    """The damping of blades with coefficients that meet the ratios of the first blade.

    Args:
        damping: The damping of the blades on their mesh.
        place: Where the mesh of the first one stands.
    """
    mesh = assembly.meshes[BODY]
    R, t = place.frame()
    system, model = _make_system(assembly, damping, damping.held[:1])
    nodes = nodes_of_cells(model.space, mesh.cells(BLADES[0]))
    root = nodes_of_facets(model.space, mesh.facets(ROOTS[0]))
    layout, speed = assembly.rotor.layout, assembly.case.blade.damping.speed
    axis, centre = layout.axes[2] @ R, (np.asarray(layout.centre) - t) @ R
    turning: dict[str, Any] = {}
    if speed:
        u = _find_stretch(assembly.comm, damping, axis, centre, speed)
        turning = {"displacement": u, "spin": speed * skew(axis)}
    modes = held_modes(model, nodes, root, COUNT, **turning)
    if speed:
        modes = _damp_stretched(assembly, damping, modes, turning["displacement"])
    axes = blade_axes(layout, 1) @ R
    sections = _cut(system, nodes, axes)
    named = _name(modes, [BLADE_WAYS[_find_way(sections, nodes, mode)] for mode in modes])
    return _meet(damping, model, wanted, named, "blade")


def _find_stretch(
    comm: MPI.Intracomm, damping: RayleighDamping, axis: Array, centre: Array, speed: float
) -> Array:
    """Displacements of blades that turn, shape (n_owned, 3) [m]. Collective.

    Args:
        damping: Their damping, with the roots that hold them.
        speed: Of the rotation [rad/s].
    """
    body, point = damping.flexible, tuple(centre.tolist())
    hub = RigidBody("hub", 1.0, (1.0, 1.0, 1.0), position=point)
    shaft = Revolute("shaft", None, hub, point=point, axis=tuple(axis.tolist()))
    roots = [
        Coupling(f"root_{number}", body, np.asarray(held.facets), hub)
        for number, held in enumerate(damping.held)
    ]
    state = turning_equilibrium(MultibodySystem(comm, [hub, shaft, body, *roots]), "shaft", speed)
    u: Array = state.u[0].array_r.reshape(-1, 3).copy()
    state.destroy()
    return u


def _damp_stretched(
    assembly: Assembly, damping: RayleighDamping, modes: Sequence[HeldMode], u: Array
) -> list[HeldMode]:
    """Modes with the strain rates of blades that are stretched by displacements u. Collective."""
    unit = replace(damping, stiffness=1.0, mass=0.0, held=())
    system = MultibodySystem(assembly.comm, [damping.flexible, unit])
    model = system.flexible_models[0]
    stretched, shape = model.new_vector(), model.new_vector()
    stretched.array[:] = u.ravel()
    D = model.damping_matrix(stretched, 0.0)
    assert D is not None
    found = []
    for mode in modes:
        shape.array[:] = mode.shape.ravel()
        found.append(replace(mode, strain=quadratic_form(D, shape)))
    for thing in (stretched, shape, D):
        thing.destroy()
    return found


def _damp_tower(assembly: Assembly, tower: DeformableBody, wanted: DampingCase) -> RayleighDamping:
    """The damping of the tower with nacelle and rotor as one rigid body on top."""
    mesh = assembly.meshes[TOWER]
    damping = RayleighDamping(
        f"damping_of_{TOWER}",
        tower.full,
        stiffness=wanted.stiffness_time or 0.0,
        held=[HeldPart(mesh.facets(BOTTOM))],
    )
    if not wanted.ratios:
        return replace(damping, flexible=tower)
    system, model = _make_system(assembly, damping, damping.held)
    nodes = np.arange(model.n_owned)
    foot, top = (nodes_of_facets(model.space, mesh.facets(name)) for name in (BOTTOM, TOP))
    gravity = -assembly.case.loads.gravity * np.asarray(E2)
    rider = Rider.of(top, np.zeros(3), _sum_inertia(assembly), gravity)
    weight = model.new_vector()
    weight.array[:] = (model.nodal_mass[:, None] * gravity).ravel()
    modes = held_modes(model, nodes, foot, COUNT, load=weight, rider=rider)
    sections = _cut(system, nodes, AXES)
    ways = []
    for mode in modes:
        shape = sections.motion(mode.shape)
        ways.append(name_tower(shape, shape / sections.roots, sections.stations)[0].way)
    found = _meet(damping, model, wanted, _name(modes, ways), "tower")
    return replace(found, flexible=tower)


def _make_system(
    assembly: Assembly, damping: RayleighDamping, held: Sequence[HeldPart]
) -> tuple[MultibodySystem, FlexibleModel]:
    """The body alone, with a mass coefficient of one for what `held` holds; its model."""
    unit = replace(damping, stiffness=0.0, mass=1.0, held=held)
    system = MultibodySystem(assembly.comm, [damping.flexible, unit])
    return system, system.flexible_models[0].full


def _cut(system: MultibodySystem, nodes: IntArray, axes: Array) -> CrossSections:
    """Cross-sections of a part of the only body of a system."""
    piece = Piece(system.flexible_bodies[0].name, 0, nodes)
    state = system.initial_state()
    found = CrossSections(system, state, piece, axes, axes[2])
    state.destroy()
    return found


def _find_way(sections: CrossSections, nodes: IntArray, mode: HeldMode) -> int:
    """Number of the way in which most of a blade moves."""
    return int(sum_squares([sections.motion(mode.shape[nodes])]).argmax())


def _name(modes: Sequence[HeldMode], ways: Sequence[str]) -> dict[str, HeldMode]:
    """Modes by their keys, ``flap_1``: numbered by frequency among those of one way."""
    found: dict[str, HeldMode] = {}
    for mode, way in zip(modes, ways, strict=True):
        key = way.replace("-", "_").replace(" ", "_")
        number = 1 + sum(name.rpartition("_")[0] == key for name in found)
        found[f"{key}_{number}"] = mode
    return found


def _meet(
    damping: RayleighDamping,
    model: FlexibleModel,
    wanted: DampingCase,
    named: Mapping[str, HeldMode],
    table: str,
) -> RayleighDamping:
    """The damping with coefficients that meet the ratios.

    A mode u of modal mass 1 has the ratio (beta u^T K(0) u + alpha u^T Q^T W Q u)/(2 w). The model
    has the masses W relative to the root, as of `MassDamper` with alpha = 1.
    """
    keys, rows, damper = list(wanted.ratios), [], model.mass_damper
    assert damper is not None
    for key in keys:
        if key not in named:
            raise ModelError(
                f"{table}.damping.{key}: expected one of the modes that were found: "
                f"{', '.join(named)}"
            )
        mode = named[key]
        u = np.zeros(mode.shape.size)
        power = np.array([damper.power(u, mode.shape.ravel())])
        of_mass = float(sum_over_ranks(model.body.mesh.comm, power)[0])
        rows.append(np.array([mode.strain, of_mass]) / (2.0 * mode.frequency))
    asked = np.array(list(wanted.ratios.values()))
    if len(keys) == 1:
        beta, alpha = float(asked[0] / rows[0][0]), 0.0
    else:
        beta, alpha = map(float, np.linalg.solve(rows, asked))
    if min(beta, alpha) < 0.0:
        # with the first ratio, stiffness or mass alone give the second one these
        ends = sorted(asked[0] * rows[1] / rows[0])
        raise ModelError(
            f"{table}.damping.{keys[1]} = {asked[1]:.4g}: expected {ends[0]:.4g} to {ends[1]:.4g} "
            f"beside {keys[0]} = {asked[0]:.4g}, as stiffness and mass can give"
        )
    log.info(
        "damping of the %s: %s, stiffness %.4g s, mass %.4g 1/s",
        table,
        ", ".join(
            f"{key} at {named[key].frequency / (2.0 * np.pi):.4g} Hz by {100.0 * ratio:.3g} %"
            for key, ratio in wanted.ratios.items()
        ),
        beta,
        alpha,
    )
    return replace(damping, stiffness=beta, mass=alpha)


def _sum_inertia(assembly: Assembly) -> Array:
    """Mass, first and second moments about the origin of all that stands on the tower, (4, 4)."""
    total = np.zeros((4, 4))
    for body in (x for x in assembly.parts if isinstance(x, RigidBody)):
        R = np.asarray(body.directors, dtype=float)
        r = np.append(1.0, np.asarray(body.position, dtype=float))
        total += body.mass * np.outer(r, r)
        total[1:, 1:] += R @ np.diag(body.euler) @ R.T
    others = [x for x in assembly.parts if getattr(x, "name", None) != TOWER]
    for part in (x for x in others if isinstance(x, DeformableBody)):
        total += make_model(part, (), None, ()).inertia()
    return total
