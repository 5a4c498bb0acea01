"""Progress of a study on stderr: a bar on a terminal, else a line for each run."""

from __future__ import annotations

import sys

from tqdm import tqdm

from turbine_fenicsx.study.execute import Outcome


class StudyProgress:
    """Shows how many runs are done; failures are always said immediately.

    Args:
        total: Number of runs.
        style: "bar", "log", "none", or "auto": a bar if stderr is a terminal.
    """

    def __init__(self, total: int, style: str = "auto") -> None:
        if style == "auto":
            style = "bar" if sys.stderr.isatty() else "log"
        self._style, self._total, self._done = style, total, 0
        self._bar: tqdm | None = tqdm(total=total, unit="run") if style == "bar" else None

    def show(self, outcome: Outcome) -> None:
        """Show the outcome of a run."""
        self._done += 1
        if outcome.reason:
            said = f"failed: {outcome.reason}"
        elif outcome.seconds is None:
            said = "was finished before"
        else:
            said = f"finished in {outcome.seconds:.1f} s"
        line = f"{self._done}/{self._total} {outcome.run.name}: {said}"
        if self._bar is not None:
            self._bar.update()
            if outcome.reason:
                self._bar.write(line, file=sys.stderr)
        elif self._style == "log":
            print(line, file=sys.stderr, flush=True)

    def finish(self) -> None:
        """Close the bar."""
        if self._bar is not None:
            self._bar.close()
