"""Anchors of windIO files that follow from widths and offsets."""

import numpy as np
import pytest
from windio_files import (
    IEA_15,
    constant,
    curve,
    find_turbine,
    load_yaml,
    small_turbine,
    write_turbine,
)

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.windio import read_turbine

S = np.linspace(0.1, 0.9, 9)


@pytest.fixture
def read(tmp_path):
    """Read the small turbine with its anchors changed by a function."""

    def read(change):
        tables = small_turbine()
        anchors = {a["name"]: a for a in tables["components"]["blade"]["structure"]["anchors"]}
        change(anchors)
        return read_turbine(write_turbine(tables, tmp_path, "mine.yaml")).blade

    return read


def band(blade, name):
    """Start, end and length in metres of a layer at stations."""
    (layer,) = (layer for layer in blade.layers if layer.name == name)
    start, end = layer.start(S), layer.end(S)
    return start, end, (end - start) * blade.outer_shape.girth(S)


def width(value, *handles):
    return {**constant(value), "defines": list(handles)}


def test_the_girth_is_the_length_around_the_surface(read):
    blade = read(lambda anchors: None)
    fine = np.linspace(0.0, 1.0, 4001)
    points = blade.surface(np.full((1, 1), 0.4), fine)[0]
    around = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert blade.outer_shape.girth(np.array([0.4]))[0] == pytest.approx(around, rel=1e-3)


@pytest.mark.parametrize("handle", ["end_nd_arc", "start_nd_arc"])
def test_a_width_places_the_end_that_it_defines(read, handle):
    plain = read(lambda anchors: None)

    def change(anchors):
        del anchors["LE_band"][handle]
        anchors["LE_band"]["width"] = width(0.2, handle)

    blade = read(change)
    start, end, length = band(blade, "nose")
    kept, other = (start, end) if handle == "end_nd_arc" else (end, start)
    expected = band(plain, "nose")[0 if handle == "end_nd_arc" else 1]
    assert kept == pytest.approx(expected, abs=1e-12)
    assert np.all(other != expected)
    assert length == pytest.approx(0.2, rel=1e-3)
    assert not blade.warnings


def test_a_width_spreads_both_ends_about_the_middle(read):
    def change(anchors):
        anchors["LE_band"] |= {"midpoint_nd_arc": constant(0.5), "width": width(0.3)}
        del anchors["LE_band"]["width"]["defines"]
        del anchors["LE_band"]["start_nd_arc"], anchors["LE_band"]["end_nd_arc"]

    start, end, length = band(read(change), "nose")
    assert 0.5 * (start + end) == pytest.approx(0.5, abs=1e-12)
    assert length == pytest.approx(0.3, rel=1e-3)


@pytest.mark.parametrize("key", ["offset_arc", "offset_nd_arc"])
def test_an_offset_places_an_anchor_beside_another(read, key):
    def change(anchors):
        del anchors["LE_band"]["end_nd_arc"]
        other = {"name": "LE", "handle": "start_nd_arc"}
        anchors["LE_band"][key] = {**constant(0.08), "defines": "end_nd_arc", "anchor": other}

    blade = read(change)
    _, end, _ = band(blade, "nose")
    unit = blade.outer_shape.girth(S) if key == "offset_arc" else 1.0
    assert (end - 0.5) * unit == pytest.approx(0.08, rel=1e-3)


def test_a_width_that_disagrees_with_both_ends_warns_of_the_largest_difference(read):
    def change(anchors):
        anchors["LE_band"]["width"] = curve((0.0, 0.3), (1.0, 0.3))
        anchors["LE_band"]["width"]["defines"] = ["start_nd_arc", "end_nd_arc"]

    (sentence,) = read(change).warnings
    assert "anchors['LE_band'] has a width of 0.3 m, but its start and end, which are" in sentence


def test_a_width_counts_where_the_end_only_holds_a_place(read):
    """Published files have 1 for ends that follow from a width."""

    def change(anchors):
        anchors["TE_ss"] |= {"end_nd_arc": constant(1.0), "width": width(0.2, "end_nd_arc")}

    blade = read(change)
    start, _, length = band(blade, "te_ss")
    assert start == pytest.approx(0.0, abs=1e-12)
    assert length == pytest.approx(0.2, rel=1e-3)
    (sentence,) = blade.warnings
    assert "anchors['TE_ss'] has a width of 0.2 m, which is used, but its given start" in sentence


def test_doubling_a_width_of_a_published_turbine_warns(tmp_path):
    tables = load_yaml(find_turbine(IEA_15))
    assert not read_turbine(find_turbine(IEA_15)).blade.warnings
    for anchor in tables["components"]["blade"]["structure"]["anchors"]:
        if anchor["name"] == "Spar_Cap_SS":
            anchor["width"]["values"] = [2.0 * x for x in anchor["width"]["values"]]
    blade = read_turbine(write_turbine(tables, tmp_path, "mine.yaml")).blade
    (sentence,) = blade.warnings
    assert "Spar_Cap_SS" in sentence


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"width": constant(-1.0)}, "must be between 0 and 100, got -1"),
        ({"width": {**constant(0.1), "defines": ["middle"]}}, "must name start_nd_arc or end_nd"),
        ({}, "is not resolved: it has no 'end_nd_arc'"),
    ],
)
def test_places_that_do_not_follow_are_refused(read, changes, words):
    def change(anchors):
        del anchors["LE_band"]["end_nd_arc"]
        anchors["LE_band"].update(changes)

    with pytest.raises(ModelError, match=words):
        read(change)


def test_parts_of_a_blade_that_are_left_out_are_told(tmp_path):
    tables = small_turbine()
    structure = tables["components"]["blade"]["structure"]
    structure["webs"][0]["flanges"] = [{"side": "suction"}]
    structure["joint"] = {"position": 0.5, "mass": 900.0, "cost": 1.0}
    found = read_turbine(write_turbine(tables, tmp_path, "mine.yaml")).blade.warnings
    assert [w.split(" left out")[0] for w in found] == [
        "mine.yaml: flanges of components.blade.structure.webs['web'] are",
        "mine.yaml: components.blade.structure.joint of 900 kg is",
    ]
