"""Points of the cells of a flexible body at which its inertia and its stress are evaluated."""

from __future__ import annotations

from typing import Any

import ufl

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.materials.base import Quadrature, Sampled


def stress_rule(body: FlexibleBody) -> Quadrature:
    """Points and weights of the stress terms of a body on the reference cell."""
    if isinstance(body.material, Sampled) and body.material.quadrature is not None:
        return body.material.quadrature
    return Quadrature(*_compat.quadrature(_compat.cell_name(body.mesh), _degrees(body)[1]))


def _degrees(body: FlexibleBody) -> tuple[int, int]:
    """Degrees of the usual rules for inertia and stress."""
    p = body.degree
    hexahedron = _compat.cell_name(body.mesh) == "hexahedron"
    return (2 * p + 1, 2 * p + 1) if hexahedron else (2 * p, p)


def make_measures(body: FlexibleBody) -> tuple[Any, Any]:
    """Measures of the inertia terms and of the stress terms.

    Hexahedra take p + 1 Gauss points per direction for both. Tetrahedra take the degree that is
    exact for inertia, and one point (P1) or four points (P2) for the stress; their weights are
    positive, so that the strain energy is. A material that is `Sampled` brings its own points for
    the stress. Energy is conserved exactly for any choice, as energy and stress use the same
    points.
    """
    mass, stress = _degrees(body)
    data: dict[str, Any] = {"quadrature_degree": stress}
    if isinstance(body.material, Sampled) and body.material.quadrature is not None:
        points, weights = body.material.quadrature
        data |= {
            "quadrature_rule": "custom",
            "quadrature_points": points.tolist(),  # lists, of which UFL makes all digits a key
            "quadrature_weights": weights.tolist(),
        }
    return (
        ufl.dx(domain=body.mesh, metadata={"quadrature_degree": mass}),
        ufl.dx(domain=body.mesh, metadata=data),
    )
