"""Time per step and memory against unknowns, both axes logarithmic.

``plot.py RESULTS_JSON PICTURE`` draws again.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from report import Results


def plot(data: dict[str, Any], path: Path) -> None:
    """Draw all codes that ran, ours with a thick line."""
    results = Results(data["records"])
    sizes = results.sizes("growth")
    codes = dict.fromkeys(
        c for s in sizes for p in ("compare", "growth") for c in results.codes(p, s)
    )
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.8), sharex=True)
    for k, code in enumerate(codes):
        rows = [
            (
                results.unknowns(s),
                results.step("growth", code, s),
                results.least("growth", code, "memory", s),
            )
            for s in sizes
            if results.of("growth", code, s)
        ]
        n, step, memory = zip(*rows, strict=True)
        width = 3.0 if code == "ours-hybrid" else 1.2
        marker = "os^DvP"[k // 10 % 6]  # a new one where the ten colours begin again
        how = {"marker": marker, "linewidth": width, "markersize": 5}
        left.loglog(n, step, label=code, **how)
        right.loglog(n, memory, **how)
    left.set_ylabel("time per step [s]")
    right.set_ylabel("memory [MB]")
    for axes in (left, right):
        axes.set_xlabel("unknowns")
        axes.grid(True, which="both", alpha=0.3)
    figure.legend(loc="center right", fontsize="small")
    figure.tight_layout(rect=(0.0, 0.0, 0.82, 1.0))
    figure.savefig(path, dpi=120)
    plt.close(figure)


if __name__ == "__main__":
    plot(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")), Path(sys.argv[2]))
