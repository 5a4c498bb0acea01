"""The table of benchmarks: what passes, what fails, what is written."""

import importlib
import runpy
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "demos" / "verification"


@pytest.fixture(scope="module")
def modules():
    """The modules ``published`` and ``page``."""
    sys.path.insert(0, str(FOLDER))
    yield importlib.import_module("published"), importlib.import_module("page")
    sys.path.remove(str(FOLDER))


@pytest.fixture
def row(modules):
    """A row that holds."""
    return modules[0].Row("angle", "rad", 1.0, 1.01, 0.02, "Δt = 1 ms", 1.95, 1.0 + 1e-6, 1e-5)


@pytest.mark.parametrize(
    "wrong",
    [
        {"value": 1.021},
        {"value": 0.979},
        {"value": np.nan},
        {"order": 1.89},
        {"order": 2.11},
        {"order": np.nan},
        {"limit": 1.0 + 2e-5},
        {"limit": np.nan},
        {"expected_order": 4.0},
    ],
)
def test_row_holds_only_within_its_bounds(row, wrong):
    assert row.holds
    assert not replace(row, **wrong).holds


def test_row_without_refinement_has_no_order(row):
    assert replace(row, order=None, limit=None).holds


def test_refined_runs_give_order_and_limit(modules):
    published, _ = modules
    expected = {
        "a": published.Reference("a", 3.0, "m", 1.0),
        "b": published.Reference("b", 1, "-", 1),
    }
    h = {100: 0.02, 200: 0.01, 400: 0.005}
    a, b = published.refine(
        lambda n: {"a": 3.0 + h[n] ** 2 - 5.0 * h[n] ** 4, "b": 1.0 + h[n]},
        tuple(h),
        2.0,
        expected,
    )
    assert a.limit == pytest.approx(3.0, abs=1e-13)
    assert a.error == pytest.approx(0.005**2 - 5.0 * 0.005**4, rel=1e-9)
    assert a.step == "Δt = 5 ms"
    assert a.holds
    assert b.order == pytest.approx(1.0)
    assert not b.holds


def test_table_shows_two_digits_of_errors(modules, row):
    _, page = modules
    assert page.table([row]).splitlines()[-1] == (
        "| angle | 1 rad | 1.010 | 1e-2 | 1.95 | 1.00000 | < 1e-5 |"
    )
    exact = replace(row, unit="-", order=None, limit=None, step="", round_off=True)
    assert page.table([exact]).splitlines()[-1] == "| angle | 1 |  | < 2e-2 |"


def test_table_marks_what_fails(modules, row):
    _, page = modules
    bad = replace(row, value=1.5, step="Δt = 2 ms")
    assert page.FAILS in page.table([bad]) and page.FAILS not in page.table([row])
    # with two steps each row says its own
    text = page.table([row, bad]).splitlines()
    assert "(Δt = 1 ms)" in text[2] and "(Δt = 2 ms)" in text[3] and "Δt" not in text[0]


def test_overview_shows_relative_errors_where_units_differ(modules, row):
    _, page = modules
    heavy = replace(row, unit="kg", reference=2e5, value=1.98e5, order=None, limit=None)
    assert page.largest_error([heavy]) == "2e3"
    assert page.largest_error([row, heavy]) == "1 %"
    assert page.largest_error([row, replace(row, value=0.95), heavy]) == "5 %"
    assert page.largest_error([replace(row, reference=0.0, value=0.5), heavy]) == "2e3"


def test_page_has_all_benchmarks(modules):
    published, page = modules
    text = (ROOT / "docs" / "verification.md").read_text(encoding="utf-8")
    assert text.startswith(page.HEAD)
    assert page.FAILS not in text
    for name in published.names():
        title, words = page.described(name)
        section = f"({name})=\n## {title}\n\n{words}\n\n| quantity |"
        assert section in text, f"run python demos/verification {name}"
        assert f"{published.source(name)} Made by" in text
        for r in published.references(name).values():
            assert f"| {r.quantity} | " in text
    assert text.count("\n## ") == len(published.names())


def test_page_keeps_what_was_not_run(modules, row):
    _, page = modules
    text = (ROOT / "docs" / "verification.md").read_text(encoding="utf-8")
    assert page.markdown({}, text) == text
    changed = page.markdown({"heavy_top": [row]}, text)
    assert changed != text
    assert page.table([row]) in changed
    for name in ("four_bar", "heavy_top", "squeezer"):
        assert changed.count(f"({name})=") == changed.count(f"(#{name})") == 1
    alone = page.markdown({"heavy_top": [row]})
    assert alone.count("\n## ") == 1 and "squeezer" not in alone


@pytest.mark.parametrize("error", [0.0, 1.0])
def test_run_writes_the_page_and_tells_whether_all_rows_hold(
    modules, monkeypatch, capsys, shared_tmp_path, comm, error
):
    published, _ = modules
    row = published.Row("angle", "rad", 1.0, 1.0 + error, 0.5)
    seen = []

    def benchmark(name):
        slow = name == "squeezer"
        main = staticmethod(lambda: seen.append(name) or [row])
        return type("Benchmark", (), {"main": main, "SLOW": slow})

    scope = runpy.run_path(str(FOLDER / "__main__.py"))["main"].__globals__
    monkeypatch.setitem(scope, "PAGE", shared_tmp_path / "page.md")
    monkeypatch.setitem(scope, "names", lambda: ["heavy_top", "squeezer"])
    monkeypatch.setitem(scope, "load", benchmark)
    assert scope["main"]([]) == bool(error)
    assert seen == ["heavy_top"]  # the other is slow
    assert scope["main"](["squeezer"]) == bool(error)
    assert seen == ["heavy_top", "squeezer"]
    assert ("heavy_top: angle" in capsys.readouterr().err) == (bool(error) and comm.rank == 0)
    if comm.rank == 0:
        text = (shared_tmp_path / "page.md").read_text(encoding="utf-8")
        assert text.count("| angle | 1 rad |") == 2


def test_unknown_benchmark_is_named(modules):
    with pytest.raises(ValueError, match=r"no benchmark 'nothing'.*heavy_top"):
        modules[0].load("nothing")
