"""Whether a mesh can be the blades of a turbine, seen from its arrays on one rank.

All mistakes are found together; suspicious values are warnings.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.blade import RotorLayout
from turbine_fenicsx.meshing.block import face_keys
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.meshing.topology import (
    Faces,
    count_coincident_nodes,
    faces_of,
    number_connected_parts,
)

FAR, NEAR = 0.1, 0.01
"""Gap between root and hub in hub radii: an error from the first on, a warning from the second."""

BESIDE, ASKEW = 1.0, 0.5
"""Distance of the middle of a root from the line of its span through the hub centre, in radii of
the root itself: an error, a warning."""

TURNED, BENT = 30.0, 10.0
"""Angle between a blade and its place in degrees: an error, a warning. Precone and prebend of real
blades are below 10 degrees."""

TIP = 0.01
"""Difference of the tip radius from the case in blade lengths that is worth a warning."""


@dataclass(frozen=True)
class Findings:
    """Mistakes and warnings, one sentence each."""

    mistakes: tuple[str, ...]
    warnings: tuple[str, ...]


class Span(Protocol):
    """Where a blade begins and ends."""

    @property
    def hub_radius(self) -> float:
        """Distance of the root from the rotor centre [m]."""

    @property
    def length(self) -> float:
        """From the root to the tip along the span [m]."""


def find_curved_cells(geometry_degree: int, degree: int) -> list[str]:
    """A sentence if displacements of a degree cannot follow the shape of the cells."""
    if geometry_degree <= degree:
        return []
    return [
        f"its cells have degree {geometry_degree}, more than mesh.degree = {degree}, so that a "
        "rigid rotation would store energy"
    ]


def examine_blades(mesh: MeshArrays, layout: RotorLayout, blade: Span) -> Findings:
    """Look at everything that a mesh of blades needs beside valid cells and its groups.

    Args:
        mesh: The mesh, with the volumes blade_1, ... and the surfaces root_1, ...
    """
    mistakes: list[str] = []
    warnings: list[str] = []
    faces = faces_of(mesh.cells, mesh.reference)
    blades = [mesh.volumes[name] for name in layout.volume_groups]
    strangers = int(np.count_nonzero(~np.isin(mesh.cell_groups, blades)))
    if strangers:
        names = ", ".join(layout.volume_groups)
        mistakes.append(f"{strangers} cells belong to none of the groups {names}")
    crowded = int(np.count_nonzero(faces.counts > 2))
    if crowded:
        mistakes.append(f"{crowded} faces belong to more than two cells, so that cells overlap")
    double = _count_double_nodes(mesh)
    fallen = _find_pieces(mesh, faces, layout, double)
    mistakes += fallen
    if double and not fallen:
        warnings.append(f"{double} nodes lie on top of others; cells do not hang together there")
    nodes_of_roots = []
    for k in range(1, layout.n_blades + 1):
        own = mesh.cells[mesh.cell_groups == mesh.volumes[f"blade_{k}"]]
        root = mesh.facets[mesh.facet_groups == mesh.surfaces[f"root_{k}"]]
        nodes_of_roots.append(np.unique(root))
        misplaced = _check_root(mesh, faces, root, k)
        mistakes += misplaced
        if not misplaced:
            at_root = mesh.points[nodes_of_roots[-1]]
            hub = _at_hub(at_root, layout, blade.hub_radius, k)
            place = _in_place(mesh.points[np.unique(own)], layout, blade, k)
            beside = _on_span(at_root, layout, k)
            mistakes += [*hub.mistakes, *place.mistakes]
            warnings += [*hub.warnings, *place.warnings]
            if not place.mistakes:  # a blade that points elsewhere has its root there
                mistakes += beside.mistakes
                warnings += () if place.warnings else beside.warnings
    shared = sum(map(len, nodes_of_roots)) - len(np.unique(np.concatenate(nodes_of_roots)))
    if shared:
        mistakes.append(f"{shared} nodes belong to the roots of two blades")
    return Findings(tuple(mistakes), tuple(warnings))


def _find_pieces(mesh: MeshArrays, faces: Faces, layout: RotorLayout, double: int) -> list[str]:
    """Each blade must be one part, held together by faces."""
    pairs = faces.neighbours
    groups = mesh.cell_groups[pairs]
    part = number_connected_parts(len(mesh.cells), pairs[groups[:, 0] == groups[:, 1]])
    mistakes = []
    for name in layout.volume_groups:
        _, counts = np.unique(part[mesh.cell_groups == mesh.volumes[name]], return_counts=True)
        if len(counts) > 1:
            sizes = ", ".join(str(n) for n in sorted(counts, reverse=True)[:5])
            why = (
                f"{double} nodes of the mesh lie on top of others, merge them (in gmsh: Coherence)"
                if double
                else "expected one"
            )
            mistakes.append(
                f"{name} falls into {len(counts)} parts without a common face, of {sizes}"
                f"{', ...' if len(counts) > 5 else ''} cells; {why}"
            )
    return mistakes


def _count_double_nodes(mesh: MeshArrays) -> int:
    """Number of nodes on top of others, within a millionth of a typical cell."""
    size = np.ptp(mesh.points[mesh.cells[:: 1 + len(mesh.cells) // 1000]], axis=1).max(axis=1)
    return count_coincident_nodes(mesh.points, 1e-6 * float(np.median(size)))


def _check_root(mesh: MeshArrays, faces: Faces, root: IntArray, k: int) -> list[str]:
    """The faces of a root must lie on the surface of the same blade."""
    cells, counts = faces.find(face_keys(root, mesh.reference))
    inner = counts > 1
    others = ~inner & (mesh.cell_groups[cells] != mesh.volumes[f"blade_{k}"])
    mistakes = []
    if others.any():
        mistakes.append(
            f"{np.count_nonzero(others)} faces of the group root_{k} do not lie on blade_{k}"
        )
    if inner.any():
        mistakes.append(
            f"{np.count_nonzero(inner)} faces of the group root_{k} lie inside a body, not on its "
            "surface"
        )
    return mistakes


def _at_hub(points: Array, layout: RotorLayout, radius: float, k: int) -> Findings:
    """The nodes of a root must lie on the hub: on a flat disc, a cylinder, a sphere or between."""
    X = points - np.asarray(layout.centre)
    distance, mean = np.linalg.norm(X, axis=1), X.mean(axis=0)
    towards = mean / max(float(np.linalg.norm(mean)), 1e-300)
    # a flat root may have its nodes anywhere around the span
    heights = np.minimum(X @ towards, X @ layout.frame(k)[0])
    gap = float(np.maximum(heights - radius, radius - distance).max())
    if gap <= NEAR * radius:
        return Findings((), ())
    centre = ", ".join(f"{x:g}" for x in layout.centre)
    sentence = (
        f"root_{k} does not touch the hub: it is {distance.min():.4g} m to {distance.max():.4g} m "
        f"away from the hub centre at ({centre}) m, up to {gap:.3g} m from the hub surface of "
        f"blade.hub_radius = {radius:g} m"
    )
    if distance.mean() > 300.0 * radius:
        sentence += "; coordinates must be in metres"
    return Findings((sentence,), ()) if gap > FAR * radius else Findings((), (sentence,))


def _on_span(points: Array, layout: RotorLayout, k: int) -> Findings:
    """The line of the span through the hub centre meets the root."""
    X = points - np.asarray(layout.centre)
    mean, span = X.mean(axis=0), layout.frame(k)[0]
    size = float(np.linalg.norm(X - mean, axis=1).max())
    aside = mean - (mean @ span) * span
    distance = float(np.linalg.norm(aside))
    if distance <= ASKEW * size:
        return Findings((), ())
    centre, way = (", ".join(f"{x:.3g}" for x in v) for v in (layout.centre, aside + 0.0))
    sentence = (
        f"root_{k} lies {distance:.3g} m beside the line of its span through the hub centre at "
        f"({centre}) m, by ({way}) m; the root itself has a radius of {size:.3g} m"
    )
    return Findings((sentence,), ()) if distance > BESIDE * size else Findings((), (sentence,))


def _in_place(points: Array, layout: RotorLayout, blade: Span, k: int) -> Findings:
    """A blade must point where the rotor has it: fibres and tips follow the rotor."""
    X = points - np.asarray(layout.centre)
    span = layout.frame(k)[0]
    mean = X.mean(axis=0)
    cosine = float(np.clip(mean @ span / max(float(np.linalg.norm(mean)), 1e-300), -1.0, 1.0))
    angle = float(np.degrees(np.arccos(cosine)))
    if angle > BENT:
        direction = ", ".join(f"{x:.3g}" for x in span + 0.0)
        sentence = (
            f"blade_{k} points {angle:.0f} degrees away from ({direction}), the direction of its "
            "span and fibres"
        )
        return Findings((sentence,), ()) if angle > TURNED else Findings((), (sentence,))
    tip, expected = float((X @ span).max()), blade.hub_radius + blade.length
    if abs(tip - expected) <= TIP * blade.length:
        return Findings((), ())
    sentence = (
        f"blade_{k} ends at a radius of {tip:.4g} m, not at blade.hub_radius + blade.length = "
        f"{expected:.4g} m, where the tip is expected"
    )
    return Findings((), (sentence,))
