"""ElastoDyn's tower file: mass and bending stiffness along the height.

The file says nothing of torsion, stretch and shear. They are taken as those of a thin tube of steel
with this mass and bending stiffness: A = m/rho, EA = E A, GA/2 for shear, and GJ = 2 G I for the
mean of both I. Axes are x downwind, y = z x x and z up.
"""

from __future__ import annotations

import os

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.keyed_text import KeyedText
from turbine_fenicsx.foundation.section_matrices import place_inertia
from turbine_fenicsx.reduction.beam_sections import BeamSections

STEEL = {"E": 210e9, "G": 80.8e9, "rho": 7850.0}
"""Moduli [Pa] and density [kg/m^3] of steel."""

FACTORS = ("AdjTwMa", "AdjFASt", "AdjSSSt")
"""Factors of mass and of stiffness fore and aft, and to the sides."""


def read_elastodyn_tower(path: str | os.PathLike[str], height: float) -> BeamSections:
    """Sections of a tower file.

    Args:
        path: A tower file of ElastoDyn.
        height: Of the flexible tower [m].

    Raises:
        InputError: with the line, if it is none or wrong.
        FileError: if it cannot be read.
    """
    text = KeyedText.read(path, "ElastoDyn (tower)")
    count, first = text.find_count("NTwInpSt")
    factors = []
    for key in FACTORS:
        found = text.find(key)
        factors.append(1.0 if found is None else text.read_numbers(found[1], 1)[0])
    heading = next(
        (k for k in range(first, len(text.lines)) if text.lines[k].split()[:1] == ["HtFract"]), None
    )
    if heading is None:
        raise InputError(f"{text.path} is no file of {text.what}: it has no HtFract")
    table = text.read_table(heading + 1, count, 4)
    fraction, mass, fore_aft, side_side = table[:, :4].T
    mass, fore_aft, side_side = (
        factor * x for factor, x in zip(factors, (mass, fore_aft, side_side), strict=True)
    )
    if np.any(np.diff(fraction) <= 0.0) or (fraction[0], fraction[-1]) != (0.0, 1.0):
        raise InputError(f"{text.path}: HtFract must rise from 0 to 1")
    for k in np.flatnonzero(np.min([mass, fore_aft, side_side], axis=0) <= 0.0):
        raise InputError(
            f"{text.path}: mass and stiffness must be positive, they are not at HtFract = "
            f"{fraction[k]:g}"
        )
    area, mean = mass / STEEL["rho"], 0.5 * (fore_aft + side_side) / STEEL["E"]
    E, G = STEEL["E"], STEEL["G"]
    entries = (0.5 * G * area, 0.5 * G * area, E * area, side_side, fore_aft, 2.0 * G * mean)
    stiffness = np.array(entries).T[:, :, None] * np.eye(6)
    squares = np.column_stack([side_side, fore_aft]) / (E * area)[:, None]
    inertia = place_inertia(mass, np.zeros((count, 2)), squares, np.zeros(count))
    return BeamSections(fraction * height, stiffness, inertia)
