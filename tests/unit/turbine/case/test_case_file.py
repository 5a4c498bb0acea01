"""Claims about case files and overrides."""

import os

import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.case.case import Case


@pytest.fixture
def case_file(tmp_path):
    """Writes a case file and returns its path."""

    def write(text, name="case.toml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize(
    ("override", "section", "name", "value"),
    [
        ("time.end=1.0", "time", "end", 1.0),
        ("time.end = 1", "time", "end", 1.0),
        ('time.step="10 ms"', "time", "step", 0.01),
        ("time.step=10 ms", "time", "step", 0.01),  # a string may go without quotes
        ("mesh.cell=tetrahedron", "mesh", "cell", "tetrahedron"),
        ("mesh.elements=[1, 1, 4]", "mesh", "elements", (1, 1, 4)),
        ("turbine.blade_arm=29.25", "turbine", "blade_arm", 29.25),
        ("loads.rotor_torque=-3.6e7", "loads", "rotor_torque", -3.6e7),
        ("output.fields_every=0", "output", "fields_every", 0.0),  # section not in the file
    ],
)
def test_override_replaces_a_key(case_file, override, section, name, value):
    path = case_file("[time]\nstep = 0.02\nend = 12.0\n[mesh]\ndegree = 2\n")
    case = Case.load(path, [override])
    assert getattr(getattr(case, section), name) == value
    assert case.mesh.degree == 2  # the rest stays


def test_last_override_wins(case_file):
    assert Case.load(case_file(""), ["time.end=1", "time.end=2"]).time.end == 2.0


@pytest.mark.parametrize("override", ["time.end", "=3", "time.=3", ".end=3", "", "time..end=1"])
def test_override_without_key_or_value_is_one_sentence(case_file, override):
    with pytest.raises(InputError) as error:
        Case.load(case_file(""), [override])
    assert str(error.value) == f"cannot read {override!r}: write --set section.key=value"


def test_override_of_what_is_no_table_is_one_sentence(case_file):
    with pytest.raises(InputError, match=r"cannot set 'time\.step\.x': 'step' is not a table"):
        Case.load(case_file("[time]\nstep = 0.02\n"), ["time.step.x=1"])


def test_unknown_key_in_an_override_gets_the_same_hint(case_file):
    with pytest.raises(InputError, match=r"unknown key 'time\.ende'; did you mean 'time\.end'\?"):
        Case.load(case_file(""), ["time.ende=1"])


def test_missing_file_is_one_sentence(tmp_path):
    with pytest.raises(InputError, match=r"cannot read the case file .*No such file or directory"):
        Case.load(tmp_path / "none.toml")


def test_folder_is_no_case_file(tmp_path):
    with pytest.raises(InputError, match=r"cannot read the case file .*Is a directory"):
        Case.load(tmp_path)


def test_what_would_never_end_is_no_case_file(tmp_path):
    os.mkfifo(tmp_path / "fifo")
    for path in (tmp_path / "fifo", "/dev/zero"):
        with pytest.raises(InputError, match=r"cannot read the case file .*not a regular file"):
            Case.load(path)
    with (tmp_path / "huge.toml").open("wb") as file:
        file.truncate(10**12)  # a hole, no bytes on the disk
    with pytest.raises(InputError, match=r"has 1000000000000 bytes, expected at most 10000000"):
        Case.load(tmp_path / "huge.toml")


def test_file_that_is_no_toml_is_one_sentence_with_the_line(case_file):
    with pytest.raises(InputError, match=r"is not valid TOML: .*line 2") as error:
        Case.load(case_file("[time]\nstep = 0.02 s\n"))
    assert "\n" not in str(error.value)


def test_file_in_another_encoding_is_one_sentence(tmp_path):
    path = tmp_path / "latin.toml"
    path.write_bytes('title = "Flügel"\n'.encode("latin-1"))
    with pytest.raises(InputError, match="it is not UTF-8 text"):
        Case.load(path)


def test_byte_order_mark_of_an_editor_is_no_mistake(tmp_path):
    (tmp_path / "bom.toml").write_bytes(b"\xef\xbb\xbf[time]\nend = 1.0\n")
    assert Case.load(tmp_path / "bom.toml").time.end == 1.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a = " + "[" * 100000, "nested too deeply"),
        (".".join(["time"] * 5000) + " = 1", "nested too deeply"),
        (f"[time]\nstep = {'9' * 5000}", "too many digits"),
        (f"[time]\nstep = 0x{'f' * 5000}", "time.step = a int too large to show"),
    ],
)
def test_what_python_itself_refuses_is_one_sentence(case_file, text, words):
    with pytest.raises(InputError, match=words) as error:
        Case.load(case_file(text))
    assert "\n" not in str(error.value)


def test_all_malformed_overrides_are_named(case_file):
    with pytest.raises(InputError) as error:
        Case.load(case_file("title = 'x'"), ["time.end", "=3", "title.x=3", "time.step=0"])
    assert len(str(error.value).splitlines()) == 4


def test_mesh_file_that_is_none_is_told_with_the_other_mistakes(case_file):
    path = case_file('[mesh]\nfile = "own.msh"\ndegree = 3\n')
    with pytest.raises(InputError, match=r"mesh.degree(.|\n)*cannot read .*own.msh'"):
        Case.load(path)
    path.with_name("own.msh").write_text("solid")
    with pytest.raises(InputError, match=r"mesh.file: .*own.msh' is not a mesh"):
        Case.load(path, ["mesh.degree=2"])
    assert Case.load(path, ["mesh.degree=2", "turbine.model=rigid"]).warnings


def test_mesh_file_is_relative_to_the_case_file(case_file, tmp_path):
    path = case_file('[mesh]\nfile = "meshes/own.msh"\n')
    other = tmp_path / "x.msh"
    (tmp_path / "meshes").mkdir()
    for file in (tmp_path / "meshes" / "own.msh", other):
        file.write_text("$MeshFormat\n")
    assert Case.load(path).mesh.file == str(tmp_path / "meshes" / "own.msh")
    assert Case.load(path, [f'mesh.file="{other}"']).mesh.file == str(other)
