"""Forces on the surface of a flexible body as UFL forms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import fem

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.facets import check_facets
from turbine_fenicsx.forces.prescribed_force import SurfaceForce
from turbine_fenicsx.forces.surface_point import SurfacePoint
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.materials.kinematics import deformation_gradient


class SurfaceIntegrals:
    """Virtual works of forces on the surface of a body.

    Facets are numbered by the forces that act on them, because a form can have one set of surface
    numbers only.

    Args:
        mesh: The mesh.
        forces: The forces.
        parameter: Turns numbers and arrays into UFL constants.
        quadrature_degree: Degree of the quadrature.

    Attributes:
        forces: The forces.

    Raises:
        ModelError: if a force has no facet on any rank, or one inside the body.

    Note:
        Collective.
    """

    def __init__(
        self,
        mesh: Any,
        forces: Sequence[SurfaceForce],
        parameter: Callable[[Any], Any],
        quadrature_degree: int,
    ) -> None:
        self._mesh, self.forces, self._parameter = mesh, tuple(forces), parameter
        self._factors = [fem.Constant(mesh, PETSc.ScalarType(0.0)) for _ in forces]
        self._time = fem.Constant(mesh, PETSc.ScalarType(0.0))
        if forces:
            facets, tags, self._tags_of_force = _number_facets(mesh, forces)
            ds = _compat.facet_measure(mesh, facets, tags)
            self._ds = ds(metadata={"quadrature_degree": quadrature_degree})

    def set_time(self, time: float) -> None:
        """Set the time of the forces [s]."""
        self._time.value = time
        for factor, force in zip(self._factors, self.forces, strict=True):
            factor.value = force.function(time)

    def integrals(self, u: Any, v: Any, w: Any) -> list[Any]:
        """One form per force: the integral of its traction times w.

        Args:
            u: Displacement, a UFL expression.
            v: Velocity, a UFL expression.
            w: Test function or virtual displacement.
        """
        if not self.forces:
            return []
        X, N = ufl.SpatialCoordinate(self._mesh), ufl.FacetNormal(self._mesh)
        F = deformation_gradient(u)
        forms = []
        for force, factor, mine in zip(
            self.forces, self._factors, self._tags_of_force, strict=True
        ):
            at = SurfacePoint(X, X + u, v, F, N, self._time, factor, self._parameter)
            forms.append(ufl.dot(force.traction(at), w) * self._ds(mine))
        return forms


Facets = npt.NDArray[np.int32]


def _number_facets(
    mesh: Any, forces: Sequence[SurfaceForce]
) -> tuple[Facets, Facets, list[tuple[int, ...]]]:
    """One number for each set of forces that act together on some facet.

    Returns:
        Loaded facets of this rank, the number of each, and the numbers that each force acts on.
    """
    comm, tdim = mesh.comm, mesh.topology.dim
    exterior = _compat.exterior_facets(mesh)
    n_owned = mesh.topology.index_map(tdim - 1).size_local
    acting: dict[int, tuple[int, ...]] = {}
    for k, force in enumerate(forces):
        mine = check_facets(force.name, mesh, force.facets)
        owned = mine[mine < n_owned]
        inside = comm.allreduce(int(np.count_nonzero(~np.isin(owned, exterior))))
        if inside:
            raise ModelError(
                f"{inside} facets of force {force.name!r} are not on the surface of "
                f"{force.flexible.name!r}"
            )
        if not comm.allreduce(owned.size):
            raise ModelError(f"force {force.name!r} has no facets on {force.flexible.name!r}")
        for facet in owned.tolist():
            acting[facet] = (*acting.get(facet, ()), k)
    sets = sorted(set().union(*comm.allgather(set(acting.values()))))
    number = {chosen: n + 1 for n, chosen in enumerate(sets)}
    facets = np.array(sorted(acting), dtype=np.int32)
    tags = np.array([number[acting[f]] for f in facets.tolist()], dtype=np.int32)
    return (
        facets,
        tags,
        [tuple(number[chosen] for chosen in sets if k in chosen) for k in range(len(forces))],
    )
