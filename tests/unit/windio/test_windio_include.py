"""Files that windIO files include: read as parts, watched as parts, and bounded."""

import time

import pytest
import yaml
from windio_files import small_turbine

from turbine_fenicsx.case.files import hash_files
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.case.turbine_file import load_turbine
from turbine_fenicsx.turbine.tables.tables import Tables
from turbine_fenicsx.windio import read_turbine, yaml_file
from turbine_fenicsx.windio.yaml_file import list_included, read_yaml
from turbine_fenicsx.windio.yaml_text import YamlError


def split(folder):
    """A turbine whose materials and blade stand in further files, one of which has a third."""
    tables = small_turbine()
    (folder / "parts").mkdir()
    blade = tables["components"]["blade"]
    shape = blade["outer_shape"]
    (folder / "parts" / "shape.yml").write_text(yaml.safe_dump(shape))
    blade["outer_shape"] = "INCLUDE shape.yml"
    (folder / "parts" / "blade.yaml").write_text(include(blade))
    (folder / "materials.yaml").write_text(yaml.safe_dump(tables["materials"]))
    tables["components"]["blade"] = "INCLUDE parts/blade.yaml"
    tables["materials"] = "INCLUDE materials.yaml"
    (folder / "turbine.yaml").write_text(include(tables))
    return folder / "turbine.yaml"


def include(tables):
    """Tables as text, with tags in place of texts."""
    return yaml.safe_dump(tables).replace("INCLUDE ", "!include ")


def test_included_files_are_read_as_if_they_stood_there(tmp_path):
    path = split(tmp_path)
    assert read_yaml(path) == small_turbine()
    assert {p.removeprefix(f"{tmp_path}/") for p in list_included(path)} == {
        "materials.yaml", "parts/blade.yaml", "parts/shape.yml",
    }  # fmt: skip


def test_a_change_of_an_included_file_is_seen(tmp_path):
    path = split(tmp_path)
    data = {"turbine": {"file": str(path)}}
    density = load_turbine(str(path)).materials["foam"].ply.density
    before = hash_files(data, Tables)
    assert load_turbine(str(path)) is load_turbine(str(path))
    materials = yaml.safe_load((tmp_path / "materials.yaml").read_text())
    next(m for m in materials if m["name"] == "foam")["rho"] = 2.0 * density
    (tmp_path / "materials.yaml").write_text(yaml.safe_dump(materials))
    assert load_turbine(str(path)).materials["foam"].ply.density == 2.0 * density
    assert hash_files(data, Tables) != before


@pytest.mark.parametrize(
    ("files", "sentence"),
    [
        ({"a.yaml": "a: !include a.yaml"}, "includes 'a.yaml', of which it is part"),
        (
            {"a.yaml": "a: !include b.yaml", "b.yaml": "b: !include ./a.yaml"},
            "includes 'b.yaml', which includes './a.yaml', of which it is part",
        ),
        ({"a.yaml": "a: !include b.nc"}, "includes 'b.nc', expected a file in .yaml"),
        ({"a.yaml": "a: !include [b]"}, "has the tag '!include' in line 1, which is not read"),
        (
            {"a.yaml": "a: !include b.yaml", "b.yaml": "b: [1"},
            "includes 'b.yaml', which is not valid YAML",
        ),
        (
            {
                "a.yaml": "- !include b.yaml\n" * 100,
                "b.yaml": "- !include c.yaml\n" * 100,
                "c.yaml": "- 1\n" * 100,
            },
            "holds more than 500000 values",
        ),
        (
            {f"{k}.yaml": f"!include {k + 1}.yaml" for k in range(60)}
            | {"a.yaml": "!include 0.yaml"},
            "includes '5.yaml', which is included through more than 5 files",
        ),
        (
            {"a.yaml": "\n".join(f"- !include {k}.yaml" for k in range(60))}
            | {f"{k}.yaml": "1" for k in range(60)},
            "includes '50.yaml', which is one of more than 50 included files",
        ),
    ],
)  # fmt: skip
def test_wrong_and_hostile_includes_are_refused_in_one_sentence(files, sentence, tmp_path):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    begin = time.process_time()
    with pytest.raises(YamlError) as caught:
        read_yaml(tmp_path / "a.yaml")
    assert sentence in str(caught.value)
    assert len(list_included(tmp_path / "a.yaml")) <= yaml_file.MAX_FILES
    assert time.process_time() - begin < 5.0


def test_the_file_that_is_missing_is_named(tmp_path):
    (tmp_path / "a.yaml").write_text("a: !include none.yaml")
    with pytest.raises(InputError, match=r"cannot read the included file '.*none\.yaml': No such"):
        read_turbine(tmp_path / "a.yaml")
