"""Axes and thickness coordinate of walls meshed with one cell through the thickness.

The axes of the reference hexahedron must point along the span, around the section and outwards
through the wall, as those of `turbine_fenicsx.meshing.hollow.HollowBlock` do. A section of such
walls has quadrilaterals with the last two of these axes, and its span is z.
"""

from __future__ import annotations

import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh
from ufl.core.expr import Expr

from turbine_fenicsx import _compat


def wall_frame(mesh: Mesh) -> tuple[Expr, Expr, Expr]:
    """Orthonormal axes along the span, around the section and normal to the wall, in each point.

    The normal is exactly that of the surface zeta = constant through the point, the first axis
    lies in that surface along the reference axis of the span.
    """
    J = ufl.Jacobian(mesh)
    if mesh.topology.dim == 2:
        span = ufl.as_vector([0.0, 0.0, 1.0])
        around = ufl.as_vector([J[0, 0], J[1, 0], 0.0])
        around /= ufl.sqrt(ufl.dot(around, around))
        return span, around, ufl.cross(span, around)
    along, around = J[:, 0], J[:, 1]
    normal = ufl.cross(along, around)
    a1, a3 = (a / ufl.sqrt(ufl.dot(a, a)) for a in (along, normal))
    return a1, ufl.cross(a3, a1), a3


def thickness_coordinate(mesh: Mesh) -> fem.Function:
    """The coordinate zeta through the wall, from -1/2 at the inner to 1/2 at the outer face."""
    zeta = fem.Function(_compat.cellwise_space(mesh, (), 1))
    points = _compat.interpolation_points(zeta.function_space)
    zeta.x.array[_compat.dofs_of_cells(zeta.function_space)] = points[:, -1] - 0.5
    return zeta
