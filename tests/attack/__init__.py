"""Attacks at full size, see `tests.attack.__main__`; the suite of tests repeats them small."""

import sys
from pathlib import Path

# the files beside tests/conftest.py are modules, as pytest makes them
sys.path.append(str(Path(__file__).parents[1]))
