"""Strain gauges of a case lie where it says, on blades of every kind."""

import csv

import numpy as np
import pytest
from users_meshes import write_mesh
from windio_files import small_turbine, write_turbine

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.surface_rays import Skin
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.gauges import make_gauges
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run.run import run_case

pytestmark = pytest.mark.parallel

SPAR, FACE = "spar cap, pressure side", "trailing edge"
PLACES = ["suction side", "pressure side", "leading edge", FACE, 0.1, 0.35, 0.7]
ELLIPSES = {"chord": [2, 3, 1], "thickness": [2, 2, 0.6], "twist": ["20 deg", "10 deg", 0]}
SOLID = {"blade": ELLIPSES, "mesh": {"elements": [4, 4, 12]}}


def gauges_at(places, station=0.4, blade=2, **more):
    one = {"station": station, "blade": blade, **more}
    return {"output": {"gauges": {f"g{k}": {**one, "around": a} for k, a in enumerate(places)}}}


def build(tables, comm, folder="."):
    """The turbine of a case, and its gauges."""
    turbine = build_turbine(Case.parse(tables, folder), comm)
    body = turbine.part("blades")
    return turbine, make_gauges(turbine, body)


def find_points(turbine, gauges):
    """Where the gauges are, in the frame of their blade from the rotor centre, and the normals."""
    skin, layout = Skin(turbine.system.flexible_models[0]), turbine.rotor.layout
    cases, found = turbine.case.output.gauges.values(), []
    for gauge, case in zip(gauges.gauges, cases, strict=True):
        crossings = skin.leave(gauge.point, gauge.outward)
        X = np.asarray(gauge.point) + crossings[0].distance * np.asarray(gauge.outward)
        axes = layout.frame(case.blade)
        normal = np.mean([crossing.normal for crossing in crossings], axis=0)
        found.append((axes @ (X - layout.centre), axes @ normal))
    return [np.array(each) for each in zip(*found, strict=True)]


def test_on_solid_blades_they_are_on_the_ellipses(comm):
    turbine, gauges = build({**SOLID, **gauges_at(PLACES)}, comm)
    points, normals = find_points(turbine, gauges)
    arcs = [0.25, 0.75, 0.5, 0.0, *PLACES[4:]]
    expected = turbine.rotor.blades.shape.surface(np.array(0.4), np.array(arcs))
    assert np.abs(points - expected).max() < 0.05  # flat facets, of half a metre and more
    assert normals[0] @ normals[1] < -0.9 and normals[0, 2] > 0.9
    assert normals[2] @ normals[3] < -0.9 and normals[2, 1] > 0.9


def test_on_hollow_blades_they_are_on_the_contour_of_the_file(comm, shared_tmp_path):
    on_rank0(comm, lambda: write_turbine(small_turbine(), shared_tmp_path))
    places = [*PLACES, SPAR]
    tables = {
        "turbine": {"file": "small.yaml"},
        "mesh": {"span": 6, "around": 16},
        "tower": {"flexible": False},
        **gauges_at(places, 0.5, blade=3),
    }
    turbine, gauges = build(tables, comm, shared_tmp_path)
    points, normals = find_points(turbine, gauges)
    shape = turbine.rotor.blades.shape
    leading = float(shape.leading(np.array([0.5]))[0])
    cap = np.interp(0.5, [0.1, 0.9], [0.725, 0.695])  # middle of the cap of the file
    arcs = [0.5 * leading, 0.5 + 0.5 * leading, leading, 0.0, *PLACES[4:], cap]
    expected = shape.surface(np.array(0.5), np.array(arcs))
    assert np.abs(points - expected).max() < 4e-3  # of a bent blade in six cells of 3 m
    assert normals[0, 2] > 0.9 and normals[7, 2] < -0.9
    assert normals[2, 1] > 0.9 and normals[3, 1] < -0.9


def test_on_the_mesh_of_a_file_they_are_seen_from_the_middle_of_the_section(comm, shared_tmp_path):
    path = shared_tmp_path / "boxes.msh"
    blades = ["blade_1", "blade_2", "blade_3"]
    roots = {f"root_{k}": k - 1 for k in (1, 2, 3)}
    on_rank0(comm, lambda: write_mesh(path, blades, roots))
    tables = {"mesh": {"file": str(path)}, "blade": {"length": 10.0}}
    turbine, gauges = build(tables | gauges_at(PLACES[:4], 0.4, blade=1), comm)
    points, _ = find_points(turbine, gauges)
    across = [[0, 0.5], [0, -0.5], [0.5, 0], [-0.5, 0]]
    assert points == pytest.approx(np.column_stack([[6.25] * 4, across]), abs=1e-9)


def test_they_read_along_the_span_or_at_an_angle(comm):
    """A blade that is longer by 1 % and sheared in its surface, each known exactly."""
    tables = {**SOLID, "blade": {"chord": [3, 3, 3], "thickness": [2, 2, 2]}}
    readings = []
    for angle in ("0 deg", "45 deg", "-45 deg", "90 deg"):
        turbine, gauges = build(tables | gauges_at(["suction side"], angle=angle), comm)
        system = turbine.system
        state, layout = system.initial_state(), turbine.rotor.layout
        X = system.flexible_models[0].positions
        a1, a2, _ = layout.frame(2)
        F = np.eye(3) + 0.01 * np.outer(a1, a1) + 0.02 * np.outer(a1, a2)
        state.u[0].array[:] = (X @ (F - np.eye(3)).T).ravel()
        snapshot = Snapshot(0, state, None, None, None, 0.0, 0.0, None, 0.0, None)
        readings.append(float(gauges.at(snapshot)[0]))
        state.destroy()
    plus, minus = (np.hypot(1.01 + sign * 0.02, 1.0) / np.sqrt(2.0) - 1.0 for sign in (1, -1))
    across = np.hypot(0.02, 1.0) - 1.0
    assert readings == pytest.approx([0.01, plus, minus, across], abs=1e-12)


def test_their_columns_are_in_the_history(comm, shared_tmp_path):
    tables = {
        "mesh": {"elements": [1, 1, 2]},
        "time": {"end": 0.04},
        **gauges_at(["leading edge"], blade=1),
    }
    tables["output"] |= {"fields_every": 0.0}
    run_case(Case.parse(tables), shared_tmp_path / "out", comm, progress="none")
    with (shared_tmp_path / "out" / "history.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    strains = [float(row["strain_g0_[-]"]) for row in rows]
    assert abs(strains[0]) < 1e-14 and 1e-9 < abs(strains[-1]) < 1e-3
