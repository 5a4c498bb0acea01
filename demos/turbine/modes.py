"""Modes of the turbine on its flexible tower.

Frequencies and names of the first modes at rest; the command ``turbine-fenicsx modes`` also writes
tables and shapes.
"""

from pathlib import Path

from mpi4py import MPI

from turbine_fenicsx import Case
from turbine_fenicsx.turbine.modes.find_modes import ModesWanted, find_modes

case = Case.load(Path(__file__).with_name("flexible_tower.toml"))
wanted = ModesWanted(count=12, locked=("rotor", "yaw"))  # parked: both brakes are on
(table,), _ = find_modes(case, None, MPI.COMM_WORLD, wanted)
if MPI.COMM_WORLD.rank == 0:
    for number, mode in enumerate(table.rows, start=1):
        print(f"{number:2d}  {mode.frequency:.4f} Hz  {mode.name}")
