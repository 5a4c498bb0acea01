"""The demos of the paper, and the sentences about a case with mistakes, for tests."""

from pathlib import Path

import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.case.case import Case

DEMOS = Path(__file__).parents[2] / "demos" / "paper"


def mistakes(data):
    """The sentences about a case given as nested tables."""
    with pytest.raises(InputError) as error:
        Case.parse(data)
    return str(error.value).splitlines()
