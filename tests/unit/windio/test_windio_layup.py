"""Layup of blades of windIO files: mass of layers, order, angles, strengths."""

from itertools import pairwise
from math import inf, radians

import numpy as np
import pytest
from scipy.integrate import trapezoid
from windio_files import (
    IEA_15,
    IEA_22,
    find_turbine,
    load_turbine,
    load_yaml,
    small_turbine,
    write_turbine,
)

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.windio import read_turbine


def quads(points):
    """Areas of a grid of quadrilaterals, (m, n), from its points, (m + 1, n + 1, 3)."""
    one, other = points[1:, 1:] - points[:-1, :-1], points[1:, :-1] - points[:-1, 1:]
    return 0.5 * np.linalg.norm(np.cross(one, other), axis=-1)


def at_stations(curve, s):
    grid, values = (np.array(curve[key], float) for key in ("grid", "values"))
    there = (s >= grid[0] - 1e-9) & (s <= grid[-1] + 1e-9)
    return np.where(there, np.interp(s, grid, values), 0.0)


def masses_of_the_file(file, blade):
    """Mass of each material from the file's layers and anchors and the areas of shell and webs."""
    structure = file["components"]["blade"]["structure"]
    anchors = {a["name"]: a for a in structure["anchors"]}
    density = {m["name"]: float(m["rho"]) for m in file["materials"]}
    s, a = np.linspace(0.0, 1.0, 401), np.linspace(0.0, 1.0, 2001)
    shell = quads(blade.surface(s[:, None], a))
    fine = np.concatenate([np.zeros((len(s) - 1, 1)), np.cumsum(shell, axis=1)], axis=1)
    middle = 0.5 * (s[1:] + s[:-1])
    web_areas = {}
    for k, web in enumerate(blade.webs):
        edges = blade.surface(s[:, None], blade.web_arcs(k, s))
        web_areas[web.name] = quads(edges)[:, 0]
    masses = dict.fromkeys((layer["material"] for layer in structure["layers"]), 0.0)

    def arc(layer, key):
        place = layer[key]
        while "anchor" in place:
            place = anchors[place["anchor"]["name"]][place["anchor"]["handle"]]
        return at_stations(place, middle)

    for layer in structure["layers"]:
        if "web" in layer:
            area = web_areas[layer["web"]]
        else:
            ends = zip(arc(layer, "start_nd_arc"), arc(layer, "end_nd_arc"), fine, strict=True)
            area = np.array([np.interp(e, a, f) - np.interp(b, a, f) for b, e, f in ends])
        volume = area @ at_stations(layer["thickness"], middle)
        masses[layer["material"]] += density[layer["material"]] * volume
    return masses


def masses_of_the_layup(blade, n=80, around=3):
    """Mass of each material from the plies of cells between the blade's lines, and of its webs."""
    s = np.unique(np.concatenate([np.linspace(0.0, 1.0, n + 1), blade.breaks]))
    cells = []
    between = np.linspace(0.0, 1.0, around + 1)[:-1]
    lines = blade.lines(s)
    arcs = (lines[:, :-1, None] + np.diff(lines, axis=1)[..., None] * between).reshape(len(s), -1)
    arcs = np.column_stack([arcs, np.ones(len(s))])
    steps = np.linspace(0.0, 1.0, 5)
    for k, (begin, end) in enumerate(pairwise(s)):
        inner = begin + (end - begin) * steps
        rows = arcs[k] + (arcs[k + 1] - arcs[k]) * steps[:, None]
        finer = rows[:, :-1, None] + np.diff(rows, axis=1)[..., None] * steps[:-1]
        finer = np.column_stack([finer.reshape(len(steps), -1), np.ones(len(steps))])
        area = quads(blade.surface(inner[:, None], finer)).sum(axis=0).reshape(-1, 4).sum(axis=1)
        middle = 0.5 * (arcs[k] + arcs[k + 1])
        cells += [
            ("shell", (begin, end), (one, other), size)
            for one, other, size in zip(middle[:-1], middle[1:], area, strict=True)
            if other > one
        ]
        for i, web in enumerate(blade.webs):
            if begin > web.start - 1e-9 and end < web.end + 1e-9:
                edges = blade.surface(inner[:, None], blade.web_arcs(i, inner))
                cells.append((web.name, (begin, end), (0.0, 1.0), quads(edges).sum()))
    masses = {material.name: 0.0 for material in blade.materials}
    for part, span, arc, size in cells:
        for ply in blade.layup(part, span, arc):
            masses[ply.material.name] += ply.material.density * ply.thickness * size
    return masses


@pytest.mark.parametrize("name", [IEA_22, IEA_15])
def test_each_material_has_the_mass_of_its_layers_in_the_file(name):
    blade = load_turbine(name).blade
    file = load_yaml(find_turbine(name))
    expected = masses_of_the_file(file, blade)
    found = masses_of_the_layup(blade)
    total = sum(expected.values())
    assert sum(found.values()) == pytest.approx(total, rel=1e-3)
    for material, mass in expected.items():
        assert found.get(material, 0.0) == pytest.approx(mass, rel=2e-3, abs=1e-5 * total), material


def test_iea_22_weighs_what_its_file_says():
    """On the outer surface, which is a little larger than the middle of the walls."""
    turbine = load_turbine(IEA_22)
    sections, blade = turbine.blade_sections, turbine.blade
    published = trapezoid(sections.inertia[:, 0, 0], sections.grid) * blade.length
    found = sum(masses_of_the_layup(blade).values())
    assert 1.0 < found / published < 1.02


@pytest.fixture
def blade(tmp_path):
    return read_turbine(write_turbine(small_turbine(), tmp_path)).blade


def test_plies_stand_in_the_order_of_the_file(blade):
    plies = blade.layup("spar cap, suction side", (0.5, 0.52), (0.26, 0.3))
    assert [ply.material.name for ply in plies] == ["gelcoat", "biax", "uniax", "biax"]
    plies = blade.layup("web", (0.5, 0.52), (0.0, 0.5))
    assert [ply.material.name for ply in plies] == ["biax", "foam", "biax"]


def test_a_layer_counts_by_the_part_of_a_cell_that_it_covers(blade):
    """The reinforcement covers the contour up to 0.09."""
    whole, half = (blade.layup("x", (0.5, 0.52), arc) for arc in ((0.05, 0.07), (0.08, 0.1)))
    assert whole[2].material.name == half[2].material.name == "uniax"
    assert whole[2].thickness == pytest.approx(3e-3, rel=1e-12)
    assert half[2].thickness == pytest.approx(1.5e-3, rel=1e-12)


def test_what_hardly_reaches_into_a_cell_is_left_to_its_neighbour(blade):
    """Of the cap from 0.235 to 0.345 and the core beside it."""
    cap = blade.layup("x", (0.49, 0.51), (0.2345, 0.345))
    assert [ply.material.name for ply in cap] == ["gelcoat", "biax", "uniax", "biax"]
    assert cap[2].thickness == pytest.approx(0.03, rel=0.02)
    assert cap[2].thickness > 0.0297  # whole, not by 99.5 %
    core = blade.layup("x", (0.49, 0.51), (0.1, 0.2355))
    assert [ply.material.name for ply in core] == ["gelcoat", "biax", "foam", "biax"]


def test_thickness_is_the_mean_over_the_span_of_a_cell(blade):
    """The outer layer has a kink at 0.2: 20 mm at the root, 3 mm there, 1 mm at the tip."""
    outer = blade.layup("x", (0.0, 0.2), (0.6, 0.62))[1]
    assert outer.thickness == pytest.approx(0.0115, rel=1e-12)


def test_fibres_turn_to_the_leading_edge_on_both_sides(blade):
    """The angle of a ply is positive about the outer normal: to the leading edge above only."""
    for arc, angle in (((0.2, 0.22), 30.0), ((0.4, 0.42), 30.0), ((0.6, 0.62), -30.0)):
        plies = blade.layup("x", (0.5, 0.52), arc)
        assert plies[-1].angle == pytest.approx(radians(angle), rel=1e-12)
        assert plies[0].angle == 0.0


def test_a_web_begins_in_the_middle_of_the_ramp_with_its_full_thickness(blade):
    (web,) = blade.webs
    assert (web.start, web.end) == (pytest.approx(0.15), 0.9)
    assert blade.web_wall(0, np.array([0.15, 0.2])) == pytest.approx(0.024)


def test_a_cell_without_a_layer_is_refused(blade):
    with pytest.raises(
        ModelError, match=r"no layer covers 'web' between 0\.02 and 0\.05 of the span"
    ):
        blade.layup("web", (0.02, 0.05), (0.0, 1.0))


def test_strengths_and_fatigue_come_with_the_materials(tmp_path):
    materials = read_turbine(write_turbine(small_turbine(), tmp_path)).materials
    strengths = materials["uniax"].ply.strengths
    assert strengths.tension == (6.4e8, 3.8e7, inf)  # zero is unknown
    assert strengths.compression == (3.7e8, 8.2e7, inf)
    assert strengths.shear == (3.0e7, 1.9e7, 6.2e6)
    assert materials["foam"].ply.strengths.shear == (1.25e6,) * 3
    assert materials["biax"].ply.strengths.tension == (inf, inf, inf)
    assert (materials["uniax"].fatigue_exponent, materials["uniax"].fatigue_strength) == (10, 3.5e8)
    assert (materials["biax"].fatigue_exponent, materials["biax"].fatigue_strength) == (None, None)
    assert materials["gelcoat"].ply.shear[0] == pytest.approx(3.44e9 / 2.6)
