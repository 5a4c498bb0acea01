"""Claims about what a run will take: unknowns exactly, disk nearly, time and memory roughly."""

import pytest

from turbine_fenicsx.meshing import MeshOptions, RotorLayout
from turbine_fenicsx.meshing.rotor import rotor_arrays
from turbine_fenicsx.turbine.case import Case
from turbine_fenicsx.turbine.estimate import estimate
from turbine_fenicsx.turbine.inspection import inspect_mesh
from turbine_fenicsx.turbine.model import ROOTS, blade_geometry, build_turbine, mesh_options
from turbine_fenicsx.turbine.run import run_case
from turbine_fenicsx.turbine.size import MeshSize, size_of_arrays, size_of_options
from turbine_fenicsx.turbine.summary import unknowns


def expected(data):
    """The estimate of a case from its file alone."""
    case = Case.parse(data)
    size = None
    if case.turbine.model == "hybrid":
        size = size_of_options(blade_geometry(case), mesh_options(case), case.mesh.degree)
    return estimate(case, size)


def hexahedra(displacements):
    """The estimate of a mesh of a given size with default options."""

    def of(**solver):
        nodes = displacements // 3
        size = MeshSize("hexahedron", nodes, nodes, nodes, 27, True)
        return estimate(Case.parse({"solver": solver}), size)

    return of


@pytest.mark.parametrize(
    "mesh",
    [
        {"elements": [1, 2, 3]},
        {"elements": [2, 1, 4], "degree": 2},
        {"elements": [1, 1, 3], "degree": 2, "geometry_degree": 2},
        {"size": "3 m", "degree": 2, "geometry_degree": 2},
        None,
    ],
)
def test_unknowns_of_built_in_hexahedra_and_of_the_rigid_turbine_are_exact(comm, mesh):
    data = {"mesh": mesh} if mesh else {"turbine": {"model": "rigid"}}
    found = expected(data)
    assert found.exact
    assert found.unknowns == unknowns(build_turbine(Case.parse(data), comm))


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
@pytest.mark.parametrize("degree", [1, 2])
def test_unknowns_of_a_mesh_that_exists_are_counted(comm, cell, degree):
    data = {"mesh": {"cell": cell, "size": "2.5 m", "degree": degree}}
    case = Case.parse(data)
    found = estimate(case, inspect_mesh(case, comm).size)
    assert found.exact
    assert found.unknowns == unknowns(build_turbine(case, comm))


@pytest.mark.parametrize("fineness", [{}, {"size": 0.8}, {"elements": (1, 1, 6)}])
def test_numbers_of_tetrahedra_are_known_roughly(fineness):
    case = Case.parse({"mesh": {"cell": "tetrahedron"} | fineness})
    options, blade = mesh_options(case), blade_geometry(case)
    mesh = rotor_arrays(blade, RotorLayout(), MeshOptions("tetrahedron", **fineness))
    for degree in (1, 2):
        counted = size_of_arrays(mesh, ROOTS, degree)
        guessed = size_of_options(blade, options, degree)
        assert counted.exact
        assert not guessed.exact
        for name in ("cells", "vertices", "nodes"):
            # down to the coarsest mesh, of one element through the thickness
            assert getattr(guessed, name) == pytest.approx(getattr(counted, name), rel=0.3)
        assert 0.3 < guessed.root_nodes / counted.root_nodes < 3.0


# Wall times of a step and memory as measured for benchmarks/README.md and for the fits.
@pytest.mark.parametrize(
    ("displacements", "solver", "seconds"),
    [
        (1053, {}, 0.006),
        (11025, {}, 0.035),
        (70713, {}, 0.33),
        (70713, {"tolerance": 1e-8}, 0.24),
        (301725, {}, 1.95),
        (11025, {"preconditioner": "iterative"}, 0.06),
        (70713, {"preconditioner": "iterative"}, 0.59),
        (301725, {"preconditioner": "iterative"}, 3.2),
        (11025, {"preconditioner": "lu"}, 0.6),
        (70713, {"preconditioner": "lu"}, 11.0),
    ],
)
def test_step_takes_what_was_measured_within_a_factor_of_two(displacements, solver, seconds):
    found = hexahedra(displacements)(**solver)
    assert 0.5 < found.step_seconds / seconds < 2.0
    assert found.seconds > found.steps * found.step_seconds


@pytest.mark.parametrize(
    ("displacements", "gigabytes"), [(1053, 0.177), (70713, 0.609), (244881, 2.1), (302000, 2.7)]
)
def test_memory_is_what_was_measured_within_a_third(displacements, gigabytes):
    found = hexahedra(displacements)()
    assert found.memory / 1e9 == pytest.approx(gigabytes, rel=0.33)


def test_solver_is_named_and_too_little_memory_is_warned_of():
    assert hexahedra(1000)().preconditioner == "frozen"
    assert hexahedra(3_000_000)().preconditioner == "iterative"
    assert hexahedra(1000)(preconditioner="lu").preconditioner == "lu"
    assert hexahedra(1000)().warnings == []
    (warning,) = hexahedra(3_000_000_000)(preconditioner="frozen").warnings
    assert warning.startswith("the run needs about ")
    assert warning.endswith('solver.preconditioner = "iterative" needs less')


def test_more_steps_and_finer_tolerance_take_longer():
    base = expected({})
    assert base.steps == 600
    assert expected({"time": {"end": 24.0}}).seconds > 1.7 * base.seconds
    assert expected({"solver": {"tolerance": 1e-8}}).step_seconds < 0.75 * base.step_seconds
    assert expected({"turbine": {"model": "rigid"}}).step_seconds == pytest.approx(0.0026)


@pytest.mark.parametrize("model", ["rigid", "hybrid"])
@pytest.mark.parametrize("every", [0.0, 0.04])
def test_disk_space_is_that_of_the_files(comm, shared_tmp_path, model, every):
    data = {
        "turbine": {"model": model},
        "time": {"end": 0.1},
        "mesh": {"elements": [1, 1, 4]},
        "output": {"fields_every": every},
    }
    run_case(Case.parse(data), shared_tmp_path, comm, "none")
    comm.barrier()
    sizes = {path.name: path.stat().st_size for path in shared_tmp_path.iterdir()}
    fields = sum(size for name, size in sizes.items() if name.startswith("fields"))
    found = expected(data)
    history = 700.0 * found.steps
    assert found.steps == 5
    # 0, 0.04, 0.08, and the end; headers, of a kilobyte each, are not counted
    assert found.disk - history == pytest.approx(fields, rel=0.01)
    assert found.disk < sum(sizes.values()) + 1000
