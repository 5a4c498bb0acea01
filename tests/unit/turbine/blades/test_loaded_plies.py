"""Claims about the axes of loads in sections."""

import numpy as np
import pytest

from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.turbine.blades.loaded_plies import find_turns


def test_axes_of_sections_turn_with_the_twist_of_the_blade():
    line = BeamLine.straight(10.0, twist=np.pi / 2.0)
    turns = find_turns(line, np.array([0.0, 10.0]))
    assert turns[0] @ [1.0, 2.0, 3.0] == pytest.approx([1.0, 2.0, 3.0], abs=1e-9)
    assert turns[1] @ [1.0, 2.0, 3.0] == pytest.approx([2.0, -1.0, 3.0], abs=1e-9)
