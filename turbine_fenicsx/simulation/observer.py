"""Interface of observers of a run: time series, fields, progress, or a user's class."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any, Protocol, runtime_checkable

from turbine_fenicsx.foundation.argument_checks import check_methods
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.simulation.snapshot import Snapshot


class Observer(Protocol):
    """Watches a run. All methods are called on all ranks.

    An observer that must know after a restart what it knew before is a `RestartableObserver`.
    """

    def start(self, snapshot: Snapshot, resumed: bool) -> None:
        """Begin: open files, look at the first state.

        Args:
            snapshot: The state at t = 0, or the one that the run resumes from.
            resumed: Whether the run continues, so that an earlier run has observed this state.
        """

    def observe(self, snapshot: Snapshot) -> None:
        """Look at the state after an accepted step.

        Args:
            snapshot: The state, valid until this method returns.
        """

    def finish(self) -> None:
        """The run has ended, normally or not; called if `start` has returned."""


@runtime_checkable
class RestartableObserver(Observer, Protocol):
    """An observer whose data checkpoints hold.

    On restart, `restore` is called before `start`, unless the checkpoint comes from a run without
    this observer.

    Attributes:
        name: Under which checkpoints know it; no two observers of a run have the same.
    """

    name: str

    def save(self) -> RestartData:
        """State of the observer, for a checkpoint.

        Its output must be on the disk when this returns, because the checkpoint counts from then
        on.

        Raises:
            OSError: if something is not on the disk, on all ranks.
        """

    def restore(self, data: RestartData) -> None:
        """Take back what `save` has returned in an earlier run."""


@runtime_checkable
class SeriesObserver(RestartableObserver, Protocol):
    """An observer whose files grow during a run and may have lost their end since."""

    def find_shortfall(self, data: RestartData, time: float) -> str | None:
        """Missing parts of the files since the data were saved. Called on rank 0 only.

        Args:
            data: What `save` has returned for a checkpoint.
            time: That of the checkpoint [s].

        Returns:
            A clause, such as "history.csv holds 3 of its 5 rows up to t = 1 s"; None if the files
            reach the checkpoint.
        """


def describe_shortfall(name: str, there: int, needed: int, what: str, time: float) -> str | None:
    """The clause of `SeriesObserver.find_shortfall`, None if there is enough.

    Args:
        there: How many rows, or times, it holds up to the time.
        needed: How many it held when the checkpoint was written.
        time: Time of the checkpoint [s].
    """
    if there >= needed:
        return None
    return f"{name} holds {there} of its {needed} {what} up to t = {time:g} s"


def check_observers(observers: Iterable[Any]) -> None:
    """Check that observers have what they need."""
    names = []
    for observer in observers:
        check_methods("an observer", observer, ("start", "observe", "finish"))
        if isinstance(observer, RestartableObserver):
            names.append(observer.name)
        elif hasattr(observer, "save") or hasattr(observer, "restore"):
            raise TypeError(
                "an observer that survives a restart needs a name, save() and restore(), but "
                f"{observer!r} lacks one of them"
            )
    for name, count in Counter(names).items():
        if count > 1:
            raise ModelError(f"{count} observers are called {name!r}, so checkpoints mix them up")
