"""What `check` says of the windIO file of a case."""

import pytest
from windio_files import IEA_22, find_turbine, small_turbine, write_turbine

from turbine_fenicsx.cli.main import main


def test_check_warns_of_mistakes_by_the_schema(tmp_path, capsys):
    """The reader does not ask for the drag of the hub, the schema does."""
    find_turbine(IEA_22)
    pytest.importorskip("jsonschema")
    tables = small_turbine()
    del tables["components"]["hub"]["cd"]
    write_turbine(tables, tmp_path, "mine.yaml")
    case = tmp_path / "case.toml"
    case.write_text(
        "[turbine]\nfile = 'mine.yaml'\n[mesh]\nspan = 6\naround = 16\n[time]\nend = '1 s'\n"
    )
    assert main(["check", str(case)]) == 0
    told = capsys.readouterr().out
    assert "warning: mine.yaml: windIO's schema says of components.hub that 'cd' is a req" in told


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("blade.reduction.file=none.npz", "cannot read"),
        ("blade.reduction.file=case.toml", "is not a basis of a reduced body"),
    ],
)
def test_check_says_in_a_sentence_that_a_basis_cannot_be_read(tmp_path, capfd, key, words):
    write_turbine(small_turbine(), tmp_path, "mine.yaml")
    case = tmp_path / "case.toml"
    case.write_text(
        "[turbine]\nfile = 'mine.yaml'\n[blade]\nmodel = 'reduced'\n"
        "[mesh]\nspan = 6\naround = 16\ntip = 'open'\n[time]\nend = '1 s'\n"
    )
    assert main(["check", str(case), "--set", key]) == 2
    said = capfd.readouterr().err.splitlines()[-1]
    assert said.startswith("error: ") and words in said
