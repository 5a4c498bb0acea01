"""Section matrices as windIO's ``elastic_properties``, see `section_properties` for their axes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.foundation.types import Array


def write_section_properties(path: Path, grid: Array, stiffness: Array, inertia: Array) -> None:
    """Write the table that a file has below ``components.blade.structure``.

    Args:
        grid: Span fractions from 0 to 1, shape (m,) [-].
        stiffness: Shape (m, 6, 6) [N, N m, N m^2].
        inertia: About the reference axis, shape (m, 6, 6) [kg/m, kg, kg m].
    """
    K = {f"K{i + 1}{j + 1}": stiffness[:, i, j].tolist() for i in range(6) for j in range(i, 6)}
    M = np.asarray(inertia)
    mass = M[:, 2, 2]
    of = {
        "grid": np.asarray(grid),
        "mass": mass,
        "cm_x": -M[:, 2, 4] / mass,
        "cm_y": M[:, 2, 3] / mass,
        "i_edge": M[:, 3, 3],
        "i_flap": M[:, 4, 4],
        "i_plr": M[:, 5, 5],
        "i_cp": -M[:, 3, 4],
    }
    tables = {
        "elastic_properties": {
            "stiffness_matrix": {"grid": np.asarray(grid).tolist(), **K},
            "inertia_matrix": {key: x.tolist() for key, x in of.items()},
            "structural_damping": {"mu": [0.0] * 6},
        }
    }
    text = yaml.safe_dump(tables, sort_keys=False, default_flow_style=None, width=100)
    replace_file(path, text.encode())
