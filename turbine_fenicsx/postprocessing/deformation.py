"""The deformation of the parts of ``fields.xdmf``, exaggerated.

Each flexible part is seen from what carries it: the ground, the hub, the ring of a pitch bearing.
Its displacement relative to that motion is multiplied, so that turning, yawing and pitching stay as
they are. Parts on a flexible part, as a nacelle on its tower, ride along with it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.rotations import nearest_rotation
from turbine_fenicsx.records.parts import Parts

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """A rotation about a point, and where this point goes.

    Args:
        rotation: Shape (3, 3).
        start: The point, shape (3,) [m].
        end: Where it goes, shape (3,) [m].
    """

    rotation: Points
    start: Points
    end: Points

    def __call__(self, points: Points) -> Points:
        """Moved points, shape (n, 3) [m]."""
        return (points - self.start) @ self.rotation.T + self.end


STILL = RigidMotion(np.eye(3), np.zeros(3), np.zeros(3))


def fit_motion(before: Points, after: Points) -> RigidMotion:
    """The rigid motion that fits best, by the singular values of the correlation.

    Points in a line, or fewer than three, say nothing about a rotation and are only shifted.

    Args:
        before: Points, shape (n, 3) [m].
        after: The same points later, shape (n, 3) [m].
    """
    start, end = before.mean(axis=0), after.mean(axis=0)
    if not span_a_plane(before):
        return RigidMotion(np.eye(3), start, end)
    return RigidMotion(nearest_rotation((after - end).T @ (before - start)), start, end)


def exaggerate(
    x: Points,
    u: Points,
    coupling: NDArray[np.int32],
    points_of: Callable[[int], NDArray[np.bool_]],
    parts: Parts,
    scale: float,
) -> Points:
    """Points with the deformation of the flexible parts multiplied.

    Args:
        x: Present positions, shape (n, 3) [m].
        u: Displacements, shape (n, 3) [m].
        coupling: Number of the coupling that holds a point, 0 for none, shape (n,).
        points_of: Which points a part has, by its number; shape (n,) of bool.
        scale: Factor of the deformation; 1 shows it as it is, 0 none.

    Returns:
        Positions, shape (n, 3) [m].
    """
    X, moved = x - u, x.copy()
    rides: dict[int, RigidMotion] = {0: STILL}  # with the number of what one stands on
    flexible = [p.number for p in parts.parts if p.stands_on is None]
    mine = {number: points_of(number) for number in flexible}
    held = {number: set(coupling[mine[number]].tolist()) - {0} for number in flexible}
    while flexible:
        number = next(n for n in flexible if _find_ground(held[n], parts.roots) in rides)
        flexible.remove(number)
        ride = rides[_find_ground(held[number], parts.roots)]
        roots = mine[number] & np.isin(coupling, list(parts.roots))
        fixed = roots if span_a_plane(X[roots]) else mine[number]
        rigid = fit_motion(X[fixed], x[fixed])(X[mine[number]])
        moved[mine[number]] = ride(rigid + scale * (x[mine[number]] - rigid))
        for head in held[number] - set(parts.roots):
            there = mine[number] & (coupling == head)
            rides[head] = fit_motion(x[there], moved[there])
    for part in parts.parts:
        if part.stands_on:
            there = points_of(part.number)
            moved[there] = rides[part.stands_on](x[there])
    return moved


def _find_ground(held: set[int], roots: Mapping[int, int]) -> int:
    """Supports of the parent bodies of a part."""
    return min((roots[number] for number in held if number in roots), default=0)


def span_a_plane(points: Points) -> bool:
    """Whether there are three points or more that are not in a line."""
    if len(points) < 3:
        return False
    sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(sizes[1] > 1e-6 * sizes[0])
