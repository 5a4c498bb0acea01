"""Claims about the stations of a tower in a case."""

import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.tower import tower_geometry

STATIONS = {
    "flexible": True,
    "height": 100.0,
    "stations": [0.0, 0.4, 1.0],
    "diameters": [8.0, "7 m", 5.0],
    "walls": ["50 mm", 0.04, 0.03],
}


def test_stations_take_the_place_of_the_cone():
    geometry = tower_geometry(Case.parse({"tower": STATIONS}).tower)
    assert geometry.stations == (0.0, 0.4, 1.0)
    assert geometry.diameters == (8.0, 7.0, 5.0)
    assert geometry.walls == (0.05, 0.04, 0.03)


def test_keys_of_the_cone_have_no_effect_beside_stations():
    case = Case.parse({"tower": {**STATIONS, "wall": 3.0}})
    assert "tower.wall has no effect beside tower.stations" in case.warnings


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"walls": None}, "tower.walls: expected beside tower.stations and tower.diameters"),
        ({"stations": [0.0, 0.4, 0.9]}, "tower.stations = .*begin with 0 and end with 1"),
        ({"stations": [0.0, 1.0, 1.0]}, "tower.stations = .*begin with 0 and end with 1"),
        ({"diameters": [8.0, 7.0]}, "tower.diameters = .*each of the 3 tower.stations, got 2"),
        ({"walls": [0.1, 0.1, 2.5]}, "tower.walls: 2.5 leaves no hollow, expected less than 2.5"),
        ({"walls": [0.1, 0.0, 0.1]}, "tower.walls"),
    ],
)
def test_stations_that_do_not_fit_are_refused(change, sentence):
    table = {key: value for key, value in {**STATIONS, **change}.items() if value is not None}
    with pytest.raises(InputError, match=sentence):
        Case.parse({"tower": table})
