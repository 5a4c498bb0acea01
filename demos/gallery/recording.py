"""Runs of a benchmark's script, watched: what it computes is also written as fields."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from turbine_fenicsx import MultibodySystem, Simulation, equilibrium
from turbine_fenicsx.bodies.rigid_surface import RigidSurface, inertia_box
from turbine_fenicsx.simulation.observers.fields import Fields

_THIN = 0.025
"""Thickness of a bar by the largest distance between the joints of a model."""


@dataclass
class _Seen:
    """All that `Fields` looks at of a snapshot."""

    state: Any


@contextmanager
def recorded(script: Any, fields: Path, every: float) -> Iterator[None]:
    """Let a script write the fields of its time steps, or of its equilibria.

    Args:
        script: The module, which calls `Simulation` or `equilibrium` by that name.
        fields: The XDMF file; of several runs the last one stays.
        every: Time between two outputs of a run in time [s]; all equilibria are written.
    """

    class Watched(Simulation):
        def __init__(self, *arguments: Any, **more: Any):
            super().__init__(*arguments, **more)
            writer = Fields(self.system, fields, every, self.end, bars(self.system))
            self.observers = (*self.observers, writer)

    writers: dict[int, Fields] = {}

    def watched(system: MultibodySystem, times: Any, state: Any = None) -> Any:
        if id(system) not in writers:
            writers[id(system)] = Fields(system, fields, 1e-9, np.inf, bars(system))
            writers[id(system)].start(_Seen(system.initial_state()), resumed=False)
        for time in times:
            state = equilibrium(system, (time,), state)
            shown = state.copy()
            shown.time = float(time)
            writers[id(system)].observe(_Seen(shown))
        return state

    known = Simulation, equilibrium
    kept = {k: v for k, v in vars(script).items() if any(v is original for original in known)}
    assert kept, f"{script.__name__} calls neither Simulation nor equilibrium"
    try:
        for name, value in kept.items():
            setattr(script, name, Watched if value is Simulation else watched)
        yield
    finally:
        for name, value in kept.items():
            setattr(script, name, value)


def bars(system: MultibodySystem) -> list[RigidSurface]:
    """Rigid bodies as bars between their joints, as a cone on one joint, as a box without.

    What only holds the end of a flexible body is not drawn.
    """
    holders = {coupling.rigid for coupling in system.couplings}
    held: dict[Any, list[Any]] = {body: [] for body in system.rigid_bodies}
    for joint in system.joints:
        for body in joint.bodies:
            if body is not None:
                held[body].append(np.asarray(joint.point, dtype=float))
    all_points = [p for points in held.values() for p in points]
    size = max((float(np.linalg.norm(p - q)) for p, q in combinations(all_points, 2)), default=0.0)
    surfaces = []
    for k, (body, joints) in enumerate(held.items()):
        centre = np.asarray(body.position, dtype=float)
        points = corners_of(centre, joints)
        length = max(
            (float(np.linalg.norm(p - q)) for p, q in combinations(points, 2)), default=0.0
        )
        if body in holders and not joints:
            continue
        if length == 0.0:
            surfaces.append(inertia_box(body, k))
            continue
        if len(joints) == 1 and body not in holders:
            thick = float(np.median(body.euler)) / body.mass
            pieces = [cone(points[0], centre, float(np.sqrt(20.0 / 3.0 * thick)))]
        else:
            pieces = [bar(p, q, 0.5 * _THIN * size) for p, q in combinations(points, 2)]
        starts = np.cumsum([0, *(len(p) for p, _ in pieces)])
        faces = [q + start for (_, q), start in zip(pieces, starts, strict=False)]
        vertices = np.concatenate([p for p, _ in pieces])
        surfaces.append(RigidSurface(body, vertices, np.concatenate(faces), k))
    return surfaces


def corners_of(centre: Any, joints: list[Any]) -> list[Any]:
    """What bars connect: distinct joints, and the centre of mass where it is beside their line."""
    points: list[Any] = []
    for p in joints:
        if all(np.linalg.norm(p - q) > 1e-9 for q in points):
            points.append(p)
    if len(points) == 1:
        return [points[0], centre]
    if len(points) == 2:
        along = points[1] - points[0]
        away = (centre - points[0]) - along * ((centre - points[0]) @ along) / (along @ along)
        if np.linalg.norm(away) > 0.1 * np.linalg.norm(along):
            points.append(centre)
    return points


def cone(tip: Any, centre: Any, radius: float) -> tuple[Any, Any]:
    """A cone by its tip and its centre of mass: points, and faces with one side of no length."""
    height = float(np.linalg.norm(centre - tip)) / 0.75
    along = (centre - tip) / (0.75 * height)
    side, up = across(along)
    angles = np.linspace(0.0, 2.0 * np.pi, 49)[:-1]
    ring = np.outer(np.cos(angles), side) + np.outer(np.sin(angles), up)
    base = tip + height * along
    points = np.concatenate([[tip, base], base + min(radius, 0.5 * height) * ring])
    i, n = np.arange(48), np.roll(np.arange(48), -1)
    faces = [np.column_stack([apex, apex, 2 + i, 2 + n]) for apex in (np.zeros(48), np.ones(48))]
    return points, np.concatenate(faces).astype(np.int64)


def bar(start: Any, end: Any, half: float) -> tuple[Any, Any]:
    """A bar with a square section: its 8 points and 6 faces."""
    along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-30)
    side, up = across(along)
    section = [half * (s * side + t * up) for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    points = np.array([p + x for p in (start - half * along, end + half * along) for x in section])
    faces = [
        (0, 1, 2, 3),
        (4, 7, 6, 5),
        *((i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4) for i in range(4)),
    ]
    return points, np.array(faces, dtype=np.int64)


def across(along: Any) -> tuple[Any, Any]:
    """Two unit vectors at right angles to one."""
    side = np.cross(along, (0.0, 0.0, 1.0) if abs(along[2]) < 0.9 else (1.0, 0.0, 0.0))
    side /= np.linalg.norm(side)
    return side, np.cross(side, along)
