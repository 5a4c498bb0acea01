"""Steady states as files: numbers over the wind speed, values along a blade, and both in YAML.

The YAML file has the layout of the published steady states of the IEA 22 MW turbine.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import yaml

from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.records.number_tables import read_columns
from turbine_fenicsx.records.row_file import write_table

WIND, SPAN = names.WIND_SPEED, "span_[-]"
"""Columns of the wind speed, and of the place as a fraction of the length of the blade."""

STEADY, BLADE, LAYOUT = "steady.csv", "steady_blade.csv", "steady.yaml"
"""Names of the files."""

_INTEGRATED = {
    "mechanical_power": names.AERO_POWER,
    "electrical_power": "electrical_power_[W]",
    "generator_torque": names.AERO_TORQUE,
    "rotor_thrust": names.AERO_THRUST,
    "rotor_torque": names.AERO_TORQUE,
}
_DISTRIBUTED = {
    "aero_force_axial": "force_x_[N/m]",
    "aero_force_tangential": "force_y_[N/m]",
    **{f"blade_translation_deflection_{x}_pitching": f"deflection_{x}_[m]" for x in "xyz"},
    **{f"blade_rotation_deflection_{x}_pitching": f"rotation_{x}_[deg]" for x in "xyz"},
}
"""Names of the layout, and columns of the tables."""

Numbers = Mapping[str, float]
Along = Mapping[str, Array]


def write_steady(folder: Path, states: Sequence[tuple[Numbers, Along]]) -> list[str]:
    """Write steady states, one or more; the names of the files."""
    numbers = [dict(numbers) for numbers, _ in states]
    along = [
        {WIND: of_wind[WIND], **{name: x[k] for name, x in values.items()}}
        for of_wind, values in states
        for k in range(len(values[SPAN]))
    ]
    for name, rows in ((STEADY, numbers), (BLADE, along)):
        write_table(folder / name, [*rows[0]], ([f"{x:.9g}" for x in r.values()] for r in rows))
    text = yaml.safe_dump([_lay_out(*state) for state in states], sort_keys=False)
    replace_file(folder / LAYOUT, text.encode())
    return [STEADY, BLADE, LAYOUT]


def _lay_out(numbers: Numbers, along: Along) -> dict[str, object]:
    """A steady state in the layout of the published ones."""
    grid = [float(x) for x in along[SPAN]]
    return {
        "configuration": {
            "wind_speed": float(numbers[WIND]),
            "rotor_speed": float(numbers[names.ROTOR_SPEED]),
            "pitch": float(numbers[names.PITCH]),
            "tip_speed_ratio": float(numbers["tip_speed_ratio_[-]"]),
        },
        "outputs": {
            "integrated": {name: float(numbers[key]) for name, key in _INTEGRATED.items()},
            "distributed": {
                name: {"grid": grid, "values": [float(x) for x in along[key]]}
                for name, key in _DISTRIBUTED.items()
            },
        },
    }


def read_steady(path: str | os.PathLike[str]) -> dict[str, Array]:
    """Columns of a table of steady states, or of published ones with the same names.

    Raises:
        InputError: if it has no column of the wind speed, or something else than numbers.
    """
    return read_columns(path, "table of steady states", (WIND,))
