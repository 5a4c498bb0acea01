"""Warnings about files: what disagrees in them, what is left out, angles in radians."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, radians
from pathlib import Path

import numpy as np

from turbine_fenicsx.turbine.case.beam_file import load_beam
from turbine_fenicsx.turbine.case.comparisons import compare_file
from turbine_fenicsx.turbine.tables.tables import Tables

_LEAST_TWIST = radians(1.0)
"""Blades with less twist are rare: a file of degrees may hold radians [rad]."""

_SAME_HEIGHT = 0.05
"""Relative difference of hub heights that are the same."""

_SAME_DENSITY = 1e-3
"""Relative difference of densities that are the same."""


def doubt_files(case: Tables) -> Iterator[str]:
    """Sentences about ``turbine.file``, ``wind.file`` and ``aero.file``."""
    if case.turbine.file is not None:
        from turbine_fenicsx.turbine.case.turbine_file import load_turbine

        turbine = load_turbine(case.turbine.file)
        yield from turbine.blade.warnings
        yield from compare_file(case)
        if case.has_beam_blades and case.blade.beam.file is None and turbine.blade_sections:
            yield from turbine.blade_sections.warnings
    if case.blade.beam.file is not None and case.has_beam_blades:
        yield from load_beam(case.blade.beam.file).warnings
    if case.wind.file is not None and case.wind.table is None:
        yield from _doubt_height(case, case.wind.file)
    if not case.wind.blows or case.aero.file is None:
        return
    from turbine_fenicsx.turbine.case.aero_blade import find_aero_file, load_aero_blade
    from turbine_fenicsx.turbine.tables.named_files import is_windio

    path, aero = find_aero_file(case), load_aero_blade(case)
    yield from _doubt_twist(float(np.abs(aero.twist).max()), path)
    if not is_windio(path):
        yield from _doubt_settings(case, path)


def _doubt_height(case: Tables, path: str) -> Iterator[str]:
    """Turbulence has its mean wind at the height of the hub."""
    from turbine_fenicsx.wind.turbsim import read_turbsim_height

    height = read_turbsim_height(path)
    if abs(height - case.hub_height) > _SAME_HEIGHT * case.hub_height:
        yield (
            f"{Path(path).name} has its mean wind at a hub height of {height:.4g} m, the rotor "
            f"centre is at {case.hub_height:.4g} m"
        )


def _doubt_twist(largest: float, path: str) -> Iterator[str]:
    """Twist is in degrees."""
    if 0.0 < largest < _LEAST_TWIST:
        yield (
            f"the largest twist in {Path(path).name} is {degrees(largest):.3g} degrees; does the "
            "file hold radians? Its twist is read in degrees"
        )


def _doubt_settings(case: Tables, path: str) -> Iterator[str]:
    """Settings of AeroDyn's primary file that differ from what the case does."""
    from turbine_fenicsx.foundation.keyed_text import KeyedText
    from turbine_fenicsx.wind.aerodyn_files import read_setting

    text = KeyedText.read(path)
    differ = [
        f"{key} = {value}"
        for key, same in _list_settings(case).items()
        if (value := read_setting(text, key)) is not None and value not in same
    ]
    density = read_setting(text, "AirDens")
    if density is not None and density != "default":
        differ += _compare_density(density, case.wind.density)
    if differ:
        yield (
            f"{Path(path).name} sets {', '.join(differ)}; only blades and polars are read of it, "
            "models and air are those of [aero] and [wind]"
        )


def _list_settings(case: Tables) -> dict[str, tuple[str, ...]]:
    """AeroDyn's settings, and those of their values that are what the case does."""
    aero = case.aero
    wake = ("1", "2") if aero.induction else ("0",)
    unsteady = aero.unsteady or aero.dynamic_stall == "oeye"
    shadow = aero.tower_shadow
    yes, no = ("true", "default"), ("false", "default")
    return {
        **dict.fromkeys(("Wake_Mod", "WakeMod"), wake),
        "TwrPotent": ("0",) if shadow == "none" else ("1", "2"),
        "TwrShadow": ("1", "true") if shadow == "powles" else ("0", "false"),
        "Skew_Mod": ("1",) if aero.skewed_wake else ("0", "default"),
        "SkewMod": ("2",) if aero.skewed_wake else ("1",),
        "UA_Mod": ("2", "3", "4", "5") if unsteady else ("0", "1"),
        "AFAeroMod": ("2",) if unsteady else ("1",),
        **dict.fromkeys(("TipLoss", "HubLoss", "TanInd", "AIDrag", "TIDrag"), yes),
        **dict.fromkeys(("TwrAero", "FrozenWake", "CavitCheck", "Buoyancy", "NacelleDrag"), no),
    }


def _compare_density(text: str, density: float) -> list[str]:
    """The file's density of the air if it is another one."""
    try:
        given = float(text.replace("d", "e"))
    except ValueError:
        return [f"AirDens = {text}"]
    return [] if abs(given - density) <= _SAME_DENSITY * density else [f"AirDens = {given:g}"]
