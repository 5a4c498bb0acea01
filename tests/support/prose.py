"""The project's prose as sentences: pages without code, tables and formulas, and docstrings."""

import ast
import inspect
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
GENERATED = ("case_file.md", "commands.md", "changelog.md")
"""Pages made of docstrings, which are read where they stand, and the changelog."""

_END = re.compile(r"(?<=[.!?])[\"')*_]*\s+(?=[\"'(*_\[`$\\{]*[A-Z0-9`$\[{(])")
_PARAGRAPH = re.compile(r"\n\s*\n|\n(?=\s*(?:[-*+]|\d+\.)\s)|^#.*$", re.M)
_ENTRY = re.compile(r"\n(?=\s+[\w, ]+: )|\n(?=\s*(?:Args|Returns|Raises|Attributes|Note):)")
_NO_PROSE = re.compile(
    r"^\s*(`{3,}|~{3,})[^\n]*\n.*?^\s*\1`*\s*$"  # code
    r"|^\s*:::.*?$|^:\w+:.*?$|^\s*\|.*?$"  # directives, tables
    r"|\$\$.*?\$\$|\\begin\{align.*?\\end\{align\*?\}|<!--.*?-->",
    re.S | re.M,
)
_SET_APART = re.compile(r"(?<=\n\n)(?: {4}.*\n?)+(?=\n|$)")
"""Formulas, tables and code, indented between empty lines."""

_ONE_WORD = re.compile(r"\{[a-z:]+\}`[^`]*`|`+[^`]*`+|\$[^$]*\$|<[^>]+>")


def find_prose():
    """Each page and docstring: where it stands, and its text."""
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), ROOT / "meshes" / "README.md"]
    for page in sorted(pages):
        if "_build" not in page.parts and page.name not in (*GENERATED, "CHANGELOG.md"):
            text = _NO_PROSE.sub("\n\n", page.read_text(encoding="utf-8"))
            yield str(page.relative_to(ROOT)), _SET_APART.sub("", text)
    for file in sorted((ROOT / "turbine_fenicsx").rglob("*.py")):
        for text in _find_docstrings(file):
            yield str(file.relative_to(ROOT)), text


def _find_docstrings(file):
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        body = getattr(node, "body", None)
        for line in body if isinstance(body, list) else ():
            value = getattr(line, "value", None)
            if isinstance(line, ast.Expr) and isinstance(getattr(value, "value", None), str):
                text = inspect.cleandoc(value.value)
                formula = r"(?<=\n\n)(?: {4}.*\n?)+(?=\n|$)"  # set apart by empty lines
                yield from _ENTRY.split(re.sub(formula, "", text))


def split_sentences(text):
    """The sentences of a text, on one line each."""
    for paragraph in _PARAGRAPH.split(text):
        yield from filter(None, _END.split(" ".join(paragraph.split())))


def count_words(sentence):
    """Number of words; code, a formula or a link counts as one."""
    plain = re.sub(r"\]\([^)]*\)", "] ", _ONE_WORD.sub(" x ", sentence))
    return len(re.findall(r"[A-Za-z0-9][\w'./-]*", plain))
