"""Library and input of ROSCO for the NREL 5 MW turbine, for tests."""

import importlib.util
from pathlib import Path

import pytest


def rosco_files():
    """Library and DISCON.IN; skips the test without them."""
    spec = importlib.util.find_spec("rosco")
    for place in [] if spec is None else map(Path, spec.submodule_search_locations):
        library = place / "lib" / "libdiscon.so"
        infile = place.parent / "Examples" / "Test_Cases" / "NREL-5MW" / "DISCON.IN"
        if library.exists() and infile.exists():
            return library, infile
    pytest.skip("rosco with its examples is not installed (pip install --no-deps rosco)")
