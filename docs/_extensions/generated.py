"""Parts of pages that are made from the package: ``<!-- generated: NAME ... -->`` in Markdown.

``case-tables`` and ``case-units`` come from the types in `turbine_fenicsx.turbine.case.tables`,
``commands`` from the parsers of the command line, ``public-names`` and ``room`` from the
package and its docstrings.
"""

from __future__ import annotations

import argparse
import importlib
import inspect
import pkgutil
import re
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Literal, get_args, get_origin

if TYPE_CHECKING:
    from sphinx.application import Sphinx

HERE = Path(__file__).parent
MARK = re.compile(r"<!-- generated: ([\w-]+)\s*(.*?)\s*-->", re.DOTALL)
NO_LIMIT = 1e30
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
    from turbine_fenicsx.turbine.case.tables import Tables

    meanings = tomllib.loads((HERE / "case_keys.toml").read_text(encoding="utf-8"))
    parts = list(_sections("", Tables, Tables(), meanings))
    if meanings:
        raise ValueError(f"case_keys.toml explains what does not exist: {meanings}")
    return "\n".join(parts)


def _sections(name: str, model: Any, default: Any, meanings: dict[str, Any]) -> Iterator[str]:
    """One table of a case file, then those inside it; takes the meanings it has used."""
    rows, inner = [], []
    for key, field in model.model_fields.items():
        if hasattr(field.annotation, "model_fields"):
            inner.append((key, field.annotation, getattr(default, key)))
            continue
        if get_origin(field.annotation) is dict:  # tables with names of the user's own
            kind = get_args(field.annotation)[1]
            inner.append((f"{key}.NAME", kind, kind()))
            continue
        meaning = meanings.pop(key, None) or field.description
        if meaning is None:
            raise ValueError(f"case_keys.toml does not explain {name}.{key}")
        kind = [field.annotation, *field.metadata]
        value = _toml(getattr(default, key))
        rows.append([f"`{key}`", _unit(kind), value, _allowed(kind), meaning])
    title = f"## `[{name}]`" if name else "## Outside of all tables"
    text = "\n\n".join(
        " ".join(part.split()) for part in (inspect.getdoc(model) or "").split("\n\n")
    )
    head = ["key", "unit", "default", "allowed", "meaning"]
    if name:
        text = re.sub(r"`{1,2}([^`]+)`{1,2}", r"`\1`", text)
        yield f"{title}\n\n{text}\n\n{table(head, rows)}"
    else:
        yield f"{title}\n\n{table(head, rows)}"
    for key, annotation, value in inner:
        dotted = f"{name}.{key}" if name else key
        yield from _sections(dotted, annotation, value, meanings.get(key, {}))
        if not meanings.get(key, True):
            del meanings[key]


def _walk(kind: Any) -> Iterator[Any]:
    """A type, its parts, and what annotates them."""
    if isinstance(kind, list):
        for part in kind:
            yield from _walk(part)
        return
    yield kind
    for part in (
        *get_args(kind),
        *getattr(kind, "__metadata__", ()),
        *getattr(kind, "metadata", ()),
    ):
        if get_origin(kind) is not Literal:
            yield from _walk(part)


def _unit(kind: Any) -> str:
    """Unit of a number."""
    from turbine_fenicsx.turbine.case.quantities import Unit

    for part in _walk(kind):
        if isinstance(part, Unit):
            return part.symbol.replace("^2", "²").replace("^3", "³") or "-"
    return ""


def _allowed(kind: Any) -> str:
    """Choices, range and number of entries."""
    parts = list(_walk(kind))
    choices = [f"`{_toml_text(c)}`" for p in parts if get_origin(p) is Literal for c in get_args(p)]
    bounds = {
        (sign, getattr(p, name))
        for p in parts
        for sign, name in ((">", "gt"), ("≥", "ge"), ("<", "lt"), ("≤", "le"))
        if getattr(p, name, None) is not None and abs(getattr(p, name)) < NO_LIMIT
    }
    if choices and float in parts:
        bounds = {(">", 0.0)}
    limits = [f"{sign} {value:g}" for sign, value in sorted(bounds, key=lambda b: b[1])]
    text = ", ".join([*dict.fromkeys(choices), *limits])
    for part in parts:
        if get_origin(part) is tuple:
            entries = get_args(part)
            count = "list" if Ellipsis in entries else f"{len(entries)} numbers"
            return f"{count}, each {text}" if text else count
    if not text and bool in parts:
        text = "`true`, `false`"
    if not text:
        text = "text" if str in parts else "any"
    return text


def _toml(value: Any) -> str:
    """A default in Markdown."""
    return "none" if value is None else f"`{_toml_text(value)}`"


def _toml_text(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple):
        return f"[{', '.join(map(_toml_text, value))}]"
    if isinstance(value, float) and abs(value) >= 1e8:
        power = 9 if abs(value) >= 1e9 else 6
        return f"{value / 10**power:.12g}e{power}"
    return f"{value:.12g}"


def case_units(_: str) -> str:
    """Units and prefixes."""
    from turbine_fenicsx.turbine.case import quantities

    units = ", ".join(f"`{name}`" for name in quantities._UNITS)
    powers = {name: str(n).translate(SUPERSCRIPT) for name, n in quantities._PREFIXES.items()}
    prefixes = ", ".join(f"`{name}` 10{power}" for name, power in powers.items())
    return f"Units: {units}.\n\nPrefixes: {prefixes}.\n"


# --- command line


def commands(_: str) -> str:
    """All commands with their arguments."""
    from turbine_fenicsx.cli.main import _make_parser

    found = (a for a in _make_parser()._actions if isinstance(a, argparse._SubParsersAction))
    (subparsers,) = found
    return "\n".join(_command(name, parser) for name, parser in subparsers.choices.items())


def _command(name: str, parser: argparse.ArgumentParser) -> str:
    """One command."""
    parser.formatter_class = lambda prog: argparse.HelpFormatter(prog, width=88)
    usage = parser.format_usage().removeprefix("usage: ")
    rows = [
        [f"`{_invocation(action)}`", _sentence(action)]
        for action in parser._actions
        if not isinstance(action, argparse._HelpAction)
    ]
    text = re.sub(r"(--\w+(?: S\b)?)", r"`\1`", str(parser.description).strip())
    parts = [f"## `{name}`", text, f"```text\n{usage}```"]
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
        [f"{{py:obj}}`{name} <turbine_fenicsx.{module}.{name}>`", summary(thing)]
        for name, module in _homes(turbine_fenicsx)
        for thing in [getattr(turbine_fenicsx, name)]
    ]
    return table(["name", "what it is"], rows)


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
    "commands": commands,
    "public-names": public_names,
    "room": room,
}


SOURCES = {
    "case-tables": "turbine/case/*.py",
    "case-units": "turbine/case/*.py",
    "commands": "cli/commands/*.py",
    "public-names": "__init__.py",
    "room": "",  # Sphinx sees these by itself
}
"""Files of the package that a part is made from."""


def fill_in(app: Sphinx, docname: str, source: list[str]) -> None:
    """Replace the marks of a page."""
    package, names = HERE.parents[1] / "turbine_fenicsx", MARK.findall(source[0])
    if names:
        source[0] = MARK.sub(lambda mark: GENERATORS[mark[1]](mark[2]), source[0])
        for pattern in {SOURCES[name] for name, _ in names} - {""}:
            for path in package.glob(pattern):
                app.env.note_dependency(str(path))
        app.env.note_dependency(str(HERE / "case_keys.toml"))


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("source-read", fill_in)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
