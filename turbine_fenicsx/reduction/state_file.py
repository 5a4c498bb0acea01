"""Finished load paths in a file, so that an interrupt loses none of them."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from typing import NamedTuple

from mpi4py import MPI

import numpy as np
from scipy.spatial import cKDTree

from turbine_fenicsx.bodies.reduced_body import SAME_PLACE
from turbine_fenicsx.foundation.array_file import read_arrays, write_arrays
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.reduction.load_path import LoadPath

log = logging.getLogger(__name__)

Lack = Callable[[float, Array], float]
"""Forces that a body lacks for equilibrium at a time with displacements, as a part of the loads."""

MARGIN = 2.0
"""How much more a state may lack when it is read than when it was stored."""

FLOOR = 1e-6
"""Part of the loads that it may lack in any case."""


class PathStates(NamedTuple):
    """Equilibria along a path.

    Attributes:
        name: Name of the path.
        times: Times of the equilibria, shape (states,) [s].
        displacements: Of all nodes in the order of their numbers, shape (states, N, 3) [m].
        given_up: Whether the path ends before its last time.
    """

    name: str
    times: Array
    displacements: Array
    given_up: bool


class StateFile:
    """A file of equilibria. Collective, like all methods.

    States of a file are used if they are equilibria of the path of the same name, whatever has
    changed since in law or loads.

    Args:
        comm: Communicator.
        path: The file; None for none.
        positions: X of all nodes in the order of their numbers, shape (N, 3) [m].

    Raises:
        InputError: for a file of something else, or another mesh.
        FileError: if it cannot be read or written.
    """

    def __init__(
        self, comm: MPI.Intracomm, path: str | os.PathLike[str] | None, positions: Array
    ) -> None:
        self._comm, self._path, self._positions = comm, path, positions
        self._stored: dict[str, dict[str, Array]] = {}
        if path is not None:
            self._stored = on_rank0(comm, self._read)
            on_rank0(comm, self._write)  # a folder that takes no file is heard of before the work

    def _read(self) -> dict[str, dict[str, Array]]:
        """Arrays of each path, nodes in the order of this mesh."""
        assert self._path is not None
        if not os.path.exists(self._path):
            return {}
        arrays = read_arrays(self._path, "a file of equilibria")
        X, points = self._positions, arrays.pop("points", np.zeros((0, 3)))
        distance, order = np.inf, np.arange(0)
        if points.shape == X.shape and np.all(np.isfinite(points)):
            distance, order = cKDTree(points).query(X)
        if np.max(distance) > SAME_PLACE * np.max(np.ptp(X, axis=0)):
            raise InputError(
                f"{os.fspath(self._path)!r} has equilibria of another mesh: give another file"
            )
        stored: dict[str, dict[str, Array]] = {}
        for name, values in arrays.items():
            path, _, what = name.rpartition(" ")
            stored.setdefault(path, {})[what] = values
        return {p: s for p, s in stored.items() if _take(s, order, X.shape)}

    def find(self, path: LoadPath, find_lack: Lack) -> PathStates | None:
        """The states of a path if they are stored and equilibria of it."""
        stored = self._stored.get(path.name)
        if stored is None or not np.array_equal(stored["wanted"], path.times):
            return None
        times, u = stored["times"], stored["displacements"]
        for time, displacements, lack in zip(times, u, stored["lacks"], strict=True):
            if not find_lack(float(time), displacements) <= MARGIN * lack + FLOOR:
                log.info("stored equilibria of %r are none of this body", path.name)
                return None
        given_up = not len(times) or bool(times[-1] < path.times[-1])
        return PathStates(path.name, times, u, given_up)

    def add(self, path: LoadPath, states: PathStates, find_lack: Lack) -> None:
        """Store the states of a path."""
        if self._path is None:
            return
        lacks = [find_lack(float(t), u) for t, u in zip(*states[1:3], strict=True)]
        self._stored[path.name] = {
            "wanted": np.asarray(path.times, dtype=float),
            "times": states.times,
            "displacements": states.displacements,
            "lacks": np.array(lacks),
        }
        on_rank0(self._comm, self._write)

    def _write(self) -> None:
        """Write all paths."""
        assert self._path is not None
        arrays = {
            f"{path} {what}": values
            for path, stored in self._stored.items()
            for what, values in stored.items()
        }
        write_arrays(self._path, {"points": self._positions, **arrays})


def _take(stored: dict[str, Array], order: IntArray, shape: tuple[int, ...]) -> bool:
    """Put the nodes of stored states in order; whether they are states at all."""
    if not {"wanted", "times", "displacements", "lacks"} <= set(stored):
        return False
    times, u = stored["times"], stored["displacements"]
    if times.ndim != 1 or u.shape != (len(times), *shape) or stored["lacks"].shape != times.shape:
        return False
    if not all(x.dtype.kind == "f" and np.all(np.isfinite(x)) for x in stored.values()):
        return False
    stored["displacements"] = u[:, order]
    return True
