"""The command ``demo``: every demo case of the project, wherever the package is installed."""

from pathlib import Path

import pytest
from windio_files import IEA_15, find_turbine

from turbine_fenicsx.cli.main import main
from turbine_fenicsx.turbine.case.case import Case

ROOT = Path(__file__).parents[2]
FOLDERS = ("paper", "turbine", "emergency_stop", "iea15", "iea15_gust")
CASES = {f.stem: f for folder in FOLDERS for f in (ROOT / "demos" / folder).glob("*.toml")}


@pytest.fixture
def windio():
    """Skips the test without the turbines of windIO, by whose names cases find them."""
    find_turbine(IEA_15)


def test_every_case_of_the_folder_demos_is_listed_with_its_title(capfd, windio):
    assert main(["demo"]) == 0
    lines = capfd.readouterr().out.splitlines()
    assert dict(line.split(maxsplit=1) for line in lines) == {
        name: Case.load(file).title for name, file in CASES.items()
    }


@pytest.mark.parametrize("name", CASES)
def test_written_case_is_that_of_the_folder_demos(name, tmp_path, monkeypatch, capfd, windio):
    monkeypatch.chdir(tmp_path)
    assert main(["demo", name]) == 0
    written = tmp_path / f"{name}.toml"
    assert written.read_bytes() == CASES[name].read_bytes()
    assert not written.is_symlink()
    assert main(["check", f"{name}.toml"]) == 0  # it needs no file beside it
    said = capfd.readouterr().out
    assert said.startswith(
        f"wrote {name}.toml; now: turbine-fenicsx run {name}.toml -o out/{name}\n"
    )


def test_an_existing_file_stays(tmp_path, capfd):
    mine = tmp_path / "mine.toml"
    mine.write_text("my work")
    assert main(["demo", "rigid", "-o", str(mine)]) == 2
    assert capfd.readouterr().err == f"error: {str(mine)!r} exists; give another file with -o\n"
    assert mine.read_text() == "my work"


def test_wrong_names_and_places_are_told(tmp_path, capfd):
    assert main(["demo", "rigit"]) == 2
    assert (
        "no demo case 'rigit'; choose from emergency_stop, flexible_tower" in capfd.readouterr().err
    )
    assert main(["demo", "rigid", "-o", str(tmp_path / "no" / "a.toml")]) == 2
    assert "No such file or directory" in capfd.readouterr().err


def test_two_ranks_write_one_file(command_line, tmp_path):
    result = command_line("demo", "rigid", "-o", tmp_path / "a.toml", ranks=2)
    assert result.returncode == 0, result.stderr
    assert result.stdout.count("wrote") == 1
