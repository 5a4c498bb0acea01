"""Write blades as files of HAWC2, see `turbine_fenicsx.beam_files.hawc2` for its axes.

Matrices are fully populated (``FPM 1``), about the elastic centre and along the axes of bending.
Radii of gyration are about the same axes; their product of inertia, which the format does not have,
is left out.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from turbine_fenicsx.beam_files.beam_blade import BeamBlade
from turbine_fenicsx.beam_files.hawc2 import TURN
from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.foundation.section_matrices import find_to_point
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.reduction.beam_sections import moments_of
from turbine_fenicsx.sections.centres import find_principal_axes, find_tension_centre

BODY = """; {title}: put this body into an htc file, in new_htc_structure
begin main_body;
  name        blade1 ;
  type        timoschenko ;
  nbodies     10 ;
  node_distribution    c2_def ;
  damping_posdef  0.0 0.0 0.0 {damping} ;
  begin timoschenko_input ;
    filename {structure} ;
    FPM 1 ;
    set 1 1 ;
  end timoschenko_input ;
  begin c2_def ;
    nsec {count} ;
{sections}
  end c2_def ;
end main_body ;
"""

HEAD = (
    *("r", "m", "x_cg", "y_cg", "ri_x", "ri_y", "pitch", "x_e", "y_e"),
    *(f"K{i + 1}{j + 1}" for i in range(6) for j in range(i, 6)),
)
"""Columns of a structural file with fully populated matrices."""


def write_hawc2(path: Path, blade: BeamBlade, title: str) -> list[Path]:
    """Write a main body, and the structural file beside it.

    Args:
        path: The body, ``NAME.htc``; the structure is ``NAME_st.dat``.
        title: For the first line of both.

    Returns:
        Both files.
    """
    line, sections = blade.line, blade.sections
    s = np.asarray(sections.stations)
    points, directors = line.at(s)
    X = points @ TURN
    x = -directors[:, 1] @ TURN  # to the leading edge
    twist = np.degrees(np.arctan2(x[:, 1], x[:, 0]))
    rows = [
        f"    sec {k + 1} {_format([*place, angle])} ;"
        for k, (place, angle) in enumerate(zip(X, twist, strict=True))
    ]
    other = path.with_name(f"{path.stem}_st.dat")
    of_y, of_x, of_z = np.asarray(sections.viscosity)[3:]
    text = BODY.format(
        title=title,
        damping=f"{of_x:g} {of_y:g} {of_z:g}",
        structure=f"./{other.name}",
        count=len(s),
        sections="\n".join(rows),
    )
    replace_file(path, text.encode())
    R = np.kron(np.eye(2), TURN)
    table = _tabulate(s, R.T @ sections.stiffness @ R, R.T @ sections.inertia @ R)
    lines = ["1 number of sets", f"#1 {title}", "  ".join(HEAD), f"$1 {len(s)}"]
    replace_file(other, "\n".join([*lines, *map(_format, table), ""]).encode())
    return [path, other]


def _tabulate(s: Array, C: Array, M: Array) -> Array:
    """Rows of a structural file, from matrices about c2_def, shape (m, 30)."""
    compliance = np.linalg.inv(C)
    x, y = np.array([find_tension_centre(S) for S in compliance]).T
    angle = np.array([find_principal_axes(S)[1] for S in compliance])
    # the axes that are nearest to those of the section
    angle = (angle + 0.25 * np.pi) % (0.5 * np.pi) - 0.25 * np.pi
    back = np.linalg.inv(find_to_point(x, y, angle))
    K = back.swapaxes(1, 2) @ C @ back
    A = moments_of(M)
    mass, centre = A[:, 0, 0], A[:, 0, 1:] / A[:, :1, 0]
    c, n = np.cos(angle), np.sin(angle)
    # x' = c (x - x_e) + n (y - y_e) and y' = -n (x - x_e) + c (y - y_e) as sums of 1, x, y
    ways = np.array([[-c * x - n * y, c, n], [n * x - c * y, -n, c]]).transpose(2, 0, 1)
    squares = np.einsum("kai,kij,kaj->ka", ways, A, ways) / mass[:, None]
    radii = np.sqrt(squares[:, ::-1])  # about x' and y'
    i, j = np.triu_indices(6)
    parts = [s, mass, centre, radii, np.degrees(angle), x, y, K[:, i, j]]
    return np.column_stack(parts)


def _format(row: Array | list[float]) -> str:
    return " ".join(f"{value:.12e}" for value in row)
