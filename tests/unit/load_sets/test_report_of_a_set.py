"""Claims about the page of a load set, from tables that a set has written."""

import re
from html import unescape

import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.load_sets import set_panels
from turbine_fenicsx.load_sets.report import report_set
from turbine_fenicsx.load_sets.stored_set import read_winds

MOMENT = "root_moment_1_y_[Nm]"
COLUMNS = ("factored", ""), ("run_of", ""), ("time_of", "_[s]")
HEAD = ["situation", "column"]
HEAD += [f"{x}_{side}{unit}" for side in ("least", "largest") for x, unit in COLUMNS]
TABLES = {
    "runs.csv": """run,situation,wind_speed_[m/s],seed,state,reason
1.2/v5_s1,1.2,5.0,1,finished,
1.2/v15_s2,1.2,15.0,2,finished,
6.1/v50_s3,6.1,50.0,3,failed,a step <did> not converge
""",
    "set.csv": ",".join(HEAD)
    + f"""
1.1,{MOMENT},-3e6,extrapolated,,4e6,extrapolated,
1.2,{MOMENT},-2e6,1.2/v5_s1,7.5,5e6,1.2/v15_s2,9.5
all,{MOMENT},-3e6,extrapolated,,5e6,1.2/v15_s2,9.5
all,rotor_speed_[rpm],1.0,1.2/v5_s1,7.5,5.0,1.2/v15_s2,9.5
""",
    "fatigue.csv": f"""run,column,slope,equivalent_range,times_in_life
1.2/v5_s1,{MOMENT},10.0,1e6,1000.0
lifetime,{MOMENT},10.0,2e6,1.0
lifetime,strain_flap_[-],10.0,2e-4,1.0
""",
    "extrapolated.csv": f"""situation,column,side,return_period_[years],value,low,high,seen
1.1,{MOMENT},largest,1.0,3.5e6,3.3e6,3.8e6,3e6
1.1,{MOMENT},largest,50.0,4e6,3.7e6,4.4e6,3e6
""",
    "winds.csv": f"""situation,column,wind_speed_[m/s],runs,mean,deviation,least,largest
1.2,{MOMENT},15.0,1,2e6,1e6,1e5,5e6
1.2,{MOMENT},5.0,1,1e6,1e6,-2e6,3e6
""",
}


@pytest.fixture
def folder(tmp_path):
    for name, text in TABLES.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def test_the_page_has_runs_extremes_and_their_diagrams(folder):
    page = report_set(folder)
    assert re.findall("<h2>(.*?)</h2>", page) == [
        *("Runs", "Over the wind speed", "Extremes", "Return periods", "Life", "Spectra")
    ]
    assert page.count("<img ") == 3  # no histories, no spectra
    text = unescape(re.sub(r"<[^>]*>", " ", page.replace("</th>", "|").replace("</td>", "|")))
    assert "runs: 2 finished, 1 failed" in text
    assert "1.2| 2| 2| 5, 15|" in text and "6.1| 1| 0| 50|" in text
    assert "6.1/v50_s3| a step <did> not converge|" in text
    row = "root moment 1 y [MN m]| -3| 1.1, extrapolated| 5| 1.2/v15_s2 at 9.5 s|"
    assert row in text and "rotor speed" not in text
    assert "folders of the runs are not here" in text
    assert "http" not in page


def test_tables_of_others_are_drawn_beside(folder, monkeypatch):
    other = folder / "published.csv"
    other.write_text(
        f"# by others\ncolumn,wind_speed_[m/s],mean\n{MOMENT},5,1.5e6\n{MOMENT},7,2.5e6\n"
    )
    drawn = []
    monkeypatch.setattr(
        set_panels, "draw_winds", lambda own, others, path: drawn.append(others) or path.touch()
    )
    page = report_set(folder, [other, folder / "winds.csv"])
    (others,) = drawn
    assert others["published"][MOMENT].mean.tolist() == [1.5e6, 2.5e6]
    assert others["winds"][MOMENT].speeds.tolist() == [5.0, 15.0]
    assert "lines: published, winds with deviation" in page


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("wind_speed_[m/s],mean\n5,1\n", "has no column 'column'"),
        ("column,wind_speed_[m/s],mean\nx,5,much\n", "could not convert string to float: 'much'"),
        ("column,wind_speed_[m/s],mean\nx,5\n", "has not one entry a column in row 2"),
        ("column,wind_speed_[m/s],mean\nx,5,1,2\n", "has not one entry a column in row 2"),
    ],
)
def test_tables_that_are_none_are_told(folder, text, words):
    path = folder / "other.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=r"other.csv' has") as caught:
        read_winds(path)
    assert words in str(caught.value)


def test_a_set_without_results_has_a_page_and_other_folders_none(folder):
    for name in TABLES:
        if name != "runs.csv":
            (folder / name).unlink()
    assert re.findall("<h2>(.*?)</h2>", report_set(folder)) == ["Runs", "Spectra"]
    (folder / "runs.csv").unlink()
    with pytest.raises(InputError, match=r"cannot read .*runs.csv"):
        report_set(folder)
