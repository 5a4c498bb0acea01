"""Failure indices of plies in the files that a run writes."""

from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest
from dolfinx import mesh
from outputs import read_fields
from walls import CARBON, laminate, load_wall, wall_arrays

from turbine_fenicsx import (
    Coupling,
    Fields,
    FlexibleBody,
    Gravity,
    History,
    ModelError,
    MultibodySystem,
    Simulation,
    StVenantKirchhoff,
    cell_field,
)
from turbine_fenicsx.materials.laminate import Laminate
from turbine_fenicsx.materials.laminate_theory import tabulate_walls
from turbine_fenicsx.materials.ply import PlyMaterial, Strengths
from turbine_fenicsx.materials.ply_failure import CRITERIA
from turbine_fenicsx.simulation.observers.ply_failure import failure_channel, failure_field
from turbine_fenicsx.system.ply_stresses import PlyStresses

pytestmark = pytest.mark.parallel

comm = MPI.COMM_WORLD

STRENGTHS = Strengths((1500e6,) * 3, (900e6,) * 3, (70e6,) * 3)
STRONG = PlyMaterial(
    "strong", CARBON.density, CARBON.young, CARBON.shear, CARBON.poisson, STRENGTHS
)
PLIES = laminate((STRONG, 0.01, 20), (CARBON, 0.01, 0))


@pytest.fixture
def folder(tmp_path):
    """A folder that all ranks share."""
    return Path(comm.bcast(str(tmp_path)))


def strip(s, a, z):
    return np.stack([2.0 * s, 0.3 * a, 0.02 * z], axis=-1)


def make_strip():
    """A clamped strip of laminate that falls, and a block that does as well."""
    loaded, number = load_wall(comm, wall_arrays(strip, 6, 1))
    table = tabulate_walls([PLIES] * len(number), np.full(len(number), 0.02))
    law = Laminate.from_table(loaded.mesh, table)
    density = cell_field(loaded.mesh, table.density)
    body = FlexibleBody("strip", loaded.mesh, law, density, degree=2)
    cells = mesh.create_box(comm, [[5, 0, 0], [6, 1, 1]], [2, 1, 1], mesh.CellType.hexahedron)
    block = FlexibleBody("block", cells, StVenantKirchhoff(1e6, 1e6), 1000.0)
    root = Coupling("root", body, loaded.facets("root"), None)
    system = MultibodySystem(comm, [block, body, root, Gravity((0.0, 0.0, -9.81))])
    return system, PlyStresses(system, body, [PLIES] * len(number)), number


def test_fields_and_columns_show_the_worst_ply_of_each_cell_and_panel(folder):
    system, plies, number = make_strip()
    place = (number + 0.5) / 3.0
    panels = {"inner": np.flatnonzero(number < 3), "outer": np.flatnonzero(number >= 3)}
    channel = failure_channel(plies, panels, place, ("tsai_wu", "maximum_strain"))
    assert channel.columns[:3] == (
        "inner_tsai_wu_[-]",
        "inner_tsai_wu_at_[m]",
        "inner_maximum_strain_[-]",
    )
    more = [failure_field(plies), failure_field(plies, "maximum_stress")]
    observers = [
        History(comm, folder / "history.csv", [channel]),
        Fields(system, folder / "fields.xdmf", 1.0, 0.02, more=more),
    ]
    last = Simulation(system, 0.005, 0.02, observers).run()
    comm.Barrier()
    plies.update(last.state)
    by_hand = {}
    for name in ("tsai_wu", "maximum_strain", "maximum_stress"):
        index = plies.largest(CRITERIA[name])[0]
        pairs = comm.allgather(list(zip(number.tolist(), index.tolist(), strict=True)))
        by_hand[name] = np.array([x for _, x in sorted(pair for one in pairs for pair in one)])
    assert np.argmax(by_hand["tsai_wu"]) == 0 and by_hand["tsai_wu"][0] > 1e-3  # at the root
    row = np.genfromtxt(folder / "history.csv", delimiter=",", names=True, deletechars="")[-1]
    for name in ("tsai_wu", "maximum_strain"):
        for panel, first in (("inner", 0), ("outer", 3)):
            values = by_hand[name][first : first + 3]
            assert row[f"{panel}_{name}_[-]"] == pytest.approx(values.max(), rel=1e-9)
            at = row[f"{panel}_{name}_at_[m]"]
            assert at == pytest.approx((first + np.argmax(values) + 0.5) / 3.0)
    fields = read_fields(folder / "fields.xdmf")
    written = fields[max(fields)]
    is_strip = written["part"] == np.max(written["part"])
    for name in ("tsai_wu", "maximum_stress"):
        assert np.allclose(np.sort(written[name][is_strip]), np.sort(by_hand[name]), rtol=1e-6)
        assert not written[name][~is_strip].any()
    assert not fields[0.0]["tsai_wu"].any()


def test_mistakes_are_refused_on_all_ranks():
    _, plies, number = make_strip()
    place, all_cells = np.zeros(len(number)), {"all": np.arange(len(number))}
    with pytest.raises(ModelError, match=r"one of tsai_wu, maximum_stress, .* got 'hill'"):
        failure_field(plies, "hill")
    with pytest.raises(ModelError, match="one of tsai_wu"):
        failure_channel(plies, all_cells, place, ["hill"])
    with pytest.raises(ModelError, match="panel 'cap' of 'strip' has no cells"):
        failure_channel(plies, {**all_cells, "cap": np.zeros(0, dtype=int)}, place)
    with pytest.raises(ModelError, match=r"must be those of the \d+ cells of this rank"):
        failure_channel(plies, {"all": np.array([99])}, place)
    with pytest.raises(ModelError, match=r"must be those of the \d+ cells of this rank"):
        failure_channel(plies, all_cells, np.zeros(len(number) + (comm.rank == 0)))
    other = make_strip()[0]
    with pytest.raises(
        ModelError, match=r"flexible body .strip. of tsai_wu is not among the parts"
    ):
        Fields(other, "fields.xdmf", 1.0, 1.0, more=[failure_field(plies)])
