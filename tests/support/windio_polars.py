"""Polars for the airfoils of the small turbine of windio_files."""

import numpy as np

GRID = np.linspace(-180.0, 180.0, 73)
SLOPES = {"circle": 0.0, "thick": 0.5, "thin": 1.0}
CENTRES = {"circle": 0.5, "thick": 0.3, "thin": 0.25}


def polar_set(scale, configuration="default"):
    """C_l = scale sin(2 alpha), C_d = 0.1 + scale (1 - cos(2 alpha)), C_m = -scale sin/4."""
    alpha = np.radians(GRID)
    values = {
        "cl": scale * np.sin(2.0 * alpha),
        "cd": 0.1 + scale * (1.0 - np.cos(2.0 * alpha)),
        "cm": -0.25 * scale * np.sin(alpha),
    }
    tables = {k: {"grid": GRID.tolist(), "values": v.tolist()} for k, v in values.items()}
    return {"configuration": configuration, "re_sets": [{"re": 1e7, **tables}]}


def add_polars(tables):
    """Give all airfoils of a turbine polars."""
    for airfoil in tables["airfoils"]:
        name = airfoil["name"]
        airfoil["polars"] = [polar_set(SLOPES[name])]
        airfoil["aerodynamic_center"] = CENTRES[name]
    return tables
