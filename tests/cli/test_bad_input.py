"""Bad input: exit code 2, one sentence per mistake, no traceback, at once, on 1 and on 2 ranks."""

import re
import time

import pytest

from turbine_fenicsx.cli import main
from turbine_fenicsx.meshing.session import gmsh_session

SENTENCE = "error: "


def write_mesh(path, volumes, surfaces, empty=()):
    """A user's mesh: boxes of 1 m x 10 m x 1 m side by side, with physical groups.

    Args:
        path: The file.
        volumes: Names of the boxes.
        surfaces: For each named surface the number of the box whose lower end it is.
        empty: Names of surfaces that hold no element.
    """
    with gmsh_session({"Mesh.MeshSizeMin": 1.0, "Mesh.MeshSizeMax": 2.0}) as gmsh:
        model = gmsh.model
        boxes = [model.occ.addBox(10.0 * k, 2.25, -5.5, 1, 10, 1) for k in range(len(volumes))]
        model.occ.synchronize()
        for box, name in zip(boxes, volumes, strict=True):
            model.setPhysicalName(3, model.addPhysicalGroup(3, [box]), name)
        for name, number in surfaces.items():
            faces = [face for _, face in model.getBoundary([(3, boxes[number])], oriented=False)]
            end = min(faces, key=lambda face: model.occ.getCenterOfMass(2, face)[1])
            if name in empty:
                end = model.addDiscreteEntity(2)
            model.setPhysicalName(2, model.addPhysicalGroup(2, [end]), name)
        model.mesh.generate(3)
        gmsh.write(str(path))


@pytest.fixture(scope="module")
def meshes(tmp_path_factory):
    """Meshes of a user by name."""
    folder = tmp_path_factory.mktemp("meshes")
    blades = ["blade_1", "blade_2", "blade_3"]
    roots = {"root_1": 0, "root_2": 1, "root_3": 2}
    write_mesh(folder / "good.msh", blades, roots)
    write_mesh(folder / "other_names.msh", ["Wing", "Fin", "Tail"], {"Base": 0})
    write_mesh(folder / "two_roots.msh", blades, {"root_1": 0, "root_2": 1})
    write_mesh(folder / "empty_root.msh", blades, roots, empty=["root_2"])
    write_mesh(folder / "more_parts.msh", [*blades, "tower"], roots)
    write_mesh(folder / "root_elsewhere.msh", [*blades, "tower"], roots | {"root_1": 3})
    write_mesh(
        folder / "roots_on_wrong_blades.msh", blades, {"root_1": 1, "root_2": 0, "root_3": 2}
    )
    (folder / "text.msh").write_text("this is no mesh\n")
    return folder


def refused(result, seconds):
    """The sentences of a refused command, after checking everything that all refusals share."""
    assert result.returncode == 2, result.stderr
    assert "Traceback" not in result.stderr + result.stdout
    # Without mpirun nothing else is on stderr; mpirun adds its own lines about the exit code.
    sentences = [line for line in result.stderr.splitlines() if line.startswith(SENTENCE)]
    assert sentences
    assert len(set(sentences)) == len(sentences)  # said once, not by every rank
    # before any heavy work: starting python, importing DOLFINx and reading a mesh take 1 to 4 s
    assert seconds < 20.0
    return [sentence.removeprefix(SENTENCE) for sentence in sentences]


# Case, changes, words that the sentence must hold, number of sentences
MISTAKES = {
    "missing file": ("none.toml", [], "cannot read the case file 'none.toml'"),
    "unknown key": ("hybrid_stiff.toml", ["time.stop=1"], "did you mean 'time.step'?"),
    "unknown section": ("rigid.toml", ["tme.end=1"], "unknown key 'tme'; did you mean 'time'?"),
    "negative density": ("hybrid_stiff.toml", ["material.density=-1500"], "material.density"),
    "zero step": ("rigid.toml", ["time.step=0"], "time.step = 0: "),
    "negative step": ("hybrid_soft.toml", ["time.step=-0.02 s"], "time.step = '-0.02 s': "),
    "indefinite material": (
        "hybrid_stiff.toml",
        ["material.poisson=[0.9, 0.9, 0.9]"],
        "not positive definite",
    ),
    "indefinite soft material": (
        "hybrid_soft.toml",
        ["material.shear_modulus=-1 GPa"],
        "not positive definite",
    ),
    "chord of wrong length": ("hybrid_stiff.toml", ["blade.chord=[1, 2]"], "blade.chord"),
    "bad override": ("rigid.toml", ["time.end"], "write --set section.key=value"),
    "wrong unit": ("rigid.toml", ["loads.rotor_torque=3 kN"], "number in N m"),
    "missing mesh": ("hybrid_stiff.toml", ["mesh.file=none.msh"], "none.msh"),
    "missing groups": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/other_names.msh"],
        "'blade_1', 'blade_2', 'blade_3' .*it has the volumes 'Fin', 'Tail', 'Wing' and the "
        "surface 'Base'",
    ),
    "missing root": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/two_roots.msh"],
        "lacks the physical surface 'root_3'; it has .* 'root_1', 'root_2'",
    ),
    "hub without nodes": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/empty_root.msh"],
        "lacks the physical surface 'root_2'",
    ),
    "root on another part": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/root_elsewhere.msh"],
        "belong to none of the groups blade_1, blade_2, blade_3",
    ),
    "more than the blades": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/more_parts.msh"],
        "belong to none of the groups blade_1, blade_2, blade_3",
    ),
    "roots on the wrong blades": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/roots_on_wrong_blades.msh"],
        "faces of the group root_1 do not lie on blade_1",
    ),
    "modulus that is no number": (
        "hybrid_stiff.toml",
        ["material.young=[nan, 15e9, 15e9]"],
        "material.young",
    ),
    "mesh that is none": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/text.msh"],
        "is not a mesh in gmsh's .msh format",
    ),
}
IN_THE_ISSUE = (
    "missing file",
    "unknown key",
    "negative density",
    "zero step",
    "indefinite material",
    "missing groups",
    "hub without nodes",
)


def arguments_of(name, changes, demo, meshes):
    """Arguments of the command line for a mistake, without the output folder."""
    changes = [change.format(meshes=meshes) for change in changes]
    case = demo(name) if demo(name).exists() else name
    return [str(case), *(["--set", *changes] if changes else [])]


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_is_one_sentence_and_exit_code_2(demo, meshes, tmp_path, capfd, mistake):
    # inside this process, which saves a second each; the next test starts the program
    name, changes, words = MISTAKES[mistake]
    out = tmp_path / "out"
    code = main(["run", *arguments_of(name, changes, demo, meshes), "-o", str(out)])
    output, errors = capfd.readouterr()
    assert code == 2
    assert output == ""
    (line,) = errors.splitlines()
    assert line.startswith(SENTENCE)
    assert re.search(words, line), line
    assert not (out / "history.csv").exists()  # nothing that looks like a result


@pytest.mark.parametrize("ranks", [None, 2])
@pytest.mark.parametrize("mistake", IN_THE_ISSUE)
def test_program_refuses_at_once_and_on_all_ranks(
    command_line, demo, meshes, tmp_path, mistake, ranks
):
    name, changes, words = MISTAKES[mistake]
    start = time.monotonic()
    arguments = arguments_of(name, changes, demo, meshes)
    result = command_line("run", *arguments, "-o", tmp_path / "out", ranks=ranks, timeout=60)
    (sentence,) = refused(result, time.monotonic() - start)
    assert re.search(words, sentence), sentence
    if ranks is None:
        assert result.stderr == f"{SENTENCE}{sentence}\n"
    assert result.stdout == ""


def test_several_mistakes_are_several_sentences(command_line, demo):
    result = command_line(
        "check", demo("rigid.toml"), "--set", "time.step=0", "loads.duration=0", "colour=red"
    )
    assert len(refused(result, 0.0)) == 3


@pytest.mark.parametrize(
    ("out", "ranks"), [("{file}", None), ("{file}/below", 2), ("/proc/nothing", None)]
)
def test_output_that_cannot_be_written_is_refused(command_line, demo, tmp_path, out, ranks):
    # tests may run as root, who may write everywhere but below a file and in /proc
    file = tmp_path / "file"
    file.write_text("not a folder\n")
    folder = out.format(file=file)
    start = time.monotonic()
    result = command_line("run", demo("rigid.toml"), "-o", folder, ranks=ranks, timeout=60)
    (sentence,) = refused(result, time.monotonic() - start)
    assert sentence.startswith(f"cannot write to {folder!r}: ")
    assert file.read_text() == "not a folder\n"


@pytest.mark.parametrize(("name", "ranks"), [("history.csv", None), ("fields.xdmf", 2)])
def test_result_file_that_cannot_be_written_is_refused(command_line, demo, tmp_path, name, ranks):
    (tmp_path / name).mkdir()
    start = time.monotonic()
    result = command_line("run", demo("rigid.toml"), "-o", tmp_path, ranks=ranks, timeout=60)
    (sentence,) = refused(result, time.monotonic() - start)
    assert str(tmp_path) in sentence


@pytest.mark.parametrize(
    ("file", "words"),
    [
        ("blade.vtk", "must end with .msh"),
        ("none/blade.msh", "no such directory"),
    ],
)
def test_mesh_that_cannot_be_written_is_refused(command_line, demo, tmp_path, file, words):
    start = time.monotonic()
    result = command_line("mesh", demo("hybrid_stiff.toml"), "-o", tmp_path / file)
    (sentence,) = refused(result, time.monotonic() - start)
    assert words in sentence


@pytest.mark.parametrize(
    "mistake",
    [
        "chord of wrong length",
        "missing groups",
        "roots on the wrong blades",
        "more than the blades",
    ],
)
def test_check_refuses_what_run_refuses(demo, meshes, tmp_path, capfd, mistake):
    arguments = arguments_of(*MISTAKES[mistake][:2], demo, meshes)
    assert main(["run", *arguments, "-o", str(tmp_path)]) == 2
    said = capfd.readouterr().err
    assert main(["check", *arguments]) == 2
    assert capfd.readouterr().err == said


def test_check_looks_at_the_blades_of_rigid_turbines_too(demo, capfd):
    assert main(["check", str(demo("rigid.toml")), "--set", "blade.chord=[1, 2]"]) == 2
    assert capfd.readouterr().err.startswith("error: blade.chord")


def test_good_mesh_of_a_user_runs(command_line, demo, meshes, tmp_path):
    # so that the refusals above are about what they say
    result = command_line(
        "run",
        demo("hybrid_stiff.toml"),
        *("-o", tmp_path, "--set", "time.end=0.04", f"mesh.file={meshes}/good.msh"),
    )
    assert result.returncode == 0, result.stderr
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
