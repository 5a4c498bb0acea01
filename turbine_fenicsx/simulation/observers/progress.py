"""Progress on rank 0: a bar on a terminal, else one line every few seconds."""

from __future__ import annotations

import sys
import time
from typing import Any

from mpi4py import MPI

from turbine_fenicsx.simulation.snapshot import Snapshot


class Progress:
    """Shows simulated time, energy error, iterations and time left on stderr.

    Args:
        end: End time of the run [s].
        style: "bar", "log", "none", or "auto": a bar if stderr is a terminal and there is one
            rank, else lines.
    """

    def __init__(
        self, comm: MPI.Intracomm, end: float, style: str = "auto", every: float = 10.0
    ) -> None:
        if style == "auto":
            style = "bar" if sys.stderr.isatty() and comm.size == 1 else "log"
        self._style = style if comm.rank == 0 else "none"
        self._end, self._every = end, every
        self._last = time.perf_counter()
        self._bar: Any = None

    def start(self, snapshot: Snapshot, resumed: bool) -> None:
        """Draw the bar."""
        self.observe(snapshot)

    def observe(self, snapshot: Snapshot) -> None:
        """Move the bar, or print a line if it is time to."""
        t = snapshot.state.time
        newton = snapshot.report.newton_iterations if snapshot.report else 0
        if self._style == "bar":
            if self._bar is None:
                from tqdm import tqdm

                layout = (
                    "{percentage:3.0f}%|{bar}| {n:.2f}/{total:.2f} s, {remaining} left{postfix}"
                )
                self._bar = tqdm(total=self._end, bar_format=layout, file=sys.stderr)
            self._bar.set_postfix_str(f"dH {snapshot.energy_error:.1e} J, Newton {newton}", False)
            self._bar.update(t - self._bar.n)
        elif self._style == "log" and time.perf_counter() - self._last > self._every:
            self._last = time.perf_counter()
            left = snapshot.wall_time * (self._end - t) / t if t > 0.0 else 0.0
            print(
                f"t = {t:.3f}/{self._end:g} s, step {snapshot.index}, Newton {newton}, "
                f"energy error {snapshot.energy_error:.1e} J, {left:.0f} s left",
                file=sys.stderr,
                flush=True,
            )

    def finish(self) -> None:
        """Close the bar."""
        if self._bar is not None:
            self._bar.close()
