"""YAML of windIO files: what is read, what is refused, and that nothing in it runs or hangs."""

import time
from math import inf, isnan

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from windio_files import small_turbine

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.windio import read_turbine, yaml_text
from turbine_fenicsx.windio.yaml_text import YamlError, parse_yaml


def test_values_are_those_of_yaml_1_2():
    text = """
a: [1, -2.5, 1e-5, .5, 3., +4, 1E3]
b: {c: text, d: 'quoted 1', e: "1", f: yes, g: true, h: null, i: ~, j: }
k:
  - &mine {l: 1}
  - *mine
"""
    tables = parse_yaml(text)
    assert tables["a"] == [1.0, -2.5, 1e-5, 0.5, 3.0, 4.0, 1000.0]
    assert tables["b"] == {
        "c": "text", "d": "quoted 1", "e": "1", "f": "yes",
        "g": True, "h": None, "i": None, "j": None,
    }  # fmt: skip
    assert tables["k"] == [{"l": 1.0}, {"l": 1.0}]


def test_tables_are_merged_and_own_keys_win():
    tables = parse_yaml("a: &a {b: 1, c: 2}\nd: &d {e: 3}\nf: {c: 4, <<: *a}\ng: {<<: [*d, *a]}")
    assert tables["f"] == {"b": 1.0, "c": 4.0}
    assert tables["g"] == {"b": 1.0, "c": 2.0, "e": 3.0}


def test_infinity_and_nan_are_numbers():
    a, b, c = parse_yaml("[.inf, -.inf, .nan]")
    assert (a, b) == (inf, -inf)
    assert isnan(c)


def test_a_turbine_comes_back_as_pyyaml_has_it():
    tables = small_turbine()
    assert parse_yaml(yaml.safe_dump(tables)) == tables


BOMB = "a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1]\n" + "".join(
    f"{one}: &{one} [{', '.join([f'*{other}'] * 9)}]\n"
    for other, one in zip("abcdefghi", "bcdefghij", strict=True)
)
# With libyaml, and without it.
RESOLVERS = {"yaml_implicit_resolvers": yaml_text.Loader.yaml_implicit_resolvers}
LOADERS = [yaml_text.Loader, type("PureLoader", (yaml.SafeLoader,), RESOLVERS)]
HOSTILE = {
    "aliases of aliases": (BOMB, "holds more than 500000 values in line 6"),
    "an alias in itself": ("a: &a [*a]", "has a list or a table in line 1 that is part of itself"),
    "an alias of nothing": ("a: *b", "is not valid YAML: found undefined alias"),
    "deep lists": ("[" * 300_000, "nests its lists and tables more than 30 deep in line 1"),
    "deep tables": ("{a: " * 300_000, "nests its lists and tables more than 30 deep in line 1"),
    "code": ("!!python/object/apply:os.system ['touch ran']", "has the tag 'tag:yaml.org,2002:py"),
    "a tag on a list": ("a: !!set {b, c}", "has the tag 'tag:yaml.org,2002:set' in line 1"),
    "an included file": ("a: !include other.yaml", "has the tag '!include' in line 1"),
    "a long number": ("a: " + "9" * 100_000, "holds a number with too many digits in line 1"),
    "a key twice": ("a: 1\na: 2", "has the key 'a' in line 2 twice"),
    "an anchor twice": ("a: &a 1\nb: &a 2", "found duplicate anchor"),
    "a merge of a list": (
        "a: &a [1]\nc:\n  <<: *a\n",
        "expected a mapping for merging, but found scalar",
    ),
    "a list for a key": ("? [1, 2]\n: 3", "has a key in line 1 that is not text"),
    "a second document": ("a: 1\n---\nb: 2", "found another document in line 2"),
    "what is no YAML": ("a: [1, 2\nb: 3", "is not valid YAML: "),
    "a tab": ("a:\n\t- 1", "found character"),
    "a control character": ("a: \x07", "is not valid YAML: "),
}


@pytest.mark.parametrize("loader", LOADERS)
@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_text_is_refused_at_once_in_one_sentence(name, loader, tmp_path, monkeypatch):
    text, sentence = HOSTILE[name]
    monkeypatch.setattr(yaml_text, "Loader", loader)
    monkeypatch.chdir(tmp_path)
    begin = time.process_time()
    with pytest.raises(YamlError) as caught:
        parse_yaml(text)
    assert time.process_time() - begin < 5.0
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "ran").exists()


def test_half_a_million_values_are_enough():
    with pytest.raises(YamlError, match="holds more than 500000 values in line 500000"):
        parse_yaml("- 1\n" * 600_000)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "small.yaml: the file must be a table with the key 'components', got nothing"),
        (b"\xff\xfe\x00", "is not UTF-8 text"),
        (b"a: [1", "small.yaml: the file is not valid YAML"),
        (b"- 1\n- 2\n", "small.yaml: the file must be a table with the key 'components'"),
        (b" " * 10_000_001, "it has 10000001 bytes, expected at most 10000000"),
    ],
)
def test_files_that_are_no_turbines_are_refused_in_one_sentence(content, sentence, tmp_path):
    path = tmp_path / "small.yaml"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        read_turbine(path)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_folder_and_a_missing_file_are_refused(tmp_path):
    for path in (tmp_path, tmp_path / "none.yaml"):
        with pytest.raises(InputError, match="cannot read the windIO file"):
            read_turbine(path)


@settings(max_examples=300, deadline=None, derandomize=True, database=None)
@given(st.text(st.sampled_from("ab1.e-+:,[]{}&*!<>|%@`'\"#\n\t ?~\\\x00é"), max_size=60))
def test_any_text_is_read_or_refused(text):
    try:
        parse_yaml(text)
    except YamlError as error:
        assert "\n" not in str(error)
