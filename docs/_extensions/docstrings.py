"""Docstrings of the package as reStructuredText.

They are plain text for people: formulas are indented or aligned by blanks, |x| is a norm, and one
pair of backticks names something of the package.
"""

from __future__ import annotations

import pydoc
import re
from typing import Any

import numpy as np
import numpy.typing as npt
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.domains.python import PyXRefRole
from sphinx.util.typing import stringify_annotation

_SHORT = {
    stringify_annotation(kind, mode): name  # type: ignore[arg-type]
    for mode in ("smart", "fully-qualified", "fully-qualified-except-typing")
    for kind, name in (
        (npt.ArrayLike, "ArrayLike"),
        (npt.NDArray[np.float64], "Array"),
        (npt.NDArray[np.int64], "IntArray"),
        (npt.NDArray[np.int32], "IntArray"),
        (npt.NDArray[Any], "NDArray"),
    )
}
"""Names for types of NumPy that fill many lines."""

_ALIGNED = re.compile(r"\S {3,}\S")
_SECTION = re.compile(r"(Args|Attributes|Returns|Raises|Yields|Note|Example):$")
_BACKTICKS = re.compile(r"(`[^`]+`)")


def formulas_as_literals(
    app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]
) -> None:
    """Keep the lines of indented and aligned paragraphs; escape bars elsewhere."""
    found: list[str] = []
    paragraph: list[str] = []
    in_section = False
    for line in [*lines, ""]:
        if line.strip():
            paragraph.append(line)
            continue
        if paragraph:
            first = paragraph[0]
            in_section = bool(_SECTION.match(first)) or (in_section and first.startswith(" "))
            indented = first.startswith(" ") and not in_section
            if indented or any(_ALIGNED.search(text) for text in paragraph):
                found += ["::", "", *(f"    {text}" for text in paragraph)]
            else:
                found += [_escaped(text) for text in paragraph]
            paragraph = []
        found.append("")
    lines[:] = found


def _escaped(line: str) -> str:
    """A line whose bars are bars."""
    parts = _BACKTICKS.split(line)
    return "".join(p if p.startswith("`") else p.replace("|", r"\|") for p in parts)


def short_signatures(
    app: Sphinx,
    what: str,
    name: str,
    thing: Any,
    options: Any,
    signature: str | None,
    result: str | None,
) -> tuple[str | None, str | None]:
    """Signatures that fit on the page."""

    def short(text: str | None) -> str | None:
        for long, alias in _SHORT.items():
            text = text and text.replace(long, alias)
        return text and text.replace("<factory>", "...")

    return short(signature), short(result)


def named(
    name: str,
    rawtext: str,
    text: str,
    lineno: int,
    inliner: Any,
    options: Any = None,
    content: Any = (),
) -> tuple[list[nodes.Node], list[nodes.system_message]]:
    """Link to what a name means: in the class and module at hand, or anywhere if it is capital."""
    target = text
    if text.startswith("turbine_fenicsx."):
        thing = pydoc.locate(text)
        if hasattr(thing, "__qualname__"):
            target = f"{text} <{thing.__module__}.{thing.__qualname__}>"
    elif "." in text or any(c.isupper() for c in text):
        target = f".{text}"
    return PyXRefRole()("py:obj", rawtext, target, lineno, inliner, options or {}, content)


def no_pages_without_source(app: Sphinx) -> tuple[()]:
    """Keep `sphinx.ext.viewcode` from listing modules that it could not read, such as builtins."""
    found = getattr(app.env, "_viewcode_modules", {})
    for name in [name for name, source in found.items() if not source]:
        del found[name]
    return ()


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_role("named", named)
    app.connect("autodoc-process-docstring", formulas_as_literals, priority=400)
    app.connect("autodoc-process-signature", short_signatures)
    app.connect("html-collect-pages", no_pages_without_source, priority=100)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
