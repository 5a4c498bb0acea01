"""Commands, options and exit codes of the command line."""

import argparse
import csv
import json
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from patience import patience

import turbine_fenicsx
from turbine_fenicsx.cli.commands import _running
from turbine_fenicsx.cli.commands._common import fail
from turbine_fenicsx.cli.main import main
from turbine_fenicsx.turbine.case.case import Case


def rows(folder):
    """Rows of ``history.csv`` without the header."""
    with (Path(folder) / "history.csv").open(newline="") as file:
        return list(csv.reader(file))[1:]


def test_info_prints_the_versions_of_everything(command_line):
    result = command_line("info")
    assert result.returncode == 0, result.stderr
    found = dict(line.split(maxsplit=1) for line in result.stdout.splitlines())
    assert found["turbine_fenicsx"] == turbine_fenicsx.__version__
    assert {"python", "petsc", "mpi", "numpy", "stack"} <= found.keys()
    assert {"fenics-dolfinx", "dolfinx-solver-real"} & found.keys()


def test_installed_program_and_module_are_the_same(command_line):
    program = shutil.which("turbine-fenicsx", path=str(Path(sys.executable).parent))
    if program is None:
        pytest.skip("turbine-fenicsx is not installed beside this python")
    assert command_line("info", program=[program]).stdout == command_line("info").stdout


def test_commands_speak_once_on_two_ranks(command_line, demo):
    info = command_line("info", ranks=2)
    assert info.returncode == 0, info.stderr
    assert len(re.findall("^turbine_fenicsx ", info.stdout, re.MULTILINE)) == 1
    check = command_line("check", demo("hybrid_stiff.toml"), ranks=2)
    assert check.returncode == 0, check.stderr
    assert check.stdout.count("valid") == 1


def test_help_names_all_commands(capfd):
    with pytest.raises(SystemExit) as end:
        main(["--help"])
    assert end.value.code == 0
    text = capfd.readouterr().out
    assert all(word in text for word in ("run", "mesh", "check", "info", "-tfx_snes_monitor"))


def test_check_reports_on_the_case_and_its_mesh(demo, capfd):
    assert main(["check", str(demo("rigid.toml"))]) == 0
    assert "rigid.toml: valid" in capfd.readouterr().out
    assert main(["check", str(demo("hybrid_stiff.toml"))]) == 0
    text = capfd.readouterr().out
    assert "144 linear hexahedra, 351 nodes" in text
    quality = re.search(r"worst scaled Jacobian ([0-9.]+)", text)
    assert quality
    assert 0.0 < float(quality[1]) <= 1.0


def test_mesh_writes_what_run_can_read_back(demo, capfd, tmp_path):
    path = tmp_path / "blade.msh"
    case = str(demo("hybrid_stiff.toml"))
    changes = ["--set", "mesh.elements=[1, 1, 4]"]
    assert main(["mesh", case, "-o", str(path), *changes]) == 0
    report = capfd.readouterr().out
    assert report.startswith(f"{path}\n12 linear hexahedra")
    for group in ("blade_1", "root_1", "skin_1", "blade_3", "root_3", "skin_3"):
        assert f'"{group}"' in path.read_text(encoding="utf-8")
    assert main(["check", case, "--set", f"mesh.file={path}"]) == 0
    read_back = capfd.readouterr().out
    assert report.splitlines()[1:] == read_back.splitlines()[-8:-3]


def test_settings_may_be_given_together_or_apart(demo, tmp_path, capfd):
    case, quiet = str(demo("rigid.toml")), ["--progress", "none"]
    together = ["--set", "time.end=0.1", "time.step=0.05", "output.fields_every=0"]
    apart = [x for s in together[1:] for x in ("--set", s)]
    for k, settings in enumerate((together, apart)):
        assert main(["run", case, "-o", str(tmp_path / str(k)), *settings, *quiet]) == 0
        times = [float(row[0]) for row in rows(tmp_path / str(k))]
        assert times == pytest.approx([0.0, 0.05, 0.1], abs=1e-15)
    capfd.readouterr()


def test_last_step_is_shortened_to_meet_the_end(demo, tmp_path, capfd):
    settings = ["--set", "time.end=0.07", "time.step=0.02", "output.fields_every=0"]
    assert main(["run", str(demo("rigid.toml")), "-o", str(tmp_path), *settings]) == 0
    times = [float(row[0]) for row in rows(tmp_path)]
    assert times == pytest.approx([0.0, 0.02, 0.04, 0.06, 0.07], abs=1e-15)
    capfd.readouterr()


def test_run_of_no_time_writes_the_initial_state(demo, tmp_path, capfd):
    assert main(["run", str(demo("rigid.toml")), "-o", str(tmp_path), "--set", "time.end=0"]) == 0
    assert len(rows(tmp_path)) == 1
    assert (tmp_path / "summary.json").exists()
    capfd.readouterr()


@pytest.mark.parametrize("ranks", [None, 2])
def test_options_after_two_dashes_reach_petsc_and_unused_ones_are_reported(
    command_line, demo, tmp_path, ranks
):
    result = command_line(
        "run",
        demo("hybrid_stiff.toml"),
        *("-o", tmp_path, "--set", "time.end=0.04", "output.fields_every=0"),
        *("--", "-tfx_snes_monitor", "-tfx_snes_monitr_typo"),
        ranks=ranks,
    )
    assert result.returncode == 0, result.stderr
    text = result.stdout + result.stderr
    # once for each iteration of each step, not on each rank
    iterations = sum(int(row[-3]) + 1 for row in rows(tmp_path)[1:])
    assert text.count("SNES Function norm") == iterations
    report = text[text.index("unused database option") :]
    assert "tfx_snes_monitr_typo" in report
    assert "tfx_snes_monitor " not in report


@pytest.mark.parametrize("ranks", [None, 2])
def test_step_that_does_not_converge_is_exit_code_3_and_keeps_the_results(
    command_line, demo, tmp_path, ranks
):
    # far more than a quarter revolution in the smallest step, so all halvings fail
    result = command_line(
        "run",
        demo("rigid.toml"),
        *("-o", tmp_path, "--set", "loads.rotor_torque=1e22"),
        ranks=ranks,
        timeout=60,
    )
    assert result.returncode == 3, result.stderr
    assert "Traceback" not in result.stderr
    (sentence,) = (s for s in result.stderr.splitlines() if s.startswith("error: "))
    assert "did not converge" in sentence
    assert str(tmp_path) in sentence
    assert len(rows(tmp_path)) >= 1
    assert (tmp_path / "fields.xdmf").read_text().rstrip().endswith("</Xdmf>")


def test_interrupted_run_keeps_the_results(demo, tmp_path):
    command = [sys.executable, "-m", "turbine_fenicsx", "run", str(demo("rigid.toml"))]
    command += ["-o", str(tmp_path), "--set", "time.end=1000", "output.fields_every=0.1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as p:
        try:
            start = time.monotonic()
            history = tmp_path / "history.csv"
            while not history.exists() or len(rows(tmp_path)) < 20:
                assert p.poll() is None, p.stderr.read()
                assert time.monotonic() - start < patience(60.0)
                time.sleep(0.05)
            p.send_signal(signal.SIGINT)
            _, errors = p.communicate(timeout=patience(30))
        finally:
            p.kill()
    assert p.returncode == 130
    assert errors.splitlines()[-1].startswith("error: interrupted")
    assert "Traceback" not in errors
    lengths = {len(row) for row in rows(tmp_path)}
    assert len(lengths) == 1  # no row is torn
    assert (tmp_path / "fields.xdmf").read_text().rstrip().endswith("</Xdmf>")


def test_reader_that_leaves_is_no_error(demo):
    """As with `turbine-fenicsx check CASE | head -1`."""
    command = [sys.executable, "-m", "turbine_fenicsx", "check", str(demo("hybrid_stiff.toml"))]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    process.stdout.close()
    errors = process.stderr.read()
    assert process.wait(timeout=patience(60)) == 0
    assert errors == ""


def test_a_run_whose_energy_balance_is_wrong_says_so_and_has_an_exit_code(demo, tmp_path, capfd):
    changes = ["mesh.elements=[1,1,2]", "time.end=0.2", "output.fields_every=0"]
    loose = ["run", str(demo("hybrid_stiff.toml")), "-o", str(tmp_path / "loose"), "--quiet"]
    assert main([*loose, "--set", *changes, "solver.tolerance=0.99"]) == 4
    error = capfd.readouterr().err.splitlines()[-1]  # after a wait for another's compilation
    assert error.startswith("error: the energy balance is wrong by ")  # not red: no terminal
    assert "do not trust this run" in error
    (kept,) = json.loads((tmp_path / "loose" / "summary.json").read_text())["warnings"]
    assert error == f"error: {kept}"
    assert kept in (tmp_path / "loose" / "run.log").read_text()


def test_plies_that_fail_are_a_warning_of_a_run_that_is_done(monkeypatch, capfd, comm):
    monkeypatch.setattr(_running, "_draw_history", lambda *_: [])
    result = {"interrupted": False, "warnings": ["plies fail: here"]}
    options = argparse.Namespace(out="out", quiet=True)
    assert _running.carry_out(options, comm, lambda _: (Case(), result)) == 0
    assert capfd.readouterr().err == ("warning: plies fail: here\n" if comm.rank == 0 else "")


def test_errors_are_red_on_a_terminal_only(monkeypatch, capfd, comm):
    for terminal, text in ((True, "\033[31merror: no\033[0m\n"), (False, "error: no\n")):
        monkeypatch.setattr(sys.stderr, "isatty", lambda terminal=terminal: terminal)
        assert fail(comm, "no", 2) == 2
        assert capfd.readouterr().err == text
