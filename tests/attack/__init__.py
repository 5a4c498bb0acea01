"""Attacks at full size, see `tests.attack.__main__`; the suite of tests repeats them small."""

import sys
from pathlib import Path

# conftest.py and the files of tests/support are modules, as pytest makes them
sys.path += [str(Path(__file__).parents[1]), str(Path(__file__).parents[1] / "support")]
