"""The pieces of an HTML page that needs no other file: tables, figures, notes."""

import base64
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from turbine_fenicsx._version import __version__
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records import names


def fill_page(title: str, subtitle: str, sections: Mapping[str, str]) -> str:
    """The page.

    Args:
        sections: HTML of the sections by their headings; empty ones are left out.
    """
    template = Template(Path(__file__).with_name("report.html").read_text(encoding="utf-8"))
    return template.substitute(
        title=escape(title),
        subtitle=escape(f"{subtitle}; written by turbine_fenicsx {__version__}."),
        body="\n".join(
            f"<section><h2>{escape(name)}</h2>\n{text}</section>"
            for name, text in sections.items()
            if text
        ),
    )


def format_case(
    case: Mapping[str, Any] | None, describe: Callable[[Mapping[str, Any]], Mapping[str, Any]]
) -> str:
    """The resolved case."""
    if case is None:
        return format_note(
            "There is no case.json in the output folder, so that the case is not shown."
        )
    try:
        return format_tables(group_tables(describe(case), "case"))
    except InputError as error:
        words = f"This is no valid case for this version, and shown as it is: {error}."
        return format_note(words) + format_tables(group_tables(case, "case"))


def group_tables(
    tables: Mapping[str, Any], rest: str, above: str = ""
) -> dict[str, dict[str, Any]]:
    """Nested tables one after another; what is in none of them comes first, under ``rest``."""
    own = {k: v for k, v in tables.items() if not isinstance(v, Mapping)}
    found = {rest: own} if own else {}
    for name, inner in tables.items():
        if isinstance(inner, Mapping):
            full = f"{above}{name}"
            found |= group_tables(inner, full, f"{full}.")
    return found


def format_tables(
    tables: Mapping[str, Mapping[str, Any]], label: Callable[[str], str] | None = None
) -> str:
    """Tables of two columns beside each other; empty ones are left out."""
    label = label or format_label
    texts = []
    for name, rows in tables.items():
        caption = f"<caption>{escape(format_label(name))}</caption>" if name else ""
        lines = "\n".join(
            f"<tr><th scope='row'>{escape(label(key))}</th><td>{escape(text)}</td></tr>"
            for key, text in ((key, _format_value(value)) for key, value in rows.items())
        )
        if rows:
            texts.append(f"<table>{caption}\n{lines}\n</table>")
    return f"<div class='tables'>\n{''.join(texts)}\n</div>\n"


def format_grid(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table of several columns, of which the first names the row."""
    titles = "".join(f"<th scope='col'>{escape(text)}</th>" for text in head)
    lines = "\n".join(
        f"<tr><th scope='row'>{escape(str(name))}</th>"
        + "".join(f"<td>{escape(_format_value(value))}</td>" for value in values)
        + "</tr>"
        for name, *values in rows
    )
    return f"<table class='wide'>\n<tr>{titles}</tr>\n{lines}\n</table>\n"


def format_label(key: str) -> str:
    """A key in words, its unit in brackets."""
    name, unit = names.split_unit(key)
    symbol = unit.replace("^2", "²").replace("^3", "³")
    words = name.replace("_", " ")
    return words if unit in ("", "-") else f"{words} [{symbol}]"


def _format_value(value: Any) -> str:
    """A value as a person would write it."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list | tuple):
        return ", ".join(_format_value(item) for item in value) or "none"
    return str(value)


def embed_figure(path: Path, caption: str, kind: str = "") -> str:
    """A PNG file inside the page."""
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    return (
        f"<figure{kind and f' class={kind!r}'}><img alt='{escape(caption, quote=True)}' "
        f"src='data:image/png;base64,{data}'>\n<figcaption>{escape(caption)}</figcaption></figure>\n"
    )


def format_note(text: str) -> str:
    """A sentence about what is missing."""
    return f"<p class='note'>{escape(text)}</p>\n"
