"""Whether the mesh of the blades has nodes around every aerodynamic station."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing import RotorLayout
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.turbine.case.aero_blade import load_aero_blade
from turbine_fenicsx.turbine.tables.tables import Tables
from turbine_fenicsx.wind.resampling import place_stations

NEEDED = 3
"""Nodes that show how a section moves."""

MIN_STATIONS = 5
"""No case has fewer stations."""


def list_station_mistakes(
    case: Tables, mesh: MeshArrays, layout: RotorLayout, degree: int
) -> list[str]:
    """A sentence if a case in wind has more stations than its mesh has nodes for.

    A station moves with the nodes of the skin between its neighbours.
    """
    if not case.wind.blows:
        return []
    blade = load_aero_blade(case)
    for number in range(1, layout.n_blades + 1):
        nodes = _find_nodes(mesh, layout, number, degree)
        counts = _count_nodes(blade.radius, nodes)
        if np.all(counts >= NEEDED):
            continue
        k, ends = int(np.argmax(counts < NEEDED)), (blade.hub_radius, blade.tip_radius)
        fits = [
            n
            for n in range(MIN_STATIONS, len(blade.radius))
            if np.all(_count_nodes(place_stations(*ends, n)[0], nodes) >= NEEDED)
        ]
        way = f"take at most {fits[-1]}, or a mesh that is" if fits else "take a mesh that is"
        return [
            f"aero.stations = {len(blade.radius)}: station {k + 1} at {blade.radius[k]:.4g} m has "
            f"no {NEEDED} nodes of blade_{number} around it; {way} finer along the span"
        ]
    return []


def check_stations(case: Tables, mesh: MeshArrays, layout: RotorLayout, degree: int) -> None:
    """Refuse a case in wind with more stations than its mesh has nodes for."""
    for sentence in list_station_mistakes(case, mesh, layout, degree):
        raise ModelError(sentence)


def _find_nodes(mesh: MeshArrays, layout: RotorLayout, number: int, degree: int) -> Array:
    """Distances of the nodes of a blade's skin from the rotor centre along its span [m]."""
    facets = mesh.facets[mesh.facet_groups == mesh.surfaces[f"skin_{number}"]]
    z = (mesh.points - np.asarray(layout.centre)) @ layout.frame(number)[0]
    nodes = z[np.unique(facets)]
    if degree > mesh.reference.degree:  # nodes in the middles of straight edges
        edges = np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2)
        nodes = np.concatenate([nodes, z[np.unique(np.sort(edges, axis=1), axis=0)].mean(axis=1)])
    return np.asarray(np.sort(nodes))


def _count_nodes(stations: Array, nodes: Array) -> Array:
    """Number of nodes that have a part of each station, shape (n,).

    Those beyond the ends belong to the first and the last.
    """
    z = np.clip(nodes, stations[0], stations[-1])
    before = np.concatenate([[-np.inf], stations[:-1]])
    after = np.concatenate([stations[1:], [np.inf]])
    counts = z.searchsorted(after, side="left") - z.searchsorted(before, side="right")
    return np.asarray(counts)
