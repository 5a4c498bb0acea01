"""Checkpoints: everything a run must remember, in one file that any number of ranks can read.

Nodal values lie in the order of the ranks that wrote them, with the initial positions of the nodes
beside them. The same ranks with the same partition take theirs back bit for bit; others find their
nodes by position. A file is written under another name and renamed when it is complete and on the
disk, so that the end of the program at any moment leaves the last ones intact.
"""

from __future__ import annotations

import io
import json
import os
import zipfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.errors import InputError
from turbine_fenicsx.memory import Memory
from turbine_fenicsx.parallel import on_rank0
from turbine_fenicsx.rotations import Array
from turbine_fenicsx.state import State
from turbine_fenicsx.system import MultibodySystem

KEPT = 2
"""Number of checkpoints that are kept."""


def remember_state(system: MultibodySystem, state: State) -> Memory:
    """A state as named data; coupling forces become nodal values."""
    forces = []
    for block, coupling, force in zip(
        system.flexible_blocks, system.coupling_blocks, state.coupling, strict=True
    ):
        nodal = np.zeros((block.n_owned, 3))
        nodal[coupling.nodes] = force.array_r.reshape(-1, 3)
        forces.append(nodal)
    names = ("q", "q_dot", "angles", "angle_rates", "multipliers")
    return Memory(
        {"time": state.time},
        {name: getattr(state, name).copy() for name in names},
        {
            "u": tuple(u.array_r.reshape(-1, 3).copy() for u in state.u),
            "v": tuple(v.array_r.reshape(-1, 3).copy() for v in state.v),
            "coupling": tuple(forces),
        },
    )


def recall_state(system: MultibodySystem, memory: Memory) -> State:
    """The state that was remembered."""
    state = system.initial_state()
    state.time = memory.numbers["time"]
    for name, values in memory.arrays.items():
        getattr(state, name)[:] = values
    for name in ("u", "v"):
        for vector, values in zip(getattr(state, name), memory.nodal.get(name, ()), strict=True):
            vector.array[:] = values.ravel()
    for coupling, force, values in zip(
        system.coupling_blocks, state.coupling, memory.nodal.get("coupling", ()), strict=True
    ):
        force.array[:] = values[coupling.nodes].ravel()
    return state


class Checkpoints:
    """The checkpoints of a run in a folder, numbered by step; the last two are kept.

    Args:
        system: The system.
        folder: Folder for ``checkpoint_*.npz``.
        labels: What a restarted run must agree in, for example versions and hashes.
        every: Simulated time between two checkpoints [s]; 0 for none.
        every_wall: Wall time between two checkpoints [s]; 0 for none.
    """

    def __init__(
        self,
        system: MultibodySystem,
        folder: str | os.PathLike[str],
        labels: Mapping[str, str] | None = None,
        every: float = 0.0,
        every_wall: float = 0.0,
    ) -> None:
        """Nothing is written yet."""
        self._system, self._folder, self._labels = system, Path(folder), dict(labels or {})
        self._every, self._every_wall = every or np.inf, every_wall or np.inf
        self._time = self._wall = 0.0
        self._written = -1

    def due(self, time: float, wall_time: float) -> bool:
        """Whether it is time for the next one; only rank 0's answer counts."""
        passed = np.floor(time / self._every + 1e-9) > np.floor(self._time / self._every + 1e-9)
        return bool(passed or wall_time - self._wall >= self._every_wall)

    def write(self, index: int, time: float, wall_time: float, memory: Memory) -> None:
        """Write a checkpoint unless that of this step exists. Collective.

        Raises:
            OSError: if it cannot be written, on all ranks; earlier ones are intact.
        """
        self._time, self._wall = time, wall_time
        if index == self._written:
            return
        save(self._folder / f"checkpoint_{index:08d}.npz", self._system, memory, self._labels)
        self._written = index
        on_rank0(self._system.comm, lambda: self._remove(found(self._folder)[KEPT:]))

    def clear(self) -> None:
        """Remove the checkpoints of an earlier run. Collective."""
        on_rank0(self._system.comm, lambda: self._remove(found(self._folder)))

    def _remove(self, files: list[Path]) -> None:
        """Remove files, and what an earlier run left half written."""
        for old in (*files, *self._folder.glob("checkpoint_*.tmp")):
            old.unlink(missing_ok=True)


def found(folder: str | os.PathLike[str]) -> list[Path]:
    """The checkpoints in a folder, newest first."""
    return sorted(Path(folder).glob("checkpoint_*.npz"), reverse=True)


def save(path: Path, system: MultibodySystem, memory: Memory, labels: Mapping[str, str]) -> None:
    """Write one checkpoint. Collective.

    Raises:
        OSError: if it cannot be written, on all ranks.
    """
    comm = system.comm
    head = {"labels": dict(labels), "numbers": memory.numbers, "ranks": comm.size}
    data: dict[str, Any] = {f"array.{name}": values for name, values in memory.arrays.items()}
    for k, block in enumerate(system.flexible_blocks):
        sizes = comm.gather(block.n_owned)
        positions = _gather(comm, block.positions)
        if comm.rank == 0:
            data[f"sizes.{k}"], data[f"positions.{k}"] = np.array(sizes), positions
    for name, bodies in memory.nodal.items():
        for k, values in enumerate(bodies):
            data[f"nodal.{name}.{k}"] = _gather(comm, values)

    def write() -> None:
        temporary = path.with_suffix(".tmp")
        content = io.BytesIO()  # a zip file that cannot be completed complains when it is deleted
        np.savez(content, head=np.array(json.dumps(head)), **data)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with temporary.open("wb") as file:
                file.write(content.getbuffer())
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        except OSError as error:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
            raise OSError(error.errno, f"cannot write {path}: {error.strerror}") from None

    on_rank0(comm, write)


def load_newest(
    folder: str | os.PathLike[str], system: MultibodySystem, check: Callable[[dict[str, str]], None]
) -> Memory:
    """Read the newest complete checkpoint of a folder. Collective.

    Args:
        folder: The folder.
        system: The system, on any number of ranks.
        check: Called with the labels; raises an `InputError` if they do not fit.

    Raises:
        InputError: if there is none that can be read, or it belongs to another mesh.
    """
    comm = system.comm
    head, data = on_rank0(comm, lambda: _read_newest(folder, check))
    memory = Memory(
        head["numbers"],
        {k.removeprefix("array."): v for k, v in data.items() if k.startswith("array.")},
    )
    order = [_order(data, k, block, comm, head["ranks"]) for k, block in _enumerated(system)]
    names = {k.split(".", 1)[1].rsplit(".", 1)[0] for k in data if k.startswith("nodal.")}
    for name in sorted(names):
        memory.nodal[name] = tuple(
            np.ascontiguousarray(data[f"nodal.{name}.{k}"][nodes]) for k, nodes in enumerate(order)
        )
    return memory


def _enumerated(system: MultibodySystem) -> list[tuple[int, Any]]:
    """The flexible blocks with their numbers."""
    return list(enumerate(system.flexible_blocks))


def _read_newest(
    folder: str | os.PathLike[str], check: Callable[[dict[str, str]], None]
) -> tuple[dict[str, Any], dict[str, Array]]:
    """Head and arrays of the newest file that is complete."""
    files = found(folder)
    if not files:
        raise InputError(f"there is no checkpoint in {os.fspath(folder)!r}")
    for path in files:
        try:
            with np.load(path, allow_pickle=False) as file:
                data = {name: file[name] for name in file.files}
            head = json.loads(str(data.pop("head")))
            labels = head["labels"]
        except (OSError, EOFError, ValueError, KeyError, zipfile.BadZipFile):
            continue  # not complete; the one before is
        check(labels)
        return head, data
    raise InputError(f"no checkpoint in {os.fspath(folder)!r} can be read")


def _order(data: dict[str, Array], k: int, block: Any, comm: MPI.Intracomm, ranks: int) -> Any:
    """Which stored nodes are this rank's: a slice if nothing has changed, else by position."""
    nothing = np.zeros(0)
    sizes, X = data.get(f"sizes.{k}", nothing), data.get(f"positions.{k}", nothing)
    fits = len(X) == comm.allreduce(block.n_owned)
    same = False
    mine: Any = slice(0, 0)
    if fits and ranks == comm.size:
        start = int(np.sum(sizes[: comm.rank]))
        mine = slice(start, start + int(sizes[comm.rank]))
        same = np.array_equal(X[mine], block.positions)
    if comm.allreduce(same, op=MPI.LAND):
        return mine
    far = 0.0
    if fits:
        from scipy.spatial import cKDTree

        distance, mine = cKDTree(X).query(block.positions)
        far = float(np.max(distance, initial=0.0)) / max(1.0, float(np.max(np.abs(X))))
    if not fits or comm.allreduce(far, op=MPI.MAX) > 1e-9:
        raise InputError(f"the checkpoint belongs to another mesh of {block.body.name!r}")
    return mine


def _gather(comm: MPI.Intracomm, values: Array) -> Array:
    """Rows of all ranks on rank 0, shape (n, 3); nothing on the others."""
    values = np.ascontiguousarray(values, dtype=float)
    sizes = comm.gather(values.size)
    if comm.rank:
        comm.Gatherv(values, None)
        return np.zeros((0, 3))
    whole = np.empty(sum(sizes or ()))
    comm.Gatherv(values, (whole, sizes))
    return whole.reshape(-1, 3)
