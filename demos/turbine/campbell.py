"""Campbell diagram of the turbine on its flexible tower.

Frequencies over the speed of the rotor; the command ``turbine-fenicsx modes --speeds`` also writes
and draws them.
"""

from math import pi
from pathlib import Path

from mpi4py import MPI

from turbine_fenicsx import Case
from turbine_fenicsx.turbine.modes.find_modes import ModesWanted, find_modes

case = Case.load(Path(__file__).with_name("flexible_tower.toml"))
speeds = tuple(rpm * pi / 30.0 for rpm in (0.0, 7.0, 14.0))
wanted = ModesWanted(count=8, speeds=speeds, locked=("yaw",))
tables, _ = find_modes(case, None, MPI.COMM_WORLD, wanted)
if MPI.COMM_WORLD.rank == 0:
    for modes in zip(*(table.rows for table in tables), strict=True):  # one mode at all speeds
        print(*(f"{mode.frequency:7.4f}" for mode in modes), f"Hz  {modes[-1].name}")
