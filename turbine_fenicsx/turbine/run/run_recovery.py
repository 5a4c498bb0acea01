"""All that can be recovered of a run, each part made when it is first needed."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import cached_property

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.ply_failure import CRITERIA
from turbine_fenicsx.turbine.run.chosen_rows import find_moments, find_rows
from turbine_fenicsx.turbine.run.full_motion import FullMotion
from turbine_fenicsx.turbine.run.ply_history import PlyHistory, PlyRecovery
from turbine_fenicsx.turbine.run.recorded_run import RecordedRun
from turbine_fenicsx.turbine.run.recovered_fields import FieldRecovery
from turbine_fenicsx.turbine.run.worst_moment import WorstMoment, find_worst_moment


class RunRecovery:
    """A run, its plies and its full meshes. Collective, also its methods.

    Args:
        run: The run.
        progress: Called with the part that is done of what is made, from 0 to 1.
    """

    def __init__(
        self, run: RecordedRun, progress: Callable[[float], None] = lambda part: None
    ) -> None:
        self.run, self.progress = run, progress
        self._histories: dict[str, PlyHistory] = {}

    @cached_property
    def plies(self) -> PlyRecovery:
        """The plies; an InputError for blades of one material."""
        return PlyRecovery(self.run)

    @cached_property
    def motion(self) -> FullMotion:
        """The motion on the full meshes."""
        return FullMotion(self.run)

    def find_history(self, criterion: str) -> PlyHistory:
        """The failure of all panels, see `PlyRecovery`."""
        if criterion not in self._histories:
            found = self.plies.find_history(criterion, self.progress)
            self._histories[criterion] = found
        return self._histories[criterion]

    def find_worst(self, criterion: str) -> WorstMoment:
        """The moment nearest to failure."""
        return find_worst_moment(self.plies, self.find_history(criterion))

    def find_rows(self, texts: Sequence[str]) -> list[int]:
        """Rows of the motion by texts, see `turbine_fenicsx.turbine.run.chosen_rows`."""

        def largest(criterion: str) -> tuple[Array, Array]:
            history = self.find_history(criterion)
            return history.times, history.index.max(axis=1)

        needed = [name for name in CRITERIA if any(f"({name})" in text for text in texts)]
        found = {name: largest(name) for name in needed}
        folder, times = self.run.folder, self.run.motion.times
        return on_rank0(
            self.run.turbine.comm, lambda: find_rows(times, find_moments(texts, folder, found))
        )

    def find_fields(self, wanted: Collection[str] | None) -> FieldRecovery:
        """Fields on the full meshes, see `FieldRecovery`."""
        return FieldRecovery(self.motion, wanted)
