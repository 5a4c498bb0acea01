"""The page about a run stands alone and says what the output folder says."""

import base64
import importlib.util
import json
import sys
from html.parser import HTMLParser

import numpy as np
import pytest
from outputs import history, turbine, write

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing import report as module
from turbine_fenicsx.postprocessing.fatigue import find_fatigue
from turbine_fenicsx.postprocessing.report import report
from turbine_fenicsx.records.output_folder import read_history
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.description import describe_case

pytestmark = [
    pytest.mark.filterwarnings("ignore:Unable to import Axes3D"),
    pytest.mark.skipif(
        importlib.util.find_spec("matplotlib") is None, reason="Matplotlib, which draws, is missing"
    ),
]
SUMMARY = {
    "versions": {"turbine_fenicsx": "0.1.0", "fenics-dolfinx": "0.5.2"},
    "mesh": {"nodes": 351, "cells": 144},
    "masses_[kg]": {"hub": 30000.0},
    "mean_newton_iterations": 2.25,
}
CASE = {
    "title": "soft & <bold>",
    "time": {"step": 0.02},
    "turbine": {"hub": {"euler": [1.0, 2.5]}, "balanced": True},
}


class Page(HTMLParser):
    """Checks that tags match, and keeps sources, links, headings, tables and notes."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open, self.links, self.headings, self.cells, self.notes = [], [], [], [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.links += [value for name, value in attributes if name in ("src", "href", "srcset")]
        assert tag not in ("script", "link", "iframe")
        if tag not in ("meta", "img"):
            self.open.append((tag, dict(attributes).get("class")))

    def handle_endtag(self, tag):
        assert self.open.pop()[0] == tag

    def handle_data(self, data):
        if not self.open or not data.strip():
            return
        tag, kind = self.open[-1]
        kept = {"h2": self.headings, "th": self.cells, "td": self.cells, "p": self.notes}
        if tag in kept and (tag != "p" or kind == "note"):
            kept[tag].append(data)

    def rows(self):
        return dict(zip(self.cells[::2], self.cells[1::2], strict=True))


@pytest.fixture
def folder(tmp_path):
    write(tmp_path / "run" / "history.csv", history())
    return tmp_path / "run"


@pytest.fixture
def no_diagrams(monkeypatch):
    """Leave out what takes time."""
    monkeypatch.setattr(module, "_draw_diagrams", lambda run, tolerance: "")


def test_page_needs_nothing_but_itself(folder):
    text = report(folder)
    page = Page(text)
    assert len(page.links) == 5
    for link in page.links:
        kind, data = link.split(",", 1)
        assert kind == "data:image/png;base64"
        assert base64.b64decode(data, validate=True).startswith(b"\x89PNG")
    style = text.split("<style>")[1].split("</style>")[0]
    for word in ("url(", "@import", "http"):
        assert word not in style
    outside = text
    for link in page.links:
        outside = outside.replace(link, "")
    assert "://" not in outside


def test_page_shows_case_mesh_and_versions(folder, no_diagrams):
    (folder / "summary.json").write_text(json.dumps(SUMMARY))
    (folder / "case.json").write_text(json.dumps(CASE))
    text = report(folder, pictures=False)
    page = Page(text)
    assert page.headings == ["Key figures", "Case", "Fatigue", "Model and results", "Versions"]
    rows = page.rows()
    assert rows["euler"] == "1, 2.5"
    assert rows["balanced"] == "yes"
    assert rows["nodes"] == "351"
    assert rows["mean newton iterations"] == "2.25"
    assert rows["turbine_fenicsx"] == "0.1.0"
    assert rows["largest tip deflection [m]"].startswith("0.99")
    assert "masses [kg]" in text
    assert "<title>soft &amp; &lt;bold&gt;</title>" in text
    assert page.notes == []


def test_a_balance_that_is_wrong_is_said_in_red_before_the_figures(folder, no_diagrams):
    assert "class='warning'" not in report(folder)
    warning = "the energy balance is wrong by 58 % <"
    (folder / "summary.json").write_text(json.dumps(SUMMARY | {"warnings": [warning]}))
    page = report(folder)
    at = page.index("<p class='warning'>the energy balance is wrong by 58 % &lt;</p>")
    assert page.index("Key figures") < at < page.index("<table")
    assert page.count("wrong by 58 %") == 1
    assert ".warning { color: #b00020;" in page
    Page(page)


def test_key_figures_are_those_of_the_history(folder, no_diagrams):
    rows = Page(report(folder, pictures=False)).rows()
    columns = history()
    potential = columns["potential_energy_[J]"]
    columns["potential_energy_[J]"] = potential - potential[0]  # wherever the origin is
    largest = max(
        abs(columns[f"{name}_energy_[J]"]).max() for name in ("kinetic", "strain", "potential")
    )
    assert float(rows["largest energy [MJ]"]) == pytest.approx(largest / 1e6, rel=1e-5)
    error = abs(columns["energy_error_[J]"]).max()
    assert float(rows["largest energy error [J]"]) == pytest.approx(error, rel=1e-5)
    for name, sign in (("rotor", 1.0), ("yaw", -1.0)):  # signs of OpenFAST
        end = sign * np.degrees(columns[f"angle_{name}_[rad]"][-1])
        assert float(rows[f"{name} angle at the end [deg]"]) == pytest.approx(end, rel=1e-5)


def test_moments_are_in_large_units_and_round_off_is_zero(folder, no_diagrams):
    columns = history()
    columns["angle_yaw_[rad]"] = 1e-29 * np.arange(len(columns["time_[s]"]))
    for axis in "xyz":
        columns[f"tower_base_moment_{axis}_[Nm]"] = -4e6 * columns["time_[s]"]
    write(folder / "history.csv", columns)
    rows = Page(report(folder, pictures=False)).rows()
    flap = max(abs(columns[f"root_moment_{k}_y_[Nm]"][1:]).max() for k in (1, 2, 3))
    words = "largest flap moment at a root [MN m]"
    assert float(rows[words]) == pytest.approx(1e-6 * flap, rel=1e-5)
    words = "largest fore-aft moment at the tower base [MN m]"
    assert float(rows[words]) == pytest.approx(4.0 * columns["time_[s]"][-1], rel=1e-5)
    assert rows["yaw angle at the end [deg]"] == "0"


def test_case_has_units_and_only_what_has_an_effect(folder, no_diagrams):
    case = Case.parse({"loads": {"rotor_torque": "-36 MN m"}})
    (folder / "case.json").write_text(json.dumps(case.model_dump(mode="json")))
    text = report(folder, pictures=False, describe=describe_case)
    rows = Page(text).rows()
    assert rows["length [m]"] == "54"
    assert rows["rotor torque [N m]"] == "-3.6e+07"
    assert rows["euler [kg m²]"].count(",") == 2
    assert rows["model"] == "full" and "hybrid" in text  # of the blades, and of the turbine
    assert rows["flexible"] == rows["bearings"] == "no"
    for unused in ("top mass [kg]", "ring mass [kg]", "blade arm", "first lame [Pa]"):
        assert unused not in rows
    assert "turbine.nacelle" in text and "turbine.blade" not in text
    tower = Case.parse({"tower": {"flexible": True}, "turbine": {"model": "rigid"}})
    described = describe_case(tower.model_dump(mode="json"))
    assert "top_mass_[kg]" in described["tower"]
    assert "mesh" not in described and "blade" in described["turbine"]


def test_case_that_is_not_valid_is_shown_as_it_is(folder, no_diagrams):
    (folder / "case.json").write_text(json.dumps({"blade": {"length": -1}}))
    page = Page(report(folder, pictures=False, describe=describe_case))
    assert page.rows()["length"] == "-1"
    assert any("no valid case" in note and "blade.length" in note for note in page.notes)


def test_what_is_missing_is_said(folder, no_diagrams):
    notes = " ".join(Page(report(folder)).notes)
    for words in ("no case.json", "no summary.json", "has written no fields"):
        assert words in notes
    with pytest.raises(InputError, match=r"there is no .*fields\.xdmf"):
        report(folder, times=[1.0])


def test_missing_graphics_library_is_a_note_and_a_wrong_time_an_error(
    folder, no_diagrams, monkeypatch
):
    turbine(folder / "fields.xdmf")

    def fail(fields, out, times, look):
        assert times == [0.25, 0.5, 0.75, 1.0]
        raise InputError(f"cannot draw {out}/turbine_t1.png: there is no graphics library")

    monkeypatch.setattr(module, "render_times", fail)
    notes = " ".join(Page(report(folder)).notes)
    assert "There are no pictures: turbine_t1.png: there is no graphics library." in notes
    with pytest.raises(InputError, match="t = 2 s is outside of the run"):
        report(folder, times=[2.0])


@pytest.mark.parametrize("name", ["history.csv", "summary.json", "case.json"])
def test_broken_file_is_one_sentence(folder, no_diagrams, name):
    (folder / name).write_text("{")
    with pytest.raises(InputError, match=name):
        report(folder)


def test_page_shows_equivalent_loads(folder, no_diagrams, monkeypatch):
    found = {each.column: each for each in find_fatigue(read_history(folder / "history.csv"))}
    page = Page(report(folder))
    assert "Fatigue" in page.headings
    flap = found["root_moment_1_y_[Nm]"].equivalent[10.0]
    assert page.rows()["root moment 1 y [MN m]"] == f"{1e-6 * flap:.6g}"
    monkeypatch.setitem(sys.modules, "rainflow", None)
    notes = Page(report(folder)).notes
    assert any("Fatigue is left out: counting cycles needs rainflow" in note for note in notes)
