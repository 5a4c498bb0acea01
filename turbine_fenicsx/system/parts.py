"""Parts of a system: sorted by kind, and checked."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.bodies.surface_frame import SurfaceFrame
from turbine_fenicsx.forces.body_force import BodyForce
from turbine_fenicsx.forces.force import Force
from turbine_fenicsx.forces.node_force import NodeForce
from turbine_fenicsx.forces.prescribed_force import PrescribedForce, SurfaceForce
from turbine_fenicsx.forces.rayleigh_damping import RayleighDamping
from turbine_fenicsx.forces.section_loads import SectionLoads
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.joints.base import Joint
from turbine_fenicsx.joints.relation import Relation


@dataclass(frozen=True)
class Parts:
    """The parts of a system by kind, in the order in which they were given.

    Raises:
        TypeError: for a joint or coupling of the wrong kind of body.
        ModelError: for a duplicate name, or a partner that is not among the parts.
    """

    rigid_bodies: tuple[RigidBody, ...]
    flexible_bodies: tuple[DeformableBody, ...]
    couplings: tuple[Coupling, ...]
    joints: tuple[Joint, ...]
    relations: tuple[Relation, ...]
    motion_forces: tuple[Force, ...]
    prescribed_forces: tuple[PrescribedForce, ...]
    on_bodies: tuple[SurfaceForce | NodeForce | BodyForce | SectionLoads, ...]
    dampings: tuple[RayleighDamping, ...]

    def __post_init__(self) -> None:
        bodies: list[Any] = [*self.rigid_bodies, *self.flexible_bodies]
        _check_unique([*bodies, *self.joints, *self.couplings])
        _check_unique([*self.motion_forces, *self.on_bodies, *self.dampings, *self.relations])
        for joint in self.joints:
            for body in joint.bodies:
                _require(joint.name, body, RigidBody, "a rigid body or the ground")
            if joint.bodies[0] is joint.bodies[1]:
                where = getattr(joint.bodies[0], "name", "the ground")
                raise ModelError(f"both partners of {joint.name!r} are {where!r}")
        for coupling in self.couplings:
            _require(coupling.name, coupling.rigid, RigidBody, "a rigid body or the ground")
        attached: list[Any] = [*self.couplings, *self.on_bodies, *self.dampings]
        for part in attached:
            _require(part.name, part.flexible, DeformableBody, "a flexible body", or_none=False)
        damped = [damping.flexible.name for damping in self.dampings]
        twice = sorted({name for name in damped if damped.count(name) > 1})
        if twice:
            raise ModelError(f"a body has one Rayleigh damping, but {twice} have more")
        self._check_partners({id(b) for b in bodies} | {id(None)})

    def _check_partners(self, known: set[int]) -> None:
        """Raise a ModelError for partners that are not among the parts."""
        pairs: list[tuple[str, tuple[Any, ...]]] = [(j.name, j.bodies) for j in self.joints]
        pairs += [(c.name, (c.flexible, c.rigid)) for c in self.couplings]
        pairs += [(x.name, (x.flexible,)) for x in (*self.on_bodies, *self.dampings)]
        for name, partners in pairs:
            for partner in partners:
                if id(partner) not in known:
                    body = getattr(partner, "name", partner)
                    raise ModelError(
                        f"{name!r} refers to body {body!r}, which is not among the parts"
                    )


def sort_parts(parts: Iterable[Any]) -> Parts:
    """The parts of a system by kind."""
    of_nodes = NodeForce | BodyForce
    kinds = (RigidBody, DeformableBody, Coupling, of_nodes, SectionLoads, RayleighDamping)
    protocols = (Relation, Joint, Force, SurfaceForce, PrescribedForce)
    groups: dict[Any, list[Any]] = {kind: [] for kind in (*kinds, *protocols)}
    for part in parts:
        kind = next((k for k in groups if isinstance(part, k)), None)
        if kind is None:
            raise TypeError(f"{part!r} is no body, joint, relation, coupling or force")
        groups[kind].append(part)
    return Parts(
        rigid_bodies=tuple(groups[RigidBody]),
        flexible_bodies=tuple(groups[DeformableBody]),
        couplings=tuple(groups[Coupling] + _couplings_of_frames(groups[RigidBody])),
        joints=tuple(groups[Joint]),
        relations=tuple(groups[Relation]),
        motion_forces=tuple(groups[Force]),
        prescribed_forces=tuple(groups[PrescribedForce]),
        on_bodies=(*groups[SurfaceForce], *groups[of_nodes], *groups[SectionLoads]),
        dampings=tuple(groups[RayleighDamping]),
    )


def _couplings_of_frames(bodies: Iterable[RigidBody]) -> list[Coupling]:
    """Couplings that frames on surfaces bring along."""
    return [c for body in bodies if isinstance(body, SurfaceFrame) for c in body.couplings]


def number_names(names: Sequence[str]) -> tuple[str, ...]:
    """The names, numbered where they occur again."""
    found: list[str] = []
    for name in names:
        number, other = 1, name
        while other in found:
            number += 1
            other = f"{name} {number}"
        found.append(other)
    return tuple(found)


def _check_unique(parts: Iterable[Any]) -> None:
    """Raise a ModelError for names that occur more than once."""
    names = [part.name for part in parts]
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise ModelError(f"names must be unique, but {twice} occur more than once")


def _require(name: str, body: Any, kind: Any, words: str, or_none: bool = True) -> None:
    """Raise a TypeError unless a partner is of the right kind, or None where that is allowed."""
    if not isinstance(body, kind) and not (or_none and body is None):
        hint = "; a SurfaceFrame holds its surface" if isinstance(body, DeformableBody) else ""
        raise TypeError(f"{name!r} needs {words}, got {describe(body)}{hint}")
