"""Bad input: exit code 2, one sentence per mistake, no traceback, at once, on 1 and on 2 ranks."""

import json
import re
import time
from math import hypot, pi

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from patience import patience

from turbine_fenicsx.cli.main import main
from turbine_fenicsx.meshing.session import gmsh_session

SENTENCE = "error: "


def write_mesh(path, volumes, surfaces, empty=(), radius=2.25, bricks=1):
    """A user's mesh: boxes of 1 m x 10 m x 1 m on the hub, with physical groups.

    Args:
        path: The file.
        volumes: Names of the boxes; the first three stand where the blades belong, others far off.
        surfaces: For each named surface the number of the box whose inner end it is.
        empty: Names of surfaces that hold no element.
        radius: Where the boxes begin [m].
        bricks: Number of bricks on top of each other that make up a box, not merged.
    """
    with gmsh_session({"Mesh.MeshSizeMin": 1.0, "Mesh.MeshSizeMax": 2.0}) as gmsh:
        model, ends = gmsh.model, []
        for k, name in enumerate(volumes):
            height = 10.0 / bricks
            box = [
                (3, model.occ.addBox(-0.5, radius + i * height, -5.5, 1, height, 1))
                for i in range(bricks)
            ]
            model.occ.rotate(box, 0, 0, 0, 0, 0, 1, 2.0 * pi / 3.0 * (k - 1))
            model.occ.translate(box, 0, 0, 100.0 * (k // 3))
            model.occ.synchronize()
            tags = [tag for _, tag in box]
            model.setPhysicalName(3, model.addPhysicalGroup(3, tags), name)
            faces = [face for _, face in model.getBoundary(box[:1], oriented=False)]
            ends.append(min(faces, key=lambda f: hypot(*model.occ.getCenterOfMass(2, f)[:2])))
        for name, number in surfaces.items():
            end = model.addDiscreteEntity(2) if name in empty else ends[number]
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
    write_mesh(folder / "off_the_hub.msh", blades, roots, radius=3.0)
    write_mesh(folder / "not_merged.msh", blades, roots, bricks=2)
    write_mesh(folder / "everything.msh", [*blades, "tower"], roots, radius=3.0, bricks=2)
    (folder / "text.msh").write_text("this is no mesh\n")
    return folder


def without_warnings(text):
    """Lines that are not about keys without effect."""
    return [line for line in text.splitlines() if not line.startswith("warning: ")]


def refused(result, seconds):
    """The sentences of a refused command, after checking everything that all refusals share."""
    assert result.returncode == 2, result.stderr
    assert "Traceback" not in result.stderr + result.stdout
    # Without mpirun nothing else is on stderr; mpirun adds its own lines about the exit code.
    sentences = [line for line in result.stderr.splitlines() if line.startswith(SENTENCE)]
    assert sentences
    assert len(set(sentences)) == len(sentences)  # said once, not by every rank
    # before any heavy work: starting python, importing DOLFINx and reading a mesh take 1 to 4 s
    assert seconds < patience(20.0)
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
    "wrong unit": ("rigid.toml", ["loads.rotor_torque=3 kN"], "expected a torque, for example"),
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
        2,
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
        2,
    ),
    "blades off the hub": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/off_the_hub.msh"],
        "root_1 does not touch the hub: .* up to 0.75 m from the hub surface",
        3,
    ),
    "bricks that are not merged": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/not_merged.msh"],
        "blade_1 falls into 2 parts without a common face, .* nodes of the mesh lie on top of",
        3,
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


@pytest.mark.parametrize("ranks", [None, 2])
@pytest.mark.parametrize("mistake", IN_THE_ISSUE)
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
        "blades off the hub",
        "bricks that are not merged",
        "mesh that is none",
    ],
)
def test_check_refuses_what_run_refuses(demo, meshes, tmp_path, capfd, mistake):
    arguments = arguments_of(*MISTAKES[mistake][:2], demo, meshes)
    assert main(["run", *arguments, "-o", str(tmp_path)]) == 2
    said = capfd.readouterr().err
    assert main(["check", *arguments]) == 2
    assert without_warnings(capfd.readouterr().err) == without_warnings(said)


ALL_AT_ONCE = [
    "time.step=0 kg",
    "time.end=-1",
    "loads.step=1",
    "material.poisson=[0.9, 0.9, 0.9]",
    "solver.tolerance=true",
    "mesh.file={meshes}/everything.msh",
]


def test_check_names_all_mistakes_of_case_and_mesh_on_any_number_of_ranks(
    command_line, demo, meshes
):
    changes = [change.format(meshes=meshes) for change in ALL_AT_ONCE]
    said = []
    for ranks in (1, 2, 3):
        result = command_line("check", demo("hybrid_stiff.toml"), "--set", *changes, ranks=ranks)
        said.append(refused(result, 0.0))
        assert result.stdout == ""
    sentences = said[0]
    assert said == [sentences] * 3
    for words in (
        "time.step = '0 kg': expected a time",
        "time.end = -1: must be greater than or equal to 0",
        "unknown key 'loads.step'; did you mean 'time.step'?",
        "material is not positive definite",
        "solver.tolerance = True: expected a number",
        "cells belong to none of the groups",
        *(f"blade_{k} falls into 2 parts" for k in (1, 2, 3)),
        *(f"root_{k} does not touch the hub" for k in (1, 2, 3)),
    ):
        assert sum(words in sentence for sentence in sentences) == 1, words
    assert len(sentences) == 12


def test_check_of_a_users_mesh_counts_and_warns(demo, meshes, capfd):
    changes = [f"mesh.file={meshes}/good.msh", "mesh.elements=[1, 1, 1]", "mesh.degree=2"]
    assert main(["check", str(demo("hybrid_soft.toml")), "--set", *changes]) == 0
    text = capfd.readouterr().out
    assert "warning: mesh.elements has no effect beside mesh.file\n" in text
    assert "warning: blade_1 ends at a radius of 12.25 m" in text
    assert re.search(r"^unknowns: \d+ \(\d+ displacements, ", text, re.MULTILINE)
    assert "mass of the blades 45 t\n" in text  # three boxes of 10 m^3 with 1500 kg/m^3


def test_estimate_of_a_huge_mesh_comes_without_building_it(demo, capfd):
    start = time.monotonic()
    changes = ["mesh.elements=[100, 100, 4000]", "mesh.degree=1"]
    assert main(["check", str(demo("hybrid_stiff.toml")), "--set", *changes]) == 0
    text = capfd.readouterr().out
    assert f"({9 * 101 * 101 * 4001} displacements" in text
    assert "linear solver: iterative" in text
    assert "too large to be made" in text
    changes = ["tower.flexible=true", "tower.elements=[400, 40, 400]"]
    assert main(["check", str(demo("hybrid_stiff.toml")), "--set", *changes]) == 0
    assert "mesh of the tower is too large to be made" in capfd.readouterr().out
    assert time.monotonic() - start < patience(10.0)


def test_check_estimates_for_other_ranks_and_looks_at_the_folder(demo, tmp_path, capfd):
    case = str(demo("hybrid_stiff.toml"))
    assert main(["check", case, "--ranks", "64", "-o", str(tmp_path)]) == 0
    text = capfd.readouterr().out
    assert " on 64 ranks, " in text
    assert "warning" not in text
    (tmp_path / "summary.json").touch()
    assert main(["check", case, "-o", str(tmp_path)]) == 0
    assert f"warning: '{tmp_path}' holds a run already\n" in capfd.readouterr().out
    assert main(["check", case, "--ranks", "0"]) == 2
    assert "--ranks 0: must be at least 1" in capfd.readouterr().err


@pytest.mark.parametrize("ranks", [1, 2])
def test_what_does_not_fit_into_the_memory_is_refused(command_line, demo, tmp_path, ranks):
    changes = ["--set", "mesh.elements=[400, 400, 400]"]
    for command in ("run", "mesh"):
        out = tmp_path / "out.msh"
        result = command_line(command, demo("hybrid_stiff.toml"), "-o", out, *changes, ranks=ranks)
        (sentence,) = refused(result, 0.0)
        assert "--force continues anyway" in sentence
        assert not out.exists()


@pytest.mark.parametrize(
    "changes",
    [
        ["blade.length=1e30"],
        ["blade.hub_radius=1e30"],
        ["turbine.hub_distance=1e30"],
        ["blade.thickness=[1e-300, 1e-300, 1e-300]"],
        ["blade.length=1e-300", "mesh.cell=tetrahedron"],
        ["blade.length=1e30", "mesh.cell=tetrahedron"],
        ["mesh.size=1e-30", "mesh.cell=tetrahedron"],
        ["mesh.size=1e30"],
        ["material.density=1e-300", "solver.tolerance=1e-300", "output.fields_every=1e-300"],
    ],
    ids=" ".join,
)
def test_extreme_cases_are_checked_or_refused_without_noise(demo, capfd, changes):
    code = main(["check", str(demo("hybrid_stiff.toml")), "--set", *changes])
    output, errors = capfd.readouterr()
    assert code in (0, 2)
    assert output.endswith(": valid\n") == (code == 0)
    assert all(line.startswith(SENTENCE) for line in errors.splitlines())


values = st.one_of(
    st.sampled_from([0, -1, "3 kg", "3 m", "nan", "", [], [1], {}, True, 10**40, "x" * 200, [[1]]]),
    st.floats(allow_nan=False, allow_infinity=False),
)
names = st.sampled_from(
    "time.step time.end blade.chord blade.stations blade.length mesh.size mesh.elements mesh.file "
    "material.law material.young turbine.model turbine.hub.mass loads.gravity solver.tolerance "
    "output.fields_every tim.e step a.b.c".split()
)


@settings(
    max_examples=40,
    derandomize=True,
    database=None,
    deadline=None,
    suppress_health_check=list(HealthCheck),
)
@given(st.dictionaries(names, values, min_size=1, max_size=8))
def test_check_tells_what_is_wrong_with_any_case(demo, capfd, changes):
    # a mistake that is always there keeps meshes from being built
    overrides = [f"{name}={json.dumps(value)}" for name, value in changes.items()]
    code = main(["check", str(demo("hybrid_stiff.toml")), "--set", "mesh.degree=3", *overrides])
    output, errors = capfd.readouterr()
    assert code == 2
    assert output == ""
    lines = errors.splitlines()
    assert all(line.startswith(SENTENCE) for line in lines)
    assert sum(line.startswith("error: mesh.degree = 3") for line in lines) == 1


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
