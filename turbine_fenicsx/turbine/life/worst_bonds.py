"""Where the bonds of the blades fail first by fatigue, an estimate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.turbine.life.ply_life import PlyLife, describe_years

WORDS = ("", "peel", "shear", "exertion")
"""The stresses of a bond, at the places of `turbine_fenicsx.materials.ply_fatigue.MEASURES`."""


@dataclass(frozen=True)
class WorstBond:
    """The place where a bond fails first.

    Args:
        damage: Miner's sum over the life [-].
        distance: Of the place from the root [m].
        bond: Its name and side.
        measure: The stress that does it: "peel", "shear" or "exertion".
        years: Its life; infinite without damage.
        peel: Largest range of the peel stress [Pa].
        shear: Largest range of the shear stress [Pa].
        blade: Number of the blade, from 1.
        run: The run that does most damage.
    """

    damage: float
    distance: float
    bond: str
    measure: str
    years: float
    peel: float
    shear: float
    blade: int
    run: str

    def __str__(self) -> str:
        """A line for people."""
        return (
            f"bonds, an estimate: {self.bond} of blade {self.blade} fails first, "
            f"{self.distance:.4g} m from the root, by {self.measure}; damage {self.damage:.3g}, "
            f"life {describe_years(self.years)}"
        )


def find_worst_bonds(life: PlyLife) -> list[WorstBond]:
    """The worst place of each bond, the worst bond first; none without an adhesive. Collective."""
    if life.bond_histories is None or life.bonds is None:
        return []
    comm, distances = life.recovery.run.turbine.comm, life.recovery.plies.place
    found: dict[str, WorstBond] = {}
    for j, (bond, cell) in enumerate(
        zip(life.bond_histories.names, life.bond_histories.cells, strict=True)
    ):
        own = life.bonds.damage[:, j]
        copy, side, k = np.unravel_index(int(np.argmax(own)), own.shape)
        at = copy, j, side, k
        damage, ranges = float(life.bonds.damage[at]), life.bonds.range[copy, j, side]
        place = WorstBond(
            damage=damage,
            distance=float(distances[cell]),
            bond=bond,
            measure=WORDS[k] or WORDS[-1],
            years=life.years / damage if damage > 0.0 else np.inf,
            peel=float(ranges[1]),
            shear=float(ranges[2]),
            blade=int(copy) + 1,
            run=life.runs[life.bonds.worst[at]].name,
        )
        if bond not in found or _rank(place) < _rank(found[bond]):
            found[bond] = place
    every = [place for of_rank in comm.allgather(list(found.values())) for place in of_rank]
    worst: dict[str, WorstBond] = {}
    for place in sorted(every, key=_rank):
        worst.setdefault(place.bond, place)
    return list(worst.values())


def _rank(place: WorstBond) -> tuple[float, float]:
    """Bonds are sorted by this, the worst first."""
    return -place.damage, place.distance
