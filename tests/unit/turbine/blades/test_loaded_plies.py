"""Claims about loads in sections: their axes, and the states of a table."""

import numpy as np
import pytest

from turbine_fenicsx.records.loads_along import read_loads
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.turbine.blades.loaded_plies import find_turns

HEAD = "span_[-]," + ",".join(f"section_{x}" for x in ("force_x_[N]", "force_y_[N]", "force_z_[N]"))
HEAD += "," + ",".join(f"section_moment_{x}_[Nm]" for x in "xyz")


def test_axes_of_sections_turn_with_the_twist_of_the_blade():
    line = BeamLine.straight(10.0, twist=np.pi / 2.0)
    turns = find_turns(line, np.array([0.0, 10.0]))
    assert turns[0] @ [1.0, 2.0, 3.0] == pytest.approx([1.0, 2.0, 3.0], abs=1e-9)
    assert turns[1] @ [1.0, 2.0, 3.0] == pytest.approx([2.0, -1.0, 3.0], abs=1e-9)


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
