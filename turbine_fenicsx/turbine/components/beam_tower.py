"""The tower as a beam: section matrices of a tube.

With the outer radius R, the inner one r, m = r/R and Poisson's ratio nu, the tube has

    A = pi (R^2 - r^2),    I = pi/4 (R^4 - r^4),    J = 2 I,
    k = 6 (1 + nu) (1 + m^2)^2/((7 + 6 nu) (1 + m^2)^2 + (20 + 12 nu) m^2),

with the shear coefficient k of G. R. Cowper, J. Appl. Mech. 33 (1966) 335-340.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.beam_files.elastodyn import read_elastodyn_tower
from turbine_fenicsx.bodies.beam_basis import BeamBasis
from turbine_fenicsx.bodies.carrier import Carrier
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.rotations import E1, E2, E3
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing import TowerGeometry
from turbine_fenicsx.reduction.beam_basis import beam_basis
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.reduction.beam_sections import BeamSections
from turbine_fenicsx.turbine.tables.tower import TowerCase

Facets = npt.NDArray[np.int32]

BETWEEN = 10
"""Stations between those of the tower: stiffness falls with the fourth power of the diameter."""


def make_tower_basis(
    tower: TowerCase, geometry: TowerGeometry, carrier: Carrier, foot: Facets, head: Facets
) -> BeamBasis:
    """The basis of the tower between ground and yaw bearing. Collective."""
    ends = np.outer([-geometry.height, 0.0], E2)
    directors = np.broadcast_to([E3, E1], (2, 2, 3))
    line, b = BeamLine(np.array([0.0, 1.0]), ends, np.array(directors)), tower.beam
    sections = on_rank0(carrier.mesh.comm, lambda: find_sections(tower, geometry))
    return beam_basis(carrier, line, sections, b.elements, b.degree, foot, head, hold=b.hold)


def find_sections(tower: TowerCase, geometry: TowerGeometry) -> BeamSections:
    """Stiffness and mass along the height: of a file, or of the tube."""
    if tower.beam.file is not None:
        return read_elastodyn_tower(tower.beam.file, geometry.height)
    return tube_sections(tower, geometry)


def tube_sections(tower: TowerCase, geometry: TowerGeometry) -> BeamSections:
    """Stiffness and mass of a tube along its height."""
    own = np.asarray(geometry.stations)
    parts = np.arange(BETWEEN) / BETWEEN
    s = np.append((own[:-1, None] + np.diff(own)[:, None] * parts).ravel(), own[-1])
    diameter, wall = (np.interp(s, own, x) for x in (geometry.diameters, geometry.walls))
    R, nu = 0.5 * diameter, tower.poisson
    r = R - wall
    A, I2 = np.pi * (R**2 - r**2), 0.25 * np.pi * (R**4 - r**4)
    m2 = (r / R) ** 2
    k = 6.0 * (1.0 + nu) * (1.0 + m2) ** 2
    k = k / ((7.0 + 6.0 * nu) * (1.0 + m2) ** 2 + (20.0 + 12.0 * nu) * m2)
    E, G = tower.young, 0.5 * tower.young / (1.0 + nu)
    stiffness = _diagonals(G * k * A, G * k * A, E * A, E * I2, E * I2, 2.0 * G * I2)
    inertia = tower.density * _diagonals(A, A, A, I2, I2, 2.0 * I2)
    return BeamSections(s * geometry.height, stiffness, inertia)


def _diagonals(*entries: Array) -> Array:
    """Diagonal matrices of their entries, shape (m, 6, 6)."""
    return np.asarray(np.array(entries).T[:, :, None] * np.eye(6))
