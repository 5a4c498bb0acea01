"""Lines between panels follow what matters and run on smoothly where nothing is."""

import copy

import numpy as np
from windio_files import at, constant, curve, small_blade

CAP = "spar cap, suction side"


def edges(blade, panel, s):
    """Contour fractions of both lines of a panel, (m, 2)."""
    k = blade.panels.index(panel)
    return blade.lines(np.asarray(s))[:, k : k + 2]


def add_layer(blade, name, material, thickness, start, end):
    structure = blade["structure"]
    structure["anchors"].append(
        {"name": name, "start_nd_arc": constant(start), "end_nd_arc": constant(end)}
    )
    structure["layers"].append(
        {
            "name": name,
            "material": material,
            "thickness": constant(thickness),
            "start_nd_arc": at(name, "start_nd_arc"),
            "end_nd_arc": at(name, "end_nd_arc"),
        }
    )


def test_of_two_caps_the_stiffer_one_has_the_lines(tmp_path):
    blade = small_blade(tmp_path, lambda b, _: add_layer(b, "thin", "biax", 1e-3, 0.15, 0.42))
    assert np.abs(edges(blade, CAP, [0.5]) - [[0.235, 0.345]]).max() < 1e-4
    blade = small_blade(tmp_path, lambda b, _: add_layer(b, "thick", "uniax", 0.1, 0.15, 0.42))
    assert np.abs(edges(blade, CAP, [0.5]) - [[0.15, 0.42]]).max() < 1e-4


def test_foam_and_skins_have_no_lines(tmp_path):
    def strip(blade, tables):
        layers = blade["structure"]["layers"]
        layers[:] = [layer for layer in layers if not layer["name"].startswith("cap")]
        add_layer(blade, "more foam", "foam", 0.05, 0.15, 0.42)
        add_layer(blade, "skin", "uniax", 0.05, 0.02, 0.98)

    panels = small_blade(tmp_path, strip).panels
    edges = ("trailing edge", "trailing-edge reinforcement, suction side")
    assert panels[:4] == (*edges, "suction side", "leading edge")
    assert len(panels) == 8


def test_places_of_a_layer_that_is_not_there_have_no_influence(tmp_path):
    """The nose has no thickness up to 0.3; its places jump before."""

    def jump(blade, tables):
        band = next(a for a in blade["structure"]["anchors"] if a["name"] == "LE_band")
        band["start_nd_arc"] = curve((0, 0.5), (0.2, 0.5), (0.25, 0.46), (1, 0.46))
        nose = next(x for x in blade["structure"]["layers"] if x["name"] == "nose")
        nose["thickness"] = curve((0, 0.0), (0.3, 0.0), (0.4, 4e-3), (1, 1e-3))

    line = edges(small_blade(tmp_path, jump), "leading edge", np.linspace(0.15, 1.0, 50))[:, 0]
    assert np.abs(line - 0.46).max() < 1e-12


def test_lines_keep_away_from_webs(tmp_path):
    """A second web 0.001 before the edge of the cap, another 0.001 behind the other edge."""

    def add_webs(blade, tables):
        structure = blade["structure"]
        web = structure["webs"][0]
        core = next(x for x in structure["layers"] if x["name"] == "web_core")
        for name, start, shift in (("front", 0.33, 0.001), ("rear", 0.22, 0.001)):
            arcs = [(0.1, start + shift), (0.9, start + 0.03 + shift)]
            structure["webs"].append(
                copy.deepcopy(web)
                | {"name": name, "start_nd_arc": curve(*arcs)}
                | {"end_nd_arc": curve(*((s, 1.0 - a) for s, a in arcs))}
            )
            structure["layers"].append(copy.deepcopy(core) | {"name": f"{name}_core", "web": name})

    blade = small_blade(tmp_path, add_webs)
    s = np.linspace(0.15, 0.9, 76)
    start, end = edges(blade, CAP, s).T
    for k, line, side in ((1, end, -1.0), (2, start, -1.0)):
        assert blade.webs[k].name in ("front", "rear")
        assert np.min(side * (line - blade.web_arcs(k, s)[:, 0])) > 0.00299
