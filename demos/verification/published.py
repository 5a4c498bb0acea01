"""What benchmarks are made of: references and their source, refined runs, rows of the table."""

from __future__ import annotations

import importlib.util
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from turbine_fenicsx.study.convergence import observed_order

HERE = Path(__file__).parent
ORDER_TOLERANCE = 0.1
"""How far a fitted order may be from the order of the method."""


@dataclass(frozen=True)
class Row:
    """One quantity of a benchmark beside its reference.

    Attributes:
        quantity: What it is, with its time.
        unit: Its unit, "-" without one.
        reference: The published or exact value.
        value: Ours, at the finest step.
        tolerance: Largest error allowed.
        step: What the value was computed with, e.g. "Δt = 0.25 ms"; empty if nothing is refined.
        order: Fitted order of accuracy; None if nothing is refined.
        limit: Ours, extrapolated to a step of zero; None if nothing is refined.
        limit_tolerance: Largest error allowed there.
        expected_order: Order of the method.
        round_off: Whether the error is round-off, of which the table shows the bound alone.
    """

    quantity: str
    unit: str
    reference: float
    value: float
    tolerance: float
    step: str = ""
    order: float | None = None
    limit: float | None = None
    limit_tolerance: float = np.inf
    expected_order: float = 2.0
    round_off: bool = False

    @property
    def error(self) -> float:
        """Ours minus the reference."""
        return self.value - self.reference

    @property
    def limit_error(self) -> float:
        """The extrapolated value minus the reference; zero without one."""
        return 0.0 if self.limit is None else self.limit - self.reference

    @property
    def holds(self) -> bool:
        """Whether errors and order are what they should be; never so for NaN."""
        order = self.expected_order if self.order is None else self.order
        return (
            abs(self.error) <= self.tolerance
            and abs(self.limit_error) <= self.limit_tolerance
            and abs(order - self.expected_order) <= ORDER_TOLERANCE
        )


@dataclass(frozen=True)
class Reference:
    """A value to compare with and how near a benchmark must come to it.

    Attributes:
        quantity: What it is, with its time.
        value: The value.
        unit: Its unit.
        tolerance: Largest error allowed at the finest step.
        limit_tolerance: Largest error allowed of the value extrapolated to a step of zero.
    """

    quantity: str
    value: float
    unit: str
    tolerance: float
    limit_tolerance: float = np.inf


def references(benchmark: str) -> dict[str, Reference]:
    """What ``reference.toml`` of a benchmark lists, by the names that its script uses."""
    tables = _reference_file(benchmark)
    return {name: Reference(**t) for name, t in tables.items() if isinstance(t, dict)}


def source(benchmark: str) -> str:
    """Where the references come from, in Markdown."""
    return str(_reference_file(benchmark)["source"]).strip()


def _reference_file(benchmark: str) -> dict[str, Any]:
    """Content of ``reference.toml``."""
    return tomllib.loads((HERE / benchmark / "reference.toml").read_text(encoding="utf-8"))


def read_long_run(benchmark: str) -> dict[str, Any]:
    """Numbers of a run too long for the page: ``result.toml``, which its ``compute.py`` makes."""
    return tomllib.loads((HERE / benchmark / "result.toml").read_text(encoding="utf-8"))


def compare_long_run(benchmark: str) -> list[Row]:
    """Rows of the table from those numbers; nothing is run."""
    found = read_long_run(benchmark)
    step = f"{found['steps']} steps, {found['revolutions']:.0f} revolutions"
    return [
        Row(r.quantity, r.unit, r.value, found[name], r.tolerance, step)
        for name, r in references(benchmark).items()
    ]


def refine(
    solve: Callable[[int], Mapping[str, float]],
    steps: Sequence[int],
    duration: float,
    expected: Mapping[str, Reference],
) -> list[Row]:
    """Run a benchmark with finer and finer steps and compare it with its references.

    Args:
        solve: Takes a number of steps and returns the quantities by name.
        steps: Numbers of steps, rising.
        duration: What the steps divide [s].
        expected: The references by name.

    Returns:
        One row for each reference.
    """
    runs = [solve(n) for n in steps]
    dt = duration / np.asarray(steps, dtype=float)
    rows = []
    for name, r in expected.items():
        values = np.array([run[name] for run in runs])
        rows.append(
            Row(
                quantity=r.quantity,
                unit=r.unit,
                reference=r.value,
                value=float(values[-1]),
                tolerance=r.tolerance,
                step=f"Δt = {1e3 * dt[-1]:.4g} ms",
                order=observed_order(dt, np.abs(values - r.value)),
                limit=extrapolate(dt, values),
                limit_tolerance=r.limit_tolerance,
            )
        )
    return rows


def extrapolate(sizes: np.ndarray, values: np.ndarray) -> float:
    """Value at a step of zero, by Richardson's extrapolation through all runs.

    The time step is symmetric: it goes back the way it came. So its error has even powers of the
    step only, q(h) = q* + c1 h^2 + c2 h^4 + ..., and q* is the value at 0 of the polynomial in
    h^2 through all (h^2, q), by the scheme of Aitken and Neville.
    """
    x, q = np.asarray(sizes, dtype=float) ** 2, np.array(values, dtype=float)
    for k in range(1, len(q)):
        q[k:] = q[k:] + (q[k:] - q[k - 1 : -1]) * x[k:] / (x[:-k] - x[k:])
    return float(q[-1])


def names() -> list[str]:
    """All benchmarks: every folder here that has a ``run.py``."""
    return sorted(path.parent.name for path in HERE.glob("*/run.py"))


def load(name: str, script: str = "run") -> ModuleType:
    """A script of a benchmark as a module."""
    path = HERE / name / f"{script}.py"
    spec = importlib.util.spec_from_file_location(f"verification_{name}_{script}", path)
    if spec is None or spec.loader is None or not path.exists():
        raise ValueError(f"there is no benchmark {name!r}; there are {names()}")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
