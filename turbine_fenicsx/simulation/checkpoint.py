"""Checkpoints: everything a run needs to resume, in one file that any number of ranks can read.

Nodal values lie in the order of the ranks that wrote them, with the initial positions of the nodes
beside them. The same ranks with the same partition take theirs back bit for bit; others find their
nodes by position. A file is written under another name and renamed when it is complete and on the
disk. So the last ones stay intact whenever the program ends; a checksum reveals those that were
damaged later.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np

from turbine_fenicsx._version import __version__
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import name_file_in_errors
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.checkpoint_file import (
    UnusableError,
    list_checkpoints,
    read_arrays,
    read_head,
    step_of,
    write_checkpoint,
)
from turbine_fenicsx.simulation.observer import Observer, SeriesObserver
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

log = logging.getLogger(__name__)

KEPT_CHECKPOINTS = 2
"""Number of checkpoints that are kept."""


def save_state(system: MultibodySystem, state: State) -> RestartData:
    """A state as named data; coupling forces become nodal values."""
    forces = []
    for block, coupling, force in zip(
        system.flexible_models, system.coupling_blocks, state.coupling, strict=True
    ):
        nodal = np.zeros((block.n_owned, 3))
        nodal[coupling.nodes] = force.array_r.reshape(-1, 3)
        forces.append(nodal)
    names = ("q", "q_dot", "joint_coordinates", "joint_rates", "multipliers")
    return RestartData(
        {"time": state.time},
        {name: getattr(state, name).copy() for name in names},
        {
            "u": tuple(u.array_r.reshape(-1, 3).copy() for u in state.u),
            "v": tuple(v.array_r.reshape(-1, 3).copy() for v in state.v),
            "coupling": tuple(forces),
        },
    )


def restore_state(system: MultibodySystem, data: RestartData) -> State:
    """The state that was saved; an InputError on all ranks if it is that of another system."""
    state = system.initial_state()
    state.time = data.numbers["time"]
    for name, values in data.arrays.items():
        mine = getattr(state, name)
        if mine.shape != values.shape:
            raise InputError(
                f"the checkpoint belongs to another system, with {values.size} {name} and not "
                f"{mine.size}"
            )
        mine[:] = values
    for name in ("u", "v"):
        for vector, values in zip(getattr(state, name), data.nodal.get(name, ()), strict=True):
            vector.array[:] = values.ravel()
    for coupling, force, values in zip(
        system.coupling_blocks, state.coupling, data.nodal.get("coupling", ()), strict=True
    ):
        force.array[:] = values[coupling.nodes].ravel()
    return state


class Checkpoints:
    """The checkpoints of a run in a folder, numbered by step; the last two are kept.

    Args:
        system: The system.
        folder: Folder for ``checkpoint_*.npz``.
        labels: What a resumed run must agree in, such as the hash of an input file, besides the
            version of turbine_fenicsx and the names of the parts.
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
        self._system, self._folder = system, Path(folder)
        self._labels = {
            "version of turbine_fenicsx": __version__,
            **(labels or {}),
            **{
                f"basis of {model.body.name!r}": model.meaning
                for model in system.flexible_models
                if model.meaning
            },
            "list of parts": _hash_parts(system),  # last, since it does not say what differs
        }
        self._every, self._every_wall = every or np.inf, every_wall or np.inf
        self._time = self._wall = 0.0
        self._written = -1

    def due(self, time: float, wall_time: float) -> bool:
        """Whether it is time for the next one; only rank 0's answer counts."""
        passed = np.floor(time / self._every + 1e-9) > np.floor(self._time / self._every + 1e-9)
        return bool(passed or wall_time - self._wall >= self._every_wall)

    def write(self, index: int, time: float, wall_time: float, data: RestartData) -> None:
        """Write a checkpoint unless that of this step exists. Collective.

        Raises:
            OSError: if it cannot be written, on all ranks; earlier ones are intact.
        """
        self._time, self._wall = time, wall_time
        if index == self._written:
            return
        comm = self._system.comm
        if self._written < 0:  # later on a missing folder was moved or deleted by somebody
            on_rank0(comm, self._make_folder)
        write_restart_data(
            self._folder / f"checkpoint_{index:08d}.npz", self._system, data, self._labels
        )
        self._written = index
        on_rank0(comm, lambda: self._remove(self._list_superseded(index)))

    def load(self, observers: Iterable[Observer] = ()) -> RestartData:
        """Read the newest intact checkpoint that the series of the observers reach. Collective.

        If they reach none, it is the newest intact one. A warning says what was passed over, and
        why.

        Args:
            observers: Those that will continue; a `SeriesObserver` among them is asked whether its
                files reach a checkpoint.

        Raises:
            InputError: if there is none that can be used, or it belongs to another system or mesh.
        """
        system, watching = self._system, tuple(observers)

        def read() -> tuple[dict[str, Any], dict[str, Array]]:
            path, head = self._choose(watching)
            return head, read_arrays(path)

        head, arrays = on_rank0(system.comm, read)
        data = RestartData(
            head["numbers"],
            {k.removeprefix("array."): v for k, v in arrays.items() if k.startswith("array.")},
        )
        order = [
            _find_order(arrays, k, block, system.comm, head["ranks"])
            for k, block in enumerate(system.flexible_models)
        ]
        names = {k.split(".", 1)[1].rsplit(".", 1)[0] for k in arrays if k.startswith("nodal.")}
        for name in sorted(names):
            data.nodal[name] = tuple(
                np.ascontiguousarray(arrays[f"nodal.{name}.{k}"][nodes])
                for k, nodes in enumerate(order)
            )
        return data

    def clear(self) -> None:
        """Remove the checkpoints of an earlier run. Collective."""
        on_rank0(self._system.comm, lambda: self._remove(list_checkpoints(self._folder)))

    def _choose(self, observers: Sequence[Observer]) -> tuple[Path, dict[str, Any]]:
        """The newest intact file that the series of a run reach, else the newest intact one."""
        files = list_checkpoints(self._folder)
        if not files:
            raise InputError(f"there is no checkpoint in {str(self._folder)!r}")
        reasons: list[str] = []
        spare: tuple[Path, dict[str, Any], list[str]] | None = None
        for path in files:
            try:
                head = read_head(path)
            except UnusableError as error:
                reasons.append(f"{path.name} {error}")
                continue
            self._check_labels(head["labels"])
            missing = _find_shortfalls(observers, RestartData(head["numbers"]))
            if not missing:
                for reason in reasons:
                    log.warning("resuming from %s: %s", path.name, reason)
                return path, head
            reasons += [f"{path.name} cannot be reached, {reason}" for reason in missing]
            spare = spare or (path, head, missing)
        if spare is None:
            what = "; ".join(reasons)
            raise InputError(f"no checkpoint in {str(self._folder)!r} can be used: {what}")
        path, head, missing = spare
        for reason in missing:
            log.warning("resuming from %s, but %s; the others are lost", path.name, reason)
        return path, head

    def _check_labels(self, found: Mapping[str, str]) -> None:
        """Refuse checkpoints of something else."""
        for name, mine in self._labels.items():
            if found.get(name) != mine:
                raise InputError(
                    f"cannot resume {str(self._folder)!r}: the {name} has changed, it was "
                    f"{found.get(name)} and is {mine}"
                )

    def _list_superseded(self, index: int) -> list[Path]:
        """Those of steps that the run has left behind, and all older than the last two."""
        files = list_checkpoints(self._folder)
        later = [path for path in files if step_of(path) > index]
        return later + files[len(later) + KEPT_CHECKPOINTS :]

    def _make_folder(self) -> None:
        """Make the folder."""
        with name_file_in_errors("write", self._folder):
            self._folder.mkdir(parents=True, exist_ok=True)

    def _remove(self, files: list[Path]) -> None:
        """Remove files, and what an earlier run left half written."""
        for old in (*files, *self._folder.glob("checkpoint_*.tmp")):
            with name_file_in_errors("write", old):
                old.unlink(missing_ok=True)


def write_restart_data(
    path: Path, system: MultibodySystem, data: RestartData, labels: Mapping[str, str]
) -> None:
    """Write one checkpoint. Collective."""
    comm = system.comm
    head = {"labels": dict(labels), "numbers": data.numbers, "ranks": comm.size}
    arrays: dict[str, Any] = {f"array.{name}": values for name, values in data.arrays.items()}
    for k, block in enumerate(system.flexible_models):
        sizes = comm.gather(block.n_owned)
        positions = _gather(comm, block.positions)
        if comm.rank == 0:
            arrays[f"sizes.{k}"], arrays[f"positions.{k}"] = np.array(sizes), positions
    for name, bodies in data.nodal.items():
        for k, values in enumerate(bodies):
            arrays[f"nodal.{name}.{k}"] = _gather(comm, values)

    on_rank0(comm, lambda: write_checkpoint(path, head, arrays))


def _hash_parts(system: MultibodySystem) -> str:
    """Hash of names of all parts, by which a checkpoint knows its system."""
    parts = [
        [body.name for body in system.rigid_bodies],
        [body.name for body in system.flexible_bodies],
        [(type(joint).__name__, joint.name) for joint in system.joints],
        [coupling.name for coupling in system.couplings],
        [*system.joint_coordinate_names],
        [*system.work_names],
        [force.name for force in system.motion_forces],
    ]
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:16]


def _find_shortfalls(observers: Sequence[Observer], data: RestartData) -> list[str]:
    """Missing parts of the series since a checkpoint was written, a clause for each."""
    found = []
    for observer in observers:
        if isinstance(observer, SeriesObserver) and (
            part := data.part(f"observer.{observer.name}")
        ):
            found.append(observer.find_shortfall(part, float(data.numbers["state.time"])))
    return [clause for clause in found if clause is not None]


def _find_order(data: dict[str, Array], k: int, block: Any, comm: MPI.Intracomm, ranks: int) -> Any:
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
    if fits and block.is_small:  # one rank owns all, in one order
        return slice(0, block.n_owned)
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
