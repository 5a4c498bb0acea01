"""From the records of a run to tables: check agreement, then compare.

``report.py RESULTS_JSON`` writes the report again.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

WARM_UP = 2
AGREEMENT = 1e-3
"""Largest relative difference of tip deflections. All rules are second order, but midpoint and
trapezoidal rule differ, as do initial accelerations, by some 1e-4 in the first ten steps."""

OTHER_MOTION = ("ours-turning",)
"""What solves another problem, so that its deflections must differ."""

Records = list[dict[str, Any]]


class Results:
    """Access to the records: minima over the turns.

    Args:
        records: The records.
    """

    def __init__(self, records: Records) -> None:
        """Drop what failed."""
        self.records = [r for r in records if "error" not in r]
        self.failures = [r for r in records if "error" in r]

    def of(self, part: str, code: str, size: str = "") -> Records:
        """All turns of one competitor; "compare" also counts as "growth"."""
        parts = (part, "compare") if part == "growth" else (part,)
        return [
            r
            for r in self.records
            if r["part"] in parts and r["code"] == code and r.get("size", "") == size
        ]

    def step(self, part: str, code: str, size: str) -> float:
        """Seconds per step: for each step the fastest turn, then the mean over steps."""
        turns = [r["steps"][WARM_UP:] for r in self.of(part, code, size)]
        return float(np.mean(np.min(turns, axis=0))) if turns else math.nan

    def least(self, part: str, code: str, key: str, size: str = "") -> float:
        """Smallest value of a number over the turns."""
        return min((r[key] for r in self.of(part, code, size)), default=math.nan)

    def sizes(self, part: str) -> list[str]:
        """Sizes of a part, by unknowns."""
        parts = (part, "compare") if part == "growth" else (part,)
        found = {r["size"]: r["unknowns"] for r in self.records if r["part"] in parts}
        return sorted(found, key=lambda s: found[s])

    def codes(self, part: str, size: str) -> list[str]:
        """Codes that ran, in their order."""
        parts = (part, "compare") if part == "growth" else (part,)
        ran = [r["code"] for r in self.records if r["part"] in parts and r["size"] == size]
        return list(dict.fromkeys(ran))

    def unknowns(self, size: str) -> int:
        """Displacement unknowns of a size."""
        return next(
            r["unknowns"] for r in self.records if r.get("size") == size and "unknowns" in r
        )


def deviations(results: Results, part: str, size: str) -> dict[str, float]:
    """Relative difference of the tip deflections from those of the first code."""
    codes = results.codes(part, size)
    tips = {c: np.array(results.of(part, c, size)[0]["tips"]) for c in codes}
    reference = tips[codes[0]]
    scale = np.linalg.norm(reference)
    return {c: float(np.linalg.norm(t - reference) / scale) for c, t in tips.items()}


def report(data: dict[str, Any]) -> tuple[str, bool]:
    """The whole report in Markdown, and whether all deflections agree."""
    results = Results(data["records"])
    m = data["machine"]
    lines = [
        "# Benchmark",
        "",
        f"{m['date']}, {m['processor']}, {m['cores']} cores, load {m['load_before']:.1f} before.",
        "Seconds per step, best of all turns; memory of all ranks together.",
    ]
    agree = True
    if m["load_before"] > 0.5:
        lines += ["", "**Other programs were running: only ratios mean anything, if at all.**"]
    for part in ("compare", "soft"):
        for size in results.sizes(part):
            table, fine = comparison(results, part, size)
            lines += ["", *table]
            agree = agree and fine
    lines += ["", *growth(results), "", *small(results), "", *goals(results), "", *about(results)]
    return "\n".join(lines) + "\n", agree


def comparison(results: Results, part: str, size: str) -> tuple[list[str], bool]:
    """Table of all codes for one size; no times of a code whose deflections do not agree."""
    apart = deviations(results, part, size)
    mine = results.step(part, "ours-hybrid", size)
    kind = "Soft" if part == "soft" else "Stiff"
    lines = [
        f"## {kind} blades {size}: {results.unknowns(size)} unknowns",
        "",
        f"Tips deflected by {deflection(results, part, size):.3g} m at the end.",
        "",
        "| code | cores | s/step | relative | iterations | set-up s | memory MB | tips apart |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    fine = True
    for code in results.codes(part, size):
        r = results.of(part, code, size)[0]
        cores = f"{r['ranks']} x {r['threads']}"
        if apart[code] > AGREEMENT and code not in OTHER_MOTION:
            fine = False
            lines.append(f"| {code} | {cores} | **tips disagree** | | | | | {apart[code]:.1e} |")
            continue
        step = results.step(part, code, size)
        iterations = np.mean(r["iterations"][WARM_UP:])
        lines.append(
            f"| {code} | {cores} | {step:.4g} | {step / mine:.2f} | {iterations:.1f} "
            f"| {results.least(part, code, 'set_up', size):.1f} "
            f"| {results.least(part, code, 'memory', size):.0f} "
            f"| {'another motion' if code in OTHER_MOTION else f'{apart[code]:.1e}'} |"
        )
    return lines, fine


def deflection(results: Results, part: str, size: str) -> float:
    """Largest tip deflection of the first code [m]."""
    first = results.codes(part, size)[0]
    tips = np.array(results.of(part, first, size)[0]["tips"])
    return float(np.linalg.norm(tips, axis=1).max())


def growth(results: Results) -> list[str]:
    """Table of time and memory against unknowns."""
    lines = [
        "## Growth with the number of unknowns",
        "",
        "| code | unknowns | s/step | microseconds per unknown | memory MB |",
        "| --- | --- | --- | --- | --- |",
    ]
    for code in ("ours-hybrid", "ours-iterative"):
        for size in results.sizes("growth"):
            step, n = results.step("growth", code, size), results.unknowns(size)
            if not math.isnan(step):
                memory = results.least("growth", code, "memory", size)
                lines.append(f"| {code} | {n} | {step:.4g} | {1e6 * step / n:.2f} | {memory:.0f} |")
    return lines


def small(results: Results) -> list[str]:
    """What is known of the small cases."""
    lines = ["## Small cases", ""]
    for r in results.of("small", "paper")[:1]:
        parts = ", ".join(f"{k} {1e3 * v:.1f}" for k, v in r["step_by_part"].items())
        lines.append(
            f"- The paper's case, all of it: {results.least('small', 'paper', 'seconds'):.2f} s, "
            f"without fields {results.least('small', 'paper', 'seconds_without_fields'):.2f} s; "
            f"{r['iterations']:.2f} iterations per step; ms per step: {parts}."
        )
    for code in ("rigid", "exudyn"):
        for r in results.of("small", code)[:1]:
            seconds = results.least("small", code, "seconds")
            lines.append(f"- Rigid turbine, {code}: {seconds:.3f} s, angle {r['angle']:.5f} rad.")
    for r in [r for r in results.records if r["part"] == "units"][:1]:
        lines.append(
            f"- Units: residual {results.least('units', 'units', 'residual', r['size']):.4f} s, "
            f"solve {results.least('units', 'units', 'solve', r['size']):.4f} s."
        )
    return lines


Goal = tuple[str, float, float, bool]
"""Name, goal, value, and whether more is better."""


def goals(results: Results) -> list[str]:
    """The goals beside what was measured."""
    lines = ["## Goals", "", "| ratio | goal | measured | |", "| --- | --- | --- | --- |"]
    for name, goal, value, at_least in (*compare_codes(results), *count_costs(results)):
        met = value >= goal if at_least else value <= goal
        shown = "not measured" if math.isnan(value) else f"{value:.3g}"
        verdict = "" if math.isnan(value) else ("met" if met else "**missed**")
        lines.append(
            f"| {name} | {'at least' if at_least else 'at most'} {goal:g} | {shown} | {verdict} |"
        )
    return lines


def compare_codes(results: Results) -> list[Goal]:
    """Goals that compare the times of two codes or settings."""

    def ratio(slow: str, fast: str, unknowns: int, part: str = "compare") -> float:
        near = [s for s in results.sizes(part) if 0.8 < results.unknowns(s) / unknowns < 1.25]
        if not near:
            return math.nan
        apart = deviations(results, part, near[0])
        if any(apart.get(c, 0.0) > AGREEMENT for c in (slow, fast) if c not in OTHER_MOTION):
            return math.nan
        return results.step(part, slow, near[0]) / results.step(part, fast, near[0])

    def best(name: str) -> float:
        """The other code on one or two threads, against ours on as many cores, at 70 k."""
        pairs = ((name, "ours-hybrid"), (f"{name}-2", "ours-hybrid-2"))
        return min((r for p in pairs if not math.isnan(r := ratio(*p, k70))), default=math.nan)

    ours, k11, k70, k220, k300 = "ours-hybrid", 11_025, 70_713, 220_545, 301_725
    refactored, cholesky = "ours-refactored", "fenicsx-cholesky"
    return [
        ("full Newton + LU / ours, 70 k", 8, ratio("fenicsx-lu", ours, k70), True),
        ("full Newton + LU / ours, 220 k", 15, ratio("fenicsx-lu", ours, k220), True),
        ("lagged Cholesky / ours, 70 k", 3, ratio("fenicsx-lagged", ours, k70), True),
        ("lagged Cholesky / ours, 220 k", 3, ratio("fenicsx-lagged", ours, k220), True),
        ("CalculiX / ours, 70 k", 8, best("calculix"), True),
        ("NGSolve / ours, 70 k", 12, best("ngsolve"), True),
        ("Kratos / ours, 70 k", 25, best("kratos"), True),
        ("tolerance 1e-12 / 1e-8", 1.6, ratio("ours-hybrid-default", ours, k70), False),
        ("hybrid / clamped", 1.1, ratio(ours, "ours-clamped", k70), False),
        ("one rank / two ranks, 70 k", 1.7, ratio(ours, "ours-hybrid-2", k70), True),
        ("one rank / two ranks, 300 k", 1.7, ratio(ours, "ours-hybrid-2", k300, "growth"), True),
        ("soft: refactorising / ours, 11 k", 1, ratio(refactored, ours, k11, "soft"), True),
        ("soft: full Newton + Cholesky / ours, 11 k", 2, ratio(cholesky, ours, k11, "soft"), True),
        ("soft: full Newton + Cholesky / ours, 70 k", 2, ratio(cholesky, ours, k70, "soft"), True),
    ]


def count_costs(results: Results) -> list[Goal]:
    """Goals for the parts of a step, growth, memory and small models."""
    turns = [r for r in results.records if r["part"] == "units"]
    step, residual, solve = (
        min((r[key] for r in turns), default=math.nan) for key in ("step", "residual", "solve")
    )
    units = step / (residual + solve)  # the least of each: noise in one would flatter the ratio
    rigid, exudyn = (results.least("small", c, "seconds") for c in ("rigid", "exudyn"))
    paper = results.least("small", "paper", "seconds")
    outside = results.least("small", "paper", "share_outside_kernels")
    large = [s for s in results.sizes("growth") if results.unknowns(s) > 270_000]
    memory = results.least("growth", "ours-hybrid", "memory", large[0]) if large else math.nan
    million = [s for s in results.sizes("soft") if results.unknowns(s) > 1e6]
    runs = [
        r for s in million for p in ("growth", "soft") for r in results.of(p, "ours-iterative", s)
    ]
    most = max((r["memory"] for r in runs), default=math.nan)
    krylov = max((sum(r["krylov"]) / sum(r["iterations"]) for r in runs), default=math.nan)
    return [
        ("step / (residual + solve)", 5, units, False),
        ("exponent of growth, factor", 1.15, exponent(results, "ours-hybrid"), False),
        ("exponent of growth, iterative", 1.15, exponent(results, "ours-iterative"), False),
        ("memory at 300 k [MB]", 4096, memory, False),
        ("memory at 1.2 M, stiff and soft [MB]", 24_576, most, False),
        ("Krylov iterations per iteration at 1.2 M", 40, krylov, False),
        ("the paper's case [s]", 5, paper, False),
        ("its share outside PETSc and DOLFINx", 0.5, outside, False),
        ("rigid turbine, 600 steps [s]", 0.5, rigid, False),
        ("rigid turbine, ours / Exudyn", 8, rigid / exudyn, False),
    ]


def exponent(results: Results, code: str) -> float:
    """Slope of log(time per step) over log(unknowns)."""
    pairs = [
        (results.unknowns(s), results.step("growth", code, s)) for s in results.sizes("growth")
    ]
    pairs = [p for p in pairs if not math.isnan(p[1])]
    if len(pairs) < 2:
        return math.nan
    n, t = np.log(pairs).T
    return float(np.polyfit(n, t, 1)[0])


def about(results: Results) -> list[str]:
    """Versions and BLAS of all, and what failed."""
    lines = ["## Versions", ""]
    seen = set()
    for r in results.records:
        if r["code"] not in seen and "versions" in r:
            seen.add(r["code"])
            versions = ", ".join(f"{k} {v}" for k, v in r["versions"].items())
            blas = f"; BLAS: {r['blas']}" if "blas" in r else ""
            lines.append(f"- {r['code']}: {versions}{blas}")
    for r in results.failures:
        lines.append(f"- **{r['code']} {r.get('size', '')} failed**: {r['error']}")
    return lines


if __name__ == "__main__":
    text, _ = report(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")))
    print(text)
