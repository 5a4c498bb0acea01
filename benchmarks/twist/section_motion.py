"""Motion of sections of shells and solids, and loads on them.

A model has nodes, and rows of nodes of its skin with the lengths that they stand for. Stations are
the span fractions of the rows, and axis has the points of the axis there.

A section moves as the rigid body that fits its nodes best, weighted by the lengths they stand for.
Forces on nodes are spread in the same way, so that they work on that motion.
"""

import numpy as np

STIFF = 0.97
"""Span fraction beyond which the tip is rigid; loads at the tip act on it."""


def rigid_motion(x, weights, origin, u):
    """Displacement of a point and rotation that fit displacements of nodes best, (6,).

    Args:
        x: Nodes, shape (n, 3) [m].
        weights: Of the nodes, shape (n,).
        origin: The point [m].
        u: Displacements, shape (n, 3) [m].
    """
    A = _rigid(x - origin)
    W = np.repeat(weights, 3)[:, None]
    return np.linalg.solve(A.T @ (W * A), A.T @ (W[:, 0] * u.ravel()))


def measure(model, u, stations):
    """Displacement of the axis and rotation of sections at span fractions, (len(stations), 6)."""
    at = [
        rigid_motion(model.nodes[k], w, origin, u[k])
        for (k, w), origin in zip(model.rows, model.axis, strict=True)
    ]
    return np.array([np.interp(stations, model.stations, column) for column in np.transpose(at)]).T


def spread(x, weights, origin, load):
    """Forces on nodes, (n, 3), with a given force and moment about a point."""
    A = _rigid(x - origin)
    W = np.repeat(weights, 3)[:, None]
    return (W * A @ np.linalg.solve(A.T @ (W * A), load)).reshape(-1, 3)


def _rigid(r):
    """Displacements of nodes, (3 n, 6), by unit translations and rotations."""
    A = np.zeros((len(r), 3, 6))
    A[:, :, :3] = np.eye(3)
    x, y, z = r.T
    A[:, 0, 4], A[:, 0, 5] = z, -y
    A[:, 1, 3], A[:, 1, 5] = -z, x
    A[:, 2, 3], A[:, 2, 4] = y, -x
    return A.reshape(-1, 6)


def at_tip(model, load):
    """Forces on the nodes of the skin of the stiff tip, about the end of the axis, (n, 3) [N]."""
    found = np.zeros_like(model.nodes)
    rows = [row for row, s in zip(model.rows, model.stations, strict=True) if s > STIFF]
    numbers, weights = (np.concatenate([row[k] for row in rows]) for k in (0, 1))
    found[numbers] = spread(model.nodes[numbers], weights, model.axis[-1], load)
    return found


def along_axis(model, load):
    """Forces on the nodes of the skin by a load on each metre of the axis."""
    found = np.zeros_like(model.nodes)
    length = tributary(model.axis)
    for (numbers, weights), origin, ds in zip(model.rows, model.axis, length, strict=True):
        found[numbers] += spread(model.nodes[numbers], weights, origin, ds * np.asarray(load))
    return found


def tributary(axis):
    """Length of an axis for which each of its points stands [m]."""
    step = np.append(0.0, np.linalg.norm(np.diff(axis, axis=0), axis=1))
    return 0.5 * (step + np.append(step[1:], 0.0))
