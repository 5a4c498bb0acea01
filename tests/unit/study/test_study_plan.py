"""Study files, the runs they stand for, and when a run counts as finished."""

import json
import tomllib

import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.study.file import Study
from turbine_fenicsx.study.plan import format_case, group_series, plan
from turbine_fenicsx.study.results import is_finished
from turbine_fenicsx.turbine.case.case import Case

CASE = """
title = "small"
[time]
step = "0.02 s"
end = 0.1
[turbine]
model = "rigid"
"""


@pytest.fixture
def make(tmp_path):
    """Makes a study from TOML text, with a case file beside it."""
    (tmp_path / "case.toml").write_text(CASE)

    def study(text):
        path = tmp_path / "study.toml"
        path.write_text(f'case = "case.toml"\n{text}')
        return Study.load(path)

    return study


def refused(function, *arguments):
    """The sentences of an InputError."""
    with pytest.raises(InputError) as error:
        function(*arguments)
    return str(error.value).splitlines()


def test_grid_is_the_product_of_its_lists(make):
    study = make("[grid]\ntime.step = [0.1, 0.05]\nloads.gravity = [0, 1, 2]")
    runs = plan(study)
    assert [(r.value("time.step"), r.value("loads.gravity")) for r in runs] == [
        (step, g) for step in (0.1, 0.05) for g in (0.0, 1.0, 2.0)
    ]
    assert all(run.value("time.end") == 0.1 for run in runs)  # of the case


def test_each_entry_of_the_list_is_combined_with_the_whole_grid(make):
    study = make(
        "[grid]\ntime.end = [1, 2]\n[[run]]\n[[run]]\nloads.gravity = 0\ntime.step = '0.05 s'"
    )
    assert [run.changes for run in plan(study)] == [
        {"time.end": 1},
        {"time.end": 2},
        {"loads.gravity": 0, "time.step": "0.05 s", "time.end": 1},
        {"loads.gravity": 0, "time.step": "0.05 s", "time.end": 2},
    ]
    assert plan(study)[2].value("time.step") == 0.05


def test_keys_may_be_quoted_dotted_or_in_tables(make):
    texts = (
        '[grid]\n"time.step" = [0.1]\n[set]\n"time.end" = 3',
        "[grid]\ntime.step = [0.1]\n[set]\ntime.end = 3",
        "[grid.time]\nstep = [0.1]\n[set.time]\nend = 3",
    )
    first, *others = (plan(make(text))[0] for text in texts)
    assert first.value("time.end") == 3.0
    assert all(other.text == first.text for other in others)


def test_changes_for_all_runs_come_from_the_file_and_from_the_command_line(make):
    study = make("[grid]\ntime.step = [0.1]\n[set]\ntime.end = 3\nloads.gravity = 1")
    (run,) = plan(study, ["time.end=4"])
    assert (run.value("time.end"), run.value("loads.gravity")) == (4.0, 1.0)


def test_names_are_readable_and_do_not_depend_on_other_runs(make):
    text = "[grid]\nmesh.elements = [[2, 2, 12], [4, 4, 24]]\nmaterial.density = ['1500 kg/m^3']"
    names = [run.name for run in plan(make(text))]
    assert names == [
        "mesh.elements=2x2x12,material.density=1500_kg_m_3",
        "mesh.elements=4x4x24,material.density=1500_kg_m_3",
    ]
    more = text.replace("[[2, 2, 12]", "[[1, 1, 6], [2, 2, 12]")
    assert [run.name for run in plan(make(more))][1:] == names
    assert plan(make("[[run]]"))[0].name == "base"


def test_lists_of_files_are_named_by_their_stems(make):
    grid = "turbine.title = [['a/u1.bin', 'b/v1.bin']]"
    with pytest.raises(InputError, match=r"unknown key") as caught:
        plan(make(f"[grid]\n{grid}\ntime.step = [0.0, 0.1]"))
    assert "run 'turbine.title=u1+v1,time.step=0.0': time.step" in str(caught.value)


def test_values_that_are_equal_in_other_units_are_one_run(make):
    grid = "time.step = ['50 ms', '0.05 s', 0.1]"
    (told,) = refused(plan, make(f"[grid]\n{grid}"))
    assert told == "two runs are the same: 'time.step=50_ms' and 'time.step=0.05_s'"


def test_equal_or_endless_names_are_told_apart(make):
    runs = plan(make(f"[grid]\ntitle = ['a b', 'a_b', '{'x' * 300}']"))
    names = [run.name for run in runs]
    assert len(set(names)) == 3
    assert max(map(len, names)) < 140


def test_all_mistakes_of_all_cases_are_reported_at_once(make):
    study = make("[set]\nloads.duration = 0\n[grid]\ntime.step = [0.1, 0]\nmesh.elemnts = [1, 2]")
    sentences = refused(plan, study)
    # what is wrong in all runs is not said for each
    assert sum(s.startswith("loads.duration") for s in sentences) == 1
    assert sum(s.startswith("unknown key 'mesh.elemnts'; did you mean") for s in sentences) == 1
    assert sum("'time.step=0,mesh.elemnts=1': time.step = 0" in s for s in sentences) == 1
    assert len(sentences) == 3


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "varies nothing"),
        ("[grid]\ntime.step = 0.1", "grid.time.step = 0.1: must be a list"),
        ("[grid]\ntime.step = []", "grid.time.step = []: "),
        ("prosesses = 2\n[[run]]", "unknown key 'prosesses'; did you mean 'processes'?"),
        ("processes = 0\n[[run]]", "processes = 0: must be greater than or equal to 1"),
        ("ranks = 1.5\n[[run]]", "ranks = 1.5: "),
        ("[grid]\ntime.step = [1]\n[[run]]\ntime.step = 2", "stands in [grid] and in [[run]]"),
        ("[grid]\ntime.step = [1]\n[set]\ntime.step = 2", "stands in [set]"),
        ("[convergence]\nkey='time.step'\nquantity='x'\n[[run]]", "is not varied"),
        ("[convergence]\nkey='time.step'\nreference='best'\nquantity='x'\n[[run]]", "'richardson'"),
    ],
)
def test_mistake_in_a_study_is_one_sentence(make, text, words):
    (sentence,) = refused(make, text)
    assert words in sentence


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[grid]\ntime.step = [{ a = 1 }]", "give finite numbers, strings, true or"),
        ("[[run]]\ntime.step = 1\n[[run]]\ntime.step = 1", "two runs are the same: 'time.step=1'"),
        (
            "[grid]\ntime.step = [1, 2]\n[convergence]\nkey = 'time.step'\nquantity = 'x'",
            "needs at least 3 values of 'time.step', not 2",
        ),
        (
            "[grid]\nturbine.model = ['rigid']\n[convergence]\nkey = 'turbine.model'\n"
            "quantity = 'x'",
            "positive numbers or lists of them, not 'rigid'",
        ),
    ],
)
def test_mistake_that_needs_the_cases_is_one_sentence(make, text, words):
    (sentence,) = refused(plan, make(text))
    assert words in sentence


def test_key_that_varies_cannot_be_set_for_all_runs(make):
    (sentence,) = refused(plan, make("[grid]\ntime.step = [1]"), ["time.step=2"])
    assert "is varied by the study" in sentence


def test_runs_that_differ_in_the_refined_key_only_are_one_series(make):
    runs = plan(make("[grid]\ntime.step = [0.1, 0.05]\nloads.gravity = [0, 1]"))
    found = group_series(runs, "time.step")
    assert list(found) == ["loads.gravity=0", "loads.gravity=1"]
    assert [r.value("time.step") for r in found["loads.gravity=1"]] == [0.1, 0.05]


def test_text_of_a_run_is_its_whole_case(make, tmp_path):
    (run,) = plan(make("[grid]\ntime.step = ['0.05 s']\n[set]\nturbine.blade_arm = 29.25"))
    elsewhere = tmp_path / "elsewhere" / "case.toml"
    elsewhere.parent.mkdir()
    elsewhere.write_text(run.text)
    again = Case.load(elsewhere)
    assert again == run.case
    assert again.title == "small"
    # only what was set: a key that has no effect in this model gives a warning otherwise
    assert "mesh" not in tomllib.loads(run.text)


def test_run_is_finished_if_case_and_summary_are_there_and_nothing_changed(make, tmp_path):
    text = "[grid]\ntime.step = [0.05]"
    (run,) = plan(make(text))
    folder = tmp_path / run.name
    folder.mkdir()
    assert not is_finished(run, folder)
    (folder / "case.toml").write_text(run.text)
    assert not is_finished(run, folder)
    (folder / "summary.json").write_text('{"steps": ')  # torn
    assert not is_finished(run, folder)
    (folder / "summary.json").write_text(json.dumps({"steps": 1}))
    assert is_finished(run, folder)
    (changed,) = plan(make(text), ["time.end=0.2"])
    assert changed.name == run.name
    assert not is_finished(changed, folder)


def test_change_of_a_default_or_of_a_mesh_file_changes_the_text(tmp_path, monkeypatch):
    path = tmp_path / "blade.msh"
    path.write_text("one")
    (tmp_path / "rigid").write_text("a file that nobody means")
    monkeypatch.chdir(tmp_path)
    case = Case.parse({"turbine": {"model": "rigid"}, "mesh": {"file": "blade.msh"}})
    before = format_case(case)
    assert f'mesh.file = "{path.resolve()}"' in before
    assert 'turbine.model = "rigid"' in before
    assert format_case(case) == before
    path.write_text("two")
    assert format_case(case) != before
    stiffer = case.model_copy(update={"solver": case.solver.model_copy(update={"tolerance": 1e-9})})
    path.write_text("one")
    assert format_case(stiffer) != before  # not set in the file, so only the hash can tell


def test_all_runs_keep_bases_of_reduced_blades_beside_the_case_of_the_study(make, tmp_path):
    two = "set.turbine.model = 'hybrid'\n[grid]\ntime.end = [1, 2]"
    study = make(f"set.blade.model = 'reduced'\n{two}")
    bases = str(tmp_path / "bases")
    runs = plan(study)
    assert [run.value("blade.reduction.folder") for run in runs] == [bases, bases]
    assert f"blade.reduction.folder = {json.dumps(bases)}" in runs[0].text
    assert runs[0].value("tower.reduction.folder") is None
    run, _ = plan(study, ["blade.reduction.folder=mine"])
    assert run.value("blade.reduction.folder") == str(tmp_path / "mine")
    run, _ = plan(make(two))
    assert run.value("blade.reduction.folder") is None
