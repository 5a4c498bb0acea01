"""Failed assertions of the shared helpers show their values."""

import importlib
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "demos" / "verification"

pytest.register_assert_rewrite("runs", "beams")


@pytest.fixture(scope="module")
def published():
    """The module that all benchmarks share."""
    sys.path.insert(0, str(FOLDER))
    yield importlib.import_module("published")
    sys.path.remove(str(FOLDER))
