"""The basis of a body: what its couplings hold, modes, and responses to smooth forces."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from scipy import sparse

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.reduced_body import ReducedBasis
from turbine_fenicsx.foundation.checks import check_among_parts
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.reduction.elasticity import Law
from turbine_fenicsx.reduction.fingerprint import describe_cells
from turbine_fenicsx.reduction.interfaces import find_origins, make_interface_functions
from turbine_fenicsx.reduction.pair_stiffness import factor_stiffness, sum_pair_stiffness
from turbine_fenicsx.reduction.vector_fields import HeldBody
from turbine_fenicsx.reduction.whole_body import WholeBody, gather_body
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.system import MultibodySystem

log = logging.getLogger(__name__)

NEGLIGIBLE = {"exact": 1e-9, "responses": 1e-3}
"""Part of a field that a component must add to become a function, in the norm of masses."""


def reduce_body(
    system: MultibodySystem, body: FlexibleBody, modes: int = 6, functions: int = 48
) -> ReducedBasis:
    """The basis of a flexible body as the couplings of a system hold it.

    The surfaces that couplings hold move exactly as if rigid. Between them the functions are the
    components of vector fields: static shapes that follow from their motion, then modes with all of
    them at rest, then responses to smooth forces along the body. Forces are pushes and moments in
    three directions times polynomials. So the first modes have the frequencies of the full body.
    Energy and forces are those of the full body in the reduced motion.

    Args:
        system: A system with the body and all couplings that will hold it.
        body: The body.
        modes: Number of modes, each of them three functions.
        functions: Number of functions besides those of the interfaces. The time of a step grows
            with its third to fourth power.

    Returns:
        The basis for a `ReducedBody`.

    Raises:
        ModelError: for a body that is not a part of the system or whose law is not quadratic in the
            strain, and for numbers that do not fit.

    Note:
        Collective. Matrices of the body are gathered on one rank.
    """
    check_among_parts("flexible body", body, system.flexible_bodies)
    if not isinstance(body, FlexibleBody):
        raise ModelError(f"{body.name!r} is reduced already")
    _check_numbers(modes, functions)
    law, model = Law(body), FlexibleModel(body)
    cells = describe_cells(body, law)  # a law that cannot be reduced is found here
    surfaces = _find_surfaces(system, body, model)
    log.info("reducing %r: %d nodes, %d interfaces", body.name, model.size_global, len(surfaces))
    whole = gather_body(model, len(surfaces) > 1)

    def make() -> tuple[Array, ...]:
        masses = whole.mass.diagonal()
        origins = find_origins(whole, surfaces, masses)
        columns = _make_functions(whole, surfaces, origins, modes, functions)
        return columns, origins, masses, np.asarray(columns.T @ (whole.mass @ columns))

    columns, origins, masses, mass = on_rank0(model.comm, make)
    _warn_of_few(body, columns.shape[1] - 4 * len(origins), functions)
    log.info("stiffness of the %d pairs of functions", len(mass) * (len(mass) - 1) // 2)
    of_strain = np.concatenate(
        [whole.positions - origins[0], columns[:, 4:]], axis=1
    )  # of `ReducedBasis.strain_vectors`
    K, V = sum_pair_stiffness(model, law, of_strain[_local_nodes(model)], 3)
    W, Z = on_rank0(model.comm, lambda: factor_stiffness(K, V))
    surface_of = np.full(len(columns), -1)
    for s, nodes in enumerate(surfaces):
        surface_of[nodes] = s
    return ReducedBasis(whole.positions, columns, masses, origins, surface_of, mass, W, Z, cells)


def _check_numbers(modes: Any, functions: Any) -> None:
    """Raise a ModelError for numbers of functions that do not fit."""
    for name, value in (("modes", modes), ("functions", functions)):
        if isinstance(value, bool) or not isinstance(value, int) or value < 0:
            raise ModelError(f"{name} must be a whole number, zero or more, got {value!r}")
    if functions < max(1, 3 * modes):
        raise ModelError(
            f"functions must be three or more for each of {modes} modes, got {functions}"
        )


def _warn_of_few(body: FlexibleBody, found: int, wanted: int) -> None:
    """Warn on one rank if the mesh or the fields have fewer functions than were wanted."""
    if found < wanted and body.mesh.comm.rank == 0:
        log.warning(
            "the basis of %r has %d functions, as more are none: %d were wanted",
            body.name,
            found,
            wanted,
        )


def _find_surfaces(
    system: MultibodySystem, body: FlexibleBody, model: FlexibleModel
) -> list[IntArray]:
    """Global numbers of the nodes of each surface that a coupling holds. Collective."""
    first = model.comm.scan(model.n_owned) - model.n_owned
    held = (c for c in system.couplings if c.flexible is body)
    return [
        np.concatenate(model.comm.allgather(first + model.contact_nodes(c))).astype(np.int64)
        for c in held
    ]


def _local_nodes(model: FlexibleModel) -> IntArray:
    """Global numbers of the local nodes, ghosts included."""
    index_map = model.space.dofmap.index_map
    local = np.arange(len(model.local_positions), dtype=np.int32)
    numbers: IntArray = index_map.local_to_global(local)
    return numbers


def _make_functions(
    whole: WholeBody, surfaces: Sequence[IntArray], origins: Array, modes: int, functions: int
) -> Array:
    """Values of all functions at the nodes, shape (N, n)."""
    interface = make_interface_functions(whole, surfaces, origins)
    held = HeldBody(whole, surfaces, origins)
    try:
        exact = _subtract_rigid(interface, held.follow_interfaces(), surfaces, origins)
        squares, shapes = held.modes(modes)
        exact += list(shapes)
        left = max(functions - 3 * len(exact), 0)
        responses = held.responses(left, squares, shapes) if left else []
    finally:
        held.destroy()
    # functions of a free body are none of what its point and directors do already
    known = _Orthonormal(whole.mass, np.zeros_like(interface[:, :0]) if surfaces else interface)
    known.add(exact, NEGLIGIBLE["exact"], functions)
    known.add(responses, NEGLIGIBLE["responses"], functions)
    return np.concatenate([interface, known.functions], axis=1)


def _subtract_rigid(
    interface: Array, fields: Sequence[Array], surfaces: Sequence[IntArray], origins: Array
) -> list[Array]:
    """Fields less what the functions of the interfaces make of them, if anything is left."""
    left = [(u, u - _follow(interface, u, surfaces, origins)) for u in fields]
    return [
        rest for u, rest in left if np.linalg.norm(rest) > NEGLIGIBLE["exact"] * np.linalg.norm(u)
    ]


def _follow(interface: Array, u: Array, surfaces: Sequence[IntArray], origins: Array) -> Array:
    """Motion by the functions of the interfaces that is nearest on these, shape (N, 3)."""
    z = np.zeros((interface.shape[1], 3))
    for s, nodes in enumerate(surfaces):
        of_surface = interface[nodes, 4 * s : 4 * s + 4]
        z[4 * s : 4 * s + 4] = np.linalg.lstsq(of_surface, u[nodes], rcond=1e-9)[0]
    found: Array = interface @ z
    return found


class _Orthonormal:
    """Functions that are orthogonal to each other in the mass, with the mass of the body.

    Args:
        mass: int rho N_a N_b dV, shape (N, N).
        apart: Functions that others must be orthogonal to, shape (N, k).
    """

    def __init__(self, mass: sparse.csr_matrix, apart: Array) -> None:
        self._mass, self._scale = mass, float(np.sqrt(mass.sum()))
        self._all: list[Array] = []
        self._apart = 0
        for f in apart.T:
            self._append(f, 0.0)
        self._apart = len(self._all)

    @property
    def functions(self) -> Array:
        """The functions, shape (N, k)."""
        rows = self._all[self._apart :]
        return self._scale * np.array(rows).T.reshape(self._mass.shape[0], len(rows))

    def add(self, fields: Iterable[Array], negligible: float, most: int) -> None:
        """Add the components of fields as far as they are new, until there are enough."""
        for field in fields:
            size = float(np.sqrt(np.sum(field * (self._mass @ field))))
            for component in field.T:
                if len(self._all) - self._apart < most:
                    self._append(component, negligible * size)

    def _append(self, f: Array, least: float) -> None:
        """Append a function if what is new of it is not negligible."""
        for _ in range(2):  # twice is enough
            for known in self._all:
                f = f - (known @ (self._mass @ f)) * known
        norm = float(np.sqrt(f @ (self._mass @ f)))
        if norm > least:
            self._all.append(f / norm)
