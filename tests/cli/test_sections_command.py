"""Claims about the command that finds the sections of a blade."""

import csv

import pytest
from windio_files import small_turbine, write_turbine

from turbine_fenicsx.beam_files.any_file import read_beam
from turbine_fenicsx.cli.main import main
from turbine_fenicsx.records.loads_along import COLUMNS
from turbine_fenicsx.records.steady_tables import SPAN

HEAD = ",".join([SPAN, *COLUMNS])
FEW = ["--stations", "4", "--around", "16"]


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """A folder with a case and its sections."""
    folder = tmp_path_factory.mktemp("sections")
    write_turbine(small_turbine(), folder)
    (folder / "case.toml").write_text('turbine.file = "small.yaml"\n')
    assert main(["sections", str(folder / "case.toml"), "-o", str(folder / "out"), *FEW]) == 0
    return folder


def test_it_writes_a_table_a_picture_and_beams_for_other_codes(found):
    out = found / "out"
    with (out / "sections.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 4 and all(float(row["torsion_stiffness_[Nm2]"]) > 0.0 for row in rows)
    assert (out / "sections.png").read_bytes()[:4] == b"\x89PNG"
    prisms, inclined = (
        [read_beam(out / kind / name).sections for name in ("beamdyn.dat", "hawc2.htc")]
        for kind in ("prisms", "inclined")
    )
    for one, other in (prisms, inclined):
        assert one.stiffness == pytest.approx(other.stiffness, rel=1e-6, abs=1e-3)
    C, other = prisms[0].stiffness, inclined[0].stiffness
    assert C[:, 3:, 3:] != pytest.approx(other[:, 3:, 3:], rel=1e-3)
    mass = [float(row["mass_[kg/m]"]) for row in rows]
    assert prisms[0].inertia[1:-1, 2, 2] == pytest.approx(mass, rel=1e-8)


def test_loads_give_the_stresses_of_all_plies(found, capsys, tmp_path):
    """Twice the loads are twice the stresses; a place beyond the loads has none."""
    table, out = tmp_path / "loads.csv", tmp_path / "out"
    rows = [
        f"{wind},{s},0,0,0,0,{m * (1.0 - s)},0"
        for wind, m in ((5, 1e3), (9, 2e3))
        for s in (0, 0.7)
    ]
    table.write_text("\n".join([f"wind_speed_[m/s],{HEAD}", *rows]) + "\n")
    case = ["sections", str(found / "case.toml"), "-o", str(out), *FEW]
    assert main([*case, "--loads", str(table)]) == 0
    assert "largest index of tsai_wu: " in capsys.readouterr().out
    with (out / "section_plies.csv").open() as file:
        plies = list(csv.DictReader(file))
    assert {row["state"] for row in plies} == {"1", "2"}
    places = {float(row["span_[-]"]) for row in plies}
    assert len(places) == 2 and max(places) < 0.7
    half = len(plies) // 2
    for low, high in zip(plies[:half], plies[half:], strict=True):
        assert [low[key] for key in ("span_[-]", "panel", "ply", "material")] == [
            high[key] for key in ("span_[-]", "panel", "ply", "material")
        ]
        for key in ("stress_11_[Pa]", "stress_12_[Pa]", "tsai_wu_[-]"):
            assert float(high[key]) == pytest.approx(2.0 * float(low[key]), rel=1e-4, abs=1e-6)
    # bent to the suction side, which is compressed
    for panel, sign in (("spar_cap_suction_side", -1.0), ("spar_cap_pressure_side", 1.0)):
        caps = [row for row in plies if row["panel"] == panel and row["material"] == "uniax"]
        assert caps and all(sign * float(row["stress_11_[Pa]"]) > 0.0 for row in caps)
    assert main([*case, "--overwrite"]) == 0
    assert not (out / "section_plies.csv").exists()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("a,b\n1,2\n", "needs a column 'span_[-]' and rows with numbers"),
        (f"{HEAD}\n", "needs a column 'span_[-]' and rows with numbers"),
        (f"{HEAD}\n0.5,1,2,3,4,5\n", "needs a number in each column of each row"),
        (f"{HEAD}\n0.5,1,2,3,4,5,nan\n", "needs finite numbers"),
        (
            f"{HEAD}\n1.5,1,2,3,4,5,6\n",
            "has span_[-] = 1.5: fractions of the length are from 0 to 1",
        ),
        (HEAD + "\n" + "0.5,1,2,3,4,5,6\n" * 1001, "has 1001 states; at most 1000 are allowed"),
        (f"{HEAD}\n0.5,1,2,3,4,5,6\n0.501,1,2,3,4,5,6\n", "holds for none of the sections, at 0."),
    ],
)
def test_loads_that_are_none_are_refused(found, capsys, tmp_path, text, sentence):
    (tmp_path / "loads.csv").write_text(text)
    case = ["sections", str(found / "case.toml"), "-o", str(tmp_path / "out"), *FEW]
    assert main([*case, "--loads", str(tmp_path / "loads.csv")]) == 2
    errors = [x for x in capsys.readouterr().err.splitlines() if x.startswith("error")]
    assert len(errors) == 1 and sentence in errors[0]
    assert not (tmp_path / "out" / "sections.csv").exists()


def test_a_run_takes_them_as_beams(found, capsys):
    file = found / "out" / "inclined" / "beamdyn.dat"
    beam = f"blade = {{model = 'beam', damping = 0.0, beam.file = '{file}'}}"
    assert main(["check", str(found / "case.toml"), "--set", beam]) == 0
    assert "beams of 8 elements of degree 3" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "holds sections; --overwrite replaces them"),
        (["--stations", "3"], "--stations 3: must be from 4 to 400"),
        (["--around", "900"], "--around 900: must be from 16 to 400"),
        (
            ["--overwrite", "--set", "turbine.file=bare.yaml", "blade.model=beam"],
            "turbine.file: expected a windIO file whose blades have layers",
        ),
    ],
)
def test_wrong_input_is_one_sentence(found, capsys, arguments, sentence):
    tables = small_turbine()
    structure = tables["components"]["blade"]["structure"]
    for key in ("layers", "webs", "anchors"):
        structure.pop(key, None)
    write_turbine(tables, found, "bare.yaml")
    case = [str(found / "case.toml"), "-o", str(found / "out")]
    assert main(["sections", *case, *arguments]) == 2
    errors = [x for x in capsys.readouterr().err.splitlines() if x.startswith("error")]
    assert len(errors) == 1 and sentence in errors[0]
