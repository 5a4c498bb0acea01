"""Loads on the surface of a flexible body as UFL forms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import ufl

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.facets import checked_facets
from turbine_fenicsx.forces.load import SurfaceLoad


def surface_integrals(
    mesh: Any,
    loads: Sequence[SurfaceLoad],
    factors: Sequence[Any],
    F: Any,
    parameter: Callable[[Any], Any],
    quadrature_degree: int,
) -> Callable[[Any], list[Any]]:
    """Integrals of load times test function over the surface of each load.

    Facets are numbered by the loads that act on them, because a form can have one set of surface
    numbers only.

    Args:
        mesh: The mesh.
        loads: The loads.
        factors: Values of their functions of time, UFL constants.
        F: Deformation gradient at the middle of the step.
        parameter: Turns numbers and arrays into UFL constants.
        quadrature_degree: Degree of the quadrature.

    Returns:
        Function of the test function w that returns one form per load.

    Raises:
        ValueError: if a load has no facet on any rank, or one inside the body.

    Note:
        Collective.
    """
    facets, tags, tags_of_load = _numbered(mesh, loads)
    ds = _compat.facet_measure(mesh, facets, tags)
    ds = ds(metadata={"quadrature_degree": quadrature_degree})
    N = ufl.FacetNormal(mesh)
    terms = [
        (load.traction(F, N, factor, parameter), mine)
        for load, factor, mine in zip(loads, factors, tags_of_load, strict=True)
    ]
    return lambda w: [ufl.dot(t, w) * ds(numbers) for t, numbers in terms]


Facets = npt.NDArray[np.int32]


def _numbered(
    mesh: Any, loads: Sequence[SurfaceLoad]
) -> tuple[Facets, Facets, list[tuple[int, ...]]]:
    """One number for each set of loads that act together on some facet.

    Returns:
        Loaded facets of this rank, the number of each, and the numbers that each load acts on.
    """
    comm, tdim = mesh.comm, mesh.topology.dim
    exterior = _compat.exterior_facets(mesh)
    n_owned = mesh.topology.index_map(tdim - 1).size_local
    acting: dict[int, tuple[int, ...]] = {}
    for k, load in enumerate(loads):
        mine = checked_facets(load.name, mesh, load.facets)
        owned = mine[mine < n_owned]
        inside = comm.allreduce(int(np.count_nonzero(~np.isin(owned, exterior))))
        if inside:
            raise ValueError(
                f"{inside} facets of load {load.name!r} are not on the surface of "
                f"{load.flexible.name!r}"
            )
        if not comm.allreduce(owned.size):
            raise ValueError(f"load {load.name!r} has no facets on {load.flexible.name!r}")
        for facet in owned.tolist():
            acting[facet] = (*acting.get(facet, ()), k)
    sets = sorted(set().union(*comm.allgather(set(acting.values()))))
    number = {chosen: n + 1 for n, chosen in enumerate(sets)}
    facets = np.array(sorted(acting), dtype=np.int32)
    tags = np.array([number[acting[f]] for f in facets.tolist()], dtype=np.int32)
    return (
        facets,
        tags,
        [tuple(number[chosen] for chosen in sets if k in chosen) for k in range(len(loads))],
    )
