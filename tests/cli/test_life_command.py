"""The command that finds which ply fails first, and when."""

import csv
import json
import shutil

import pytest
from reduced_turbines import COMM, STRENGTHS, run, write_case

from turbine_fenicsx.cli.main import main
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records.vtkhdf_file import VtkHdfFile


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The folder with two runs, of different winds."""
    folder = on_rank0(COMM, lambda: tmp_path_factory.mktemp("recorded"))
    path, changes = write_case(folder), ("tower.flexible=false", "output.motion_every=0.05")
    for wind in (9, 11):
        run(path, f"v{wind}", *changes, "time.end=1.5", f"wind.speed={wind}")
    return folder


@pytest.fixture
def folder(recorded, tmp_path):
    """A copy of it."""
    return shutil.copytree(recorded, tmp_path / "runs")


def read(path):
    """Rows of a table."""
    return list(csv.DictReader(path.read_text().splitlines()))


def is_refused(command, capfd, *words):
    """Exit code 2 and one sentence with some words."""
    capfd.readouterr()
    assert main([*map(str, command)]) == 2
    (sentence,) = capfd.readouterr().err.splitlines()
    for word in ("error: ", *words):
        assert word in sentence, sentence


def test_a_run_has_its_life_in_tables_fields_and_on_its_page(folder, capfd):
    for library in ("h5py", "matplotlib"):
        pytest.importorskip(library)
    out = folder / "v9"
    moduli = "young=4e9,shear_modulus=1e9,tension=1e6,shear=1e6"
    glue = f"life.adhesive={{thickness=0.006,width=0.08,{moduli}}}"
    command = ["life", out, "--start", 0.1, "--set", *STRENGTHS, glue]
    assert main([*map(str, command)]) == 0
    printed = capfd.readouterr()
    lines = printed.out.splitlines()
    assert lines[0] == "biax has slope 9, as plies of its family: the file has none"
    assert lines[1].startswith("foam does not count: it has no slope of an S-N curve, see life.m")
    assert lines[3].startswith("1 run as 20 years; ")
    tables = [f"life{name}" for name in (".csv", "_section.csv", "_winds.csv", "_bonds.csv")]
    pictures = ["life_section.png", "life_winds.png"]
    if "there is no life.png" not in printed.err:
        pictures.insert(0, "life.png")
    expected = [str(out / name) for name in (*tables, "life.vtkhdf", *pictures)]
    assert lines[-1].split(", ") == expected
    assert all((out / name).read_bytes()[1:4] == b"PNG" for name in pictures)
    places = read(out / "life.csv")
    damages = [float(place["damage_[-]"]) for place in places]
    assert len(places) == 10 and damages == sorted(damages, reverse=True) and damages[0] > 0.0
    assert len({(place["panel"], place["ply"]) for place in places}) == 10
    first = places[0]
    assert lines[4].startswith(f"fails first: ply {first['ply']} of {first['plies']} from outside")
    assert float(first["life_[years]"]) == pytest.approx(20.0 / damages[0])
    of_measures = [float(v) for key, v in first.items() if key.startswith("damage_by_")]
    assert len(of_measures) == 4 and max(of_measures) == damages[0]
    (wind,) = read(out / "life_winds.csv")
    assert (float(wind["wind_speed_[m/s]"]), float(wind["damage_[-]"])) == (9.0, damages[0])
    assert float(first["damage_[-]"]) == max(
        float(cell["damage_[-]"]) for cell in read(out / "life_section.csv")
    )
    with VtkHdfFile(out / "life.vtkhdf") as file:
        cells = file.read(0).cell_data
    assert cells["damage"].max() == pytest.approx(damages[0], rel=1e-6)
    plies = [values for name, values in cells.items() if name.startswith("damage_ply_")]
    assert len(plies) >= int(first["plies"])
    assert max(values.max() for values in plies) == cells["damage"].max()
    assert cells["fatigue_index"].max() == pytest.approx(float(first["fatigue_index_[-]"]), 1e-6)
    is_refused(command, capfd, "life.csv' is there already: --overwrite replaces it")
    assert main(["report", str(out), "--no-pictures"]) == 0
    page = (out / "report.html").read_text()
    bond = read(out / "life_bonds.csv")[0]
    assert lines[-2].startswith(f"bonds, an estimate: {bond['bond']} of blade {bond['blade']} fail")
    assert float(bond["damage_[-]"]) > 0.0 and bond["bond"].replace("_", " ") in page
    assert "Life of the plies" in page and first["panel"].replace("_", " ") in page


def test_runs_of_a_set_count_as_often_as_they_happen(folder, capfd):
    runs = folder / "runs.csv"
    head = "run,situation,state,begin_[s],times_in_life,life_[years]\n"
    runs.write_text(
        head
        + "v9,1.2,finished,0.1,1e7,25.0\nv11,1.2,finished,0.1,1e9,25.0\n"
        + "lost,1.2,failed,0.5,0.0,25.0\nv11,1.3,finished,0.1,0.0,25.0\n"
    )
    command = ["life", folder, "--no-pictures", "--set", *STRENGTHS]
    assert main([*map(str, command)]) == 0
    assert "2 runs as 25 years; " in capfd.readouterr().out
    row, *_ = read(folder / "life.csv")
    assert row["run"] == "v11"
    (folder / "life_bonds.csv").touch()
    damage = float(row["damage_[-]"])
    runs.write_text(head + "v11,1.2,finished,0.1,1e9,25.0\n")
    assert main([*map(str, command), "--overwrite"]) == 0
    assert not (folder / "life_bonds.csv").exists()  # of an earlier life
    other = next(
        x for x in read(folder / "life.csv") if (x["panel"], x["ply"]) == (row["panel"], row["ply"])
    )
    assert 0.0 < float(other["damage_[-]"]) < damage
    for words, sentence in [
        (["--weights", "1"], "--weights: the load set"),
        (["--start", "1"], "--start: the load set"),
        (["--set", "life.years=3"], "--set life.years: the life is that of the load set"),
        ([folder / "v9", "-o", folder / "x"], "is a load set: give it alone"),
    ]:
        is_refused(["life", folder, *words], capfd, sentence)
    runs.write_text(head + "v9,1.1,finished,0.1,0.0,25.0\n")
    is_refused(["life", folder, "--overwrite"], capfd, "no finished run that counts for fatigue")
    runs.write_text("run,situation,state\n")
    is_refused(["life", folder, "--overwrite"], capfd, "has no column 'begin_[s]'")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["v9"], "material 'biax' has no strengths along its fibres: give life.material.biax.tens"),
        (["v9", "v11"], "several runs: give the folder to write to with --out"),
        (["v9", "v9", "-o", "x"], "v9' is given twice"),
        (["v9", "v11", "-o", "x", "--weights", "0.5,0.2"], "that sum up to 1, not 0.7"),
        (["v9", "v11", "-o", "x", "--weights", "1"], "expected 2 numbers, one for each run"),
        (
            ["v9", "--start", "1.43", "--set", *STRENGTHS],
            "2 rows from t = 1.43 s on, which is",
        ),
        (["v9", "--set", "time.end=3"], "--set time.end=3: only life.NAME can be set here"),
        (["v9", "--set", "life.material.tin.slope=3"], "life.material.tin: no material of turbine"),
        (["none"], "there is no output folder"),
    ],
)
def test_bad_input_is_one_sentence(folder, capfd, words, sentence):
    words = [folder / x if x[0] == "v" or x in ("x", "none") else x for x in words]
    is_refused(["life", *words], capfd, sentence)


def test_runs_of_other_blades_are_refused(folder, capfd):
    head = (folder / "v9" / "motion.json").read_text()
    tables = json.loads(head)
    for body in tables["bodies"]:
        body["meaning"] = "0" * 16
    (folder / "v9" / "motion.json").write_text(json.dumps(tables))
    command = ["life", folder / "v9", folder / "v11", "-o", folder / "x", "--set", *STRENGTHS]
    is_refused(command, capfd, "different bases of the blades, or different meshes")
    (folder / "v9" / "motion.json").write_text(head)
    tables = json.loads((folder / "v9" / "case.json").read_text())
    tables["life"]["years"] = 3.0
    (folder / "v9" / "case.json").write_text(json.dumps(tables))
    is_refused(command, capfd, "have different tables life")
