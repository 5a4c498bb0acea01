"""Tables, diagram, pictures and page of modes, drawn from files that are written here."""

import json
import re

from mpi4py import MPI

import numpy as np
import pytest
from outputs import PARTS

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing.campbell import plot_campbell, spread
from turbine_fenicsx.postprocessing.mode_pictures import LOOK, read_mode_titles, render_modes
from turbine_fenicsx.postprocessing.mode_report import report_modes
from turbine_fenicsx.records import names
from turbine_fenicsx.records.mode_tables import format_rows, read_campbell, read_table

pytestmark = [
    pytest.mark.filterwarnings("ignore:Unable to import Axes3D"),
    pytest.mark.skipif(MPI.COMM_WORLD.size > 1, reason="files of one rank"),
]


def rows(speeds=(0.0,), damping=0.0):
    """Two modes at some speeds [rpm]."""
    return [
        {
            names.SPEED: speed,
            names.MODE: number,
            names.FREQUENCY: 1.25 * number + 0.01 * speed,
            names.DAMPING_RATIO: damping,
            names.GROWTH_RATE: 0.0,
            names.MODAL_MASS(part="blade_1"): 0.75,
            names.MODAL_MASS(part="tower"): 0.0,
            names.MOTION_SHARE(way="flap"): 1.0,
            names.MODE_NAME: f"mode, {number}",
        }
        for speed in speeds
        for number in (1, 2)
    ]


def write(path, content):
    path.write_text(format_rows(content))
    return path


def test_a_table_reads_back_exactly(tmp_path):
    found = read_table(write(tmp_path / "modes.csv", rows((0.1 + 0.2, 1.0 / 3.0))))
    assert found == rows((0.1 + 0.2, 1.0 / 3.0))


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n", "\0", f"{names.MODE_NAME}\nx\n", "mode,x\n1\n"])
def test_what_is_no_table_is_one_sentence(tmp_path, text):
    (tmp_path / "modes.csv").write_text(text)
    with pytest.raises(InputError, match=r"modes.csv is not a table of modes$"):
        read_table(tmp_path / "modes.csv")


def test_a_missing_table_is_one_sentence(tmp_path):
    with pytest.raises(InputError, match=r"cannot read '.*modes.csv': No such file"):
        read_table(tmp_path / "modes.csv")


def test_campbell_follows_each_mode_by_its_number(tmp_path):
    first, second = read_campbell(write(tmp_path / "campbell.csv", rows((0.0, 5.0, 10.0))))
    assert (first.name, second.name) == ("mode, 1", "mode, 2")
    assert np.array_equal(first.speeds, (0.0, 5.0, 10.0))
    assert np.allclose(second.frequencies, (2.5, 2.55, 2.6))


@pytest.mark.parametrize(
    ("wanted", "found"),
    [
        ([0.1, 0.5, 0.9], [0.1, 0.5, 0.9]),
        ([0.5, 0.5], [0.475, 0.525]),
        ([0.52, 0.5, 0.1], [0.535, 0.485, 0.1]),
        ([0.5, 0.5, 0.5, 0.56], [0.515 - 0.075, 0.515 - 0.025, 0.515 + 0.025, 0.515 + 0.075]),
        ([], []),
    ],
)
def test_names_are_spread_as_far_as_they_need(wanted, found):
    assert spread(wanted, 0.05) == pytest.approx(found)


@pytest.mark.parametrize("damping", [0.0, 0.02, -0.01])
def test_campbell_diagram_has_a_second_panel_for_damping(tmp_path, damping):
    pytest.importorskip("matplotlib")
    from PIL import Image

    write(tmp_path / "campbell.csv", rows((0.0, 5.0, 10.0), damping))
    path = plot_campbell(tmp_path / "campbell.csv", tmp_path / "campbell.png")
    width, height = Image.open(path).size
    assert height / width == pytest.approx((9.6 if damping else 6.4) / 9.2, rel=0.01)


@pytest.fixture
def shapes(tmp_path):
    """A folder with the shapes of two modes of boxes: blade 1 moves, then blade 2."""
    from outputs import turbine

    from turbine_fenicsx.records.xdmf import XdmfSeries

    path = tmp_path / "modes.xdmf"
    write(tmp_path / "modes.csv", rows())
    fields = _boxes(turbine(tmp_path / "scratch" / "fields.xdmf", times=(0.0,)))
    series = XdmfSeries(
        MPI.COMM_SELF,
        path,
        fields["cells"],
        len(fields["points"]),
        point_data={"coupling": fields["coupling"]},
        cell_data={"part": fields["part"]},
        information={"parts": PARTS.to_text(), "modes": json.dumps(["1  one", "2  two"])},
    )
    for number in (1, 2):
        a = np.zeros_like(fields["points"])
        a[8 + 8 * number : 16 + 8 * number] = (0.0, 0.0, -9.0)  # to the front
        moved = {"mode_real": a, "mode_imaginary": 0 * a}
        series.write(number, fields["points"], moved)
    return tmp_path


def _boxes(path):
    """Points, cells and parts of the turbine of boxes."""
    from outputs import read_fields

    (fields,) = read_fields(path).values()
    cube = np.array([[0, 1, 3, 2, 4, 5, 7, 6]])
    faces = np.array([(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6)])
    cells = [
        ("quadrilateral", np.concatenate([faces, faces + 8])),
        ("hexahedron", np.concatenate([cube + 8 * i for i in (2, 3, 4)])),
    ]
    return {"points": fields["Geometry"], "cells": cells, **fields}


def test_titles_are_in_the_file(shapes):
    assert read_mode_titles(shapes / "modes.xdmf") == ["1  one", "2  two"]
    with pytest.raises(InputError, match=r"fields.xdmf' does not hold modes$"):
        read_mode_titles(shapes / "scratch" / "fields.xdmf")


def test_the_part_that_moves_is_red(shapes):
    pytest.importorskip("pyvista")
    from dataclasses import replace

    from PIL import Image

    look = replace(LOOK, size=(300, 360), view="front")
    try:
        *files, sheet = render_modes(shapes / "modes.xdmf", shapes, look=look)
    except InputError as error:
        pytest.skip(str(error))
    assert [f.name for f in (*files, sheet)] == ["mode_1.png", "mode_2.png", "modes.png"]
    dark = []
    for file in files:
        image = np.asarray(Image.open(file).convert("RGB"), dtype=int)[40:]
        red = (image[..., 0] - image[..., 1] > 30) & (image.min(axis=2) < 60)
        dark.append(np.argwhere(red).mean(axis=0))
    assert dark[0][0] < dark[1][0] - 30  # blade 1 points upwards
    assert Image.open(sheet).size == (600, 360)


def test_an_unknown_mode_is_one_sentence(shapes):
    with pytest.raises(InputError, match=r"no mode 3, they are numbered from 1 to 2$"):
        render_modes(shapes / "modes.xdmf", shapes, [3])


def test_page_shows_table_and_no_empty_columns(shapes):
    (shapes / "case.json").write_text(json.dumps({"title": "a <turbine>"}))
    page = report_modes(shapes, pictures=False)
    text = re.sub(r"<[^>]+>", "|", page)
    assert "a &lt;turbine&gt;" in page and "2 modes at rest" in text
    assert "|blade 1|" in text and "|flap|" in text and "|tower|" not in text
    assert "|mode, 1||1||1.2500||75 %||100 %|" in text
    assert "damping" not in text


def test_page_shows_the_diagram_of_several_speeds(shapes):
    pytest.importorskip("matplotlib")
    write(shapes / "modes.csv", rows((0.0, 12.0), 0.01))
    write(shapes / "campbell.csv", rows((0.0, 12.0), 0.01))
    page = report_modes(shapes, pictures=False)
    assert page.count("<img") == 1
    assert "2 modes at 2 speeds up to 12 rpm" in page
    assert "Modes at 12 rpm" in page and "<td>1.00 %</td>" in page


def test_page_without_shapes_says_so(tmp_path):
    write(tmp_path / "modes.csv", rows())
    assert re.search(r"There are no pictures: there is no .*modes.xdmf", report_modes(tmp_path))
