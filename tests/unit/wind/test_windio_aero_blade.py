"""Aerodynamic blades of windIO files: those of IEA 15 MW against its files of AeroDyn."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rosco_blades import iea_blade
from windio_files import IEA_15, IEA_22, constant, curve, load_turbine, small_turbine, write_turbine
from windio_polars import add_polars

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.wind.rotor import Operation, Rotor, find_section_loads
from turbine_fenicsx.wind.windio_blade import make_aero_blade
from turbine_fenicsx.windio import read_turbine

CCBLADE = json.loads((Path(__file__).parent / "ccblade.json").read_text())
IEA_CASES = [name for name in CCBLADE if name.startswith("iea15")]


def small(folder, change=lambda blade, tables: None):
    tables = add_polars(small_turbine())
    change(tables["components"]["blade"], tables)
    return read_turbine(write_turbine(tables, folder))


def test_chord_twist_and_bend_of_iea_15_are_those_of_its_aerodyn_file():
    expected = iea_blade()
    blade = make_aero_blade(load_turbine(IEA_15), expected.radius)
    assert blade.tip_radius == pytest.approx(expected.tip_radius, abs=1e-4)
    assert blade.chord == pytest.approx(expected.chord, abs=5e-4)
    assert blade.twist == pytest.approx(expected.twist, abs=1e-6)
    # AeroDyn's column is the bend of the aerodynamic centre, which lies on the twisted chord
    assert blade.prebend[-1] == pytest.approx(expected.prebend[-1], abs=2e-3)


@pytest.mark.parametrize("case", IEA_CASES)
def test_line_loads_differ_from_ccblade_only_by_the_polars(case):
    # The files of AeroDyn hold polars corrected for stall of turning blades, which act inboard,
    # and interpolated by splines over the thickness; windIO's are those of the airfoils.
    given, reference = CCBLADE[case], iea_blade()
    own = replace(make_aero_blade(load_turbine(IEA_15), reference.radius), prebend=None)
    operation = Operation(
        given["wind_speed"], given["rotor_speed_rad_s"], np.radians(given["pitch_deg"])
    )
    expected = np.array(given["normal_N_per_m"])
    outer = own.radius > 0.4 * own.tip_radius
    for blade, everywhere, outside in (
        (replace(own, polars=reference.polars), 1e-4, 1e-4),
        (own, 0.05, 0.01),
    ):
        found = find_section_loads(Rotor(blade), operation, np.zeros(1)).normal[0]
        error = (np.abs(found - expected) / np.max(expected))[:-1]  # the tip's loss is infinite
        assert np.max(error) <= everywhere
        assert np.max(error[outer[:-1]]) <= outside


def test_iea_22_with_its_ends_that_nearly_close_is_read():
    turbine = load_turbine(IEA_22)
    blade = make_aero_blade(turbine, np.linspace(turbine.hub.radius, 142.0, 30))
    assert blade.tip_radius == pytest.approx(142.0)
    assert blade.prebend[-1] == pytest.approx(-7.0, abs=0.5)
    thin = turbine.polars.read({a.name: a.thickness for a in _airfoils(turbine)})[0]
    found = blade.table(np.radians(np.full(30, 5.0)))
    expected = np.interp(5.0, thin.angle, thin.lift)
    assert found.lift[-1] == pytest.approx(expected, rel=1e-12)


def _airfoils(turbine):
    return turbine.blade.outer_shape.sections.airfoils


def test_polars_are_linear_in_thickness(tmp_path):
    # rthick falls from 0.4 at a quarter of the span to 0.2 at the tip: slopes 0.5 and 1
    turbine = small(tmp_path)
    radius = 1.0 + 20.0 * np.array([0.0, 0.25, 0.6, 0.8, 1.0])
    blade = make_aero_blade(turbine, radius)
    thickness = turbine.blade.outer_shape.thickness.smooth((blade.radius - 1.0) / 20.0)
    slope = np.interp(thickness, [0.2, 0.4, 1.0], [1.0, 0.5, 0.0])
    found = blade.table(np.full(5, np.radians(10.0)))
    assert found.lift == pytest.approx(slope * np.sin(np.radians(20.0)), abs=1e-12)
    centre = np.interp(thickness, [0.2, 0.4, 1.0], [0.25, 0.3, 0.5])
    assert blade.aerodynamic_centre == pytest.approx(centre, rel=1e-12)


def test_the_reference_is_where_the_chord_crosses_the_span(tmp_path):
    def change(blade, tables):
        blade["outer_shape"] |= {"section_offset_x": constant(0.1), "twist": constant(20.0)}
        blade["reference_axis"]["y"] = curve((0.0, 0.0), (1.0, 0.5))

    blade = make_aero_blade(small(tmp_path, change), [11.0, 16.0])
    shape = small(tmp_path, change).blade.outer_shape
    s = np.array([0.5, 0.75])
    x, y = shape.reference_points(s)[:, :2].T
    c, sin = np.cos(np.radians(20.0)), np.sin(np.radians(20.0))
    # the leading edge, and from there along the chord
    edge = np.stack([x + 0.1 * c - shape.offset_y.smooth(s) * sin, y - 0.1 * sin])
    edge[1] -= shape.offset_y.smooth(s) * c
    along = blade.reference * shape.chord.smooth(s)
    assert edge[1] + along * c == pytest.approx(0.0, abs=1e-12)
    assert edge[0] + along * sin == pytest.approx(blade.prebend, rel=1e-12)


def test_a_blade_of_one_airfoil_has_its_polar_everywhere(tmp_path):
    def change(blade, tables):
        blade["outer_shape"] |= {"rthick": constant(0.2)}
        blade["outer_shape"]["airfoils"] = [{"name": "thin", "spanwise_position": 0.0}]

    blade = make_aero_blade(small(tmp_path, change), [3.0, 9.0])
    assert blade.table(np.full(2, np.radians(45.0))).lift == pytest.approx(1.0)


def _open_circle(blade, tables):
    tables["airfoils"][2]["polars"][0]["re_sets"][0]["cl"]["values"][0] = 0.5


@pytest.mark.parametrize(
    ("radius", "change", "words"),
    [
        ([0.5, 20.0], lambda blade, tables: None, "between 1 and 21 m"),
        ([2.0, 22.0], lambda blade, tables: None, "between 1 and 21 m"),
        ([2.0], lambda blade, tables: None, "must be two or more between"),
        ([2.0, 9.0], _open_circle, "small.yaml: lift of polar 'thin' must be the same at -180"),
        (
            [2.0, 9.0],
            lambda blade, tables: blade["outer_shape"].update(twist=constant(70.0)),
            "twist must be below 60 degrees for aerodynamics, got 70",
        ),
    ],
)
def test_mistakes_are_named(tmp_path, radius, change, words):
    with pytest.raises(ModelError, match=words):
        make_aero_blade(small(tmp_path, change), radius)
