"""Damage of the plies over the life: against formulas, in any order, blocks and ranks."""

import shutil
from dataclasses import replace

from mpi4py import MPI

import numpy as np
import pytest
from reduced_turbines import COMM, STRENGTH, STRENGTHS, run, write_case

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.materials.laminate_theory import strain_in_ply
from turbine_fenicsx.turbine.case.ply_fatigue import find_adhesive
from turbine_fenicsx.turbine.components.flexible_blades import BODY
from turbine_fenicsx.turbine.life import run_damage
from turbine_fenicsx.turbine.life.bond_histories import BondHistories
from turbine_fenicsx.turbine.life.ply_life import find_ply_life
from turbine_fenicsx.turbine.life.run_damage import PlyHistories, RunDamage
from turbine_fenicsx.turbine.life.weighted_run import YEAR, WeightedRun, weigh
from turbine_fenicsx.turbine.life.worst_bonds import find_worst_bonds
from turbine_fenicsx.turbine.life.worst_places import WorstPlaces
from turbine_fenicsx.turbine.run.ply_history import PlyRecovery
from turbine_fenicsx.turbine.run.recorded_run import RecordedRun


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Folders of two runs, of different winds."""
    folder = on_rank0(COMM, lambda: tmp_path_factory.mktemp("recorded"))
    path, changes = write_case(folder), ("tower.flexible=false", "output.motion_every=0.05")
    return [
        run(path, f"v{wind}", *changes, "time.end=1.5", f"wind.speed={wind}") for wind in (9, 12)
    ]


def find(runs, comm=COMM):
    """The life of runs."""
    return find_ply_life(runs, comm, STRENGTHS)


@pytest.mark.parallel
def test_constant_amplitude_does_the_damage_of_the_goodman_diagram(folders):
    """The blades jump to and fro between two states, whose stresses come from the full mesh."""
    recorded = RecordedRun.open(folders[0], COMM, STRENGTHS, "life.")
    recovery = PlyRecovery(recorded)
    cycles, copy, rows = 40, 1, (2, 7)
    stresses = []
    for number, state in enumerate(recorded.list_states()):
        if number in rows:
            recovery.plies.stresses.update(state, copy)
            stresses.append(recovery.plies.stresses.stresses().mean(axis=2))
    vectors = recovery.vectors[0 : rows[1] + 1][[*rows] * cycles + [rows[0]]]
    motion = replace(recorded.motion, times=np.arange(2.0 * cycles + 1.0), vectors={BODY: vectors})
    life = find([WeightedRun(folders[0], "v9", times=1.0)])
    found = RunDamage(recovery, [PlyHistories(recovery, life.materials)]).find(motion)[0]
    low, high = np.minimum(*stresses), np.maximum(*stresses)
    A, M = 0.5 * (high - low), 0.5 * (high + low)
    names = np.array([ply.material.name for ply in recovery.plies.stresses.table.plies])
    panels = [*recovery.plies.panels.values()]
    inside = np.isin(recovery.plies.stresses.table.wall, np.concatenate(panels))
    mine = np.flatnonzero((names == "biax") & inside)
    # strengths are alike, so that N = ((R - |M|)/A)^m
    expected = cycles * (A / (STRENGTH - np.abs(M))) ** 9.0
    largest = COMM.allreduce(float(np.max(expected[mine], initial=0.0)), op=MPI.MAX)
    assert largest > 0.0
    assert found.damage[copy][mine, :, :3] == pytest.approx(
        expected[mine], rel=1e-6, abs=1e-9 * largest
    )
    assert set(np.unique(found.cycles[copy][mine])) <= {0.0, float(cycles)}
    assert not found.damage[:, names == "foam"].any()


@pytest.mark.parallel
def test_the_worst_places_depend_neither_on_ranks_nor_on_order_nor_on_blocks(folders, monkeypatch):
    runs = weigh([str(x) for x in folders], [0.25, 0.75], 0.1)
    life = find(runs)
    places, cells = WorstPlaces(life).find(), life.count_cells()
    section = WorstPlaces(life).find_section(places[0])
    monkeypatch.setattr(run_damage, "NUMBERS", 1)
    other = find(runs[::-1], MPI.COMM_SELF)
    assert len(places) == 10 and places[0].damage > 0.0
    assert cells == other.count_cells()
    again = WorstPlaces(other)
    for one, two in zip(places, again.find(), strict=True):
        assert one.damage == pytest.approx(two.damage, rel=1e-7)
        if one.damage > 0.0:
            assert (one.panel, one.ply, one.distance) == (two.panel, two.ply, two.distance)
            assert (one.blade, one.run, one.measure) == (two.blade, two.run, two.measure)
    alone = again.find_section(places[0])
    assert section.panels == alone.panels
    assert section.damage == pytest.approx(alone.damage, rel=1e-7)
    assert np.abs(section.ends) == pytest.approx(np.abs(alone.ends), abs=1e-9)


def test_damage_of_runs_adds_up_by_how_often_they_happen(folders):
    slow, fast = (WeightedRun(x, x.name) for x in folders)
    both = find([replace(slow, times=2e6), replace(fast, times=3e6)])
    alone = [find([replace(x, times=1e6)]).plies.damage for x in (slow, fast)]
    expected = 2.0 * alone[0] + 3.0 * alone[1]
    assert both.plies.damage == pytest.approx(expected, abs=1e-5 + 1e-9 * expected.max())
    assert sorted(both.plies.of_winds) == [9.0, 12.0]
    assert sum(both.plies.of_winds.values()) == pytest.approx(both.plies.damage)
    # the run of 0.5 s from 0.1 s on, all through the life
    assert WeightedRun(folders[0], "").find_times(0.4, 20.0) == 20.0 * YEAR / 0.4


def test_a_run_that_stretches_its_blades_once_is_less_than_one_cycle(folders):
    out = folders[0].parent / "once"
    shutil.copytree(folders[0], out)
    count = len(RecordedRun.open(out, COMM).motion.times)
    rows = np.frombuffer((out / "motion.bin").read_bytes()).reshape(count, -1)
    part = np.linspace(0.0, 1.0, count)[:, None]
    stretched = (1.0 + 1e-3 * part) * rows[2]
    stretched[:, 0] = rows[:, 0]
    (out / "motion.bin").write_bytes(stretched.tobytes())
    with pytest.raises(InputError, match="'once' lasts for less than one cycle of stress"):
        find([WeightedRun(out, "once", times=1e12)])


ADHESIVE = "life.adhesive={thickness=0.006,width=0.08,young=1.0,shear_modulus=1.0,slope=3,"


@pytest.mark.parallel
def test_bonds_carry_the_shear_flow_of_the_walls_that_end_in_them(folders):
    given = [*STRENGTHS, f"{ADHESIVE}tension=1e8,shear=1e8}}"]
    recorded = RecordedRun.open(folders[0], COMM, given, "life.")
    recovery = PlyRecovery(recorded)
    bonds = BondHistories(recovery, *find_adhesive(recorded.turbine.case))
    sides = ("suction_side", "pressure_side")
    names = [f"{bond}_{side}" for bond in ("web", "trailing_edge") for side in sides]
    assert list(recovery.plies.bonds) == names
    counts = {x: COMM.allreduce(len(cells)) for x, cells in recovery.plies.bonds.items()}
    for side in sides:
        assert counts[f"trailing_edge_{side}"] == 6  # in each row along the span
        panels = [recovery.plies.panels[x] for x in recovery.plies.panels if x.endswith(side)]
        assert np.isin(recovery.plies.bonds[f"trailing_edge_{side}"], np.concatenate(panels)).all()
    assert counts["web_suction_side"] == counts["web_pressure_side"] > 0
    row, copy, table = 9, 2, recovery.recovered.table
    for number, state in enumerate(recorded.list_states()):
        if number == row:
            recovery.plies.stresses.update(state, copy)
            stresses = recovery.plies.stresses.stresses().mean(axis=(1, 2))
    # N12 of the plies in the axes of the wall
    flow = np.zeros(len(table.first))
    for wall, ply, stress in zip(table.wall, table.plies, stresses, strict=True):
        flow[wall] += ply.thickness * (strain_in_ply(ply.angle).T @ stress)[2]
    moved = recovery.recovered.move(recovery.vectors[row : row + 1, copy], copy)
    found = np.zeros(len(bonds.cells))
    for block in bonds.split(1):
        found[block.places] = block.find(moved)[:, 0, 2, 0]
    largest = COMM.allreduce(float(np.max(np.abs(flow), initial=0.0)), op=MPI.MAX)
    assert found == pytest.approx(flow[bonds.cells] / 0.08, rel=1e-6, abs=1e-9 * largest)


@pytest.mark.parallel
def test_the_worst_bond_is_the_same_on_all_ranks_and_lacks_are_named(folders):
    runs = [WeightedRun(x, x.name, times=1e6) for x in folders]
    given = [*STRENGTHS, f"{ADHESIVE}tension=1e7,shear=1e7}}"]
    one, two = (find_worst_bonds(find_ply_life(runs, c, given)) for c in (COMM, MPI.COMM_SELF))
    assert len(one) == 4 and one[0].damage > 0.0
    for mine, alone in zip(one, two, strict=True):
        assert mine.damage == pytest.approx(alone.damage, rel=1e-7)
        if mine.damage > 0.0:
            assert (mine.bond, mine.blade, mine.run) == (alone.bond, alone.blade, alone.run)
    assert find_worst_bonds(find(runs)) == []
    with pytest.raises(InputError, match=r"the bonds have no shear: give life\.adhesive\.shear"):
        find_ply_life(runs, COMM, [*STRENGTHS, f"{ADHESIVE}tension=1e8}}"])
    with pytest.raises(InputError, match="expected both thickness and width, or neither"):
        find_ply_life(runs, COMM, [*STRENGTHS, "life.adhesive.width=0.1"])
