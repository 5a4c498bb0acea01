"""Claims about the prose of pages and docstrings: short sentences, plain words."""

import re

import pytest
from prose import ROOT, count_words, find_prose, split_sentences

LONGEST, LONG, MOST_LONG = 40, 35, 40
"""Words of the longest sentence allowed, of a long one, and the number of long ones allowed."""

RULES = {
    "a clause as subject": r"^(What|Whatever|Whoever|Of which)\b(?!.*\?)",
    "no role of a constant": r"\b[Ss]o many\b|\bthis part of\b",
    "'that is no' instead of 'if X is not Y'": r"\b(that|which|what) (is|are) (no|none)\b",
    "house words": r"(?i)\b(go(es|ing)?|went) on\b|\banew\b|\bat once\b|\btell(s|ing)?\b|\btold\b"
    r"|\bof (its|their|one's|our) own\b|\blives? from\b|\bas (it|one) likes\b|\b(has|have) seen\b",
    "'0.1 for 0.2' instead of 'instead of'": r"\d( %| s| ms| GB)? for \d|where (it|they) took",
}


@pytest.fixture(scope="module")
def sentences():
    return [(where, s) for where, text in find_prose() for s in split_sentences(text)]


def test_sentences_are_short(sentences):
    long = {f"{where}: {s}": count_words(s) for where, s in sentences if count_words(s) > LONG}
    assert [s for s, words in long.items() if words > LONGEST] == []
    assert len(long) <= MOST_LONG, sorted(long)


@pytest.mark.parametrize("rule", RULES)
def test_words_are_plain(sentences, rule):
    pattern = re.compile(RULES[rule])
    assert [f"{where}: {s}" for where, s in sentences if pattern.search(s)] == []


def test_pages_have_no_control_characters():
    """Such as the form feed that an unescaped \\f of a formula becomes."""
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "demos").rglob("*.py")]
    bad = [str(p) for p in pages if re.search(r"[\x00-\x09\x0b-\x1f]", p.read_text("utf-8"))]
    assert bad == []
