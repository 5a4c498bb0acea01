"""Strong and weak scaling to 10 000 ranks on paper, from the counts of `ranks.py`.

``scaling_model.py [COUNTS PICTURE]`` reads ``ranks.json`` beside it and draws
``docs/images/scaling_model.png``. What is counted: iterations, messages, collective operations and
their bytes. What is stated: `Machine` and the costs of an unknown. What is computed: how large the
interfaces of slabs of three slender blades are, a x a x 12 a hexahedra each.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from math import ceil, log2
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from turbine_fenicsx.linear_solvers.sections import CELLS, LEAST, MOST
from turbine_fenicsx.linear_solvers.shared import SLAB
from turbine_fenicsx.linear_solvers.substructures import MAX_INTERFACE_RATIO, WIDEST
from turbine_fenicsx.meshing.load import THINNEST

HERE = Path(__file__).parent
RANKS = [2**k for k in range(15) if 2**k <= 10_000] + [10_000]
STRONG = {"1.2 million unknowns": 1.2e6, "20 million": 20e6}
WEAK = 20_000
"""Unknowns of a rank."""


@dataclass(frozen=True)
class Machine:
    """A cluster whose cores are all busy."""

    latency: float = 1.5e-6  # of a message [s]
    network: float = 10e9  # of a rank [B/s]
    memory: float = 10e9  # of a core [B/s]
    residual: float = 0.06e-6  # of an unknown [s]
    frames: float = 0.12e-6  # of an unknown, with Broyden's formula, in a Newton iteration [s]
    cg: float = 0.7e-6  # of an unknown, in one iteration with its smoother [s]
    python: float = 1e-3  # of a Newton iteration, with the rigid bodies on rank 0 [s]
    factor: float = 1.1  # entries of the factor in a row, over the unknowns of a section


class Counts:
    """What one solver does in a Newton iteration, from the runs on several ranks.

    Args:
        runs: What `ranks.py` wrote.
        solver: "frozen" or "iterative".
        most: Runs on more ranks are left out.
    """

    def __init__(self, runs: list[dict], solver: str, most: int) -> None:
        chosen = [r for r in runs if r["solver"] == solver and 1 < r["ranks"] <= most]
        each = [self._count(run) for run in chosen]
        self.ranks = np.array([run["ranks"] for run in chosen])
        self.newton, self.cg, self.messages, self.collectives, self.sent = np.transpose(each)

    @staticmethod
    def _count(run: dict) -> list[float]:
        """Newton iterations of a step; of each of them: CG, messages, collectives, halos sent."""
        newton = float(np.mean(run["iterations"][2:]))
        of = {name: max(values) for name, values in run["of_rank"].items()}
        halos = of["message_bytes"] / (8.0 * of["ghosts"])
        counted = (np.mean(run["krylov"][2:]), of["messages"], of["collectives"], halos)
        return [newton, *(float(value) / newton for value in counted)]


@dataclass(frozen=True)
class Slabs:
    """Three blades in slabs: a rank has the same one of each, or, where these are thin, its own.

    Args:
        unknowns: Of all blades.
        ranks: Number of ranks.
    """

    unknowns: float
    ranks: int

    @property
    def across(self) -> float:
        """Hexahedra across a section."""
        return (self.unknowns / 108.0) ** (1.0 / 3.0)

    @property
    def section(self) -> float:
        """Unknowns of a section."""
        return 3.0 * (self.across + 1.0) ** 2

    @property
    def own(self) -> float:
        """Unknowns of a rank."""
        return self.unknowns / self.ranks

    @property
    def parts(self) -> int:
        """Congruent parts of a rank, as `meshing.parts` cuts them."""
        return 3 if 12.0 * self.across / self.ranks >= max(THINNEST, self.ranks) else 1

    @property
    def met(self) -> float:
        """Unknowns of S around a part: a section at each end, but for the ends of the blades."""
        return min(2, self.ranks - 1) * self.section

    @property
    def ghosts(self) -> float:
        """Unknowns that a rank gets from others: sections, or around a compact part."""
        compact = 6.0 * 3.0 * (self.own / 3.0) ** (2.0 / 3.0)
        return min(self.parts * self.met, compact)

    @property
    def interface(self) -> float:
        """Unknowns S where ranks meet."""
        sections = 3 * (self.ranks - 1) if self.parts == 3 else max(1, self.ranks - 3)
        return sections * self.section

    @property
    def has_factors(self) -> bool:
        """Whether each rank keeps a factor of its own, as `Substructures.pays_off`."""
        wide = self.met**2 > WIDEST * self.own
        return self.ranks == 1 or not (wide or self.interface > MAX_INTERFACE_RATIO * self.own)


def frozen_step(at: Slabs, counts: Counts, machine: Machine) -> dict[str, float]:
    """Seconds of a step with one factor for a whole run, by what takes them."""
    b = at.section
    several = at.ranks > 1
    entries = machine.factor * b * at.own / at.parts  # one for all parts, as what follows
    near = 4.0 * at.met * min(SLAB * at.met, at.own / at.parts)  # single precision
    common = 8.0 * 2.0 * 1.5 * b * at.interface if several else 0.0
    stages = ceil(log2(at.ranks)) if several else 0
    sends = np.max(counts.messages) * machine.latency if several else 0.0
    halos = np.max(counts.sent) * 8.0 * at.ghosts / machine.network
    of_S = 2.0 * 8.0 * at.interface / machine.network if several else 0.0
    each = {
        "residual and frames": (machine.residual + machine.frames) * at.own,
        "factor": (16.0 * entries + near) / machine.memory,
        "where ranks meet": common / machine.memory + of_S,
        "messages": sends + halos,
        "collectives": np.mean(counts.collectives) * machine.latency * stages,
        "Python": machine.python,
    }
    return {name: float(np.mean(counts.newton) * value) for name, value in each.items()}


def iterative_step(at: Slabs, counts: Counts, machine: Machine) -> dict[str, float]:
    """Seconds of a step with conjugate gradients, by what takes them."""
    several = at.ranks > 1
    stages = log2(at.ranks)
    degree = min(max(ceil(at.across / CELLS), LEAST), MOST)
    # ranks do not change the iterations; cells beyond what the degrees follow do, in proportion
    cg = np.mean(counts.cg) * max(1.0, at.across / (CELLS * degree))
    per_cg = 1.0 / np.mean(counts.cg)
    polynomials = 1.5 * (degree + 1) * (degree + 2)
    coarse = polynomials * 36.0 * at.across  # sections stay one element apart
    sends = np.max(counts.messages) * per_cg * machine.latency if several else 0.0
    halos = np.max(counts.sent) * per_cg * 8.0 * at.ghosts / machine.network
    gathered = 8.0 * coarse / machine.network if several else 0.0
    calls = np.mean(counts.collectives) * per_cg * machine.latency * ceil(stages)
    each = {
        "residual and frames": (machine.residual + machine.frames) * at.own,
        "CG and smoother": cg * machine.cg * at.own,
        "coarse solve": cg * 16.0 * 1.5 * polynomials * coarse / machine.memory,
        "messages": cg * (sends + halos),
        "collectives": cg * (calls + gathered),
        "Python": machine.python,
    }
    return {name: float(np.mean(counts.newton) * value) for name, value in each.items()}


def find_largest(parts: dict[str, float]) -> str:
    """What takes most of a step."""
    return max(parts, key=lambda name: parts[name])


def draw(runs: list[dict], picture: Path) -> str:
    """Draw both kinds of scaling; returns lines on what limits each."""
    machine = Machine()
    models = {
        "frozen": (frozen_step, Counts(runs, "frozen", 16)),
        "iterative": (iterative_step, Counts(runs, "iterative", 16)),
    }
    figure, (strong, weak) = plt.subplots(1, 2, figsize=(11, 4.6))
    lines = []
    for k, (solver, (step, counts)) in enumerate(models.items()):
        for (words, unknowns), style in zip(STRONG.items(), ("--", "-"), strict=True):
            found = []
            for ranks in RANKS:
                at = Slabs(unknowns, ranks)
                if solver == "frozen" and not at.has_factors:
                    break
                found.append(step(at, counts, machine))
            seconds = np.array([sum(parts.values()) for parts in found])
            label = f'"{solver}", {words}'
            strong.loglog(RANKS[: len(seconds)], seconds, style, color=f"C{k}", label=label)
            strong.plot(RANKS[len(seconds) - 1], seconds[-1], "o", color=f"C{k}")
            if solver == "iterative":
                ideal = seconds[0] / np.array(RANKS)
                strong.plot(RANKS, ideal, style, color="0.8", zorder=0)
            best = int(np.argmin(seconds))
            lines.append(
                f"{label}: {seconds[0]:.2g} s on one rank, {seconds[best]:.2g} s on {RANKS[best]}, "
                f"where most is {find_largest(found[best])}"
            )
        found = []
        for ranks in RANKS:
            at = Slabs(WEAK * ranks, ranks)
            if solver == "frozen" and not at.has_factors:
                break
            found.append(step(at, counts, machine))
        seconds = np.array([sum(parts.values()) for parts in found])
        weak.loglog(RANKS[: len(seconds)], seconds, color=f"C{k}", label=f'"{solver}"')
        weak.plot(RANKS[len(seconds) - 1], seconds[-1], "o", color=f"C{k}")
        lines.append(
            f'"{solver}", {WEAK} unknowns on each rank: {seconds[0]:.2g} s on one, '
            f"{seconds[-1]:.2g} s on {RANKS[len(seconds) - 1]}, there {find_largest(found[-1])}"
        )
    strong.plot([], [], color="0.8", label="ideal")
    strong.set_title("one problem on more ranks")
    strong.set_ylim(bottom=1e-2)
    weak.set_title(f"{WEAK:,} unknowns on each rank".replace(",", " "))
    for axes in (strong, weak):
        axes.set_xlabel("ranks")
        axes.set_ylabel("time per step [s]")
        axes.grid(True, which="major", alpha=0.3)
        axes.legend(fontsize="small")
    figure.tight_layout()
    figure.savefig(picture, dpi=110)
    plt.close(figure)
    return "\n".join(lines)


def main() -> None:
    given = [Path(word) for word in sys.argv[1:]]
    counts, picture = given or (
        HERE / "ranks.json",
        HERE.parent / "docs/images/scaling_model.png",
    )
    print(draw(json.loads(counts.read_text(encoding="utf-8")), picture))


if __name__ == "__main__":
    main()
