"""Odd arguments are refused in one sentence before anything is done; odd locales are no trouble."""

import os
import subprocess
import sys

import pytest

from turbine_fenicsx.cli.main import main


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "demos/paper/rigid.toml", "-o", ""],
        ["run", "demos/paper/rigid.toml", "--out="],
        ["run", "", "-o", "out"],
        ["plot", "out", "-o", ""],
        ["restart", ""],
    ],
)
def test_empty_argument_is_refused(arguments, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    said = capfd.readouterr()
    assert said.err == "error: an argument is empty; is a variable of the shell not set?\n"
    assert said.out == "" and os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    "arguments",
    [
        ["check", b"a\xff.toml"],
        ["run", "demos/paper/rigid.toml", "-o", b"a\xff"],
        ["info", "--", b"-a\xff"],
    ],
)
def test_argument_that_is_no_text_is_refused(arguments, tmp_path):
    # an environment variable would hide what PETSc does with it
    command = [sys.executable, "-m", "turbine_fenicsx", *arguments]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert result.returncode == 2
    assert result.stderr.startswith("error: the argument '")
    assert (
        result.stderr.endswith("\\udcff' is no text in utf-8\n") or "\\udcff.toml'" in result.stderr
    )
    assert result.stderr.count("\n") == 1
    assert os.listdir(tmp_path) == []


@pytest.mark.slow
def test_locale_of_ascii_shows_an_umlaut_in_its_own_way(command_line, demo, tmp_path, monkeypatch):
    for name, value in {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}.items():
        monkeypatch.setenv(name, value)
    out, changes = tmp_path / "out", ["title='größer'", "time.end=0.04"]
    result = command_line("run", demo("rigid.toml"), "-o", out, "--set", *changes)
    assert result.returncode == 2  # the title came in as bytes that are no text in ASCII
    assert "is no text in ascii" in result.stderr
    case = tmp_path / "case.toml"
    case.write_text(
        "title = 'größer'\n" + demo("rigid.toml").read_text(encoding="utf-8").split("\n", 4)[4],
        encoding="utf-8",
    )
    result = command_line("run", case, "-o", out, "--set", "time.end=0.04")
    assert result.returncode == 0, result.stderr
    assert result.stdout.startswith("gr\\xf6\\xdfer, 1 rank\n")
    assert (out / "summary.json").exists()
    for command in (["plot", out], ["report", out], ["check", case]):
        result = command_line(*command)
        assert result.returncode == 0, result.stderr
