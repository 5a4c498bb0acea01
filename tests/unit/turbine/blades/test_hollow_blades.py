"""Claims about the hollow blades of a turbine with a windIO file."""

import csv

from mpi4py import MPI

import numpy as np
import pytest
from outputs import read_fields
from seen import Seen
from windio_files import small_turbine, write_turbine

from turbine_fenicsx import KelvinVoigt, _compat
from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.meshing.quality import cell_volumes
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run.inspection import inspect_mesh
from turbine_fenicsx.turbine.run.run import make_stepper, run_case
from turbine_fenicsx.turbine.run.start import list_held
from turbine_fenicsx.turbine.run.summary import list_masses

MESH = {"span": 5, "around": 16}
OPEN = {**MESH, "tip": "open"}
STANDING = {"tower": {"flexible": False}}


@pytest.fixture
def make(comm, shared_tmp_path):
    """Makes a case of the small turbine with a coarse mesh, without tower."""
    if comm.rank == 0:
        write_turbine(small_turbine(), shared_tmp_path)
    comm.barrier()

    def parse(**tables):
        turbine = {"file": "small.yaml", **tables.pop("turbine", {})}
        mesh = tables.pop("mesh", MESH)
        return Case.parse({"turbine": turbine, "mesh": mesh, **STANDING, **tables}, shared_tmp_path)

    return parse


@pytest.mark.parametrize("layup", ["homogenised", "laminate"])
def test_blades_have_the_mass_of_their_layers(make, comm, layup):
    """Thickness of each layer times its width and the length of the span, added up by hand."""
    case = make(blade={"layup": layup})
    turbine = build_turbine(case, comm)
    shape, found = turbine.rotor.blades.shape, 0.0
    n, m = 2000, 200
    s, a = (np.arange(m) + 0.5) / m, np.linspace(0.0, 1.0, n + 1)
    for k in range(m):
        ends = shape.surface(np.array(s[k]), a)
        up, down = (
            shape.surface(np.array(s[k] + d), 0.5 * (a[1:] + a[:-1])) for d in (1e-3, -1e-3)
        )
        along = (up - down) / 2e-3
        areas = np.linalg.norm(np.cross(along, np.diff(ends, axis=0)), axis=1) / m
        for layer in shape.layers:
            thickness = layer.thickness_at(s[k : k + 1]) * layer.share(s[k : k + 1], a[:-1], a[1:])
            found += layer.material.density * areas @ np.broadcast_to(thickness, areas.shape)
    masses = list_masses(turbine)
    web = sum(w.sum() for w in _masses_of_webs(turbine.rotor.blades))
    # thick walls of a coarse mesh: their middle is shorter than the contour
    assert masses["blades"] / 3.0 - web == pytest.approx(found, rel=0.06)


def _masses_of_webs(blades):
    """Mass of the cells of each web [kg]."""
    block, table = blades.block, blades.table
    mass = cell_volumes(block.points, block.cells, block.reference) * table.density
    first = len(blades.shape.panels)
    return [mass[block.part == first + k] for k in range(len(blades.shape.webs))]


def test_an_open_tip_has_neither_plate_nor_short_row(make, comm):
    """The row that holds the plate is as long as the wall is thick, a slip of a cell."""
    closed, opened = (plan_rotor(make(mesh=mesh), comm).blades for mesh in (MESH, OPEN))
    assert closed.block.parts[-1] == "tip" and "tip" not in opened.block.parts
    shortest = [np.ptp(each.block.span, axis=1).min() for each in (closed, opened)]
    assert shortest[0] < 0.01 < 0.1 < shortest[1]
    masses = [
        (cell_volumes(each.block.points, each.block.cells, each.block.reference))
        @ each.table.density
        for each in (closed, opened)
    ]
    assert 0.0 < masses[0] / masses[1] - 1.0 < 0.01  # by the plate


def test_each_cell_has_the_density_of_its_place(make, comm):
    """On any number of ranks: heavy where the caps are, light in the panels."""
    turbine = build_turbine(make(), comm)
    (body,) = turbine.system.flexible_bodies
    mesh, blades = turbine.meshes["blades"], turbine.rotor.blades
    owned = mesh.mesh.topology.index_map(3).size_local
    dofs = _compat.dofs_of_cells(body.density.function_space)[:owned, 0]
    density = body.density.x.array[dofs]
    n = len(blades.block.cells)
    assert np.array_equal(density, blades.table.density[mesh.original_cells % n])
    assert comm.allreduce(len(density)) == 3 * n
    assert comm.allreduce(float(np.ptp(density)), op=MPI.MAX) > 500.0


def test_tips_and_roots_are_where_the_surface_is(make):
    plan = plan_rotor(make())
    blades = plan.blades
    assert blades.tip[0] == pytest.approx(21.0, abs=0.05)
    assert blades.tip[2] == pytest.approx(-0.5, abs=0.05)  # bent upwind
    assert blades.root_radius == pytest.approx(0.6, rel=1e-2)
    for k, tip in enumerate(plan.tips, start=1):
        assert np.allclose(plan.layout.frame(k) @ (tip - plan.layout.centre), blades.tip)


def test_roots_that_overlap_are_refused(make, comm):
    case = make(blade={"hub_radius": 0.3})
    with pytest.raises(ModelError, match=r"overlap at a hub radius of 0.3 m"):
        build_turbine(case, comm)


def test_check_tells_mass_centre_panels_and_caps(make, comm):
    found = inspect_mesh(make(), comm)
    assert found.mistakes == found.warnings == ()
    told = found.report
    assert "mass of a blade 1.4" in told and "m from the root" in told
    assert "spar cap, suction side" in told and "web from 0.15 to 0.9 of the span" in told
    assert "walls are made thinner" in told


def test_viscosity_damps_walls_too(make, comm):
    turbine = build_turbine(make(material={"shear_viscosity": "1 MPa s"}), comm)
    (body,) = turbine.system.flexible_bodies
    assert isinstance(body.material, KelvinVoigt)


@pytest.mark.parametrize("layup", ["homogenised", "laminate"])
def test_a_turbine_of_a_file_conserves_energy(make, comm, layup):
    """With pitch bearings that turn, under weight, on any number of ranks."""
    pitch = {"bearings": True, "drive": "prescribed", "angle": "5 deg", "duration": "0.1 s"}
    case = make(blade={"layup": layup}, pitch=pitch, time={"step": 0.01})
    turbine = build_turbine(case, comm)
    seen = Seen(lambda s: (abs(s.energy_error), s.balance.kinetic))
    stepper = make_stepper(case, turbine.system)
    Simulation(turbine.system, 0.01, 0.05, [seen], stepper).run()
    stepper.destroy()
    errors, energies = np.array(seen.values[1:]).T
    assert max(energies) > 1.0
    assert max(errors) < 1e-9 * max(energies)


@pytest.mark.parallel
def test_the_equilibrium_is_the_same_on_any_number_of_ranks(make, comm):
    tips = []
    for each in (comm, MPI.COMM_SELF):
        turbine = build_turbine(make(), each)
        system = turbine.system
        state = equilibrium(system, held=list_held(make(), system))
        tips.append(state.u[0].norm())
        state.destroy()
    assert tips[0] > 1e-3
    assert tips[0] == pytest.approx(tips[1], rel=1e-8)


@pytest.mark.parallel
def test_a_file_that_vanishes_is_an_error_on_all_ranks(make, comm):
    case = make()
    gone = case.turbine.model_copy(update={"file": "/no/such/file.yaml"})
    with pytest.raises(InputError, match="cannot read the windIO file"):
        plan_rotor(case.model_copy(update={"turbine": gone}), comm)


@pytest.mark.parallel
def test_failure_of_plies_goes_into_the_output(make, comm, shared_tmp_path):
    """Columns of each panel and web, and a field in the cells; the largest is the same in both."""
    case = make(time={"step": 0.01, "end": 0.02}, output={"fields_every": 0.02})
    out = shared_tmp_path / "out"
    worst = run_case(case, out, comm, progress="none")["worst_ply"]
    with (out / "history.csv").open(newline="") as file:
        names, *rows = csv.reader(file)
    last = dict(zip(names, map(float, rows[-1]), strict=True))
    indices = {n: last[n] for n in names if n.endswith("tsai_wu_[-]")}
    assert "spar_cap_suction_side_tsai_wu_[-]" in indices and "web_tsai_wu_[-]" in indices
    assert "tip_tsai_wu_[-]" not in indices and len(indices) == 11  # nobody laid up the tip
    at = last["spar_cap_suction_side_tsai_wu_at_[m]"]
    assert 0.0 < at < 20.0
    written = read_fields(out / "fields.xdmf")
    assert max(indices.values()) > 1e-4
    every = [float(x) for row in rows for n, x in zip(names, row, strict=True) if n in indices]
    assert (worst["index"], worst["criterion"]) == (max(every), "tsai_wu")
    found = written[max(written)]["tsai_wu"].max()
    assert found == pytest.approx(max(indices.values()), rel=1e-5)  # single precision
