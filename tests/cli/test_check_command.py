"""``check`` refuses what ``run`` refuses, and looks at the mesh."""

import json
import re

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from refusals import MISTAKES, SENTENCE, arguments_of, refused, without_warnings

from turbine_fenicsx.cli.main import main


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
    for ranks in (1, 2):
        result = command_line("check", demo("hybrid_stiff.toml"), "--set", *changes, ranks=ranks)
        said.append(refused(result, 0.0))
        assert result.stdout == ""
    sentences = said[0]
    assert said == [sentences] * 2
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
    assert re.search(r"^unknowns: \d+ displacements, \d+ coupling multipliers$", text, re.MULTILINE)
    assert "mass of the blades 45 t\n" in text  # three boxes of 10 m^3 with 1500 kg/m^3


def test_check_looks_at_the_folder(demo, tmp_path, capfd):
    case = str(demo("hybrid_stiff.toml"))
    assert main(["check", case, "-o", str(tmp_path)]) == 0
    assert "warning" not in capfd.readouterr().out
    (tmp_path / "summary.json").touch()
    assert main(["check", case, "-o", str(tmp_path)]) == 0
    assert f"warning: '{tmp_path}' holds a run already\n" in capfd.readouterr().out


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
