"""The basis of a body: what its couplings hold, modes, responses, and nonlinear equilibria."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Any

import numpy as np

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.reduced_body import ReducedBasis, make_strain_vectors, make_vectors
from turbine_fenicsx.foundation.argument_checks import check_among_parts
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.reduction.basis_functions import BasisFunctions
from turbine_fenicsx.reduction.elasticity import Law
from turbine_fenicsx.reduction.fingerprint import describe_cells
from turbine_fenicsx.reduction.gathered_body import gather_body
from turbine_fenicsx.reduction.interfaces import find_origins
from turbine_fenicsx.reduction.load_path import LoadPath, check_loads
from turbine_fenicsx.reduction.smooth_loads import smooth_loads
from turbine_fenicsx.reduction.static_states import find_states
from turbine_fenicsx.reduction.strain_coordinates import (
    choose_strains,
    keep_all_strains,
    sum_pair_stiffness,
)
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.system import MultibodySystem

log = logging.getLogger(__name__)


def reduce_body(
    system: MultibodySystem,
    body: FlexibleBody,
    modes: int = 6,
    functions: int = 48,
    strains: int = 25,
    loads: Sequence[LoadPath] | None = None,
) -> ReducedBasis:
    """The basis of a flexible body as the couplings of a system hold it.

    The surfaces that couplings hold move exactly as if rigid. Between them the functions are the
    components of vector fields. First come static shapes that follow from the motion of surfaces,
    then modes with all of them at rest, then responses to smooth forces along the body. The rest is
    what nonlinear equilibria have beyond these. So the first modes have the frequencies of the full
    body, and large bending and twist release their membrane strain. `judge` says how good it is.

    Args:
        system: A system with the body and all couplings that will hold it.
        body: The body.
        modes: Number of modes, each of them three functions.
        functions: Number of functions besides those of the interfaces. The time of a step grows
            with its second to third power.
        strains: Number of strain coordinates besides those that small motions need, three for each
            function. They come from the equilibria.
        loads: Load paths of the equilibria, such as the body will see and somewhat beyond; those of
            `smooth_loads` if None. Without any there are no equilibria, and all scalar products
            make strain coordinates: that is made in seconds, but slow and too stiff.

    Raises:
        ModelError: for a body that is not a part of the system or whose law is not quadratic in the
            strain, and for numbers or loads that do not fit.

    Note:
        Collective; gathers matrices of the body on one rank. Progress is logged as INFO.
    """
    numbers = {"modes": modes, "functions": functions, "strains": strains}
    _check_arguments(system, body, numbers, loads)
    law, model = Law(body), FlexibleModel(body)
    cells = describe_cells(body, law)  # a law that cannot be reduced is found here
    surfaces = _find_surfaces(system, body, model)
    loads = _choose_loads(system, body, loads)
    log.info("reducing %r: %d nodes, %d interfaces", body.name, model.size_global, len(surfaces))
    whole = gather_body(model, len(surfaces) > 1)
    origins = on_rank0(model.comm, lambda: find_origins(whole, surfaces))
    fields = BasisFunctions(whole, surfaces, origins, functions)
    on_rank0(model.comm, lambda: fields.add_linear(modes, not loads))
    states = _learn(fields, system, body, loads)
    shape = on_rank0(model.comm, fields.collect)
    F = shape["functions"]
    _warn_of_few(body, F.shape[1] - 4 * len(origins), functions)
    W, Z = _find_strains(model, law, fields, F, states, strains)
    return ReducedBasis(**shape, strain_factor=W, viscosity=Z, cells=cells)


def _check_arguments(
    system: MultibodySystem, body: Any, numbers: dict[str, Any], loads: Any
) -> None:
    """Raise an error for a body that cannot be reduced, and for numbers or loads of no use."""
    check_among_parts("flexible body", body, system.flexible_bodies)
    if not isinstance(body, FlexibleBody):
        raise ModelError(f"{body.name!r} is reduced already")
    for name, value in numbers.items():
        if isinstance(value, bool) or not isinstance(value, int) or value < 0:
            raise ModelError(f"{name} must be a whole number, zero or more, got {value!r}")
    modes, functions = numbers["modes"], numbers["functions"]
    if functions < max(1, 3 * modes):
        raise ModelError(
            f"functions must be three or more for each of {modes} modes, got {functions}"
        )
    if loads is not None:
        check_loads(loads)


def _choose_loads(
    system: MultibodySystem, body: FlexibleBody, loads: Sequence[LoadPath] | None
) -> Sequence[LoadPath]:
    """Load paths as given, else smooth ones for a body that couplings hold. Collective."""
    if loads is not None:
        return loads
    held = any(c.flexible is body for c in system.couplings)
    return smooth_loads(system, body) if held else ()


def _learn(
    fields: BasisFunctions,
    system: MultibodySystem,
    body: FlexibleBody,
    loads: Sequence[LoadPath],
) -> Array:
    """Add what equilibria have to the fields. Collective.

    Returns:
        Displacements in all of them, shape (states, N, 3) [m].
    """
    X: Array = fields.positions
    found = find_states(system, body, loads)
    states = np.concatenate([np.zeros((0, *X.shape)), *(path.displacements for path in found)])
    if len(states):
        on_rank0(system.comm, lambda: fields.add_states(states))
    elif loads:
        raise ModelError(f"none of the loads of {body.name!r} has an equilibrium: reduce them")
    return np.asarray(states)


def _find_strains(
    model: FlexibleModel,
    law: Law,
    fields: BasisFunctions,
    columns: Array,
    states: Array,
    wanted: int,
) -> tuple[Array, Array]:
    """Strain factor and viscosity of `ReducedBasis` for functions and states. Collective."""
    # functions of `ReducedBasis.strain_vectors`
    of_strain = np.concatenate([fields.positions - fields.origins[0], columns[:, 4:]], axis=1)
    m = of_strain.shape[1]
    log.info("stiffness of the %d pairs of functions", m * (m + 1) // 2)
    K, V = sum_pair_stiffness(model, law, of_strain[_local_nodes(model)], 3)

    def choose() -> tuple[Array, Array]:
        if not len(states):
            return keep_all_strains(K, V)
        return choose_strains(K, V, _pair(fields, states), wanted)

    W, Z = on_rank0(model.comm, choose)
    return W, Z


def _pair(fields: BasisFunctions, states: Array) -> Array:
    """Changes of the scalar products of all pairs in some states, shape (states, pairs)."""
    rest = make_vectors(fields.functions.shape[1], fields.origins)
    L = make_strain_vectors(len(rest), fields.origins)
    y = L @ np.concatenate([rest[None], [rest + fields.coordinates(u) for u in states]])
    first, second = np.triu_indices(len(L))
    products = (y @ y.swapaxes(1, 2))[:, first, second]
    found: Array = products[1:] - products[0]
    return found


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
