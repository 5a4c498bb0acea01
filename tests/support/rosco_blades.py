"""Blades of two reference turbines, from the files of AeroDyn that the package rosco brings."""

import importlib.util
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from turbine_fenicsx.wind.aerodyn_files import read_aerodyn_blade, read_aerodyn_polar

NREL_POLARS = (
    *("Cylinder1", "Cylinder2", "DU40_A17", "DU35_A17"),
    *("DU30_A17", "DU25_A17", "DU21_A17", "NACA64_A17"),
)


def folder():
    """Where the examples of rosco are; skips the test without them."""
    spec = importlib.util.find_spec("rosco")
    places = [] if spec is None else [Path(p) for p in spec.submodule_search_locations]
    for place in places:
        cases = place.parent / "Examples" / "Test_Cases"
        if cases.is_dir():
            return cases
    pytest.skip("rosco with its examples is not installed (pip install --no-deps rosco)")


@cache
def nrel_blade():
    cases = folder() / "NREL-5MW"
    polars = [read_aerodyn_polar(cases / "Airfoils" / f"{name}.dat") for name in NREL_POLARS]
    return read_aerodyn_blade(cases / "NRELOffshrBsline5MW_AeroDyn_blade.dat", 1.5, polars)


@cache
def iea_blade():
    cases = folder() / "IEA-15-240-RWT" / "IEA-15-240-RWT"
    name = "IEA-15-240-RWT_AeroDyn15"
    polars = [
        read_aerodyn_polar(cases / "Airfoils" / f"{name}_Polar_{k:02d}.dat") for k in range(50)
    ]
    return read_aerodyn_blade(cases / f"{name}_blade.dat", 3.97, polars)


def without_moments(blade):
    """A blade as CCBlade and tables made with it have it: sections have lift and drag alone."""
    found = {id(p): replace(p, moment=0.0 * p.moment) for p in blade.polars}
    return replace(blade, polars=tuple(found[id(p)] for p in blade.polars))
