"""The modes of this benchmark at all speeds; takes nine minutes of a core.

    python demos/verification/iea22_campbell/compute.py -o out/iea22_campbell

It writes what ``turbine-fenicsx modes`` does, and ``result.csv`` beside this file, which is the
table ``campbell.csv`` of it.
"""

import argparse
import shutil
from math import pi
from pathlib import Path

from mpi4py import MPI

from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.modes.find_modes import ModesWanted, find_modes

SPEEDS = (0.0, 2.0, 4.0, 6.0, 7.061, 8.0)  # [rpm]; 7.061 is rated
COUNT = 10

CASE = {
    "title": "the rotor of the IEA 22 MW turbine on a rigid tower",
    "turbine": {"file": "IEA-22-280-RWT.yaml"},
    "tower": {"flexible": False},
    "mesh": {"span": 20, "around": 24},
    "blade": {"damping": 0},
}


def compute(folder=None, speeds=SPEEDS, comm=MPI.COMM_WORLD):
    """Modes at speeds [rpm], a table for each; a folder gets their files.

    Args:
        folder: Where files are written; None writes none.
        speeds: Speeds [rpm].
        comm: Communicator.
    """
    speeds = tuple(speed * pi / 30.0 for speed in speeds)
    wanted = ModesWanted(count=COUNT, speeds=speeds, locked=("yaw",))

    def say(table):
        if comm.rank == 0:
            names = (f"{row.frequency:.4f} {row.name}" for row in table.rows)
            print(f"{table.speed * 30.0 / pi:g} rpm", *names, sep="\n  ", flush=True)
        return False

    return find_modes(Case.parse(CASE), folder, comm, wanted, overwrite=True, found=say)[0]


def main():
    """Compute and write ``result.csv``."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--out", type=Path, default=Path("out/iea22_campbell"))
    options = parser.parse_args()
    compute(options.out)
    if MPI.COMM_WORLD.rank == 0:
        shutil.copy(options.out / "campbell.csv", Path(__file__).with_name("result.csv"))


if __name__ == "__main__":
    main()
