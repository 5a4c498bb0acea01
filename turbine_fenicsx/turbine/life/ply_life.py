"""Damage of the plies over the life of a turbine, from its runs.

With the damage D_r of the runs, which happen w_r times in a life of L years, Miner's sum and the
life of a ply are

    D = sum_r w_r D_r,    L/D.

D^(1/m) is the fatigue index: loads that are larger by one over it use up the life, as far as means
do not count.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.ply_damage import PlyDamage
from turbine_fenicsx.materials.ply_fatigue import PlyFatigue
from turbine_fenicsx.turbine.case.ply_fatigue import find_adhesive, find_fatigue_of_file
from turbine_fenicsx.turbine.life.bond_histories import BondHistories
from turbine_fenicsx.turbine.life.damage_sum import DamageSum
from turbine_fenicsx.turbine.life.run_damage import FEWEST, Histories, PlyHistories, RunDamage
from turbine_fenicsx.turbine.life.weighted_run import WeightedRun
from turbine_fenicsx.turbine.run.ply_history import PlyRecovery
from turbine_fenicsx.turbine.run.recorded_run import RecordedRun

NEGLIGIBLE = 1e-6
"""Histories are left out that together do less damage than this in the life."""


@dataclass(frozen=True, eq=False)
class PlyLife:
    """Damage of all plies over the life; arrays are of those that this rank owns.

    Args:
        recovery: The plies.
        materials: How their materials fail, by name.
        notes: Sentences on materials that do not count, and on usual slopes.
        years: The life.
        runs: The runs by the names of their folders.
        plies: Damage of plies at their outer and inner faces.
        bond_histories: The bonds, if the case has an adhesive.
        bonds: Damage of these at both sides.
    """

    recovery: PlyRecovery
    materials: dict[str, PlyFatigue]
    notes: tuple[str, ...]
    years: float
    runs: tuple[WeightedRun, ...]
    plies: DamageSum
    bond_histories: BondHistories | None
    bonds: DamageSum | None

    @property
    def of_plies(self) -> Array:
        """The largest damage of each ply in each blade, shape (blades, plies)."""
        return np.asarray(self.plies.damage.max(axis=(2, 3)))

    @property
    def indices(self) -> Array:
        """The fatigue index of each ply in each blade, shape (blades, plies)."""
        plies, known = self.recovery.recovered.table.plies, self.materials
        slopes = [known[x.material.name].slope if x.material.name in known else 1.0 for x in plies]
        return np.asarray(self.of_plies ** (1.0 / np.array(slopes)))

    def count_cells(self) -> tuple[int, int]:
        """Number of cells with plies that count, and of those all of whose histories are left out.

        Collective.
        """
        table = self.recovery.recovered.table
        cells = np.unique(table.wall[self.plies.range.any(axis=(0, 2, 3))])
        some = np.unique(table.wall[self.plies.counted.any(axis=(0, 2, 3))])
        comm = self.recovery.run.turbine.comm
        n, m = comm.allreduce(len(cells)), comm.allreduce(len(np.setdiff1d(cells, some)))
        return int(n), int(m)


def describe_years(years: float) -> str:
    """A life in words."""
    return f"{years:.3g} years" if np.isfinite(years) else "without end"


def find_ply_life(
    runs: Sequence[WeightedRun],
    comm: MPI.Intracomm,
    overrides: Iterable[str] = (),
    years: float | None = None,
    progress: Callable[[float], None] = lambda part: None,
) -> PlyLife:
    """Damage over the life. Collective.

    Args:
        runs: Runs of one turbine, in any order.
        comm: Communicator.
        overrides: Changes of the table ``life``, such as ``"life.years=25"``.
        years: The life that the runs belong to; that of the case if None.
        progress: Called with the part that is done, from 0 to 1.

    Raises:
        InputError: for runs of different turbines, meshes or bases, blades without plies, materials
            without strengths, and runs that last for less than one cycle.
    """
    ordered = tuple(sorted(runs, key=lambda run: str(run.folder)))
    of_life = list(overrides), "life."
    first = RecordedRun.open(ordered[0].folder, comm, *of_life)
    recovery, case = PlyRecovery(first), first.turbine.case
    used = {ply.material.name for ply in recovery.recovered.table.plies}
    fatigue = find_fatigue_of_file(case, set().union(*comm.allgather(used)))
    glued = find_adhesive(case)
    bonds = None if glued is None else BondHistories(recovery, *glued)
    plies = PlyHistories(recovery, fatigue.materials)
    kinds: list[Histories] = [plies] if bonds is None else [plies, bonds]
    finder, life = RunDamage(recovery, kinds), years or case.life.years
    sums = [DamageSum(kind.shape) for kind in kinds]
    counts = [_count(first, run, life, *of_life) for run in ordered]  # before any takes long
    for k, (run, (times, wind)) in enumerate(zip(ordered, counts, strict=True)):

        def show(part: float, k: int = k) -> None:
            progress((k + part) / len(ordered))

        motion = first.read_another(run.folder, *of_life)[0]
        least = NEGLIGIBLE / (len(ordered) * max(times, 1e-30))
        found = finder.find(motion, run.begin, least, show)
        _check_cycles(comm, found[0], run)
        for total, own in zip(sums, found, strict=True):
            total.add(k, times, wind, own)
    of_bonds = sums[1] if bonds is not None else None
    materials = dict(fatigue.materials)
    return PlyLife(recovery, materials, fatigue.notes, life, ordered, sums[0], bonds, of_bonds)


def _count(
    first: RecordedRun, run: WeightedRun, years: float, overrides: Sequence[str], allowed: str
) -> tuple[float, float]:
    """How often a run happens in the life, and its wind speed [m/s]. Collective.

    Raises:
        InputError: if its turbine is another, or nothing of it counts.
    """
    motion, case = first.read_another(run.folder, overrides, allowed)
    if case.life != first.turbine.case.life:
        raise InputError(
            f"the runs {first.folder.name!r} and {run.name!r} have different tables life: expected "
            "equal ones"
        )
    rows = int(np.sum(motion.times >= run.begin))
    if rows < FEWEST:
        raise InputError(
            f"the motion of {run.name!r} has {rows} rows from t = {run.begin:g} s on, which is "
            "less than one cycle"
        )
    duration = float(motion.times[-1]) - max(run.begin, float(motion.times[0]))
    return run.find_times(duration, years), case.wind.speed or 0.0


def _check_cycles(comm: MPI.Intracomm, found: PlyDamage, run: WeightedRun) -> None:
    """Raise an InputError if what is damaged most has no whole cycle. Collective."""
    mine = (0.0, np.inf)
    if found.damage.size:
        k = int(np.argmax(found.damage))
        mine = float(found.damage.flat[k]), float(found.cycles.flat[k])
    damage, cycles = max(comm.allgather(mine))
    if damage > 0.0 and cycles < 1.0:
        raise InputError(f"the run {run.name!r} lasts for less than one cycle of stress")
