"""Claims about the command that finds the sections of a blade."""

import csv

import pytest
from windio_files import small_turbine, write_turbine

from turbine_fenicsx.beam_files.any_file import read_beam
from turbine_fenicsx.cli.main import main

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
