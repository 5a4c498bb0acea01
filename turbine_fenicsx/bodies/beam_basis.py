"""The basis of a beam, which knows the forces and moments in its sections.

With the stress resultants F, M that are conjugate to the strains (see `beam_strains`), the force
and moment that the part behind a section exerts on the part before it are

    n = F_1 d_1 + F_2 d_2 + F_3 r' + M_1 (d_2' + tau_0 d_1 - kappa_10 r')
                                   + M_2 (-d_1' + tau_0 d_2 - kappa_20 r'),
    m = M_1 d_2 x r' - M_2 d_1 x r' + M_3 d_1 x d_2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from turbine_fenicsx.bodies.reduced_body import ReducedBasis
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.lagrange import lagrange
from turbine_fenicsx.foundation.types import Array


@dataclass(frozen=True, eq=False, repr=False)
class BeamBasis(ReducedBasis):
    """Functions of a beam, made by `turbine_fenicsx.beam_basis`; without cells of a solid.

    Args:
        ends: Arc lengths of the ends of its elements, shape (elements + 1,) [m].
        section_stations: Arc lengths of the g Gauss points, as many in each element, shape (g,).
        section_factor: Q with the resultants Q c of strain coordinates c: F_1, F_2, F_3, M_1, M_2,
            M_3 of the first Gauss point, then the next, shape (6 g, r).
        section_rows: r', d_1, d_2, d_1', d_2' at the Gauss points as sums of the vectors y, one
            after the other for all points, shape (5 g, n - 1).
    """

    ends: Array
    section_stations: Array
    section_factor: Array
    section_rows: Array

    FLAT = (*ReducedBasis.FLAT, "ends", "section_stations")

    def __post_init__(self) -> None:
        super().__post_init__()
        g, (_, r), n = len(self.section_stations), self.strain_factor.shape, len(self.mass)
        elements = len(self.ends) - 1
        shapes = {"section_factor": (6 * g, r), "section_rows": (5 * g, n - 1)}
        for name, shape in shapes.items():
            found = getattr(self, name).shape
            if found != shape:
                raise ModelError(f"{name} of a beam must have the shape {shape}, got {found}")
        if elements < 1 or g < elements or g % elements:
            raise ModelError(
                f"each of {elements} elements of a beam must have as many Gauss points, got {g}"
            )

    @property
    def length(self) -> float:
        """Arc length of the axis [m]."""
        return float(self.ends[-1])

    @cached_property
    def _at_rest(self) -> tuple[Array, Array, Array]:
        """tau_0, kappa_10 and kappa_20 at the Gauss points."""
        r, d1, d2, e1, e2 = self._vectors_at(self.strain_vectors @ self.vectors)
        tau = 0.5 * (_dot(e1, d2) - _dot(d1, e2))
        return tau, _dot(r, e2), -_dot(r, e1)

    def _vectors_at(self, y: Array) -> Array:
        """r', d_1, d_2, d_1', d_2' for vectors y, shape (..., m, 3); their axis comes first."""
        found = self.section_rows.reshape(5, -1, self.section_rows.shape[1]) @ y[..., None, :, :]
        return np.asarray(np.moveaxis(found, -3, 0))

    def find_section_loads(self, y: Array, c: Array) -> Array:
        """Forces and moments of the Gauss points along x, y, z of their sections.

        Args:
            y: Vectors, shape (copies, m, 3).
            c: Strain coordinates, shape (copies, r).

        Returns:
            Shape (copies, g, 6) [N, N m]: what the part behind a section, towards the end, exerts
            on the part before it.
        """
        r, d1, d2, e1, e2 = self._vectors_at(y)
        of_sections = (c @ self.section_factor.T).reshape(len(c), -1, 6)
        F1, F2, F3, M1, M2, M3 = np.moveaxis(of_sections, -1, 0)[..., None]
        tau, k1, k2 = (x[:, None] for x in self._at_rest)
        n = F1 * d1 + F2 * d2 + F3 * r
        n += M1 * (e2 + tau * d1 - k1 * r) + M2 * (tau * d2 - e1 - k2 * r)
        m = M1 * np.cross(d2, r) - M2 * np.cross(d1, r) + M3 * np.cross(d1, d2)
        axes = _find_axes(d1, d2)
        return np.concatenate([(axes @ v[..., None])[..., 0] for v in (n, m)], axis=-1)

    def find_axes(self, places: Array) -> Array:
        """Axes x, y, z of sections at rest as rows, at arc lengths, shape (k, 3, 3)."""
        _, *directors = self._vectors_at(self.strain_vectors @ self.vectors)[:3]
        d1, d2 = (self.find_weights(places) @ d for d in directors)
        return _find_axes(d1, d2)

    def find_weights(self, places: Array) -> Array:
        """Weights of the Gauss points at arc lengths: polynomials in each element, shape (k, g)."""
        elements = len(self.ends) - 1
        gauss = self.section_stations.reshape(elements, -1)
        of = np.searchsorted(self.ends[1:-1], places, side="right")
        found = np.zeros((len(of), *gauss.shape))
        found[np.arange(len(of)), of] = lagrange(gauss[of], np.asarray(places))
        return found.reshape(len(of), -1)


def _find_axes(d1: Array, d2: Array) -> Array:
    """Unit vectors x along d_1, y and z at right angles to d_1 and d_2, as rows."""
    x, z = _unit(d1), _unit(np.cross(d1, d2))
    return np.stack([x, np.cross(z, x), z], axis=-2)


def _dot(a: Array, b: Array) -> Array:
    """Scalar products of vectors along the last axis."""
    return np.asarray(np.sum(a * b, axis=-1))


def _unit(vectors: Array) -> Array:
    """Unit vectors along the last axis."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1)[..., None])
