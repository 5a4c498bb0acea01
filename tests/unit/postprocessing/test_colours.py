"""Scales of colours: their ends, and which parts share one."""

import numpy as np
import pytest

from turbine_fenicsx.postprocessing import colours
from turbine_fenicsx.postprocessing.scene import colour_parts
from turbine_fenicsx.records.parts import Part, Parts

PARTS = Parts(
    (
        Part(1, "hub", "hub", 0),
        Part(2, "blade_1", "blades"),
        Part(3, "blade_2", "blades"),
        Part(5, "tower", "tower"),
    )
)
STRESS = "von_mises_stress"


def test_one_peak_does_not_set_the_scale():
    values = [np.linspace(0.0, 9.0, 1000) for _ in range(20)]
    values[3] = values[3].copy()
    values[3][:5] = 500.0
    assert colours.scale_of(values) == (0.0, 10.0)


def test_field_that_is_zero_nearly_everywhere_has_its_largest_value_as_end():
    values = np.zeros(1000)
    values[7] = 3.7
    assert colours.scale_of([values]) == (0.0, 4.0)
    assert colours.scale_of([np.zeros(5), np.full(3, np.nan)]) == (0.0, 1.0)


def test_colours_darken_from_light_to_dark_and_never_turn_back():
    rgb = np.array([[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in colours.colour_map()])
    light = rgb @ (0.2126, 0.7152, 0.0722)
    assert light[0] > 200 and light[-1] < 30
    assert np.all(np.diff(light) < 0.8)  # rounding to whole numbers


def test_numbers_are_shown_in_the_unit_of_the_legend():
    assert colours.to_scalars(STRESS, np.array([2e6])).tolist() == [2.0]
    assert colours.to_scalars("velocity", np.array([[3.0, 4.0, 0.0]])).tolist() == [5.0]
    assert colours.label(STRESS, "blades") == "von Mises stress\nblades [MPa]"
    assert colours.label("my_field") == "my field"


@pytest.mark.parametrize(
    ("field", "patterns", "common", "groups"),
    [
        (STRESS, [], False, {2: "blades", 3: "blades", 5: "tower"}),
        (STRESS, [], True, {2: "", 3: "", 5: ""}),  # --range
        (STRESS, ["blades"], False, {2: "", 3: ""}),
        (STRESS, ["blade_2", "hub"], False, {3: ""}),
        ("deflection", [], False, {2: "blades", 3: "blades", 5: "tower"}),
        ("displacement", [], False, {1: "", 2: "", 3: "", 5: ""}),
        ("velocity", ["t*"], False, {5: ""}),
        (None, [], False, {}),
    ],
)
def test_stress_has_a_scale_for_each_body(field, patterns, common, groups):
    assert colour_parts(PARTS, field, patterns, common) == groups


def test_pattern_that_fits_nothing_is_an_error():
    with pytest.raises(ValueError, match="no part 'nose', but hub, blade_1, blades, blade_2, tow"):
        colour_parts(PARTS, STRESS, ["nose"], False)
