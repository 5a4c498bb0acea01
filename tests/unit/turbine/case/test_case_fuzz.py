"""Whatever stands in a case file: a case, or sentences about its keys, and nothing else.

The examples are the same in every run and on every rank.
"""

import datetime
import json
import math
import re
import tempfile
from functools import cache
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from turbine_fenicsx.case.quantities import to_si
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.case.case import Case

DEMOS = Path(__file__).parents[4] / "demos" / "paper"
UNITS = ["s", "m", "kg", "kg m^2", "kg/m^3", "Pa", "N m", "N m s/rad", "m/s^2", "rad", ""]


def examples(n):
    """Settings: n examples, always the same, without a time limit and a folder of its own."""
    return settings(
        max_examples=n,
        derandomize=True,
        database=None,
        deadline=None,
        suppress_health_check=list(HealthCheck),
    )


@cache
def keys():
    """Valid keys by table, the tables inside of others too."""
    found = {}

    def walk(model, above):
        found[above] = list(model.model_fields)
        for name, field in model.model_fields.items():
            if hasattr(field.annotation, "model_fields"):
                walk(field.annotation, (*above, name))

    walk(Case, ())
    return found


pieces = st.sampled_from(
    [
        *"m s kg k N Pa GPa ^ ** * / 2 -3 99 e 1e999 0 . _ m² °C ½ ٣ \x00 nan inf ( ,".split(),
        *(" ", "\n", '"', "printed", "rigid", "hybrid", "tetrahedron", "neo_hooke", "lu"),
    ]
)
texts = st.one_of(st.lists(pieces, max_size=6).map("".join), st.text(max_size=10))
numbers = st.one_of(
    st.sampled_from([0, 1, 2, 3, -1, 10**30, 10**400, -(10**4000), 2**31, 2**64]),
    st.sampled_from([0.0, -0.0, 0.2, 1e-320, 1e-30, 1e30, 1e308, math.nan, math.inf, -math.inf]),
    st.integers(),
    st.floats(),
)
scalars = st.one_of(
    numbers,
    texts,
    st.booleans(),
    st.sampled_from([datetime.date(2012, 1, 1), datetime.time(1), datetime.datetime(2012, 1, 1)]),
    st.tuples(numbers, st.sampled_from(["m", "s", "kg", "GPa", "kN m", "kg/m^3"])).map(
        lambda pair: f"{float(pair[0]) if abs(pair[0]) < 1e300 else 1e300!r} {pair[1]}"
    ),
)
values = st.recursive(
    scalars,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=5), inner, max_size=2)
    ),
    max_leaves=6,
)


@st.composite
def tables(draw, sane=False):
    """Nested tables with mostly valid keys and any values, or with values of the right kind."""
    data = {}
    for _ in range(draw(st.integers(1, 6))):
        above = draw(st.sampled_from(sorted(keys())))
        names = keys()[above]
        name = draw(st.sampled_from(names) if sane else st.one_of(st.sampled_from(names), texts))
        if not sane and draw(st.integers(0, 9)) == 0:
            above = (*above, draw(texts))
        value = draw(good if sane else values)
        table = data
        for part in above:
            inner = table.setdefault(part, {})
            table = inner if isinstance(inner, dict) else table
        table[name] = value
    return data


good = st.one_of(
    st.floats(1e-300, 1e30),
    st.integers(1, 3),
    st.sampled_from(["rigid", "hybrid", "tetrahedron", "hexahedron", "neo_hooke", "iterative"]),
    st.sampled_from(["spring", "prescribed"]),
    st.booleans(),
    st.lists(st.floats(1e-6, 1e3), min_size=3, max_size=3),
    st.lists(st.integers(1, 300), min_size=3, max_size=3),
    st.just([0.0, 0.5, 1.0]),
)
ABOUT = re.compile(
    r"unknown key |material is not positive definite|the case|cannot read the case file|"
    r".* is not valid TOML: |cannot read .*: write --set|cannot set |"
    rf"({'|'.join(keys()[()])})\b"
)


def is_told(make):
    """The case that is made, or None after a look at the sentences of the refusal."""
    try:
        return make()
    except InputError as error:
        lines = str(error).splitlines()
        assert lines
        assert str(error).count("\n") == len(lines) - 1
        assert len(set(lines)) == len(lines)
        for line in lines:
            assert ABOUT.match(line), line
            assert len(line) < 1000
        return None


@examples(400)
@given(tables())
def test_any_tables_are_a_case_or_sentences_about_keys(data):
    is_told(lambda: Case.parse(data))


@examples(30)
@given(values)
def test_anything_in_the_place_of_the_tables(data):
    is_told(lambda: Case.parse(data))


def toml(value, depth=0):
    """A value as TOML text, in tables of one line."""
    if isinstance(value, dict):
        inner = ", ".join(f"{json.dumps(k)} = {toml(v, depth + 1)}" for k, v in value.items())
        return f"{{{inner}}}"
    if isinstance(value, list):
        return f"[{', '.join(toml(v, depth + 1) for v in value)}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, int) and abs(value) > 10**1000:
        return hex(value) if value > 0 else "-1"
    return value.isoformat() if hasattr(value, "isoformat") else repr(value)


@cache
def folder():
    """A folder for the case files of this rank."""
    return tempfile.TemporaryDirectory()


def loaded(content, overrides=()):
    """Load a file with this content."""
    path = Path(folder().name) / "case.toml"
    path.write_bytes(content)
    return is_told(lambda: Case.load(path, overrides))


@examples(200)
@given(tables())
def test_any_toml_file_is_a_case_or_sentences(data):
    text = "\n".join(f"{json.dumps(name)} = {toml(value)}" for name, value in data.items())
    loaded(text.encode("utf-8", "surrogatepass"))


@pytest.mark.parametrize("name", ["rigid", "hybrid_stiff"])
@examples(150)
@given(data=st.data())
def test_any_damage_to_a_file_is_told(name, data):
    content = bytearray((DEMOS / f"{name}.toml").read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content)))
        length = data.draw(st.integers(0, 30))
        new = data.draw(
            st.one_of(
                st.binary(max_size=6),
                st.sampled_from(
                    [b"[", b"]", b'"', b"=", b"\n", b"[time]\n", b"[[mesh]]\n", b"1e999"]
                ),
                st.sampled_from([b"nan", b"-", b"'''", b"9" * 5000, b"[" * 2000, b"a.b.c = 1\n"]),
            )
        )
        content[at : at + length] = new
    loaded(bytes(content))


@examples(200)
@given(st.lists(st.one_of(texts, st.tuples(texts, texts).map("=".join)), max_size=3), st.data())
def test_any_overrides_are_told(overrides, data):
    above = data.draw(st.sampled_from(sorted(keys())))
    key = ".".join((*above, data.draw(st.sampled_from(keys()[above]))))
    loaded(b"[time]\nend = 1.0\n", [*overrides, f"{key}={toml(data.draw(values))}"])


@examples(100)
@given(
    st.one_of(st.text(max_size=20), st.sampled_from(["", ".", "/", "\x00", "\ud800", "x" * 5000]))
)
def test_any_name_of_a_file_is_told(name):
    path = f"{folder().name}/none/{name}"
    is_told(lambda: Case.load(path))


@examples(600)
@given(st.one_of(texts, st.lists(pieces, min_size=1, max_size=8).map(lambda p: f"3 {''.join(p)}")))
def test_any_text_is_a_finite_quantity_or_a_value_error(text):
    for unit in UNITS:
        try:
            number = to_si(text, unit)
        except ValueError as error:
            assert str(error).startswith("expected a")
        else:
            assert math.isfinite(number)


@examples(100)
@given(values)
def test_anything_is_a_finite_quantity_or_a_value_error(value):
    for unit in UNITS:
        try:
            assert math.isfinite(to_si(value, unit))
        except ValueError as error:
            assert str(error).startswith("expected a")
