"""Blades with a layup on a mesh that was written to a file and read again."""

import re
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
from users_meshes import write_mesh
from windio_files import small_turbine, write_turbine

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing.rotor import write_msh
from turbine_fenicsx.records.output_folder import read_history
from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.blades.wall_cells import WallCells
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.flexible_blades import find_plies
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run.inspection import inspect_mesh
from turbine_fenicsx.turbine.run.run import run_case

NOISE = (
    "energy_error_[J]",
    "external_work_[J]",
    "work_of_motion_of_yaw_[J]",
    "constraint_error_[-]",
    "newton_iterations",
    "krylov_iterations",
    "wall_time_[s]",
)
"""Columns of round-off, of what it decides (residuals of 1.3e-10 to 1e-10) and of the clock."""
AXIS = re.compile("_[xyz](?=_)")
BLADES = ("blade_1", "blade_2", "blade_3")


def tables(**mesh):
    return {
        "turbine": {"file": "small.yaml"},
        "mesh": mesh or {"span": 5, "around": 16},
        "tower": {"flexible": False},
    }


@pytest.fixture
def arrays(comm, shared_tmp_path):
    """The mesh that is made for the small turbine, on rank 0."""
    on_rank0(comm, lambda: write_turbine(small_turbine(), shared_tmp_path))
    _, make = plan_rotor(Case.parse(tables(), shared_tmp_path), comm).mesh_source()
    return make() if comm.rank == 0 else None


def take_file(arrays, comm, folder):
    """The case on the mesh of a file."""
    path = folder / "blades.msh"
    on_rank0(comm, lambda: write_msh(arrays, path))
    return Case.parse(tables(file=str(path)), folder)


def describe_cells(turbine):
    """Density, number of plies and their thickness of each cell, by its middle, of all ranks."""
    (body,) = turbine.system.flexible_bodies
    mesh, plies = turbine.meshes["blades"], find_plies(turbine)
    owned = mesh.mesh.topology.index_map(3).size_local
    dofs = _compat.dofs_of_cells(body.density.function_space)[:owned, 0]
    table = plies.stresses.table
    counts = np.diff(np.append(table.first, len(table.plies)))
    rows = np.column_stack([body.density.x.array[dofs], counts, plies.place])
    every = np.concatenate(turbine.comm.allgather(rows))
    return every[np.lexsort(every.round(6).T)], sorted(plies.panels)


@pytest.mark.parallel
def test_what_the_command_mesh_writes_can_be_read_again(arrays, comm, shared_tmp_path):
    case = take_file(arrays, comm, shared_tmp_path)
    assert case.warnings[:-1] == []  # the last one says that it starts undeformed
    made = build_turbine(Case.parse(tables(), shared_tmp_path), comm)
    read = build_turbine(case, comm)
    for one, other in zip(describe_cells(made), describe_cells(read), strict=True):
        np.testing.assert_array_equal(one, other) if isinstance(one, list) else (
            np.testing.assert_allclose(one, other, rtol=1e-12)
        )
    told = [inspect_mesh(t.case, comm) for t in (made, read)]
    assert told[0].mistakes == told[1].mistakes == ()
    assert "mass of a blade 1.4" in told[1].report
    assert told[0].report == told[1].report


@pytest.mark.slow
def test_a_run_on_a_mesh_that_was_written_has_the_same_seven_digits(arrays, comm, shared_tmp_path):
    """Layup, axes of the blades, panels, gauges: all columns of the time series."""
    path = shared_tmp_path / "blades.msh"
    on_rank0(comm, lambda: write_msh(arrays, path))
    rows = []
    for name, mesh in (("made", {"span": 5, "around": 16}), ("read", {"file": str(path)})):
        run = {
            "time": {"step": 0.01, "end": 0.03, "start": "turning"},
            "output": {"gauges": {"cap": {"station": 0.3, "around": "spar cap, suction side"}}},
        }
        case = tables(**mesh) | run
        case["turbine"] = case["turbine"] | {"rotor_speed": "10 rpm"}
        case = Case.parse(case, shared_tmp_path)
        run_case(case, shared_tmp_path / name, comm, progress="none")
        rows.append(read_history(shared_tmp_path / name / "history.csv").columns)
    made, read = rows
    assert list(made) == list(read)
    assert "strain_cap_[-]" in made and "spar_cap_suction_side_tsai_wu_[-]" in made
    sizes = defaultdict(float)  # of whole vectors: no torque holds this shaft, but for round-off
    for name, values in made.items():
        sizes[AXIS.sub("", name)] = max(sizes[AXIS.sub("", name)], np.abs(values).max())
    for name, values in made.items():
        if name not in NOISE:
            size = 1e-7 * sizes[AXIS.sub("", name)] + 1e-20  # locked bearings turn by round-off
            np.testing.assert_allclose(read[name], values, rtol=0.0, atol=size, err_msg=name)


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("part", 99.0, "the cell data 'part' have 99, which no cell of the blades"),
        ("part", 0.5, "the cell data 'part' have 0.5"),
        ("span_end", 0.0, "the cell data 'span_end' have 0"),
        ("arc_start", -1.0, "the cell data 'arc_start' have -1"),
        ("thickness", np.nan, "the cell data 'thickness' have nan"),
        ("wanted", np.inf, "the cell data 'wanted' have inf"),
        ("arc_end", None, "it lacks the cell data arc_end: blades with a layup need a mesh that"),
    ],
)
def test_cells_that_stand_for_nothing_are_refused(arrays, shared_tmp_path, name, value, sentence):
    if arrays is None:
        return
    data = {key: values.copy() for key, values in arrays.cell_data.items()}
    if value is None:
        del data[name]
    else:
        data[name][7] = value
    plan = plan_rotor(Case.parse(tables(), shared_tmp_path))
    (found,) = plan.list_mistakes(replace(arrays, cell_data=data))
    assert sentence in found


@pytest.mark.parallel
def test_a_mesh_of_somebody_else_is_refused_in_a_sentence(arrays, comm, shared_tmp_path):
    path = shared_tmp_path / "boxes.msh"
    roots = {f"root_{k}": k - 1 for k in (1, 2, 3)}
    on_rank0(comm, lambda: write_mesh(path, BLADES, roots, radius=1.0))
    case = Case.parse(tables(file=str(path)), shared_tmp_path)
    with pytest.raises(ModelError, match=r"boxes\.msh': walls of laminates need quadratic hexahed"):
        build_turbine(case, comm)
    assert any("quadratic hexahedra" in m for m in inspect_mesh(case, comm).mistakes)


@pytest.mark.parametrize(("span", "around"), [(5, 16), (10, 32)])
def test_trailing_edges_hardly_wider_than_thick_are_ridges(arrays, shared_tmp_path, span, around):
    """Corner to corner less than six walls, however fine the mesh is."""
    if arrays is None:
        return
    blades = plan_rotor(Case.parse(tables(span=span, around=around), shared_tmp_path)).blades
    cells = WallCells.read(blades.shape, blades.block.cell_data)
    s = cells.span.mean(axis=1)
    corners = blades.shape.outer_shape.corners(s)
    height = np.linalg.norm(
        np.diff(blades.shape.surface(s[:, None], corners), axis=1)[:, 0], axis=1
    )
    face = np.array([name == "trailing edge" for name in cells.parts])[cells.part]
    assert np.array_equal(cells.is_ridge, face & (height < 6.0 * cells.wanted))
    assert cells.is_ridge.any() and not cells.is_ridge[face].all()


def test_ridges_count_for_no_panel(arrays, comm, shared_tmp_path):
    turbine = build_turbine(Case.parse(tables(), shared_tmp_path), comm)
    plies, mesh = find_plies(turbine), turbine.meshes["blades"]
    ridge = np.flatnonzero(WallCells.read(turbine.rotor.blades.shape, mesh.cell_data).is_ridge)
    assert comm.allreduce(len(ridge)) == 24
    assert set(ridge) <= set(plies.made_up)
    assert not any(np.isin(cells, ridge).any() for cells in plies.panels.values())
    assert comm.allreduce(len(plies.panels["trailing_edge"])) == 12
