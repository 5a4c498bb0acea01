"""Which body carries which, from the ground through joints and couplings."""

from __future__ import annotations

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.system.system import MultibodySystem


def find_carriers(system: MultibodySystem) -> tuple[dict[RigidBody, int], dict[int, int]]:
    """Supports of rigid bodies, and couplings that carry flexible bodies.

    The ground stands on nothing, nor does the first body of what hangs together without touching
    the ground. From there joints are followed before couplings, so that a flexible body in a loop
    is carried by rigid ones.

    Args:
        system: The system. Its couplings count from 1.

    Returns:
        For each rigid body the number of the coupling by which a flexible body carries it, 0 for
        none. For each coupling that carries a flexible body the number that its rigid body, or the
        ground, stands on.
    """
    stands_on: dict[RigidBody | None, int] = {None: 0}
    roots: dict[int, int] = {}
    carried: set[DeformableBody] = set()
    bodies = iter(system.rigid_bodies)
    while True:
        _follow_joints(system, stands_on)
        couplings = list(enumerate(system.couplings, start=1))
        new = [(k, c) for k, c in couplings if c.rigid in stands_on and c.flexible not in carried]
        roots |= {k: stands_on[c.rigid] for k, c in new}
        carried |= {c.flexible for _, c in new}
        heads = [(k, c) for k, c in couplings if c.flexible in carried and c.rigid not in stands_on]
        stands_on |= {c.rigid: k for k, c in reversed(heads)}
        if not heads and not new:
            free = next((b for b in bodies if b not in stands_on), None)
            if free is None:
                return {b: stands_on[b] for b in system.rigid_bodies}, roots
            stands_on[free] = 0


def _follow_joints(system: MultibodySystem, stands_on: dict[RigidBody | None, int]) -> None:
    """Add all rigid bodies that joints connect with those that are known."""
    waiting = list(system.joints)
    while True:
        found = [j for j in waiting if (j.bodies[0] in stands_on) != (j.bodies[1] in stands_on)]
        if not found:
            return
        for joint in found:
            a, b = joint.bodies
            known = a if a in stands_on else b
            stands_on.setdefault(b if known is a else a, stands_on[known])
