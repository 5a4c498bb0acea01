"""Polars of windIO files: read as they are, configurations by weight, mistakes in one sentence."""

import numpy as np
import pytest
from windio_files import small_turbine, write_turbine
from windio_polars import GRID, add_polars, polar_set

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.windio import read_turbine

THICKNESSES = {"circle": 1.0, "thick": 0.4, "thin": 0.2}


def read(folder, change=lambda thin, used: None):
    """Polars of the small turbine after a change of the thin airfoil and of its use."""
    tables = add_polars(small_turbine())
    change(tables["airfoils"][2], tables["components"]["blade"]["outer_shape"]["airfoils"][2])
    return read_turbine(write_turbine(tables, folder)).polars.read(THICKNESSES)


def test_polars_are_those_of_the_file_by_thickness(tmp_path):
    thin, thick, circle = read(tmp_path)
    assert (thin.name, thick.name, circle.name) == ("thin", "thick", "circle")
    assert (thin.aerodynamic_centre, circle.aerodynamic_centre) == (0.25, 0.5)
    assert thin.angle.tolist() == GRID.tolist()
    assert thick.lift == pytest.approx(0.5 * np.sin(2.0 * np.radians(GRID)), abs=1e-15)
    assert thin.drag.min() == 0.1
    assert thin.moment == pytest.approx(-0.25 * np.sin(np.radians(GRID)), abs=1e-15)


def test_sets_of_several_configurations_count_by_their_weights(tmp_path):
    def change(thin, used):
        thin["polars"] = [polar_set(1.0, "rough"), polar_set(2.0, "clean")]
        used |= {"configuration": ["clean", "rough"], "weight": [0.7, 0.3]}

    thin = read(tmp_path, change)[0]
    assert thin.lift == pytest.approx(1.7 * np.sin(2.0 * np.radians(GRID)), abs=1e-14)


def test_columns_may_have_angles_of_their_own(tmp_path):
    def change(thin, used):
        thin["polars"][0]["re_sets"][0]["cm"] = {
            "grid": [-180.0, 2.0, 180.0],
            "values": [0, 0.1, 0],
        }

    thin = read(tmp_path, change)[0]
    assert len(thin.angle) == len(GRID) + 1
    assert thin.moment[np.searchsorted(thin.angle, 2.0)] == 0.1


def _second_reynolds(thin, used):
    thin["polars"][0]["re_sets"] *= 2


def _no_polars(thin, used):
    del thin["polars"]


def _short(thin, used):
    thin["polars"][0]["re_sets"][0]["cd"]["values"].pop()


def _narrow(thin, used):
    thin["polars"][0]["re_sets"][0]["cd"] = {"grid": [-90.0, 90.0], "values": [1.0, 1.0]}


def _falling(thin, used):
    thin["polars"][0]["re_sets"][0]["cl"]["grid"].reverse()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_second_reynolds, r"polars\[0\].re_sets holds polars of 2 Reynolds numbers"),
        (_no_polars, r"airfoils\['thin'\] has no 'polars'"),
        (_short, r"re_sets\[0\].cd has 73 angles, but 72 values"),
        (_narrow, "must have cl, cd and cm over the same range of angles"),
        (_falling, "cl.grid must hold two or more angles that rise"),
        (lambda thin, used: thin.update(polars=[]), "polars must be a list of one or more"),
        (
            lambda thin, used: used.update(configuration=["clean"]),
            "configuration names 'clean', but the polars of the airfoil are of default",
        ),
        (
            lambda thin, used: used.update(configuration=["default"], weight=[0.5]),
            "must have a 'weight' for each configuration, none negative, with the sum 1",
        ),
        (
            lambda thin, used: used.update(configuration=["default"] * 2, weight=[0.5, 0.5]),
            "configuration names one set of polars twice",
        ),
        (
            lambda thin, used: thin["polars"].append(polar_set(1.0, "clean")),
            "has no 'configuration', but its airfoil has polars of several: default, clean",
        ),
    ],
)
def test_mistakes_are_named(tmp_path, change, words):
    with pytest.raises(ModelError, match=words):
        read(tmp_path, change)
