"""Parts of pages that are made from the package; ``make reference`` writes them.

Between ``<!-- generated: NAME -->`` and ``<!-- end -->`` stand tables that can be read without
Sphinx: ``case-tables`` and ``case-units`` from the tables of a case, ``channels`` from the table
of OpenFAST's names, ``commands`` from the parsers of the command line, ``public-names`` from the
package. ``<!-- room: NAME -->`` is where Sphinx
lists the modules of a room with their docstrings.
"""

from __future__ import annotations

import argparse
import importlib
import inspect
import pkgutil
import re
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

HERE = Path(__file__).parent
PART = re.compile(r"(<!-- generated: ([\w-]+) -->\n).*?(<!-- end -->)", re.DOTALL)
ROOM = re.compile(r"<!-- room: ([\w.]+) -->")
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def table(head: list[str], rows: list[list[str]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *([cell.replace("|", "\\|") for cell in r] for r in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def summary(thing: Any) -> str:
    """First paragraph of a docstring, in Markdown."""
    text = " ".join((inspect.getdoc(thing) or "").split("\n\n")[0].split())
    return re.sub(r"`+([^`]+)`+", r"`\1`", text)


# --- case files


def case_tables(_: str) -> str:
    """All tables of a case file with their keys."""
    from turbine_fenicsx.case.reference import list_tables
    from turbine_fenicsx.turbine.tables.tables import Tables

    return "\n".join(map(_case_table, list_tables(Tables)))


def _case_table(part: Any) -> str:
    """One table of a case file."""
    rows = [
        [f"`{k.name}`", k.unit, _code(k.default) or "none", _choices(k.allowed), _links(k.meaning)]
        for k in part.keys
    ]
    keys = table(["key", "unit", "default", "allowed", "meaning"], rows)
    if not part.name:
        return f"## Outside of all tables\n\n{keys}"
    text = "\n\n".join(" ".join(piece.split()) for piece in part.text.split("\n\n"))
    return f"## `[{part.name}]`\n\n{_links(text)}\n\n{keys}"


def _code(text: str) -> str:
    """A value of TOML in Markdown."""
    return text and f"`{text}`"


def _choices(text: str) -> str:
    """What is allowed, with choices as code."""
    return re.sub(r'"[^"]*"|\b(?:true|false)\b', lambda match: f"`{match[0]}`", text)


def _links(text: str) -> str:
    """A docstring in Markdown; `howto/start` and the like become links."""
    text = re.sub(r"`{1,2}([^`]+)`{1,2}", r"`\1`", text)
    return re.sub(r"\b((?:howto|theory|reference)/\w+)\b", r"[](../\1.md)", text)


def case_units(_: str) -> str:
    """Units and prefixes."""
    from turbine_fenicsx.case import quantities

    units = ", ".join(f"`{name}`" for name in quantities._UNITS)
    powers = {name: str(n).translate(SUPERSCRIPT) for name, n in quantities._PREFIXES.items()}
    prefixes = ", ".join(f"`{name}` 10{power}" for name, power in powers.items())
    return f"Units: {units}.\n\nPrefixes: {prefixes}.\n"


# --- history.out


def channels(_: str) -> str:
    """All channels with their axes."""
    from turbine_fenicsx.records.openfast_names import AXES, read_rows

    rows = [
        [
            ", ".join(map(_name_channel, row.names)),
            row.unit,
            row.axes,
            "yes" if row.default else "",
            row.meaning,
            row.source,
        ]
        for row in read_rows()
    ]
    axes = [[key, text] for key, text in AXES.items() if key]
    head = ["channel", "unit", "axes", "default", "meaning", "made of"]
    return f"{table(head, rows)}\n{table(['axes', 'of what, and where they point'], axes)}"


def _name_channel(pattern: str) -> str:
    """A pattern of names as a reader takes it."""
    shown = {"axis": "x", "yz": "y", "Axis": "X", "blade": "1", "node": "1", "section": "1"}
    others = {"axis": "y, z", "yz": "z", "Axis": "Y, Z"}
    more = [others[field] for field in re.findall(r"{(\w+)}", pattern) if field in others]
    return f"`{pattern.format(**shown)}`" + "".join(f" ({text})" for text in more)


# --- command line


def commands(_: str) -> str:
    """All commands with their arguments."""
    from turbine_fenicsx.cli.main import _make_parser

    found = (a for a in _make_parser()._actions if isinstance(a, argparse._SubParsersAction))
    (subparsers,) = found
    return "\n".join(_command(name, parser) for name, parser in subparsers.choices.items())


def _command(name: str, parser: argparse.ArgumentParser) -> str:
    """One command."""
    words = " ".join(parser.format_usage().removeprefix("usage: ").split())
    usage = textwrap.fill(words, 88, subsequent_indent=" " * 8, break_on_hyphens=False)
    rows = [
        [f"`{_invocation(action)}`", _sentence(action)]
        for action in parser._actions
        if not isinstance(action, argparse._HelpAction)
    ]
    text = re.sub(r"(--\w+(?: S\b)?)", r"`\1`", str(parser.description).strip())
    parts = [f"## `{name}`", text, f"```text\n{usage}\n```"]
    if rows:
        parts.append(table(["argument", "meaning"], rows))
    return "\n\n".join(parts) + "\n"


def _invocation(action: argparse.Action) -> str:
    """How an argument is written."""
    choices = "{" + ",".join(map(str, action.choices or ())) + "}"
    value = "" if action.nargs == 0 else str(action.metavar or choices)
    return " ".join([*([", ".join(action.option_strings)] if action.option_strings else []), value])


def _sentence(action: argparse.Action) -> str:
    """Help of an argument."""
    text = re.sub(r"(--\w+)", r"`\1`", (action.help or "").replace("%%", "%"))
    if action.choices and "{" in _invocation(action):
        return f"{text}; default: {action.default}" if "default" not in text else text
    return text


# --- Python


def public_names(_: str) -> str:
    """What can be imported from the package itself."""
    import turbine_fenicsx

    rows = [
        [f"`{name}`", f"[`{module}`]({module.split('.')[0]}.md)", summary(thing)]
        for name, module in _homes(turbine_fenicsx)
        for thing in [getattr(turbine_fenicsx, name)]
    ]
    return table(["name", "module", "what it is"], rows)


def _homes(package: Any) -> Iterator[tuple[str, str]]:
    """Public names and the modules they are defined in, without the name of the package."""
    for name in package._PUBLIC:
        thing = getattr(package, name)
        yield name, thing.__module__.removeprefix(f"{package.__name__}.")


def room(name: str) -> str:
    """Sections for a package and all its modules, by name."""
    parts = []
    for module in _modules(name.strip()):
        # a function of a package may be called like one of its modules
        inner = ", ".join(m.name for m in pkgutil.iter_modules(getattr(module, "__path__", ())))
        exclude = f"   :exclude-members: {inner}\n" if inner else ""
        text = f".. automodule:: {module.__name__}\n{exclude}"
        parts.append(f"## `{module.__name__}`\n\n```{{eval-rst}}\n{text}```\n")
    return "\n".join(parts)


def _modules(name: str) -> list[ModuleType]:
    """A package and its modules, those of inner packages included, by name."""
    package = importlib.import_module(name)
    inner = pkgutil.walk_packages(package.__path__, f"{name}.")
    return [package, *(importlib.import_module(module.name) for module in inner)]


GENERATORS: dict[str, Callable[[str], str]] = {
    "case-tables": case_tables,
    "case-units": case_units,
    "channels": channels,
    "commands": commands,
    "public-names": public_names,
}
"""Text that stands in the pages, between a mark and the mark of its end."""


def refresh(text: str) -> str:
    """A page with its generated parts as they are now."""
    return PART.sub(lambda part: f"{part[1]}\n{GENERATORS[part[2]]('')}{part[3]}", text)


def fill_in(app: Sphinx, docname: str, source: list[str]) -> None:
    """Put the modules of a room into its page, which only Sphinx can show."""
    source[0] = ROOM.sub(lambda mark: room(mark[1]), source[0])


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("source-read", fill_in)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


if __name__ == "__main__":
    for page in sorted(HERE.parent.rglob("*.md")):
        old = page.read_text(encoding="utf-8")
        if (new := refresh(old)) != old:
            page.write_text(new, encoding="utf-8")
            print(f"wrote {page}")
    import rooms

    rooms.PICTURE.write_text(rooms.draw(), encoding="utf-8")
