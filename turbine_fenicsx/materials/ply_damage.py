"""Damage of plies by their histories of stress, in C code.

Cycles are counted by the rainflow method of ASTM E1049-85, half cycles as one half. Those of
amplitude A about a mean M that a ply survives N times do it the damage 1/N, which Miner's rule adds
up. See `turbine_fenicsx.materials.ply_fatigue` for N, and for the four stresses that count.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mpi4py import MPI

import numpy as np

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.c_code import CompiledCode
from turbine_fenicsx.foundation.errors import CompilationError, ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.ply_fatigue import MEASURES, FatigueTable

DECLARATION = """
typedef struct { double tension[2], compression[2], shear; } Strength;
typedef struct {
  double tension, tension_slope, compression, compression_slope, exponent;
} Life;
int find_ply_damage(int, int, const double *, const Strength *, const Life *, double, double *,
                    double *, double *);
"""


@dataclass(frozen=True, eq=False)
class PlyDamage:
    """Damage and cycles of histories, by `turbine_fenicsx.materials.ply_fatigue.MEASURES`.

    Args:
        damage: Shape (n, 4) [-]; a ply fails at 1.
        cycles: Numbers of cycles; 0 of a stress that does not count, -1 of one that is left out.
        range: Largest range of each stress [Pa], of the exertion [-].
    """

    damage: Array
    cycles: Array
    range: Array


class DamageCode(CompiledCode):
    """The C code, compiled once. Making it is collective.

    Raises:
        CompilationError: without a compiler.
    """

    def __init__(self, comm: MPI.Intracomm) -> None:
        module = _compat.load_c(comm, Path(__file__).with_suffix(".c"), DECLARATION)
        if module is None:
            raise CompilationError("counting the cycles of plies needs a C compiler")
        super().__init__(module)

    def find(self, table: FatigueTable, stresses: Array, least: float = 0.0) -> PlyDamage:
        """Damage of histories.

        Args:
            table: The plies, with n histories.
            stresses: Along the fibre, across it, and of shear at m times, shape (n, 3, m) [Pa].
            least: Histories that surely do less damage than this are left out.

        Raises:
            ModelError: for stresses that are not finite.
        """
        n, _, m = stresses.shape
        if not np.isfinite(stresses).all():
            raise ModelError("stresses of plies are not finite")
        found = np.zeros((3, n, len(MEASURES)))
        values = [np.ascontiguousarray(x, dtype=float) for x in (stresses, *table.rows)]
        cast, buffer = self._ffi.cast, self._address
        lacks = self._lib.find_ply_damage(
            *(n, m, buffer(values[0])),
            *(cast("Strength *", buffer(values[1])), cast("Life *", buffer(values[2])), least),
            *map(buffer, found),
        )
        if lacks:
            raise MemoryError("no memory for the cycles of plies")
        return PlyDamage(*found)
