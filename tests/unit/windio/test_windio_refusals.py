"""Files that are refused: one sentence with the file, the place, the value and what is allowed."""

import copy
from functools import reduce

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from windio_files import at, constant, curve, small_turbine, write_turbine

from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.windio import read_turbine

BLADE = ("components", "blade")
SHAPE = (*BLADE, "outer_shape")
STRUCTURE = (*BLADE, "structure")
LAYERS = (*STRUCTURE, "layers")
ANCHORS = (*STRUCTURE, "anchors")
WEB = (*STRUCTURE, "webs", 0)
TOWER = ("components", "tower")


def put(*path):
    """A change that puts the last of its arguments at a place of the tables."""
    *place, key, value = path

    def change(tables):
        reduce(lambda table, k: table[k], place, tables)[key] = value

    return change


def drop(*path):
    *place, key = path

    def change(tables):
        del reduce(lambda table, k: table[k], place, tables)[key]

    return change


def append(*path):
    *place, value = path

    def change(tables):
        reduce(lambda table, k: table[k], place, tables).append(value)

    return change


def begin_at_the_nose(coordinates):
    """Turn the list of points by half of its length."""
    half = len(coordinates["x"]) // 2
    for values in coordinates.values():
        values[:] = [*values[half:], *values[:half]]


def layer_names():
    return [layer["name"] for layer in reduce(lambda t, k: t[k], LAYERS, small_turbine())]


CORE = layer_names().index("core")
CAP = layer_names().index("cap_ss")
COAT = layer_names().index("coat")

MISTAKES = {
    "version 1 by its keys": (
        put(*BLADE, "outer_shape_bem", {}),
        "the file is of windIO 1, which is not read: convert it with windIO's own",
    ),
    "version 1 by its number": (put("windIO_version", "1.0"), "the file is of windIO 1"),
    "version 3": (put("windIO_version", 3.1), "the file is of windIO 3.1, expected version 2"),
    "no version": (drop("windIO_version"), "the file has no 'windIO_version'"),
    "no blade": (drop(*BLADE), "components has no 'blade'"),
    "no components": (put("components", [1.0]), "components must be a table with the key 'blade'"),
    "empty layers": (put(*LAYERS, []), "layers must have at least one layer"),
    "no materials": (drop("materials"), "the file has no 'materials'"),
    "unknown material": (
        put(*LAYERS, CAP, "material", "wood"),
        "layers['cap_ss'] is of 'wood', which is not among the materials",
    ),
    "unknown web": (
        put(*LAYERS, CAP, "web", "web9"),
        "layers['cap_ss'] belongs to the web 'web9', which is not among the webs",
    ),
    "unknown anchor": (
        put(*LAYERS, CAP, "start_nd_arc", at("nowhere", "start_nd_arc")),
        "start_nd_arc.anchor names the anchor 'nowhere', which does not exist",
    ),
    "anchor of the converter": (
        put(*LAYERS, CAP, "start_nd_arc", at("not_defined", "not_defined")),
        "start_nd_arc.anchor names the anchor 'not_defined': windIO's converter found no place",
    ),
    "wrong handle": (
        put(*LAYERS, CAP, "start_nd_arc", at("cap_ss", "begin")),
        "start_nd_arc.anchor has the handle 'begin', allowed are start_nd_arc, end_nd_arc, mid",
    ),
    "anchor that is not resolved": (
        put(*ANCHORS, 2, {"name": "cap_ss", "width": curve((0.1, 1.0), (0.9, 1.0))}),
        "anchors['cap_ss'] is not resolved: it has no 'start_nd_arc' with grid and values",
    ),
    "anchors in a circle": (
        put(*ANCHORS, 2, "start_nd_arc", at("cap_ss", "start_nd_arc")),
        "refers to itself: 'cap_ss.start_nd_arc to cap_ss.start_nd_arc'",
    ),
    "anchor shorter than its layer": (
        put(*ANCHORS, 2, "start_nd_arc", curve((0.3, 0.22), (0.9, 0.25))),
        "layers['cap_ss'] has a thickness at station 0.1, where the anchor of its start_nd_arc is "
        "not resolved: it reaches from 0.3 to 0.9",
    ),
    "place outside of the contour": (
        put(*ANCHORS, 2, "end_nd_arc", curve((0.1, 0.3), (0.9, 1.2))),
        "end_nd_arc must be between -0.0001 and 1.0001, got 1.2 at station 0.9",
    ),
    "layer that ends before it begins": (
        put(*ANCHORS, 2, "end_nd_arc", curve((0.1, 0.3), (0.9, 0.2))),
        "layers['cap_ss'] begins behind its end at station",
    ),
    "web on one side": (
        put(*ANCHORS, 7, "end_nd_arc", curve((0.1, 0.7), (0.9, 0.3))),
        "webs['web'] lies outside of the section at station 0.9: it must run from the suction side "
        "(0 to 0.5) to the pressure side (to 1), got 0.305 to 0.3",
    ),
    "webs that cross": (
        lambda tables: add_web(tables, 0.2, 0.4, 0.8, 0.6),
        "webs 'web' and 'other' cross at station 0.",
    ),
    "web without layers": (
        lambda tables: tables["components"]["blade"]["structure"]["webs"].append(
            {**copy.deepcopy(tables["components"]["blade"]["structure"]["webs"][0]), "name": "w2"}
        ),
        "webs['w2'] has no layer with a thickness",
    ),
    "wall without a thickness": (
        lambda tables: [
            layer.update(thickness=curve((0.0, 1e-3), (0.6, 1e-3), (0.8, 0.0), (1.0, 0.0)))
            for layer in tables["components"]["blade"]["structure"]["layers"]
            if layer["name"] in ("coat", "outer", "inner")
        ],
        "layers leave the 'front panel, suction side' without a wall at station 0.8",
    ),
    "negative thickness": (
        put(*LAYERS, CORE, "thickness", "values", [0.0, -0.02, 0.0]),
        "layers['core'].thickness must be between 0 and 1, got -0.02 at station 0.3",
    ),
    "thickness in millimetres": (
        put(*LAYERS, COAT, "thickness", constant(12.0)),
        "layers['coat'].thickness must be between 0 and 1, got 12 at station 0",
    ),
    "thickness that varies around the section": (
        put(*LAYERS, COAT, "thickness", "values", [[0.0, 1.0], [1.0, 2.0]]),
        "layers['coat'].thickness.values vary around the section, which is not read",
    ),
    "grid that falls": (
        put(*SHAPE, "chord", "grid", [0.0, 0.7, 0.2]),
        "chord.grid must rise from station to station, 0.7 is followed by 0.2",
    ),
    "grid beyond the tip": (
        put(*SHAPE, "chord", "grid", [0.0, 0.7, 20.0]),
        "chord.grid must lie between 0 and 1, got 0 to 20",
    ),
    "thousands of stations": (
        put(*SHAPE, "chord", curve(*((k / 3000, 1.0) for k in range(3001)))),
        "chord.grid must have at most 2000 stations, got 3001",
    ),
    "thousands of layers": (
        put(*LAYERS, [{}] * 1001),
        "structure.layers must have at most 1000 entries, got 1001",
    ),
    "anchors in a long chain": (
        lambda tables: tables["components"]["blade"]["structure"]["anchors"].extend(
            {"name": f"a{k}", "start_nd_arc": at(f"a{k + 1}" if k < 30 else "TE", "start_nd_arc")}
            for k in range(31)
        ) or put(*LAYERS, CAP, "start_nd_arc", at("a0", "start_nd_arc"))(tables),
        "is reached by more than 20 references, one after the other",
    ),
    "one station": (
        put(*SHAPE, "chord", {"grid": [0.0], "values": [1.0]}),
        "chord.grid must have at least two stations, got 1",
    ),
    "lists of two lengths": (
        put(*SHAPE, "chord", "values", [1.0, 1.0]),
        "chord has 3 stations in its grid, but 2 values",
    ),
    "values that are not finite": (
        put(*SHAPE, "twist", "values", [1.0, float("nan")]),
        "twist.values must hold finite numbers, number 2 is nan",
    ),
    "text for a number": (
        put(*SHAPE, "twist", "values", [1.0, "two"]),
        "twist.values must hold finite numbers, number 2 is 'two'",
    ),
    "half a blade": (
        put(*SHAPE, "chord", curve((0.0, 1.0), (0.5, 1.0))),
        "chord must reach from 0 to 1, got 0 to 0.5",
    ),
    "no chord": (
        put(*SHAPE, "chord", constant(0.0)),
        "chord must be between 0.001 and 50, got 0 at station 0",
    ),
    "axis that turns back": (
        put(*BLADE, "reference_axis", "z", curve((0.0, 0.0), (0.5, 20.0), (1.0, 10.0))),
        "reference_axis.z must rise from the root to the tip, it does not behind station 0.5",
    ),
    "unknown airfoil": (
        put(*SHAPE, "airfoils", 1, "name", "wing"),
        "airfoils names 'wing', which is not among the airfoils of the file",
    ),
    "thickness that no airfoil has": (
        put(*SHAPE, "rthick", curve((0.0, 1.0), (1.0, 0.1))),
        "airfoils have relative thicknesses from 0.2 to 1, but rthick is 0.1 at station 1",
    ),
    "airfoils of one thickness": (
        put("airfoils", 1, "rthick", 0.2),
        "airfoils uses 'thick' and 'thin', which have the same relative thickness 0.2",
    ),
    "airfoil that begins at the leading edge": (
        lambda tables: begin_at_the_nose(tables["airfoils"][1]["coordinates"]),
        "airfoils['thick'].coordinates must run from the trailing edge along one side to the lead",
    ),
    "airfoil of three points": (
        put("airfoils", 1, "coordinates", {"x": [1.0, 0.0, 1.0], "y": [0.1, 0.0, -0.1]}),
        "airfoils['thick'].coordinates need ten points or more that differ, got 3",
    ),
    "airfoil with half its coordinates": (
        lambda tables: tables["airfoils"][1]["coordinates"]["y"].pop(),
        "airfoils['thick'].coordinates have 61 values of x, but 60 of y",
    ),
    "two layers of one name": (
        put(*LAYERS, CAP, "name", "coat"),
        "layers[2] is a second one of the name 'coat'",
    ),
    "nameless layer": (drop(*LAYERS, CAP, "name"), "layers[2] has no 'name'"),
    "unstable material": (
        put("materials", 3, "nu", [1.5, 0.264, 0.35]),
        "materials['uniax'] is no stable material: 'uniax': ",
    ),
    "weightless material": (
        put("materials", 3, "rho", 0.0),
        "materials['uniax'] is no stable material: density of 'uniax' must be positive, got 0",
    ),
    "two of three moduli": (
        put("materials", 3, "E", [1e10, 1e9]),
        "materials['uniax'].E must hold 3 numbers, got 2",
    ),
    "no shear modulus": (
        drop("materials", 3, "G"),
        "materials['uniax'] has no 'G', which an orthotropic material needs",
    ),
    "negative strength": (
        put("materials", 3, "Xc", [-3.7e8, 8.2e7, 0.0]),
        "materials['uniax'].Xc must not be negative, got -3.7e+08",
    ),
    "no hub": (drop("components", "hub"), "components has no 'hub'"),
    "hub without a size": (
        put("components", "hub", "diameter", 0.0),
        "components.hub.diameter must be positive, got 0",
    ),
    "inertia of no body": (
        put("components", "hub", "elastic_properties", "inertia", [1.0, 1.0, 1.0, 3.0, 0.0, 0.0]),
        "elastic_properties.inertia is no inertia of a body: its least principal moment is -2",
    ),
    "five moments": (
        put("components", "hub", "elastic_properties", "inertia", [1.0] * 5),
        "hub.elastic_properties.inertia must hold 3 or 6 numbers, got 5",
    ),
    "tower that leans": (
        put(*TOWER, "reference_axis", "x", curve((0.0, 0.0), (1.0, 1.0))),
        "components.tower.reference_axis must be upright",
    ),
    "tower without a wall": (
        put(*TOWER, "structure", "layers", 0, "thickness", constant(0.0)),
        "tower.structure.layers must be thicker than 0 and thinner than the radius, got 0 m at "
        "station 0",
    ),
    "tower of two materials": (
        append(
            *TOWER, "structure", "layers",
            {"name": "b", "material": "foam", "thickness": constant(0.01)},
        ),
        "tower.structure.layers must be of one material, got 2",
    ),
    "half a blade count": (
        put("assembly", "number_of_blades", 2.5),
        "assembly.number_of_blades must be a whole number, got 2.5",
    ),
    "section matrices with a gap": (
        drop(*STRUCTURE, "elastic_properties", "stiffness_matrix", "K35"),
        "stiffness_matrix has no 'K35'",
    ),
    "endless name": (
        put("name", "x" * 1000),
        "name must be at most 120 characters on one line, got 'xxxx",
    ),
    "no table at all": (lambda tables: tables.clear(), "the file has no 'components'"),
}  # fmt: skip


def add_web(tables, *arcs):
    """Another web, given by its places at 0 and 1, on the suction and on the pressure side."""
    structure = tables["components"]["blade"]["structure"]
    web = copy.deepcopy(structure["webs"][0]) | {"name": "other"}
    web["start_nd_arc"] = curve((0.0, arcs[0]), (1.0, arcs[1]))
    web["end_nd_arc"] = curve((0.0, arcs[2]), (1.0, arcs[3]))
    structure["webs"].append(web)
    mine = next(layer for layer in structure["layers"] if layer["name"] == "web_core")
    structure["layers"].append(copy.deepcopy(mine) | {"name": "other_core", "web": "other"})


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_sentence_a_component(mistake, tmp_path):
    change, sentence = MISTAKES[mistake]
    tables = small_turbine()
    change(tables)
    with pytest.raises(ModelError) as caught:
        read_turbine(write_turbine(tables, tmp_path))
    message = str(caught.value)
    assert sentence in message
    for line in message.splitlines():  # hub, nacelle and yaw share a mistake
        assert line.startswith("small.yaml: ")
        assert len(line) < 400


def places(value, path=()):
    """Paths to all values of nested tables and lists."""
    yield path
    items = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, list)
        else ()
    )
    for key, inner in items:
        yield from places(inner, (*path, key))


PLACES = [place for place in places(small_turbine()) if place]
VALUES = st.one_of(
    st.sampled_from(
        [None, True, "", "text", [], {}, [[]], [None], -1.0, 0.0, 1e-300, 1e300, 2**70, 0.5,
         float("nan"), float("inf"), [0.0, 1.0], [1.0, 0.0], [0.0] * 3, "x" * 1000, "a\nb",
         {"grid": 1}]
    ),
    st.floats(),
    st.floats(-2.0, 2.0),
)  # fmt: skip


@pytest.mark.slow
@settings(
    max_examples=300,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    changes=st.lists(
        st.tuples(st.sampled_from(PLACES), VALUES, st.booleans()), min_size=1, max_size=3
    )
)
def test_a_mutated_file_is_read_or_refused_in_a_sentence_a_component(changes, tmp_path):
    tables = small_turbine()
    for place, value, keep in changes:
        try:
            (put(*place, value) if keep else drop(*place))(tables)
        except (KeyError, IndexError, TypeError):  # gone by a change before
            continue
    try:
        blade = read_turbine(write_turbine(tables, tmp_path)).blade
        s = np.array([0.0, 0.37, 1.0])
        assert np.isfinite(blade.surface(s[:, None], blade.lines(s))).all()
        assert (blade.wall(s[:, None], np.linspace(0.0, 1.0, 7)) >= 0.0).all()
        blade.layup("x", (0.3, 0.4), (0.2, 0.3))
    except InputError as error:
        lines = str(error).splitlines()
        assert all(line.startswith("small.yaml: ") and len(line) < 500 for line in lines)
