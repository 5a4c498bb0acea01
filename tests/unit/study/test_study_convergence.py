"""Observed orders, limits and sizes of a refinement; reading results."""

import csv

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records.names import split_unit
from turbine_fenicsx.study.convergence import (
    choose_reference,
    make_series,
    observed_order,
    refinement_sizes,
    report,
    richardson,
    write_series,
)
from turbine_fenicsx.study.file import Study
from turbine_fenicsx.study.plan import plan
from turbine_fenicsx.study.results import (
    check_quantities,
    find_quantity,
    format_lines,
    read_results,
)
from turbine_fenicsx.study.run import StudyResult, find_orders
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.run.run import run_case

H = np.array([0.4, 0.2, 0.1, 0.05])


def made(values, reference, refined=H):
    names = [f"run{k}" for k in range(len(refined))]
    return make_series("", "q_[m]", names, list(refined), list(values), reference)


@pytest.mark.parametrize("order", [1.0, 1.7, 2.0, 4.0])
@pytest.mark.parametrize("sizes", [H, np.array([0.5, 0.3, 0.25, 0.1])])
def test_richardson_finds_the_limit_of_a_power_law(order, sizes):
    values = 3.0 - 0.7 * sizes**order
    # round-off of the differences, 1e-16 over the smallest of them, here 1e-5
    assert richardson(sizes, values) == pytest.approx(3.0, abs=1e-9)
    found = made(values, "richardson", sizes)
    assert found.order == pytest.approx(order, abs=1e-4)
    assert found.local_orders[1:] == pytest.approx(np.full(3, order), abs=1e-3)


@pytest.mark.parametrize("values", [[1, 2, 1, 2], [1, 1, 1, 1], [1, 2, 3, 4], [1, 2, 3, 4.5]])
def test_values_that_follow_no_power_law_have_no_limit(values):
    assert np.isnan(richardson(H, np.array(values, dtype=float)))
    assert np.isnan(made(values, "richardson").order)


def test_values_that_go_up_and_down_are_noticed():
    assert made([1.0, 1.2, 1.1, 1.15], "finest").oscillates
    assert not made([1.0, 1.2, 1.3, 1.3 - 1e-14], "finest").oscillates
    assert not made([3.0, 2.0, 1.0, 1.0], "finest").oscillates


def test_exact_reference_gives_the_exact_order():
    found = made(2.0 + 5.0 * H**2, 2.0)
    assert found.order == pytest.approx(2.0, abs=1e-12)
    assert found.errors == pytest.approx(5.0 * H**2)


def test_finest_reference_is_left_out_of_the_fit():
    found = made(2.0 + H**2, "finest")
    assert np.isnan(found.errors[-1])
    assert found.reference == pytest.approx(2.0 + 0.05**2)
    # errors 63, 15 and 3 in units of the finest h^2
    expected = np.polyfit([2, 1, 0], np.log2([63, 15, 3]), 1)[0]
    assert found.order == pytest.approx(expected)


def test_order_of_runs_in_the_file_does_not_matter():
    shuffled = [2, 0, 3, 1]
    found = made((2.0 + H**2)[shuffled], 2.0, H[shuffled])
    assert found.runs == ("run1", "run3", "run0", "run2")
    assert np.all(np.diff(found.sizes) < 0.0)
    assert found.order == pytest.approx(2.0)


def test_exact_results_and_single_errors_have_no_order():
    assert np.isnan(observed_order(H, np.zeros(4)))
    assert np.isnan(observed_order(H, np.array([1.0, 0.0, 0.0, np.nan])))
    assert observed_order(H, np.array([4.0, 0.0, 0.25, np.nan])) == pytest.approx(2.0)


def test_size_of_numbers_of_elements_ignores_those_that_stay():
    sizes = refinement_sizes([(2, 2, 12), (4, 4, 24), (8, 8, 48)])
    assert sizes[:-1] / sizes[1:] == pytest.approx([2.0, 2.0])
    sizes = refinement_sizes([(2, 2, 12), (2, 2, 24), (2, 2, 48)])
    assert sizes == pytest.approx([1 / 12, 1 / 24, 1 / 48])
    assert refinement_sizes([0.1, 0.05]) == pytest.approx([0.1, 0.05])


SIZES3 = np.array([0.4, 0.2, 0.1])


def series(label, values, reference="richardson", sizes=SIZES3):
    names = [f"run{k}" for k in range(len(sizes))]
    return make_series(label, "q_[m]", names, list(sizes), list(values), reference)


@pytest.mark.parametrize(
    ("reference", "runs", "checked"),
    [("richardson", 3, False), ("richardson", 4, True), (2.0, 2, False), (2.0, 3, True)],
)
def test_as_many_runs_as_numbers_check_nothing(reference, runs, checked):
    h = H[:runs]
    assert series("", 2.0 + h**2, reference, h).is_checked is checked


def test_orders_against_the_finest_of_three_runs_are_not_checked():
    assert not series("", 2.0 + SIZES3**2, "finest").is_checked
    assert series("", 2.0 + H**2, "finest", H).is_checked


def test_series_share_the_limit_of_the_one_that_is_nearest_to_it():
    """As three series were seen, with limits of 27.75, 27.58 and 26.56 and an order of 0.36."""
    fine = series("quadratic", 27.58 + 0.1 * SIZES3**3)
    coarse = series("linear", 27.75 + 3.0 * SIZES3**1.6)
    slow = series("tetrahedra", 26.56 + 2.0 * SIZES3**0.36)
    best, notes = choose_reference([coarse, fine, slow])
    assert best is fine
    assert notes[0].startswith("runs of 'tetrahedra' follow an order of 0.36: too coarse")
    assert "the limit of 'tetrahedra' by itself, 26.56, is 3.7 % off that of 'quad" in notes[1]
    assert len(notes) == 2


def test_series_without_a_limit_give_no_reference():
    assert choose_reference([series("", [1.0, 2.0, 1.0])]) == (None, [])
    slow = series("", 26.56 + 2.0 * SIZES3**0.36)
    best, (note,) = choose_reference([slow])
    assert best is None and note.startswith("runs of the series follow an order of 0.36")


def test_a_study_compares_all_series_with_one_limit(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text("")
    study = Study.parse(
        {
            "case": str(path),
            "grid": {"time.step": [0.4, 0.2, 0.1], "mesh.degree": [1, 2]},
            "convergence": {"key": "time.step", "quantity": "q", "reference": "richardson"},
        }
    )
    result = StudyResult(plan(study))
    for run in result.runs:
        h, degree = run.value("time.step"), run.value("mesh.degree")
        result.results[run.name] = {"q_[m]": 3.0 + (h**2 if degree == 1 else 0.1 * h**3)}
    find_orders(study, result)
    linear, quadratic = result.series
    assert linear.reference == quadratic.reference == pytest.approx(3.0)
    assert linear.source == quadratic.label and not quadratic.source
    assert linear.is_checked and not quadratic.is_checked
    assert (linear.order, quadratic.order) == pytest.approx((2.0, 3.0), abs=1e-6)
    assert result.notes == []


def test_table_for_people_shows_what_there_is():
    lines = list(format_lines(report(made(2.0 + H**2, "finest"))))
    assert len(lines) == 5
    assert lines[0].split() == ["run", "size", "q_[m]", "error", "order"]
    assert lines[1].split() == ["run0", "0.4", "2.16", "1.575e-01", "-"]
    assert lines[2].split()[-1] == f"{np.log2(63 / 15):.2f}"
    assert lines[4].split()[-2:] == ["-", "-"]


def test_series_are_written_with_all_digits(tmp_path):
    found = made(2.0 + H**2 / 3.0, 2.0)
    write_series(tmp_path / "convergence.csv", [found])
    with (tmp_path / "convergence.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["error"]) for row in rows] == list(found.errors)
    assert {float(row["observed_order"]) for row in rows} == {found.order}


def test_results_are_the_numbers_of_the_summary_and_the_last_row(tmp_path):
    (tmp_path / "history.csv").write_text("time_[s],energy_[J],wall_time_[s]\n0,1,2\n0.5,3,4\n")
    (tmp_path / "summary.json").write_text(
        '{"versions": {"numpy": "1"}, "wall_time_[s]": 5, "masses_[kg]": {"hub": 7}, "L": [1, 2]}'
    )
    found = read_results(tmp_path)
    assert found == {"time_[s]": 0.5, "energy_[J]": 3.0, "wall_time_[s]": 5, "masses_[kg].hub": 7}
    assert find_quantity(found, "energy") == find_quantity(found, "energy_[J]") == "energy_[J]"
    assert find_quantity(found, "masses.hub") == "masses_[kg].hub"
    with pytest.raises(InputError, match=r"'enrgy' is none of .*energy_"):
        find_quantity(found, "enrgy")


@pytest.mark.parametrize("model", ["rigid", "hybrid"])
def test_whatever_a_run_writes_is_known(tmp_path, comm, model):
    tables = {
        "turbine": {"model": model},
        "time": {"end": 0.02},
        "mesh": {"elements": [1, 1, 2]},
        "pitch": {"bearings": True},
        "tower": {"flexible": True, "elements": [4, 1, 2], "degree": 1},
    }
    run_case(Case.parse(tables), tmp_path, comm, "none")
    written = list(read_results(tmp_path))
    check_quantities([*written, *(split_unit(name)[0] for name in written)])
    check_quantities(["web_1_tsai_wu", "cap_tsai_wu_at_[m]", "strain_root_[-]", "aero_power"])


@pytest.mark.parametrize("name", ["enrgy", "tip_deflection", "web_1_tsai", "masses", "(", "{x}"])
def test_what_no_run_writes_is_refused(name):
    with pytest.raises(InputError, match="is none that a run writes"):
        check_quantities(["kinetic_energy", name])
