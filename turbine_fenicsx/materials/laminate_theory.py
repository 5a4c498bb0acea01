"""Classical lamination theory: from the plies of a wall to its stiffness and mass.

Axes of a wall are 1 along the span, 2 around the section and 3 outwards, normal to it. In-plane
stresses and strains are in the order 11, 22, 12, with engineering shear strain. The coordinate z
runs outwards from the middle of the wall; a laminate is listed from its outer to its inner face.
R. M. Jones, Mechanics of Composite Materials, 2nd edition 1999, chapter 4.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigvalsh

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.ply import Ply, PlyMaterial
from turbine_fenicsx.materials.wall_quadrature import FACE_WEIGHT, MIDDLE_WEIGHT

Plies = Sequence[Ply]


@functools.lru_cache(maxsize=1024)
def reduced_stiffness(material: PlyMaterial, angle: float = 0.0) -> Array:
    """Plane-stress stiffness Q of a ply in the axes of the wall.

    Args:
        angle: From axis 1 of the wall to the fibre, positive from 1 to 2 [rad].

    Returns:
        Shape (3, 3) [Pa], not to be changed.
    """
    (E1, E2, _), G12, nu12 = material.young, material.shear[0], material.poisson[0]
    compliance = [[1.0 / E1, -nu12 / E1, 0.0], [-nu12 / E1, 1.0 / E2, 0.0], [0.0, 0.0, 1.0 / G12]]
    T = strain_in_ply(angle)
    Q: Array = T.T @ np.linalg.inv(compliance) @ T
    Q.flags.writeable = False
    return Q


def strain_in_ply(angle: float) -> Array:
    """The matrix T that turns in-plane strains of the wall into those of a ply, shape (3, 3).

    Its transpose turns stresses of the ply into those of the wall.
    """
    c, s = np.cos(angle), np.sin(angle)
    return np.array(
        [[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]]
    )


def interfaces(plies: Plies) -> Array:
    """Coordinates z of the faces of all plies, from the outer to the inner one, shape (n + 1,)."""
    depth = np.cumsum([0.0, *(ply.thickness for ply in plies)])
    return np.asarray(0.5 * depth[-1] - depth)


def laminate_stiffness(plies: Plies) -> tuple[Array, Array, Array]:
    """A, B and D: forces and moments per length are A e + B k and B e + D k.

    e are the strains in the middle of the wall and k their derivatives by z.

    Returns:
        Shapes (3, 3) each [N/m, N, N m].
    """
    z = interfaces(plies)
    return _integrate_stiffness(plies, z[1:], z[:-1])


def _integrate_stiffness(plies: Plies, inner: Array, outer: Array) -> tuple[Array, Array, Array]:
    """Integrals of (1, z, z^2) Q dz over the plies between their inner and outer faces."""
    # (A, B, D) = sum of Q (z_i^k - z_o^k)/k, k = 1, 2, 3
    Q = np.array([reduced_stiffness(ply.material, ply.angle) for ply in plies])
    A, B, D = (np.tensordot((outer**k - inner**k) / k, Q, 1) for k in (1, 2, 3))
    return A, B, D


def transverse_stiffness(plies: Plies) -> tuple[float, Array]:
    """Stiffness through the wall, its plies in series.

    Returns:
        Young's modulus E3 [Pa], and G of shape (2, 2) [Pa], which turns the engineering shear
        strains 13, 23 into stresses.
    """
    share = np.array([ply.thickness for ply in plies])
    share /= share.sum()
    softness, compliance = 0.0, np.zeros((2, 2))
    for part, ply in zip(share, plies, strict=True):
        c, s = np.cos(ply.angle), np.sin(ply.angle)
        R = np.array([[c, s], [-s, c]])  # shear strains 13, 23 of the wall in the axes of the ply
        softness += part / ply.material.young[2]
        compliance += part * R.T @ np.diag(1.0 / np.array(ply.material.shear[1:])) @ R
    return 1.0 / softness, np.linalg.inv(compliance)


def total_thickness(plies: Plies) -> float:
    """Thickness of a laminate [m]."""
    return sum(ply.thickness for ply in plies)


def mass_per_area(plies: Plies) -> float:
    """Mass of a laminate per area [kg/m^2]."""
    return sum(ply.material.density * ply.thickness for ply in plies)


def fit_moments(plies: Plies) -> Array:
    """A stiffness Q(zeta) = Q0 + Q1 zeta + Q2 zeta^2, zeta = z/h, that stands for the laminate.

    At the three points through the wall it has the stiffness Q+, Qm, Q-, with the weights w and wm
    of a face and of the middle. Its moments are those of the laminate. With A/h, B/h^2 and D/h^3 in
    place of A, B and D they are

        w Q+ + wm Qm + w Q- = A,    w (Q+ - Q-)/2 = B,    w (Q+ + Q-)/4 = D.

    Where the stiff plies lie on one side, one of the three can come out negative, and walls would
    buckle without load. There the laminate is mixed with one whose plies are shared out between
    the two points next to them, as little of it as leaves nothing negative: A and B stay exact,
    D is larger. This does not happen to laminates that are symmetric about their middle.

    Returns:
        Q0, Q1, Q2, shape (3, 3, 3) [Pa].
    """
    z, h = interfaces(plies), total_thickness(plies)
    A, B, D = (moment / h**k for k, moment in enumerate(laminate_stiffness(plies), start=1))
    w, wm = FACE_WEIGHT, MIDDLE_WEIGHT
    fit = (2.0 * D + B) / w, (A - 4.0 * D) / wm, (2.0 * D - B) / w
    outer, inner = np.maximum(z, 0.0), np.minimum(z, 0.0)  # the halves on both sides of the middle
    upper = _integrate_stiffness(plies, outer[1:], outer[:-1])[1] / h**2
    lower = -_integrate_stiffness(plies, inner[1:], inner[:-1])[1] / h**2
    shared = 2.0 * upper / w, (A - 2.0 * (upper + lower)) / wm, 2.0 * lower / w
    # Q + x Q_shared >= 0 for x = -(smallest mu of Q v = mu Q_shared v)
    least = min(eigvalsh(Q, S)[0] for Q, S in zip(fit, shared, strict=True))
    share = max(0.0, -least) / (1.0 + max(0.0, -least))
    out, middle, into = ((1.0 - share) * Q + share * S for Q, S in zip(fit, shared, strict=True))
    return np.stack([middle, out - into, 2.0 * (out + into) - 4.0 * middle])


@dataclass(frozen=True)
class WallTable:
    """Stiffness and density of walls, a row for each.

    Attributes:
        in_plane: Entries 11, 12, 13, 22, 23, 33 of Q, shape (n, 6); or of Q0, Q1 and Q2,
            shape (n, 18) [Pa].
        through: E3 and the shear stiffness G11, G12, G22, shape (n, 4) [Pa].
        density: Mass per volume, shape (n,) [kg/m^3].
    """

    in_plane: Array
    through: Array
    density: Array

    def __getitem__(self, rows: Any) -> WallTable:
        """The table of some of the walls, in the order given."""
        return WallTable(self.in_plane[rows], self.through[rows], self.density[rows])


def tabulate_walls(
    laminates: Sequence[Plies], thickness: Array, moments: bool = False
) -> WallTable:
    """Stiffness and density of solid walls that stand for laminates.

    Where the wall of the mesh has another thickness h than the laminate, t, all stiffnesses and the
    density are multiplied by t/h. Forces per length and mass per area stay those of the laminate;
    moments are those of a laminate pressed to the thickness h.

    Args:
        laminates: The plies of each wall.
        thickness: Of each wall in the mesh, shape (n,) [m].
        moments: Whether bending stiffness and coupling are those of the laminate too; else they are
            those of a uniform wall with its A.

    Raises:
        ModelError: for a laminate without plies, or a thickness that is not positive.
    """
    rows: dict[tuple[tuple[Ply, ...], float], Array] = {}
    numbers = []
    for plies, h in zip(laminates, thickness, strict=True):
        key = (tuple(plies), float(h))
        if key not in rows:
            rows[key] = _tabulate_wall(*key, moments)
        numbers.append(rows[key])
    table = np.array(numbers).reshape(len(numbers), 23 if moments else 11)
    return WallTable(table[:, :-5], table[:, -5:-1], table[:, -1])


def _tabulate_wall(plies: Plies, thickness: float, moments: bool) -> Array:
    """A row of in-plane stiffness, stiffness through the wall, and density."""
    if not plies:
        raise ModelError("a laminate needs a ply, but one has none")
    if not 0.0 < thickness < np.inf:
        raise ModelError(f"thickness of a wall must be positive, got {thickness:g}")
    t = total_thickness(plies)
    Q = fit_moments(plies) if moments else laminate_stiffness(plies)[0][None] / t
    E3, G = transverse_stiffness(plies)
    upper = np.triu_indices(3)
    row = [Q[:, upper[0], upper[1]].ravel(), [E3, G[0, 0], G[0, 1], G[1, 1]]]
    constants: Array = np.concatenate([*row, [mass_per_area(plies) / t]])
    return constants * (t / thickness)
