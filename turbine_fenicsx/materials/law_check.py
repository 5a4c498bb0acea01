"""A look at a material before it is used: a wrong one makes or loses energy."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

import numpy as np
from dolfinx import fem

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.own_code import name_errors
from turbine_fenicsx.foundation.parallel import raise_together
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.foundation.ufl_shapes import check_ufl_shape
from turbine_fenicsx.materials.base import Material, Viscous
from turbine_fenicsx.materials.cell_fields import parameters_on
from turbine_fenicsx.materials.pointwise import CellPoints, UnknownExpression, write_out

log = logging.getLogger(__name__)

STRAIN = 0.1
"""Largest entry of the random strains."""

STEP = 1e-4
"""Strain of the differences that give the stiffness at rest."""

TOLERANCE = 1e-5
"""Round-off of these differences relative to the largest stiffness."""

SMALL_STEP = 1e-6
"""Strain of those that give the stress at rest; a law with a kink there has some of this size."""

ENERGY_AT_REST = 1e-11
"""Round-off of the energy at rest, relative to the largest stiffness."""

STRESS_AT_REST = 1e-6
"""Round-off of the stress at rest, relative to the largest stiffness."""

ROUND_OFF = 1e-10
"""Round-off of viscous stresses."""


def check_material(material: Material, mesh: Any, name: str = "") -> list[str]:
    """Check a law in a few cells of a mesh: energy and stress at rest, stiffness, viscosity.

    Args:
        material: The law.
        mesh: The mesh of the body, whose fields the law may depend on.
        name: Name of the body, for messages.

    Returns:
        Warnings, a sentence each: of energy or stress at rest, of strains without a stiffness or
        with an energy that is not finite.

    Raises:
        ModelError: if the stiffness at rest is not positive, if a law that calls itself quadratic
            is not, or if a viscous stress is not symmetric or gives energy. On all ranks.

    Note:
        Collective. Laws that depend on more than constants, fields, position and the shape of the
        cells are not checked; the log says so.
    """
    who = f"law {type(material).__name__}" + (f" of {name!r}" if name else "")
    count = mesh.topology.index_map(3).size_local
    warnings: list[str] = []
    error: Exception | None = None
    if count:
        try:
            cells = sorted({0, count // 2, count - 1})
            warnings = _check(who, material, mesh, CellPoints(mesh, np.array(cells)))
        except UnknownExpression as unknown:
            log.info("%s is not checked: it depends on %s", who, unknown)
        except Exception as problem:  # the other ranks must hear of it, whatever it is
            error = problem
    raise_together(mesh.comm, error)
    return list(dict.fromkeys(w for each in mesh.comm.allgather(warnings) for w in each))


def _check(who: str, material: Material, mesh: Any, middles: CellPoints) -> list[str]:
    """Check a law on this rank; the warnings."""
    parameter = parameters_on(mesh, who)
    C = fem.Constant(mesh, np.eye(3))
    what = f"strain_energy() of {who}"
    with name_errors(what):
        W = check_ufl_shape(what, material.strain_energy(C, parameter), ())
    W_of_C = write_out(W)

    def energy(strains: Array) -> Array:
        """W, shape (cells, strains)."""
        found: Array = middles.evaluate([W_of_C], {C: np.eye(3) + 2.0 * strains})[..., 0]
        return found

    rest = energy(np.zeros((1, 3, 3)))[:, 0]
    S, _ = _differentiate(energy, SMALL_STEP)
    _, D = _differentiate(energy, STEP)
    if not (np.isfinite(rest).all() and np.isfinite(D).all()):
        raise ModelError(f"{who} has an energy or a stress at rest that is not finite")
    stiffness = np.linalg.eigvalsh(D)
    sizes = np.abs(stiffness).max(axis=1)  # of each cell: a body may be of steel and rubber
    least, size = float(stiffness.min()), float(sizes.max())
    if size == 0.0:
        raise ModelError(f"{who} has no stiffness at rest")
    share = float((stiffness.min(axis=1) / np.where(sizes > 0.0, sizes, 1.0)).min())
    if share < -TOLERANCE:
        raise ModelError(
            f"{who} has a negative stiffness at rest, {least:.3g} Pa for some strain: its energy "
            "must have its least value without strain"
        )
    if material.quadratic:
        _check_quadratic(who, energy, size)
    if isinstance(material, Viscous):
        _check_viscosity(who, material, mesh, middles)
    warnings = []
    if share < TOLERANCE:
        warnings.append(f"{who} has no stiffness at rest against some strain")
    if np.abs(rest).max() > ENERGY_AT_REST * size:
        found = float(rest[np.abs(rest).argmax()])
        warnings.append(f"{who} has an energy of {found:.3g} J/m^3 at rest, expected 0")
    if np.abs(S).max() > STRESS_AT_REST * size:
        warnings.append(f"{who} has a stress of {np.abs(S).max():.3g} Pa at rest, expected 0")
    if not np.isfinite(energy(np.concatenate([_find_strains(), -_find_strains()]))).all():
        warnings.append(f"{who} is not finite at strains of {STRAIN:g}")
    return warnings


def _differentiate(energy: Callable[[Array], Array], step: float) -> tuple[Array, Array]:
    """Stress and stiffness at rest in a basis of strains of length 1, by differences of W.

    Returns:
        Shapes (cells, 6) [Pa] and (cells, 6, 6) [Pa].
    """
    basis = np.zeros((6, 3, 3))
    for k, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))):
        basis[k, i, j] = basis[k, j, i] = 1.0 if i == j else np.sqrt(0.5)
    pairs = [(i, j) for i in range(6) for j in range(i, 6)]
    sums = step * np.array([basis[i] + basis[j] for i, j in pairs])
    gaps = step * np.array([basis[i] - basis[j] for i, j in pairs])
    W = energy(np.concatenate([step * basis, -step * basis, sums, -sums, gaps, -gaps]))
    n = len(pairs)
    ahead, back, *ends = np.split(W, [6, 12, 12 + n, 12 + 2 * n, 12 + 3 * n], axis=1)
    with np.errstate(invalid="ignore"):  # of energies that are not finite
        S = (ahead - back) / (2.0 * step)
        D = np.zeros((len(W), 6, 6))
        for k, (i, j) in enumerate(pairs):
            change = ends[0][:, k] + ends[1][:, k] - ends[2][:, k] - ends[3][:, k]
            D[:, i, j] = D[:, j, i] = change / (4.0 * step**2)
    return S, D


def _find_strains() -> Array:
    """Some random strains, shape (n, 3, 3)."""
    values = np.random.default_rng(0).uniform(-STRAIN, STRAIN, (4, 3, 3))
    found: Array = 0.5 * (values + values.swapaxes(1, 2))
    return found


def _check_quadratic(who: str, energy: Callable[[Array], Array], size: float) -> None:
    """Check that the third differences of W vanish along random strains."""
    strains = _find_strains()
    W = energy(np.concatenate([k * strains / 3.0 for k in range(-3, 4)]))
    W = W.reshape(len(W), 7, len(strains))
    part = np.abs(np.diff(W, 3, axis=1)).max() / (STRAIN**2 * size)
    if not part <= TOLERANCE:
        raise ModelError(
            f"{who} says quadratic = True, but its energy is not quadratic in C, by {part:.2g} of "
            f"itself at strains of {STRAIN:g}: steps would not conserve energy"
        )


def _check_viscosity(who: str, material: Viscous, mesh: Any, middles: CellPoints) -> None:
    """Check that the viscous stress is symmetric and takes energy."""
    rate = fem.Constant(mesh, np.zeros((3, 3)))
    what, parameter = f"viscous_stress() of {who}", parameters_on(mesh, who)
    with name_errors(what):
        stress = check_ufl_shape(what, material.viscous_stress(rate, parameter), (3, 3))
    rates = np.concatenate([_find_strains(), -_find_strains()]) / STRAIN
    entries = [write_out(stress[i, j]) for i in range(3) for j in range(3)]
    values = middles.evaluate(entries, {rate: rates})
    S = values.reshape(*values.shape[:2], 3, 3)
    size = np.abs(S).max()
    if not np.isfinite(size):
        raise ModelError(f"{who} has a viscous stress that is not finite")
    if np.abs(S - S.swapaxes(-1, -2)).max() > ROUND_OFF * size:
        raise ModelError(
            f"{who} has a viscous stress that is not symmetric: angular momentum would be lost"
        )
    if np.einsum("csij,sij->cs", S, rates).min() < -ROUND_OFF * size:
        raise ModelError(f"{who} has a viscous stress that gives energy: S_v : E' must not be < 0")
