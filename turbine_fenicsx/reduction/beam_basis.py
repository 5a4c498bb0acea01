"""The basis of a beam, made of the matrices of its sections.

Its functions are N_k, xi N_k and eta N_k of `BeamElements` for the nodes between the ends. An end
that couplings hold has a point and three directors as every interface. See `beam_strains` for the
energy.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.beam_basis import BeamBasis
from turbine_fenicsx.bodies.carrier import Carrier
from turbine_fenicsx.bodies.reduced_body import make_strain_vectors, make_vectors
from turbine_fenicsx.bodies.surface_points import find_surface_points
from turbine_fenicsx.foundation.argument_checks import check_positive
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.reduction.beam_elements import BeamElements
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.reduction.beam_sections import BeamSections
from turbine_fenicsx.reduction.beam_strains import BeamMotion, find_mass, find_strain_factors
from turbine_fenicsx.system.mesh_areas import positions_of

Facets = npt.NDArray[np.int32]
"""Facets of a mesh, indices local to a rank."""


def beam_basis(
    carrier: Carrier,
    line: BeamLine,
    sections: BeamSections,
    elements: int = 8,
    degree: int = 3,
    start: Facets | None = None,
    end: Facets | None = None,
    hold: float = 0.01,
) -> BeamBasis:
    """The basis of a beam.

    Args:
        carrier: The mesh that carries its surfaces, points and pictures.
        line: Its reference axis and directors, where the mesh is.
        sections: Stiffness and mass of its sections.
        elements: Number of finite elements along it.
        degree: p of their functions, 1 to 5; errors of small deflections fall with the power 2 p
            of their length.
        start: Facets of the carrier at the start of the axis that a coupling will hold; None for a
            free beam.
        end: Those at its end; None for a free end.
        hold: Stiffness that keeps sections whole, over that of stretch. Less than 1 takes fewer
            iterations, and adds the part strain^2/hold to curvatures, with the bending strain at
            the radius of inertia: 0.1 % at 0.3 %. Thick beams that bend much want 1.

    Raises:
        ModelError: for numbers that do not fit, sections that end before the axis, a beam that is
            held at its end alone, and points of the carrier at which sections cross.

    Note:
        Collective.
    """
    check_positive("hold of a beam", hold)
    if end is not None and start is None:
        raise ModelError("a beam that is held at one end is held where its axis starts")
    mesh = BeamElements(line, elements, degree)
    _check_length(line, sections)
    held = [x for x in (start, end) if x is not None]
    points, surface_of = _gather_points(carrier, held)
    origins = mesh.nodes[0][[0, -1]][: max(1, len(held))]
    motion, whole = _find_motion(mesh, origins, len(held))
    energy = find_strain_factors(mesh, sections, motion, hold)
    mass = find_mass(mesh, sections, whole)
    return BeamBasis(
        points=points,
        functions=_evaluate(mesh, whole, points, surface_of, origins),
        masses=np.full(len(points), _mass_of(mass, len(origins)) / len(points)),
        origins=origins,
        surface_of=surface_of,
        mass=mass,
        strain_factor=energy.strain_factor,
        viscosity=energy.viscosity,
        cells=np.zeros((0, 7)),
        singular_values=np.zeros(0),
        ends=mesh.ends,
        section_stations=energy.stations,
        section_factor=energy.section_factor,
        section_rows=energy.section_rows,
    )


def _check_length(line: BeamLine, sections: BeamSections) -> None:
    """Raise a ModelError if the sections do not reach from end to end."""
    gap = max(abs(sections.stations[0]), abs(sections.stations[-1] - line.length))
    if gap > 1e-3 * line.length:
        raise ModelError(
            f"sections of a beam must reach from 0 to the length of its axis, {line.length:g} m, "
            f"got {sections.stations[0]:g} to {sections.stations[-1]:g} m"
        )


def _mass_of(mass: Array, interfaces: int) -> float:
    """Mass of a body by the mass matrix of its basis [kg]."""
    points = 4 * np.arange(interfaces)
    return float(mass[np.ix_(points, points)].sum())


class _Nodes(NamedTuple):
    """Nodes of a carrier."""

    points: Array
    surface_of: IntArray


def _gather_points(carrier: Carrier, held: list[Facets]) -> _Nodes:
    """Nodes of the carrier on all ranks, and the interface that each belongs to. Collective."""
    space = _compat.vector_space(carrier.mesh, carrier.degree)
    points = np.concatenate(carrier.mesh.comm.allgather(positions_of(space)))
    surface_of = np.full(len(points), -1, dtype=np.int64)
    for s, facets in enumerate(held):
        surface = find_surface_points(space, f"end {s + 1} of {carrier.name!r}", facets)
        if not len(surface):
            raise ModelError(f"end {s + 1} of the carrier {carrier.name!r} has no facets")
        size = float(np.max(np.ptp(points, axis=0)))
        near = _find_near(points, surface, 1e-9 * size)
        if np.any(surface_of[near] >= 0):
            raise ModelError(f"both ends of the carrier {carrier.name!r} have nodes in common")
        surface_of[near] = s
    return _Nodes(points, surface_of)


def _find_near(points: Array, wanted: Array, distance: float) -> IntArray:
    """Numbers of the points at wanted places."""
    found: IntArray = np.asarray(cKDTree(points).query(wanted)[1], dtype=np.int64)
    if np.max(np.linalg.norm(points[found] - wanted, axis=1), initial=0.0) > distance:
        raise ModelError("the ends of a beam must be surfaces of its carrier")
    return found


def _number_vectors(mesh: BeamElements, held: int) -> IntArray:
    """Number of the vector z of each node's axis and directors, -1 for none, shape (3, K + 1).

    The start follows its interface, and so does an end that is held. In a free beam the point and
    directors of the whole body make one function of the last node superfluous.
    """
    count = mesh.number * mesh.degree + 1
    has = np.ones((3, count), dtype=bool)
    has[:, 0] = False
    if held == 2:
        has[:, -1] = False
    if held == 0:
        has[0, -1] = False
    numbers = np.full((3, count), -1, dtype=np.int64)
    numbers[has] = 4 * max(1, held) + np.arange(has.sum())
    return numbers


def _find_motion(mesh: BeamElements, origins: Array, held: int) -> tuple[BeamMotion, Array]:
    """Axis and directors of each node as sums of the vectors y, and of all z."""
    of_nodes = _number_vectors(mesh, held)
    n = int(of_nodes.max()) + 1
    L = make_strain_vectors(n, origins)
    rows = _find_rows(mesh, of_nodes, held == 2, n)
    whole = rows @ L
    whole[0, :, 0] += 1.0
    return BeamMotion(rows, L @ make_vectors(n, origins)), whole


def _find_rows(mesh: BeamElements, of_nodes: IntArray, held_twice: bool, n: int) -> Array:
    """Axis (less the first point) and directors of each node as sums of the vectors y."""
    r, d = mesh.nodes
    rows = np.zeros((3, len(r), n - 1))
    rows[0, :, :3] = r - r[0]
    rows[1:, :, :3] = d.swapaxes(0, 1)
    for i, k in np.argwhere(of_nodes >= 0):
        rows[i, k, of_nodes[i, k] - 1] = 1.0
    if held_twice:  # y of the second interface are relative to the first one
        rows[0, -1, 3] = 1.0
        rows[1:, -1, 4:7] = d[-1]
    return rows


def _evaluate(
    mesh: BeamElements, rows: Array, points: Array, surface_of: IntArray, origins: Array
) -> Array:
    """Functions of the basis at points, shape (N, n)."""
    places = mesh.locate(points)
    xi, eta = places.xi[:, None], places.eta[:, None]
    N = mesh.all_functions(places.s)
    found: Array = N @ rows[0] + xi * (N @ rows[1]) + eta * (N @ rows[2])
    for s, origin in enumerate(origins):
        on = surface_of == s
        found[on] = 0.0
        found[on, 4 * s] = 1.0
        found[on, 4 * s + 1 : 4 * s + 4] = points[on] - origin
    # what the sections do not reach, beyond the ends, follows the first directors
    found[:, 1:4] += points - found @ make_vectors(rows.shape[2], origins)
    return found
