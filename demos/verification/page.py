"""The table of all benchmarks as a page of the documentation.

The page is its own memory: a run replaces the parts of the benchmarks that it has run.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from published import Row, load, names, source

HEAD = """\
# Verification against published benchmarks

Problems with a published or an exact solution, and nothing tuned to them. `make verification` runs
them and writes this page. It fails if an error is larger than its bound, or if an order of accuracy
is not that of the method.

The error at the finest step is mostly that of the time step or mesh. Where runs follow the law of
their order, Richardson's extrapolation takes it away. Then only errors of the model, of the
reference, and of solving the equations of a step are left.

"""
SUMMARY = ["benchmark", "order", "largest error", "error, extrapolated"]
FAILS = "**too large**"
"""Mark of an error or order that is out of bounds."""

_PART = re.compile(r"^\((\w+)\)=\n.*?(?=\n^\(\w+\)=\n|\Z)", re.DOTALL | re.MULTILINE)
_LINE = re.compile(r"^\| \[.*\]\(#(\w+)\) \|.*$", re.MULTILINE)


def markdown(results: Mapping[str, Sequence[Row]], page: str = "") -> str:
    """The page.

    Args:
        results: Rows of each benchmark that was run, by its name.
        page: The page as it was; what was not run stays as it is there.
    """
    parts = {match[1]: match[0].strip() for match in _PART.finditer(page)}
    lines = {match[1]: match[0] for match in _LINE.finditer(page)}
    for name, rows in results.items():
        parts[name], lines[name] = section(name, rows), summary(name, rows)
    known = [name for name in names() if name in parts and name in lines]
    overview = [line(SUMMARY), line(["---"] * len(SUMMARY)), *(lines[name] for name in known)]
    return HEAD + "\n\n".join(["\n".join(overview), *(parts[name] for name in known)]) + "\n"


def summary(name: str, rows: Sequence[Row]) -> str:
    """Line of a benchmark in the overview."""
    limits = [row.limit_tolerance for row in rows if row.limit is not None]
    orders = {f"{row.order:.2f}" for row in rows if row.order is not None}
    cells = [
        f"[{described(name)[0]}](#{name})",
        " - ".join(sorted({min(orders), max(orders)})) if orders else "",
        largest_error(rows),
        bound(max(limits)) if limits else "",
    ]
    return line(cells)


def largest_error(rows: Sequence[Row]) -> str:
    """Of a benchmark; in parts of the reference where the units of its rows differ."""
    if len({row.unit for row in rows}) > 1 and all(row.reference for row in rows):
        return f"{100.0 * max(abs(row.error / row.reference) for row in rows):.1g} %"
    return error(max(rows, key=lambda row: abs(row.error))).removeprefix("-")


def section(name: str, rows: Sequence[Row]) -> str:
    """Part of a benchmark."""
    title, text = described(name)
    last = f"{source(name)} Made by `python demos/verification {name}`."
    return "\n\n".join([f"({name})=\n## {title}", text, table(rows), last])


def described(name: str) -> tuple[str, str]:
    """Title and text of a benchmark: the docstring of its script."""
    title, _, text = (load(name).__doc__ or name).strip().partition("\n")
    return title.removesuffix("."), text.strip()


def table(rows: Sequence[Row]) -> str:
    """Rows of one benchmark."""
    head = ["quantity", "reference", "ours", "error"]
    if any(row.order is not None for row in rows):
        head += ["order", "ours, extrapolated", "error"]
    steps = {row.step for row in rows}
    if len(steps) == 1 and steps != {""}:
        head[2] += f", {steps.pop()}"
    lines = [line(head), line(["---"] * len(head))]
    for row in rows:
        unit = "" if row.unit == "-" else f" {row.unit}"
        step = f" ({row.step})" if row.step and not head[2].endswith(row.step) else ""
        reference = f"{row.reference!r}".removesuffix(".0")
        mark = "" if row.holds else f" {FAILS}"
        cells = [row.quantity, f"{reference}{unit}", f"{value(row)}{step}", f"{error(row)}{mark}"]
        if row.order is not None:
            cells.append(f"{row.order:.2f}")
        if row.limit is not None:
            cells += [fixed(row.limit, row.limit_tolerance), bound(row.limit_tolerance)]
        lines.append(line(cells + [""] * (len(head) - len(cells))))
    return "\n".join(lines)


def line(cells: Sequence[str]) -> str:
    """A row of a table."""
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def value(row: Row) -> str:
    """Ours, with two digits of its error; nothing where that is round-off."""
    return "" if row.round_off else fixed(row.value, abs(row.error) / 10.0)


def error(row: Row) -> str:
    """The error: round-off differs between machines, so that its bound is shown alone."""
    return bound(row.tolerance) if row.round_off else power(row.error)


def bound(tolerance: float) -> str:
    """What an error is below."""
    return f"< {power(tolerance)}" if math.isfinite(tolerance) else ""


def power(number: float) -> str:
    """Two digits and a power of ten, 5.4e-5."""
    mantissa, exponent = f"{number:.1e}".split("e")
    return f"{mantissa.removesuffix('.0')}e{int(exponent)}" if number else "0"


def fixed(number: float, resolution: float) -> str:
    """A number with so many decimals that ``resolution`` shows."""
    if not math.isfinite(resolution):
        return f"{number:.6g}"
    digits = -math.floor(math.log10(resolution)) if 0.0 < resolution < 1.0 else 0
    return f"{number:.{min(digits, 13)}f}"
