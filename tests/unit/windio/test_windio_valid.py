"""Files that are written otherwise than those of the reference turbines, and as valid."""

import copy

import numpy as np
import pytest
from windio_files import curve, small_turbine, write_turbine
from windio_polars import add_polars, polar_set

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.meshing.hollow import mesh_hollow
from turbine_fenicsx.meshing.quality import scaled_jacobian
from turbine_fenicsx.wind.windio_blade import make_aero_blade
from turbine_fenicsx.windio import read_turbine


@pytest.fixture
def read(tmp_path):
    """Read the small turbine with its tables changed by a function."""

    def read(change=lambda tables: None, tables=None):
        tables = tables or small_turbine()
        change(tables)
        return read_turbine(write_turbine(tables, tmp_path, "mine.yaml"))

    return read


def test_contours_may_run_along_the_pressure_side_first(read):
    def turn(tables):
        for airfoil in tables["airfoils"]:
            for values in airfoil["coordinates"].values():
                values.reverse()

    a = np.linspace(0.0, 1.0, 41)
    points = [t.blade.surface(np.array([[0.3], [0.8]]), a) for t in (read(), read(turn))]
    assert points[1] == pytest.approx(points[0], abs=1e-12)


def test_a_paint_may_be_incompressible_and_a_thickness_round_off(read):
    def change(tables):
        tables["materials"][0]["nu"] = 0.5
        (core,) = (
            layer
            for layer in tables["components"]["blade"]["structure"]["layers"]
            if layer["name"] == "core"
        )
        core["thickness"]["values"][0] = -1e-20

    turbine = read(change)
    assert turbine.materials["gelcoat"].ply.poisson == (0.5, 0.5, 0.5)
    (core,) = (layer for layer in turbine.blade.layers if layer.name == "core")
    assert core.thickness.values.min() == 0.0
    with pytest.raises(ModelError, match="'gelcoat': material is not positive definite"):
        read(lambda tables: tables["materials"][0].update(nu=1.0))


def test_section_matrices_may_have_diagonals_alone(read):
    def change(tables):
        matrices = tables["components"]["blade"]["structure"]["elastic_properties"]
        for i in range(1, 7):
            for j in range(i + 1, 7):
                del matrices["stiffness_matrix"][f"K{i}{j}"]
        for key in ("cm_x", "cm_y", "i_cp"):
            del matrices["inertia_matrix"][key]

    sections = read(change).blade_sections
    assert sections.stiffness[0].tolist() == np.diag(np.arange(1.0, 7.0) * 1e10).tolist()
    assert sections.inertia[:, 0, 0].tolist() == [100.0, 50.0]
    assert sections.warnings == ()


def test_section_matrices_of_thin_walls_without_shear_are_mended_with_a_warning(read):
    """Files of IEA-10.0-198-RWT and of BAR have K11 = K22 = i_flap = 0 and i_cp = -i_edge."""

    def change(tables):
        matrices = tables["components"]["blade"]["structure"]["elastic_properties"]
        stiffness, inertia = matrices["stiffness_matrix"], matrices["inertia_matrix"]
        for key in stiffness:
            if key[1] in "12" or key[1] != key[2]:
                stiffness[key] = [0.0, 0.0] if key != "grid" else stiffness[key]
        inertia.update(i_flap=[0.0, 0.0], i_plr=[1000.0, 900.0], i_edge=[600.0, 500.0])
        inertia["i_cp"] = [-600.0, -500.0]

    sections = read(change).blade_sections
    assert np.diagonal(sections.stiffness[0])[:3].tolist() == [3e10] * 3
    assert sections.inertia[0, 3:5, 3:5].tolist() == [[600.0, 0.0], [0.0, 400.0]]
    of_shear, of_mass = sections.warnings
    assert "stiffness_matrix: K11 and K22 are zero; K33 takes their place" in of_shear
    assert "inertia_matrix: i_flap is zero, though i_plr is not i_edge; i_plr - i_edge" in of_mass


def twin_cylinders(tables, positions=(0.0, 0.25)):
    """A second cylinder of twice the drag, at span fractions."""
    tables = add_polars(tables)
    (circle,) = (airfoil for airfoil in tables["airfoils"] if airfoil["name"] == "circle")
    twin = {**copy.deepcopy(circle), "name": "rough"}
    for entry in (circle, twin):
        drag = 0.3 if entry is circle else 0.6
        entry["polars"] = [polar_set(0.0)]
        entry["polars"][0]["re_sets"][0]["cd"]["values"] = [drag] * 73
    tables["airfoils"].append(twin)
    shape = tables["components"]["blade"]["outer_shape"]
    shape["rthick"] = curve((0.0, 1.0), (0.3, 1.0), (0.6, 0.4), (1.0, 0.2))
    shape["airfoils"].append({**shape["airfoils"][0], "name": "rough"})
    for name, position in zip(("circle", "rough"), positions, strict=True):
        for used in shape["airfoils"]:
            if used["name"] == name:
                used["spanwise_position"] = position
    return tables


def test_two_airfoils_of_one_thickness_have_their_parts_of_the_span(read):
    turbine = read(tables=twin_cylinders(small_turbine()))
    blade = make_aero_blade(turbine, 1.0 + 20.0 * np.array([0.0, 0.125, 0.25, 0.29]))
    drag = blade.table(np.zeros(4)).drag
    assert drag[:3] == pytest.approx([0.3, 0.45, 0.6], abs=1e-4)  # stations lie inside of the ends
    assert drag[3] == pytest.approx(0.6)


def test_airfoils_of_one_thickness_at_one_place_or_of_two_shapes_are_refused(read):
    turbine = read(tables=twin_cylinders(small_turbine(), (0.1, 0.1)))
    with pytest.raises(ModelError, match=r"'circle' and 'rough', .* its own 'spanwise_position'"):
        make_aero_blade(turbine, [1.0, 20.0])

    def squeeze(tables):
        y = tables["airfoils"][-1]["coordinates"]["y"]
        y[:] = [0.8 * value for value in y]

    with pytest.raises(ModelError, match="same relative thickness 1 and different contours"):
        read(squeeze, twin_cylinders(small_turbine()))


def narrow_edges(tables, width, names):
    """Let the trailing edges of airfoils have a width in chords."""
    for airfoil in tables["airfoils"]:
        if airfoil["name"] in names:
            x, y = (np.array(airfoil["coordinates"][key]) for key in "xy")
            upper = np.arange(len(x)) <= len(x) // 2
            half = np.where(upper, y[0] - 0.5 * width, 0.5 * width - y[0])
            airfoil["coordinates"]["y"] = (y - half * x).tolist()


@pytest.mark.parametrize(
    ("names", "width", "span", "around"),
    [
        (("thick", "thin"), 0.0, 12, 20),
        (("thick", "thin"), 1e-5, 6, 16),
        (("thick", "thin"), 3e-4, 12, 20),
        (("thick", "thin"), 1e-3, 6, 16),
        (("thick",), 0.0, 6, 16),
        (("thick",), 1e-3, 12, 20),
    ],
)
def test_narrow_trailing_edges_are_meshed(read, names, width, span, around):
    blade = read(lambda tables: narrow_edges(tables, width, names)).blade
    block = mesh_hollow(blade, span, around)
    assert scaled_jacobian(block.points, block.cells, block.reference).min() > 1e-3


def test_a_contour_may_begin_at_a_corner_of_its_trailing_edge(read):
    def turn(tables):
        for airfoil in tables["airfoils"][1:]:
            points = airfoil["coordinates"]
            for values in points.values():  # the face runs from the last point to the first
                values.append(values[0])

    plain, turned = (read(change).blade for change in (lambda tables: None, turn))
    s = np.array([0.5, 1.0])
    assert turned.lines(s)[:, 1] == pytest.approx(plain.lines(s)[:, 1], abs=1e-6)
    assert np.all(turned.lines(s)[:, 1] > 1e-3)


def test_a_filler_covers_nothing_where_its_neighbours_overlap(read):
    def widen(tables):
        anchors = {a["name"]: a for a in tables["components"]["blade"]["structure"]["anchors"]}
        anchors["TE_ss"]["end_nd_arc"] = curve((0.0, 0.09), (0.6, 0.09), (1.0, 0.3))

    (core,) = (layer for layer in read(widen).blade.layers if layer.name == "core")
    assert core.share(0.5, 0.1, 0.2) > 0.9
    assert core.share(0.95, 0.0, 1.0) < 1e-12
