"""The benchmark harness at its smallest: two codes, one tiny mesh; and what the report refuses."""

import importlib
import importlib.util
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest
from windio_files import IEA_22, find_turbine

from turbine_fenicsx.meshing.cells import reference_cell

pytestmark = pytest.mark.skipif(MPI.COMM_WORLD.size > 1, reason="starts programs of its own")

FOLDER = Path(__file__).parent.parent / "benchmarks"
EDGES = "12 23 34 41 56 67 78 85 15 26 37 48".split()
"""Corners beside the nodes 9 to 20 of CalculiX' hexahedron of 20 nodes, by its manual."""


def record(code, tips, step=1.0, **more):
    """What a competitor reports, in short."""
    numbers = {"unknowns": 70_713, "steps": [9.0, 9.0, step], "iterations": [2, 2, 2]}
    sizes = {"set_up": 1.0, "memory": 100.0, "ranks": 1, "threads": 1, "versions": {}, "turn": 0}
    known = {"part": "compare", "size": "8x8x96", "code": code, "tips": tips}
    return {**known, **numbers, **sizes, **more}


def report(*records):
    """Text of the report, and whether deflections agree."""
    spec = importlib.util.spec_from_file_location("benchmark_report", FOLDER / "report.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    machine = {"processor": "any", "cores": 1, "load_before": 0.0, "date": "2012-01-01"}
    return module.report({"machine": machine, "records": list(records)})


@pytest.mark.slow
def test_smallest_run_agrees_and_writes_all_files(tmp_path):
    command = [sys.executable, str(FOLDER / "run.py"), "--parts", "compare", "--sizes", "2x2x4"]
    command += ["--steps", "3", "--repeat", "1", "--only", "ours-hybrid|fenicsx-lu"]
    done = subprocess.run([*command, "--out", str(tmp_path)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    records = json.loads((tmp_path / "results.json").read_text())["records"]
    assert [r["code"] for r in records] == ["fenicsx-lu", "ours-hybrid"]
    assert all(len(r["steps"]) == 3 and r["unknowns"] == 9 * 3 * 3 * 5 for r in records)
    assert all(r["memory"] > 10 and "blas" in r for r in records)
    assert "| ours-hybrid |" in (tmp_path / "report.md").read_text()
    assert (tmp_path / "scaling.png").exists()


@pytest.mark.slow
def test_hollow_blades_bend_alike_in_all_codes():
    """A table with a line for each, and the units of a step only for this package."""
    find_turbine(IEA_22)
    command = [sys.executable, str(FOLDER / "hollow.py"), "--span", "5", "--around", "16"]
    command += ["--steps", "3", "clamped", "fenicsx-lagged"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = [row.split("|")[1:-1] for row in done.stdout.splitlines()[4:]]
    ours, script = ([cell.strip() for cell in row] for row in rows)
    assert (ours[0], script[0]) == ("clamped", "fenicsx-lagged")
    assert float(ours[1]) < float(script[1]) and float(ours[2]) == pytest.approx(
        100.0 * float(ours[1]), rel=0.01
    )
    assert float(ours[5]) > 1.0 and script[5] == ""


@pytest.mark.skipif(not shutil.which("ccx"), reason="needs CalculiX")
def test_hollow_blades_are_measured_with_calculix_too():
    find_turbine(IEA_22)
    command = [sys.executable, str(FOLDER / "hollow.py"), "--span", "5", "--around", "16"]
    done = subprocess.run([*command, "--steps", "3", "calculix"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    row = [cell.strip() for cell in done.stdout.splitlines()[4].split("|")[1:-1]]
    assert row[0] == "calculix" and float(row[1]) > 0.0 and float(row[3]) > 1.0


def test_calculix_gets_the_nodes_on_edges_of_hexahedra_in_its_order(monkeypatch):
    """Corners of the edges that nodes 9 to 20 of C3D20R lie on, by CalculiX' manual."""
    hollow = load("hollow", monkeypatch)
    lattice = reference_cell("hexahedron", 2).lattice  # corners at 0 and 2
    corners = lattice[:8]
    pairs = np.array([[int(k) - 1 for k in pair] for pair in EDGES])
    np.testing.assert_array_equal(
        2 * lattice[hollow.SERENDIPITY], [*2 * corners, *corners[pairs].sum(axis=1)]
    )


@pytest.mark.parametrize(
    ("words", "sentence"),
    [(["nastran"], "no such code: nastran"), (["--around", "14"], "take at least 15 elements")],
)
def test_hollow_blades_that_cannot_be_measured_are_refused(words, sentence):
    find_turbine(IEA_22)
    command = [sys.executable, str(FOLDER / "hollow.py"), *words]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2 and sentence in done.stderr


def test_ratios_come_from_the_fastest_turn_of_codes_that_agree():
    tips = [[0.0, 1.0, 0.0]] * 3
    text, agree = report(
        record("fenicsx-lu", tips, 20.0),
        record("fenicsx-lu", tips, 12.0, turn=1),
        record("ours-hybrid", tips, 1.0),
    )
    assert agree
    assert "| full Newton + LU / ours, 70 k | at least 8 | 12 | met |" in text


def test_other_deflections_give_no_ratio():
    tips, wrong = [[0.0, 1.0, 0.0]] * 3, [[0.0, 1.01, 0.0]] * 3
    text, agree = report(record("fenicsx-lu", tips, 20.0), record("ours-hybrid", wrong, 1.0))
    assert not agree
    assert "| full Newton + LU / ours, 70 k | at least 8 | not measured |" in text
    assert "tips disagree" in text


def test_a_size_that_all_codes_ran_counts_as_growth_too():
    tips = [[0.0, 1.0, 0.0]] * 3
    big = {"size": "14x14x148", "unknowns": 301_725}
    one, two = (
        record(code, tips, s) | big for code, s in (("ours-hybrid", 2), ("ours-hybrid-2", 1))
    )
    text, agree = report(one, two)
    assert agree
    assert "| one rank / two ranks, 300 k | at least 1.7 | 2 | met |" in text


@pytest.mark.slow
def test_the_benchmark_of_the_whole_command_runs_it_as_often_as_it_needs(tmp_path, monkeypatch):
    paper = load("paper", monkeypatch)
    for _ in range(2):
        seconds, summary = paper.run(str(tmp_path), "time.end=0.04", "mesh.elements=[1,1,2]")
        assert seconds > 0.0 and summary["steps"] == 2


def load(name, monkeypatch):
    """A script of the benchmarks as a module."""
    monkeypatch.syspath_prepend(str(FOLDER))
    return importlib.import_module(name)


@pytest.mark.skipif(not shutil.which("mpicc"), reason="needs mpicc")
@pytest.mark.slow
def test_a_step_on_two_ranks_sends_between_neighbours_and_has_the_same_result(tmp_path):
    command = [sys.executable, str(FOLDER / "ranks.py"), "--sizes", "2x2x12", "--ranks", "1,2"]
    command += ["--solvers", "frozen", "--steps", "3", "--out", str(tmp_path)]
    clean = dict(os.environ)  # without what MPI has added since
    done = subprocess.run(command, capture_output=True, text=True, env=clean)
    assert done.returncode == 0, done.stdout + done.stderr
    alone, both = (run["of_rank"] for run in json.loads((tmp_path / "ranks.json").read_text()))
    assert alone["messages"] == [0.0] and both["messages"][0] == both["messages"][1] > 0
    assert 0 < max(both["ghosts"]) < max(both["owned"]) < alone["owned"][0]
    assert "| `frozen` | 2 |" in done.stdout


def test_what_depends_on_the_number_of_ranks_is_told(monkeypatch):
    runs = [
        {"solver": "frozen", "ranks": 1, "iterations": [5], "tips": [[0.0, 1.0, 0.0]]},
        {"solver": "frozen", "ranks": 4, "iterations": [7], "tips": [[0.0, 1.0 + 1e-8, 0.0]]},
    ]
    ranks = load("ranks", monkeypatch)
    assert ranks.compare(runs) == [
        '"frozen" on 4 ranks: tips differ by 1.0e-08 from those on 1',
        '"frozen" on 4 ranks: iterations [7], not [5]',
    ]


def test_model_of_many_ranks_agrees_with_steps_that_were_measured(monkeypatch, tmp_path):
    pytest.importorskip("matplotlib")
    model = load("scaling_model", monkeypatch)
    runs = json.loads((FOLDER / "ranks.json").read_text())
    machine, alone = model.Machine(), model.Slabs(70_713, 1)
    frozen = model.frozen_step(alone, model.Counts(runs, "frozen", 16), machine)
    iterative = model.iterative_step(alone, model.Counts(runs, "iterative", 16), machine)
    assert 0.5 < sum(frozen.values()) / 0.13 < 1.5  # benchmarks/README.md
    assert 0.5 < sum(iterative.values()) / 0.755 < 1.5
    lines = model.draw(runs, tmp_path / "model.png").splitlines()
    assert (tmp_path / "model.png").stat().st_size > 10_000
    assert [line.partition(":")[0] for line in lines][-1].startswith('"iterative", 20000 unknowns')


KERNEL = """
void tabulate_tensor_integral_1(double* restrict A, const double* restrict w,
    const double* restrict c, const double* restrict coordinate_dofs,
    const int* restrict entity_local_index, const uint8_t* restrict quadrature_permutation)
{
  double s[2];
  s[0] = w[0] * w[1] + c[0];
  for (int k = 0; k < 2; ++k)
    A[k] += s[0] * coordinate_dofs[3];
}
"""


@pytest.mark.skipif(not shutil.which("g++"), reason="needs g++")
def test_operations_and_bytes_of_a_kernel_are_counted(monkeypatch, tmp_path):
    roofline = load("roofline", monkeypatch)
    numbers = roofline.run_kernel(KERNEL, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], tmp_path)
    assert numbers[:4] == [6, 16, 8, 16]  # operations; bytes of w, coordinates and A
    assert all(number > 0.0 for number in numbers[4:])
