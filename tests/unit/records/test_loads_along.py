"""Claims about tables of loads along a blade."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records.loads_along import COLUMNS, read_loads
from turbine_fenicsx.records.steady_tables import SPAN

HEAD = ",".join([SPAN, *COLUMNS])


def test_a_state_begins_where_places_do_not_rise(tmp_path):
    file = tmp_path / "loads.csv"
    rows = [(0.0, 4.0), (0.5, 2.0), (0.2, 7.0)]
    lines = [f"{span},0,0,{force},0,0,0" for span, force in rows]
    file.write_text("\n".join([HEAD, *lines]) + "\n")
    first, second = read_loads(file)
    assert first.wind is None
    numbers, loads = first.at(np.array([0.1, 0.25, 0.6]))
    assert numbers.tolist() == [0, 1] and loads[:, 2] == pytest.approx([3.6, 3.0])
    numbers, loads = second.at(np.array([0.1, 0.25, 0.6]))
    assert numbers.tolist() == [1] and loads[:, 2].tolist() == [7.0]


def test_a_field_that_is_too_long_is_refused(tmp_path):
    file = tmp_path / "loads.csv"
    file.write_text(HEAD + "\n" + "1" * 200_000 + "\n")
    with pytest.raises(InputError, match="is no table of columns: field larger than"):
        read_loads(file)
