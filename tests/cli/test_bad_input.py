"""Bad input: exit code 2, one sentence per mistake, no traceback, at once, on 1 and on 2 ranks."""

import re
import time

import pytest
from refusals import MISTAKES, SENTENCE, arguments_of, refused, without_warnings

from turbine_fenicsx.cli.main import main

IN_PROCESSES = [("unknown key", None), ("unknown key", 2), ("missing groups", 2)]
"""Mistakes in a case and in a mesh; the others are looked for inside of the tests."""


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_is_one_sentence_and_exit_code_2(demo, meshes, tmp_path, capfd, mistake):
    # inside this process, which saves a second each; the next test starts the program
    name, changes, words, number = (*MISTAKES[mistake], 1)[:4]
    out = tmp_path / "out"
    code = main(["run", *arguments_of(name, changes, demo, meshes), "-o", str(out)])
    output, errors = capfd.readouterr()
    assert code == 2
    assert output == ""
    lines = without_warnings(errors)
    assert len(lines) == number
    assert all(line.startswith(SENTENCE) for line in lines)
    assert re.search(words, errors), errors
    assert not (out / "history.csv").exists()  # nothing that looks like a result


@pytest.mark.parametrize(("mistake", "ranks"), IN_PROCESSES)
def test_program_refuses_at_once_and_on_all_ranks(
    command_line, demo, meshes, tmp_path, mistake, ranks
):
    name, changes, words = MISTAKES[mistake][:3]
    start = time.monotonic()
    arguments = arguments_of(name, changes, demo, meshes)
    result = command_line("run", *arguments, "-o", tmp_path / "out", ranks=ranks, timeout=60)
    (sentence,) = refused(result, time.monotonic() - start)
    assert re.search(words, sentence), sentence
    if ranks is None:
        assert without_warnings(result.stderr) == [f"{SENTENCE}{sentence}"]
    assert result.stdout == ""


def sentences(capfd, *arguments):
    """The sentences of a command that is refused."""
    assert main([str(x) for x in arguments]) == 2
    return [line.removeprefix(SENTENCE) for line in without_warnings(capfd.readouterr().err)]


def test_several_mistakes_are_several_sentences(demo, capfd):
    changes = ["time.step=0", "loads.duration=0", "colour=red"]
    assert len(sentences(capfd, "check", demo("rigid.toml"), "--set", *changes)) == 3


@pytest.mark.parametrize("out", ["{file}", "/proc/nothing"])
def test_output_that_cannot_be_written_is_refused(demo, tmp_path, capfd, out):
    # tests may run as root, who may write everywhere but below a file and in /proc
    file = tmp_path / "file"
    file.write_text("not a folder\n")
    folder = out.format(file=file)
    (sentence,) = sentences(capfd, "run", demo("rigid.toml"), "-o", folder)
    assert sentence.startswith(f"cannot write to {folder!r}: ")
    assert file.read_text() == "not a folder\n"


@pytest.mark.parametrize("name", ["history.csv", "fields.xdmf"])
def test_result_file_that_cannot_be_written_is_refused(command_line, demo, tmp_path, capfd, name):
    (tmp_path / name).mkdir()
    arguments = ["run", demo("rigid.toml"), "-o", tmp_path]
    if name == "history.csv":
        (sentence,) = sentences(capfd, *arguments)
    else:  # on two ranks
        start = time.monotonic()
        result = command_line(*arguments, ranks=2, timeout=60)
        (sentence,) = refused(result, time.monotonic() - start)
    assert str(tmp_path) in sentence


@pytest.mark.parametrize(
    ("file", "words"),
    [
        ("blade.vtk", "must end with .msh"),
        ("none/blade.msh", "no such directory"),
    ],
)
def test_mesh_that_cannot_be_written_is_refused(demo, tmp_path, capfd, file, words):
    (sentence,) = sentences(capfd, "mesh", demo("hybrid_stiff.toml"), "-o", tmp_path / file)
    assert words in sentence


def test_what_does_not_fit_into_the_memory_is_refused(demo, tmp_path, capfd, monkeypatch):
    memory = "turbine_fenicsx.linear_solvers.memory.machine_memory"
    monkeypatch.setattr(memory, lambda comm: 1e6)
    assert main(["run", str(demo("hybrid_stiff.toml")), "-o", str(tmp_path), "--quiet"]) == 2
    (sentence,) = capfd.readouterr().err.splitlines()
    assert sentence.startswith("error: 1053 displacements need ")
    assert "--force continues anyway" in sentence
    assert not (tmp_path / "history.csv").exists()


def test_good_mesh_of_a_user_runs(demo, meshes, tmp_path, no_pictures):
    # so that the refusals above are about what they say
    changes = ["time.end=0.04", f"mesh.file={meshes}/good.msh"]
    command = ["run", str(demo("hybrid_stiff.toml")), "-o", str(tmp_path), "--quiet"]
    assert main([*command, "--set", *changes]) == 0
    assert (tmp_path / "history.csv").exists()


@pytest.mark.parametrize(
    "arguments",
    [[], ["run"], ["run", "case.toml"], ["march", "case.toml"], ["check"], ["mesh", "case.toml"]],
)
def test_wrong_usage_is_exit_code_2_with_the_usage(capfd, arguments):
    with pytest.raises(SystemExit) as end:
        main(arguments)
    assert end.value.code == 2
    assert capfd.readouterr().err.startswith("usage: turbine-fenicsx")
