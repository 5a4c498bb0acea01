"""A run with reduced bodies, opened again: its case, its turbine and its stored motion."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from mpi4py import MPI

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records.conventions import MOTION
from turbine_fenicsx.records.motion_file import Motion, read_motion
from turbine_fenicsx.records.output_folder import need_folder
from turbine_fenicsx.simulation.observers.reduced_motion import describe_body
from turbine_fenicsx.system.reduced_model import ReducedModel
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run.resume import BASES, read_case

GAUGES = "output.gauges."
"""Keys that may change where gauges are recovered."""

WITHOUT = ("wind", "control", "event", "generator")
"""Tables that nothing recovered depends on."""


@dataclass(frozen=True, eq=False)
class RecordedRun:
    """A run whose motion is stored.

    Args:
        folder: Its output folder.
        turbine: Its turbine, without wind, control and damping.
        motion: Its motion.
    """

    folder: Path
    turbine: Turbine
    motion: Motion

    @classmethod
    def open(
        cls,
        folder: str | os.PathLike[str],
        comm: MPI.Intracomm,
        overrides: Sequence[str] = (),
        allowed: str = GAUGES,
    ) -> RecordedRun:
        """Read a run and build its turbine. Collective.

        Args:
            folder: Its output folder.
            comm: Communicator.
            overrides: Changes such as ``"output.gauges.flap.station=0.3"``.
            allowed: How the keys begin that may change.

        Raises:
            InputError: if there is no such run, or its files do not belong together.
        """
        path, case, motion = on_rank0(comm, lambda: _read(folder, overrides, allowed))
        run = cls(path, build_turbine(_leave_out(case), comm), motion)
        if other := run._find_other(motion):
            raise InputError(
                f"{str(path / MOTION)!r} does not belong to the {other} of {str(path)!r}: the "
                "functions, or numbers of copies, of their bases differ"
            )
        return run

    def read_another(
        self,
        folder: str | os.PathLike[str],
        overrides: Sequence[str] = (),
        allowed: str = GAUGES,
    ) -> tuple[Motion, Case]:
        """The motion and the whole case of any run of the same reduced bodies. Collective.

        Args:
            folder: Its output folder.
            overrides: As of `open`.
            allowed: As of `open`.

        Raises:
            InputError: if there is none, or its bodies are others.
        """
        comm = self.turbine.comm
        path, case, motion = on_rank0(comm, lambda: _read(folder, overrides, allowed))
        mine, its = self.turbine.case.turbine.file, case.turbine.file
        if mine != its:
            raise InputError(
                f"the runs {str(self.folder)!r} and {str(path)!r} are of different turbines: "
                f"turbine.file is {mine!r} and {its!r}"
            )
        if other := self._find_other(motion):
            raise InputError(
                f"the runs {str(self.folder)!r} and {str(path)!r} have different bases of the "
                f"{other}, or different meshes: expected runs that share them"
            )
        return motion, case

    def _find_other(self, motion: Motion) -> str:
        """Name of a reduced body that a motion is not of; empty for none."""
        bodies = motion.bodies
        names = (name for name, m in self.reduced.items() if describe_body(m) not in bodies)
        return next(names, "")

    @property
    def reduced(self) -> dict[str, ReducedModel]:
        """The reduced bodies by their names."""
        models = self.turbine.system.flexible_models
        return {m.body.name: m for m in models if isinstance(m, ReducedModel)}

    def list_states(self) -> Iterator[State]:
        """States of the rows of the motion, of which the next one changes those before. Collective.

        They have the displacements of reduced bodies alone.
        """
        system = self.turbine.system
        state = system.initial_state()
        vectors = {model: u for model, u in zip(system.flexible_models, state.u, strict=True)}
        for row, time in enumerate(self.motion.times):
            state.time = float(time)
            for name, model in self.reduced.items():
                z = self.motion.vectors[name][row].reshape(-1, 3)[: model.n_owned]
                vectors[model].array[:] = (z - model.positions).ravel()
            yield state


def _read(
    folder: str | os.PathLike[str], overrides: Sequence[str], allowed: str
) -> tuple[Path, Case, Motion]:
    """The case and the motion of a run, on this rank."""
    path = need_folder(folder)
    for override in overrides:
        if not override.strip().startswith(allowed):
            raise InputError(f"--set {override}: only {allowed}NAME can be set here")
    case = read_case(path, overrides)
    if not case.moves_by_vectors:
        raise InputError(
            f"no part of {str(path)!r} is reduced: its history.csv and fields.xdmf have what the "
            "blades have seen"
        )
    kept = {
        "blade": case.has_reduced_blades and not case.has_beam_blades,
        "tower": case.has_reduced_tower and not case.has_beam_tower,
    }
    for table, basis in BASES.items():
        if kept[table] and not (path / basis).exists():
            raise InputError(f"{str(path / basis)!r} is missing, which {MOTION} depends on")
    motion = read_motion(path / MOTION)
    if not len(motion.times):
        raise InputError(f"{str(path / MOTION)!r} holds no whole row")
    return path, case, motion


def _leave_out(case: Case) -> Case:
    """The case without what nothing recovered depends on."""
    tables: dict[str, object] = {name: type(getattr(case, name))() for name in WITHOUT}
    for name in BASES:
        table = getattr(case, name)
        none = type(table.damping)()
        if name == "blade":  # the viscosity of beams belongs to their basis
            none = none.model_copy(update={"mu": table.damping.mu})
        tables[name] = table.model_copy(update={"damping": none})
    return case.model_copy(update=tables)
