"""The commands that look at an output folder."""

import importlib.util
import re

import numpy as np
import pytest
from outputs import history, turbine, write

from turbine_fenicsx.cli.main import main

pytestmark = [
    pytest.mark.filterwarnings("ignore:Unable to import Axes3D"),
    pytest.mark.skipif(
        any(importlib.util.find_spec(name) is None for name in ("matplotlib", "pyvista")),
        reason="Matplotlib or PyVista, which draw, is missing",
    ),
]


@pytest.fixture
def out(tmp_path):
    """An output folder."""
    write(tmp_path / "run" / "history.csv", history(n=9))
    turbine(tmp_path / "run" / "fields.xdmf")
    return tmp_path / "run"


def test_plot_writes_png_and_pdf_into_the_first_folder_and_prints_them(out, capfd):
    other = write(out.parent / "other" / "history.csv", history(n=5)).parent
    assert main(["plot", str(out), str(other)]) == 0
    names = ("root_moments", "tip_deflections", "angles", "energy", "angular_momentum")
    paths = [out / f"{name}.{suffix}" for name in names for suffix in ("png", "pdf")]
    assert capfd.readouterr().out.splitlines() == [str(path) for path in paths]
    assert all(path.stat().st_size > 5000 for path in paths)
    assert not list(other.glob("*.png"))


def test_plot_puts_all_together_on_request(out, capfd, tmp_path):
    target = tmp_path / "new"
    options = ["--together", "--format", "svg", "-o", str(target), "--angles", "deg"]
    assert main(["plot", str(out), *options]) == 0
    assert capfd.readouterr().out == f"{target}/diagrams.svg\n"
    assert [path.name for path in target.iterdir()] == ["diagrams.svg"]


def test_results_are_printed_once_on_two_ranks(command_line, out):
    result = command_line("report", out, "--no-pictures", ranks=2)
    assert result.returncode == 0, result.stderr
    assert result.stdout == f"{out}/report.html\n"
    assert (out / "report.html").read_text().startswith("<!DOCTYPE html>")
    wrong = command_line("render", out, "--times", "0,7", ranks=2)
    assert wrong.returncode == 2
    assert wrong.stderr.count("error: t = 7 s is outside of the run") == 1


def test_render_draws_the_last_time_in_the_range_asked_for(out, capfd):
    from PIL import Image

    reds = []
    for high in (20, 200):  # MPa; the largest stress is 20 MPa
        code = main(["render", str(out), "--range", f"0,{high}", "--size", "640x360"])
        printed = capfd.readouterr()
        if "no graphics library" in printed.err:
            pytest.skip(printed.err)
        assert code == 0
        assert printed.out == f"{out}/turbine_t1.png\n"
        image = np.asarray(Image.open(out / "turbine_t1.png"), dtype=int)
        assert image.shape == (360, 640, 3)
        blades = image[:, :500]  # without the legend
        reds.append(int((blades[..., 0] - blades[..., 2] > 90).sum()))
    assert reds[1] == 0 < reds[0]


def test_pictures_of_either_format_are_the_same(out, capfd):
    pytest.importorskip("h5py")
    command = ["render", str(out), "--times", "0.9", "--size", "160x120", "--scale", "2"]
    if main(command) != 0:
        pytest.skip(capfd.readouterr().err)
    picture = out / "turbine_t1.png"
    first = picture.read_bytes()
    picture.unlink()
    (out / "fields.xdmf").unlink()
    turbine(out / "fields.vtkhdf")
    assert main(command) == 0
    assert picture.read_bytes() == first


def test_progress_is_told_where_there_is_no_terminal(out, capfd, monkeypatch):
    monkeypatch.setattr("turbine_fenicsx.cli.commands._frames.EVERY", 0.0)
    if main(["render", str(out), "--times", "0,1", "--size", "160x120"]) != 0:
        pytest.skip(capfd.readouterr().err)
    printed = capfd.readouterr()
    assert printed.err == "frame 1 of 2\nframe 2 of 2\n"
    assert len(printed.out.splitlines()) == 2


@pytest.mark.parametrize("command", ["plot", "render", "report"])
def test_help_explains_every_option(command, capfd):
    with pytest.raises(SystemExit) as end:
        main([command, "--help"])
    assert end.value.code == 0
    text = capfd.readouterr().out
    options = {
        "plot": ("--out", "--format", "--together", "--angles", "--tolerance", "kNms"),
        "render": (
            "--times",
            "--movie",
            "--scale",
            "--field",
            "--parts",
            "--size",
            "--cells",
            "ring",
        ),
        "report": ("--out", "--times", "--scale", "--no-pictures"),
    }[command]
    assert all(option in text for option in options)


MISTAKES = {
    "no folder": (["plot", "{none}"], "no output folder"),
    "no history": (["plot", "{empty}"], "cannot read .*history.csv.*No such file"),
    "folder given twice": (["plot", "{out}", "{out}"], "given twice"),
    "broken history": (["plot", "{broken}"], "history.csv: row 1: .*'now'"),
    "tolerance of zero": (["plot", "{out}", "--tolerance", "0"], "greater than 0"),
    "plot on a file": (["plot", "{out}", "-o", "{out}/history.csv"], "cannot write to"),
    "render no folder": (["render", "{none}"], "no output folder"),
    "no fields": (["render", "{empty}"], "there is no .*fields.xdmf"),
    "broken fields": (["render", "{broken}"], "fields.xdmf is not the field output"),
    "time outside": (["render", "{out}", "--times", "0,1.5"], "t = 1.5 s is outside"),
    "time that is none": (["render", "{out}", "--times", "0;1"], "--times 0;1: give numbers"),
    "negative scale": (["render", "{out}", "--scale", "-1"], "--scale -1: must be"),
    "no speed": (["render", "{out}", "--movie", "a.mp4", "--speed", "0"], "--speed 0: must be"),
    "range upside down": (["render", "{out}", "--range", "3,1"], "a low and a higher number"),
    "size that is none": (["render", "{out}", "--size", "big"], "--size big: give width x height"),
    "size too large": (["render", "{out}", "--size", "9x99999"], "--size 9x99999: give"),
    "odd movie": (["render", "{out}", "--size", "641x360", "--movie", "a.mp4"], "must be even"),
    "movie of another kind": (["render", "{out}", "--movie", "a.gif"], "ends in .mp4"),
    "render on a file": (["render", "{out}", "-o", "{out}/history.csv"], "cannot write to"),
    "movie below a file": (["render", "{out}", "--movie", "{out}/history.csv/a.mp4"], "cannot wr"),
    "report no folder": (["report", "{none}"], "no output folder"),
    "report no history": (["report", "{empty}"], "cannot read .*history.csv"),
    "report below a file": (
        ["report", "{out}", "--no-pictures", "-o", "{out}/history.csv/page.html"],
        "cannot write",
    ),
    "report on a result": (
        ["report", "{out}", "--no-pictures", "-o", "{out}/history.csv"],
        "the name of a page ends in .html",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_is_one_sentence_and_exit_code_2(out, capfd, mistake):
    arguments, words = MISTAKES[mistake]
    folders = {name: out.parent / name for name in ("none", "empty", "broken")}
    folders["empty"].mkdir()
    folders["broken"].mkdir()
    (folders["broken"] / "history.csv").write_text("time_[s]\nnow\n")
    (folders["broken"] / "fields.xdmf").write_text("no XML")
    assert main([argument.format(out=out, **folders) for argument in arguments]) == 2
    printed = capfd.readouterr()
    (line,) = printed.err.splitlines()
    assert line.startswith("error: ")
    assert re.search(words, line), line
    assert printed.out == ""
