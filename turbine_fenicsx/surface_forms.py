"""Loads on the surface of a flexible body as UFL forms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import ufl

from turbine_fenicsx import _compat
from turbine_fenicsx.loads.base import SurfaceLoad


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
        ValueError: if a load has no facet on any rank.

    Note:
        Collective.
    """
    n_facets = max((int(np.max(x.facets, initial=-1)) + 1 for x in loads), default=0)
    number = np.zeros(n_facets, dtype=np.int32)
    for k, load in enumerate(loads):
        number[np.unique(load.facets)] += 2**k
    facets = np.flatnonzero(number).astype(np.int32)
    ds = _compat.facet_measure(mesh, facets, number[facets])
    ds = ds(metadata={"quadrature_degree": quadrature_degree})
    used = sorted(set().union(*mesh.comm.allgather(set(number[facets].tolist()))))
    N = ufl.FacetNormal(mesh)
    terms = []
    for k, (load, factor) in enumerate(zip(loads, factors, strict=True)):
        mine = tuple(n for n in used if n & 2**k)
        if not mine:
            raise ValueError(f"load {load.name!r} has no facets on {load.flexible.name!r}")
        terms.append((load.traction(F, N, factor, parameter), mine))
    return lambda w: [ufl.dot(t, w) * ds(numbers) for t, numbers in terms]
