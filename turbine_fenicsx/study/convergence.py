"""Observed orders of convergence.

The error e of a quantity falls like C h^p with the size h of what is refined. p is the slope of
log e over log h, fitted by least squares. Against the finest run of the series itself, which has an
error itself, the observed order is somewhat too high; Richardson's extrapolation

    q(h) = q* + C h^p   through the three finest runs

gives a reference q* without that flaw, if the runs are fine enough for the law to hold. Three runs
fit q*, C and p exactly, whatever they are, so that such an order is evidence of nothing. Series of
one quantity therefore share one reference, see `choose_reference`, which other series can check.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

Array = npt.NDArray[np.float64]
_HIGHEST_ORDER = 20.0

MIN_ORDER = 1.0
"""Runs of a lower order are too coarse to point to a limit."""

ROUND_OFF = 1e-12
"""Smaller steps from one run to the next count as zero, as a part of the largest value."""

CLEAR_SPREAD = 0.01
"""Limits of series that differ by a larger part of themselves are worth a note."""


@dataclass(frozen=True)
class Series:
    """A quantity over one refinement, coarsest first.

    Attributes:
        label: What distinguishes the series from others, empty if there is one only.
        sizes: h, shape (n,).
        values: The quantity, shape (n,).
        reference: What it is compared with; NaN if there is none.
        errors: Absolute errors, shape (n,); NaN for the reference itself.
        order: Observed order; NaN if it cannot be determined.
        source: Series whose limit the reference is, if it is another one.
        own_limit: Whether the reference is the limit of the series itself.
    """

    label: str
    quantity: str
    runs: tuple[str, ...]
    sizes: Array
    values: Array
    reference: float
    errors: Array
    order: float
    source: str = ""
    own_limit: bool = False

    @property
    def finest(self) -> bool:
        """Whether the reference is the finest run of the series itself."""
        return bool(len(self.values) and self.values[-1] == self.reference)

    @property
    def is_checked(self) -> bool:
        """Whether there are more errors than numbers that are fitted to them."""
        usable = int(np.count_nonzero(np.isfinite(self.errors) & (self.errors > 0.0)))
        return usable > (3 if self.own_limit else 2)

    @property
    def oscillates(self) -> bool:
        """Whether the values go up and down as the size falls, by more than round-off."""
        steps = np.diff(self.values)
        steps = steps[np.abs(steps) > ROUND_OFF * np.max(np.abs(self.values), initial=0.0)]
        return bool(np.any(steps[1:] * steps[:-1] < 0.0))

    @property
    def local_orders(self) -> Array:
        """Orders between each run and the one before, shape (n,), the first NaN."""
        with np.errstate(divide="ignore", invalid="ignore"):
            log_e, log_h = np.log(self.errors), np.log(self.sizes)
            found = np.diff(log_e, prepend=np.nan) / np.diff(log_h, prepend=np.nan)
        return np.asarray(np.where(np.isfinite(found), found, np.nan))


def make_series(
    label: str,
    quantity: str,
    runs: Sequence[str],
    refined: Sequence[Any],
    values: Sequence[float],
    reference: float | str,
    source: str = "",
) -> Series:
    """Compare the runs of one refinement with a reference and fit the order.

    Args:
        refined: Value of the refined key in each run: sizes, or lists of numbers of elements.
        source: Series whose limit the value is, if it is one.
    """
    sizes = refinement_sizes(refined)
    order = np.argsort(-sizes, kind="stable")
    h, q = sizes[order], np.asarray(values, dtype=float)[order]
    if reference == "finest":
        exact = float(q[-1]) if len(q) else np.nan
    elif reference == "richardson":
        exact = richardson(h, q)
    else:
        exact = float(reference)
    errors = np.abs(q - exact)
    if reference == "finest" and len(q):
        errors[-1] = np.nan
    names = tuple(runs[k] for k in order)
    own = reference == "richardson" and bool(np.isfinite(exact))
    order_found = observed_order(h, errors)
    return Series(label, quantity, names, h, q, exact, errors, order_found, source, own)


def choose_reference(series: Sequence[Series]) -> tuple[Series | None, list[str]]:
    """The series whose Richardson limit is the reference of all series of a quantity.

    Of those whose order is 1 or more, it is the one with the finest run nearest to its limit.

    Args:
        series: Series of one quantity, each with its own limit as reference.

    Returns:
        The series, None if there is none, and notes: sentences about limits that disagree.
    """
    with_limit = [s for s in series if np.isfinite(s.reference)]
    usable = [s for s in with_limit if s.order >= MIN_ORDER]
    best = min(usable, key=lambda s: abs(s.values[-1] - s.reference), default=None)
    notes = [
        f"runs of {_name(s)} follow an order of {s.order:.2f}: too coarse to point to a limit"
        for s in with_limit
        if s.order < MIN_ORDER
    ]
    for s in with_limit:
        if best is None or s is best:
            continue
        part = abs(s.reference - best.reference) / max(abs(best.reference), 1e-300)
        if part > CLEAR_SPREAD:
            notes.append(
                f"the limit of {_name(s)} by itself, {s.reference:.6g}, is {100.0 * part:.2g} % "
                f"off that of {_name(best)}, {best.reference:.6g}"
            )
    return best, notes


def _name(series: Series) -> str:
    """A series in a sentence."""
    return repr(series.label) if series.label else "the series"


def refinement_sizes(refined: Sequence[Any]) -> Array:
    """Sizes h that stand for the values of a refined key.

    A number is the size itself. Of lists, such as numbers of elements along the edges of a block,
    it is one over the geometric mean of those numbers that are not the same in all runs.

    Returns:
        Shape (n,).
    """
    numbers = np.asarray(refined, dtype=float)
    if numbers.ndim == 1:
        return numbers
    changing = np.any(numbers != numbers[:1], axis=0)
    return np.asarray(np.exp(-np.mean(np.log(numbers[:, changing]), axis=1)))


def observed_order(sizes: Array, errors: Array) -> float:
    """Slope of log error over log size by least squares; NaN with fewer than two errors."""
    usable = np.isfinite(errors) & (errors > 0.0)
    if np.count_nonzero(usable) < 2 or np.ptp(sizes[usable]) == 0.0:
        return float("nan")
    return float(np.polyfit(np.log(sizes[usable]), np.log(errors[usable]), 1)[0])


def richardson(sizes: Array, values: Array) -> float:
    """Limit q* of q(h) = q* + C h^p through the three finest values.

    Args:
        sizes: h, falling, shape (n,).
        values: q, shape (n,).

    Returns:
        q*; NaN if the last two differences do not fall as any power of h does.
    """
    if len(sizes) < 3:
        return float("nan")
    (h1, h2, h3), (q1, q2, q3) = sizes[-3:] / sizes[-1], values[-3:]
    if q1 == q2 or q2 == q3:
        return float("nan")

    def mismatch(p: float) -> float:
        return float((h1**p - h2**p) / (h2**p - h3**p) - (q1 - q2) / (q2 - q3))

    low, high = 1e-3, _HIGHEST_ORDER
    if not mismatch(low) < 0.0 < mismatch(high):
        return float("nan")
    p = brentq(mismatch, low, high)
    return float(q3 - (q2 - q3) * h3**p / (h2**p - h3**p))


def report(series: Series) -> list[list[str]]:
    """Rows of a table for people, with a head."""

    def text(number: float, form: str) -> str:
        return format(number, form) if np.isfinite(number) else "-"

    rows = [["run", "size", series.quantity, "error", "order"]]
    columns = (series.runs, series.sizes, series.values, series.errors, series.local_orders)
    for name, h, q, e, p in zip(*columns, strict=True):
        rows.append([name, f"{h:.6g}", f"{q:.9g}", text(e, ".3e"), text(p, ".2f")])
    return rows


def write_series(path: Path, found: Sequence[Series]) -> None:
    """Write all series to one CSV file, one row for each run and quantity."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        head = ["series", "quantity", "run", "size", "value", "reference", "error", "local_order"]
        writer.writerow([*head, "observed_order"])
        for s in found:
            for name, h, q, e, p in zip(
                s.runs, s.sizes, s.values, s.errors, s.local_orders, strict=True
            ):
                writer.writerow([s.label, s.quantity, name, h, q, s.reference, e, p, s.order])
