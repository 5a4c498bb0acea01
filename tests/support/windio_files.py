"""A small turbine as a windIO file with all that is read, and the two of windIO itself."""

from functools import cache

import numpy as np
import pytest
import yaml

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.windio import find_turbine_file, read_turbine

IEA_22 = "IEA-22-280-RWT.yaml"
IEA_15 = "IEA-15-240-RWT.yaml"


def find_turbine(name):
    """Path of a turbine of windIO; the test is skipped where windIO is not installed."""
    try:
        return find_turbine_file(name)
    except InputError:
        pytest.skip("windIO is not installed, which has the file (make setup does it)")


@cache
def _read(path):
    return read_turbine(path)


def load_turbine(name):
    """A turbine of windIO, read once."""
    return _read(find_turbine(name))


def load_yaml(path):
    """A file as PyYAML reads it, with numbers such as 1e-05, which are text to YAML 1.1."""
    return yaml.load(path.read_text(), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))


def curve(*points):
    """A curve through pairs of station and value."""
    return {"grid": [float(s) for s, _ in points], "values": [float(v) for _, v in points]}


def constant(value):
    return curve((0.0, value), (1.0, value))


def at(name, handle):
    """A reference to an anchor."""
    return {"anchor": {"name": name, "handle": handle}}


def _airfoil(name, thickness, edge):
    """A symmetric ellipse-like contour with a flat trailing edge of a height."""
    angle = np.linspace(0.0, np.pi, 31)
    x = 0.5 * (1.0 + np.cos(angle))
    round_off = np.clip((1.0 - x) / 0.4, 0.0, 1.0) ** 0.5 if edge < thickness else 1.0
    y = 0.5 * thickness * np.sin(angle) * round_off + 0.5 * edge * x * (edge < thickness)
    return {
        "name": name,
        "coordinates": {
            "x": [*x.tolist(), *x[-2::-1].tolist()],
            "y": [*y.tolist(), *(-y[-2::-1]).tolist()],
        },
        "rthick": float(thickness),
    }


def _layer(name, material, thickness, start, end, **more):
    return {
        "name": name,
        "material": material,
        "thickness": thickness,
        "start_nd_arc": start,
        "end_nd_arc": end,
        **more,
    }


def _anchor(name, start, end=None):
    return {"name": name, "start_nd_arc": start} | ({"end_nd_arc": end} if end else {})


def _anchors():
    first, last = at("TE", "start_nd_arc"), at("TE", "end_nd_arc")
    suction = [curve((0.1, 0.22), (0.9, 0.25)), curve((0.1, 0.33), (0.9, 0.36))]
    pressure = [curve((0.1, 0.67), (0.9, 0.64)), curve((0.1, 0.78), (0.9, 0.75))]
    return [
        _anchor("TE", constant(0.0), constant(1.0)),
        _anchor("LE", constant(0.5)),
        _anchor("cap_ss", *suction),
        _anchor("cap_ps", *pressure),
        _anchor("LE_band", constant(0.46), constant(0.54)),
        _anchor("TE_ss", first, constant(0.09)),
        _anchor("TE_ps", constant(0.91), last),
        _anchor("main", at("cap_ss", "midpoint_nd_arc"), at("cap_ps", "midpoint_nd_arc")),
    ]


def _layer(name, material, thickness, ends, **more):
    start, end = ends
    place = {"start_nd_arc": start, "end_nd_arc": end}
    return {"name": name, "material": material, "thickness": thickness} | place | more


def _between(start, end=None):
    """From the start of an anchor to the end of the same or another one."""
    return at(start, "start_nd_arc"), at(end or start, "end_nd_arc")


def _layers():
    core_ends = at("TE_ss", "end_nd_arc"), at("cap_ss", "start_nd_arc")
    cap = curve((0.1, 0.02), (0.5, 0.03), (0.9, 2e-3))
    web_skin = curve((0.1, 0.0), (0.2, 2e-3), (0.9, 2e-3))
    web_core = curve((0.1, 0.0), (0.2, 0.02), (0.9, 0.01))
    outer = curve((0.0, 0.02), (0.2, 3e-3), (1.0, 1e-3))
    nose = curve((0.0, 0.0), (0.3, 4e-3), (1.0, 1e-3))
    return [
        _layer("coat", "gelcoat", constant(5e-4), _between("TE")),
        _layer("outer", "biax", outer, _between("TE")),
        _layer("cap_ss", "uniax", cap, _between("cap_ss")),
        _layer("cap_ps", "uniax", cap, _between("cap_ps")),
        _layer("nose", "uniax", nose, _between("LE_band")),
        _layer("te_ss", "uniax", constant(3e-3), _between("TE", "TE_ss")),
        _layer("te_ps", "uniax", constant(3e-3), _between("TE_ps", "TE")),
        _layer("core", "foam", curve((0.1, 0.0), (0.3, 0.02), (0.9, 0.0)), core_ends),
        _layer("inner", "biax", constant(1e-3), _between("TE"), fiber_orientation=constant(30.0)),
        _layer("web_front", "biax", web_skin, _between("whole"), web="web"),
        _layer("web_core", "foam", web_core, _between("whole"), web="web"),
        _layer("web_back", "biax", web_skin, _between("whole"), web="web"),
    ]


def _structure():
    main = at("main", "start_nd_arc"), at("main", "end_nd_arc")
    web = _anchor("web", *main) | {"anchors": [_anchor("whole", constant(0.0), constant(1.0))]}
    return {
        "anchors": _anchors(),
        "webs": [web],
        "layers": _layers(),
        "elastic_properties": _section_matrices(),
    }


def _section_matrices():
    zero = {f"K{i}{j}": [0.0, 0.0] for i in range(1, 7) for j in range(i, 7)}
    stiffness = {f"K{i}{i}": [i * 1e10, i * 1e9] for i in range(1, 7)}
    inertia = {key: [2.0, 1.0] for key in ("cm_x", "cm_y", "i_edge", "i_flap", "i_plr")}
    return {
        "stiffness_matrix": {"grid": [0.0, 1.0], **zero, **stiffness},
        "inertia_matrix": {
            "grid": [0.0, 1.0],
            **inertia,
            "mass": [100.0, 50.0],
            "i_cp": [0.5, 0.25],
        },
        "structural_damping": {"mu": [0.0] * 6},
    }


def _materials():
    return [
        {"name": "gelcoat", "orth": 0, "rho": 1235.0, "E": 3.44e9, "nu": 0.3},
        {
            "name": "foam",
            "orth": 0,
            "rho": 130.0,
            "E": 1.425e8,
            "G": 5.4e7,
            "nu": 0.32,
            "S": 1.25e6,
        },
        {"name": "steel", "orth": 0, "rho": 7850.0, "E": 2e11, "G": 7.93e10, "nu": 0.265, "m": 3},
        {
            "name": "uniax",
            "orth": 1,
            "rho": 1940.0,
            "E": [4.37e10, 1.65e10, 1.545e10],
            "G": [3.265e9, 3.495e9, 3.48e9],
            "nu": [0.262, 0.264, 0.35],
            "Xt": [6.4e8, 3.8e7, 0.0],
            "Xc": [3.7e8, 8.2e7, 0.0],
            "S": [3.0e7, 1.9e7, 6.2e6],
            "m": [10.0, 12.0],
            "A": [3.5e8],
        },
        {
            "name": "biax",
            "orth": 1,
            "rho": 1940.0,
            "E": [1.1e10, 1.1e10, 1.6e10],
            "G": [1.32e10, 3.49e9, 3.49e9],
            "nu": [0.688, 0.117, 0.117],
        },
    ]


def _blade():
    return {
        "reference_axis": {
            "x": curve((0.0, 0.0), (0.5, -0.1), (1.0, -0.5)),
            "y": constant(0.0),
            "z": curve((0.0, 0.0), (1.0, 20.0)),
        },
        "outer_shape": {
            "chord": curve((0.0, 1.2), (0.2, 1.8), (1.0, 0.5)),
            "twist": curve((0.0, 10.0), (1.0, -1.0)),
            "section_offset_y": curve((0.0, 0.6), (0.2, 0.7), (1.0, 0.15)),
            "section_offset_x": constant(0.0),
            "rthick": curve((0.0, 1.0), (0.05, 1.0), (0.25, 0.4), (1.0, 0.2)),
            "airfoils": [
                {"name": "circle", "spanwise_position": 0.0},
                {"name": "thick", "spanwise_position": 0.25},
                {"name": "thin", "spanwise_position": 1.0},
            ],
        },
        "structure": _structure(),
    }


def _tower():
    wall = {"name": "wall", "material": "steel", "thickness": constant(0.02)}
    axis = {"x": constant(0.0), "y": constant(0.0), "z": curve((0.0, 0.0), (1.0, 38.5))}
    return {
        "reference_axis": axis,
        "outer_shape": {"outer_diameter": curve((0.0, 3.0), (1.0, 2.0)), "cd": constant(0.5)},
        "structure": {"outfitting_factor": 1.05, "layers": [wall]},
    }


def _drivetrain(body):
    generator = {"mass": 2e3, "inertia": [5e2, 3e2, 3e2], "location": [0.5]}
    return {
        "outer_shape": {"uptilt": 5.0, "distance_tt_hub": 1.5, "overhang": 3.0},
        "gearbox": {"gear_ratio": 50.0},
        "generator": {"elastic_properties": generator},
        "elastic_properties": body,
    }


def small_turbine():
    """Tables of a turbine with blades of 20 m, a web, nacelle and tower; new ones each time."""
    body = {"mass": 1e4, "inertia": [3e4, 2e4, 2e4, 0.0, 1e3, 0.0], "location": [-1.0, 0.0, 1.0]}
    return {
        "windIO_version": "2.0",
        "name": "small",
        "assembly": {
            "number_of_blades": 3,
            "rotor_orientation": "Upwind",
            "hub_height": 40.0,
            "rated_power": 2e5,
        },
        "components": {
            "blade": _blade(),
            "hub": {"diameter": 2.0, "cone_angle": 3.0, "cd": 0.5, "elastic_properties": body},
            "drivetrain": _drivetrain(body),
            "yaw": {"elastic_properties": body},
            "tower": _tower(),
        },
        "airfoils": [
            _airfoil("circle", 1.0, 1.0),
            _airfoil("thick", 0.4, 0.05),
            _airfoil("thin", 0.2, 0.01),
        ],
        "materials": _materials(),
    }


def write_turbine(tables, folder, name="small.yaml"):
    """Write tables as a YAML file.

    Returns:
        Its path.
    """
    path = folder / name
    dumper = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
    path.write_text(yaml.dump(tables, Dumper=dumper, sort_keys=False))
    return path


def small_blade(folder, change=lambda blade, tables: None):
    """The blade of the small turbine after a change of its tables."""
    tables = small_turbine()
    change(tables["components"]["blade"], tables)
    return read_turbine(write_turbine(tables, folder)).blade
