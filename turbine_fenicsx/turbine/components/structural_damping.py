"""Structural damping of blades and tower, Rayleigh's with the ratios of named modes.

A mode u of modal mass 1 and angular frequency w of a part that is held at one end has the ratio

    (beta u.D_1 u + alpha u.D_2 u)/(2 w),

with the damping matrices D_1 of beta = 1 and D_2 of alpha = 1 in the equilibrium of the part. A
blade that turns has the stiffness K(u) + M S^2 about its equilibrium, S = omega x; what gyroscopic
forces change is left out.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.analysis.bordered_solver import blocks_of
from turbine_fenicsx.analysis.cross_sections import CrossSections
from turbine_fenicsx.analysis.linear_system import LinearSystem, quadratic_form
from turbine_fenicsx.analysis.modal_sums import Piece
from turbine_fenicsx.analysis.modes import find_rest, modes_of
from turbine_fenicsx.analysis.piece_nodes import PieceNodes
from turbine_fenicsx.analysis.slepc import import_slepc
from turbine_fenicsx.analysis.turning import turning_equilibrium
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.placement import Placement
from turbine_fenicsx.bodies.reduced_body import ReducedBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.gravity import Gravity
from turbine_fenicsx.forces.rayleigh_damping import HeldPart, RayleighDamping
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.rotations import E2, skew
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.revolute import Revolute
from turbine_fenicsx.meshing import load_arrays
from turbine_fenicsx.meshing.tower import BOTTOM, TOP
from turbine_fenicsx.records.conventions import BLADES, TOWER
from turbine_fenicsx.system.make_model import make_model
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS
from turbine_fenicsx.turbine.blades.clamped_blade import ClampedBlade, SingleMesh, clamp
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.axes import TOWER_AXES, blade_axes
from turbine_fenicsx.turbine.components.component import Assembly, Component
from turbine_fenicsx.turbine.components.flexible_blades import BODY
from turbine_fenicsx.turbine.components.mode_names import (
    BLADE_WAYS,
    name_tower,
    sum_squares,
)
from turbine_fenicsx.turbine.tables.damping import BladeDampingCase, DampingCase, TowerDampingCase

log = logging.getLogger(__name__)

COUNT = 10
"""Number of modes among which the named ones are looked for."""


@dataclass(frozen=True)
class StructuralDamping(Component):
    """Rayleigh damping of the flexible blades and of the tower, as far as the case asks for it."""

    def mistakes(self, case: Case) -> Iterator[str]:
        """A sentence if modes are asked for where nothing can find them."""
        tables = {
            "blade": (case.turbine.model != "rigid", case.blade.damping),
            "tower": (case.tower.flexible, case.tower.damping),
        }
        asked = [
            f"{k}.damping" for k, (bends, damping) in tables.items() if bends and damping.ratios
        ]
        try:
            if asked:
                import_slepc()
        except InputError as error:
            yield f"{' and '.join(asked)}: {error}; without it give stiffness_time, or 0"

    def parts(self, assembly: Assembly) -> list[RayleighDamping]:
        """Parts ``damping_of_blades`` and ``damping_of_tower``."""
        case, found = assembly.case, []
        blades, tower = assembly.find(BODY), assembly.find(TOWER)
        if blades is not None and case.blade.damping.acts:
            found.append(_damp_blades(assembly, blades, case.blade.damping))
        if tower is not None and case.tower.damping.acts:
            found.append(_damp_tower(assembly, tower, case.tower.damping))
        return found


@dataclass(frozen=True, eq=False)
class _HeldMode:
    """A mode of modal mass 1 of a part that is held at one end.

    Args:
        frequency: w [rad/s].
        shape: Displacement of the owned nodes of its mesh, shape (n, 3).
        rates: u.D_1 u [1/s^2] and u.D_2 u [1], shape (2,).
    """

    frequency: float
    shape: Array
    rates: Array


def _damp_blades(
    assembly: Assembly, blades: DeformableBody, wanted: BladeDampingCase
) -> RayleighDamping:
    """The damping of all blades, found from the first one: they are equal."""
    mesh = assembly.meshes[BODY]
    held = [
        HeldPart(mesh.facets(root), mesh.cells(blade))
        for root, blade in zip(ROOTS, BLADES, strict=True)
        if blade in mesh.cell_names
    ]
    beta, alpha = wanted.stiffness_time or 0.0, 0.0
    if wanted.ratios:
        beta, alpha = _meet("blade", wanted, _name_blade_modes(assembly, wanted.speed))
    return RayleighDamping(f"damping_of_{BODY}", blades, stiffness=beta, mass=alpha, held=held)


def _name_blade_modes(assembly: Assembly, speed: float) -> dict[str, _HeldMode]:
    """Modes of a blade that is clamped at its root and turns at a speed [rad/s]. Collective."""
    blade, layout = _take_one_blade(assembly), assembly.rotor.layout
    R = layout.frame(1).T
    spin = speed * skew(layout.axes[2] @ R)
    state = blade.system.initial_state()
    if speed:
        state.u[0].destroy()
        state.u = (_find_stretch(blade, layout.axes[2] @ R, speed),)
    found = _find_modes(blade.system, state, blade.root, spin @ spin)
    sections = _cut(blade.system, blade_axes(layout, 1) @ R)
    ways = [BLADE_WAYS[int(sum_squares([sections.motion(m.shape)]).argmax())] for m in found]
    state.destroy()
    return _name(found, ways)


def _take_one_blade(assembly: Assembly) -> ClampedBlade[Any]:
    """The first blade in its own axes, clamped at its root. Collective."""
    mesh = assembly.meshes[BODY]
    if assembly.case.has_reduced_blades:
        blades = assembly.find(BODY)
        assert isinstance(blades, ReducedBody)
        return clamp(replace(blades, name="blade", placements=(Placement(),)), mesh)
    if BLADES[1] in mesh.cell_names:
        single = SingleMesh(assembly.rotor)
        mesh = load_arrays(assembly.comm, single.make, single.source)
    return ClampedBlade.of("blade", mesh, assembly.rotor)


def _find_stretch(blade: ClampedBlade[Any], axis: Array, speed: float) -> PETSc.Vec:
    """Displacements of a blade that turns about an axis through its origin. Collective."""
    hub = RigidBody("hub", 1.0, (1.0, 1.0, 1.0))
    shaft = Revolute("shaft", None, hub, point=(0.0, 0.0, 0.0), axis=tuple(axis.tolist()))
    parts = [hub, shaft, blade.body, Coupling("root", blade.body, blade.root, hub)]
    state = turning_equilibrium(MultibodySystem(blade.system.comm, parts), "shaft", speed)
    stretched: PETSc.Vec = state.u[0].copy()
    state.destroy()
    return stretched


def _damp_tower(
    assembly: Assembly, tower: DeformableBody, wanted: TowerDampingCase
) -> RayleighDamping:
    """The damping of the tower."""
    held = [HeldPart(assembly.meshes[TOWER].facets(BOTTOM))]
    beta, alpha = wanted.stiffness_time or 0.0, 0.0
    if wanted.ratios:
        beta, alpha = _meet("tower", wanted, _name_tower_modes(assembly, tower))
    return RayleighDamping(f"damping_of_{TOWER}", tower, stiffness=beta, mass=alpha, held=held)


def _name_tower_modes(assembly: Assembly, tower: DeformableBody) -> dict[str, _HeldMode]:
    """Modes of the tower with nacelle and rotor as one rigid body on top. Collective."""
    mesh, rider = assembly.meshes[TOWER], _join_riders(assembly)
    foot, head = mesh.facets(BOTTOM), mesh.facets(TOP)
    ends = Coupling("foot", tower, foot, None), Coupling("head", tower, head, rider)
    weight = Gravity(tuple((-assembly.case.loads.gravity * np.asarray(E2)).tolist()))
    system = MultibodySystem(assembly.comm, [rider, tower, *ends, weight])
    state = find_rest(system)
    found, sections, ways = _find_modes(system, state, foot), _cut(system, TOWER_AXES), []
    state.destroy()
    for mode in found:
        shape = sections.motion(mode.shape)
        ways.append(name_tower(shape, shape / sections.roots, sections.stations)[0].way)
    return _name(found, ways)


def _join_riders(assembly: Assembly) -> RigidBody:
    """All that stands on the tower as one rigid body. Collective."""
    total = np.zeros((4, 4))  # mass, first and second moments about the origin
    for body in (x for x in assembly.parts if isinstance(x, RigidBody)):
        R = np.asarray(body.directors, dtype=float)
        r = np.append(1.0, np.asarray(body.position, dtype=float))
        total += body.mass * np.outer(r, r)
        total[1:, 1:] += R @ np.diag(body.euler) @ R.T
    others = [x for x in assembly.parts if getattr(x, "name", None) != TOWER]
    for part in (x for x in others if isinstance(x, DeformableBody)):
        total += make_model(part, (), None, ()).inertia()
    mass, middle = float(total[0, 0]), total[0, 1:] / total[0, 0]
    E = total[1:, 1:] - mass * np.outer(middle, middle)
    inertia = np.trace(E) * np.eye(3) - E
    return RigidBody.from_inertia("rider", mass, inertia, position=middle)


def _find_modes(
    system: MultibodySystem, state: State, held: npt.ArrayLike, softening: Array | None = None
) -> list[_HeldMode]:
    """Modes of the only flexible body of a system, the lowest first. Collective.

    Args:
        state: An equilibrium.
        held: Facets of the surface that holds the body.
        softening: A matrix S^2, with which M S^2 adds to the stiffness, shape (3, 3) [1/s^2].
    """
    (body,), linear = system.flexible_bodies, LinearSystem(system, state)
    if softening is not None:
        system.flexible_models[0].add_mass(softening, blocks_of(linear.stiffness)[0])
    shapes = modes_of(linear, min(COUNT, linear.degrees_of_freedom))
    linear.destroy()
    units = (
        RayleighDamping("unit", body, stiffness=1.0),
        RayleighDamping("unit", body, stiffness=0.0, mass=1.0, held=[HeldPart(held)]),
    )
    matrices = []
    for unit in units:
        (model,) = MultibodySystem(system.comm, [body, unit]).flexible_models
        D = model.damping_matrix(state.u[0], state.time)
        assert D is not None
        matrices.append(D)
    found, nodes = [], PieceNodes(system, _whole(system))
    for mode in shapes:
        u = mode.real.u[0]
        rates = np.array([quadratic_form(D, u) for D in matrices])
        shape = nodes.displacements(u)
        found.append(_HeldMode(mode.eigenvalue.imag, shape, rates))
        mode.destroy()
    for D in matrices:
        D.destroy()
    return found


def _cut(system: MultibodySystem, axes: Array) -> CrossSections:
    """Cross-sections of the only flexible body of a system."""
    state = system.initial_state()
    found = CrossSections(system, state, _whole(system), axes, axes[2])
    state.destroy()
    return found


def _whole(system: MultibodySystem) -> Piece:
    """All nodes of the only flexible body of a system."""
    (model,) = system.flexible_models
    return Piece(model.body.name, 0, np.arange(model.n_owned))


def _name(modes: Iterable[_HeldMode], ways: Iterable[str]) -> dict[str, _HeldMode]:
    """Modes by their keys, ``flap_1``: numbered by frequency among those of one way."""
    found: dict[str, _HeldMode] = {}
    for mode, way in zip(modes, ways, strict=True):
        key = way.replace("-", "_").replace(" ", "_")
        number = 1 + sum(name.rpartition("_")[0] == key for name in found)
        found[f"{key}_{number}"] = mode
    return found


def _meet(table: str, wanted: DampingCase, named: Mapping[str, _HeldMode]) -> tuple[float, float]:
    """The coefficients beta and alpha that meet the ratios."""
    keys = list(wanted.ratios)
    for key in keys:
        if key not in named:
            raise ModelError(
                f"{table}.damping.{key}: expected one of the modes that were found: "
                f"{', '.join(named)}"
            )
    rows = [named[key].rates / (2.0 * named[key].frequency) for key in keys]
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
    return beta, alpha
