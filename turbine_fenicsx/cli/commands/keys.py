"""Print the keys of case files with units, defaults, what is allowed and what they mean.

Without TABLE it lists the tables; `keys all` prints them all. A table inside another has a dotted
name, such as turbine.hub.
"""

from __future__ import annotations

import argparse
import json
import shutil
import textwrap
from typing import TYPE_CHECKING, Any

from turbine_fenicsx.cli.commands._common import OK

if TYPE_CHECKING:
    from turbine_fenicsx.case.reference import Table

alone = True


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("table", metavar="TABLE", nargs="?", help="name of a table, or all")
    parser.add_argument(
        "--schema", action="store_true", help="print the JSON schema of case files, for editors"
    )


def run(options: argparse.Namespace, comm: Any) -> int:
    """Print the tables that are asked for, on one rank."""
    from turbine_fenicsx.case.reference import list_tables
    from turbine_fenicsx.case.schema import make_schema
    from turbine_fenicsx.foundation.errors import InputError
    from turbine_fenicsx.foundation.text_files import quote, suggest
    from turbine_fenicsx.turbine.tables.tables import Tables

    if options.schema and (comm is None or comm.rank == 0):
        print(json.dumps(make_schema(Tables, "Case file of turbine_fenicsx"), indent=1))
    if options.schema:
        return OK
    tables = {table.name: table for table in list_tables(Tables)}
    wanted = options.table and options.table.strip("[]")
    if wanted not in (None, "all", *tables):
        hint = suggest(wanted, tables) or "; `turbine-fenicsx keys` lists the tables"
        raise InputError(f"there is no table {quote(wanted)} in a case file{hint}")
    if comm is not None and comm.rank != 0:
        return OK
    if wanted is None:
        print(_list_names(tables.values()))
    else:
        chosen = tables.values() if wanted == "all" else [tables[wanted]]
        print("\n\n".join(_show(table) for table in chosen))
    return OK


def _list_names(tables: Any) -> str:
    """A line for each table: its name, and what it is about."""
    from turbine_fenicsx.case.reference import strip_marks

    lines = [
        f"{f'[{table.name}]' if table.name else '(before all tables)':<24}"
        f"{strip_marks(table.text.split(chr(10), 1)[0])}"
        for table in tables
    ]
    return "\n".join([*lines, "", "turbine-fenicsx keys TABLE prints the keys of one of them."])


def _show(table: Table) -> str:
    """A table: a paragraph for each key."""
    from turbine_fenicsx.case.reference import strip_marks

    width = min(100, max(60, shutil.get_terminal_size((100, 24)).columns))
    parts = [f"[{table.name}]" if table.name else "(before all tables)"]
    if table.name:
        parts.append(strip_marks(table.text))
    for key in table.keys:
        unit = f" {key.unit}" if key.unit not in ("", "-") else ""
        default = f"default {key.default}{unit}" if key.default else "default none"
        facts = f"  {key.name}: {default}; {key.allowed}{unit if '>' in key.allowed else ''}"
        meaning = textwrap.wrap(strip_marks(key.meaning), width - 6)
        parts.append("\n".join([facts.rstrip(), *(f"      {line}" for line in meaning)]))
    return "\n\n".join(parts)
