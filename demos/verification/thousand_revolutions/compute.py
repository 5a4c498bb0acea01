"""The long run of this benchmark; takes half an hour to an hour.

    python demos/verification/thousand_revolutions/compute.py -o out/thousand_revolutions

It writes the usual output folder of a run, with checkpoints, and ``result.toml`` beside this file.
Ended too early, it goes on with ``--resume``.
"""

import argparse
from pathlib import Path

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.records.output_folder import read_history
from turbine_fenicsx.simulation.observers.history import Channel, History
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.run.run import run_case

STEP = 0.05  # [s]; 99 steps per revolution
LOADED = 14.0  # the hat of torque ends [s]
END = 5000.0  # [s]; 1011 revolutions

CASE = {
    "title": "a thousand revolutions",
    "time": {"step": STEP, "end": END},
    "turbine": {"model": "hybrid"},
    "mesh": {"cell": "hexahedron", "elements": [2, 2, 12], "degree": 1},
    "material": {"law": "transversely_isotropic"},
    "loads": {"rotor_torque": -3.6e7, "duration": LOADED, "gravity": 9.81},
    "output": {"fields_every": 0.0, "checkpoint_every": 250.0},
}


def hub_angle(snapshot):
    """Angle of the hub about the rotor axis, from the directors alone, in (-pi, pi] [rad]."""
    nacelle, hub = snapshot.state.q.reshape(-1, 4, 3)[:2, 1:]
    return np.arctan2(nacelle[1] @ hub[0], nacelle[0] @ hub[0])


def recorder(comm, path):
    """Observer that writes the angle of the directors beside the joint angle."""

    def values(snapshot):
        return [snapshot.state.time, snapshot.state.joint_coordinates[1], hub_angle(snapshot)]

    columns = ("time_[s]", "joint_angle_[rad]", "director_angle_[rad]")
    return History(comm, path, [Channel(columns, values)])


def evaluate(folder):
    """What a run conserved, and how its angle went on.

    Args:
        folder: Output folder of the run, with ``angles.csv`` of `recorder`.

    Returns:
        Numbers by name.
    """
    run = read_history(folder / "history.csv").columns
    angles = read_history(folder / "angles.csv").columns
    joint, directors = (angles[f"{name}_angle_[rad]"] for name in ("joint", "director"))
    turns = np.round((np.unwrap(directors) - directors) / (2.0 * np.pi))
    counted = directors + 2.0 * np.pi * turns  # without the round-off of a sum of all steps
    t = run["time_[s]"]
    free = t >= LOADED * (1.0 - 1e-9)
    H, kinetic = run["total_energy_[J]"], run["kinetic_energy_[J]"]
    L = np.column_stack([run[f"angular_momentum_{i}_[Nms]"] for i in (1, 2, 3)])
    return {
        "steps": len(t) - 1,
        "step": float(t[1] - t[0]),
        "revolutions": float(abs(joint[-1] - joint[0]) / (2.0 * np.pi)),
        "energy_drift": float(np.max(np.abs(H[free] - H[free][0])) / np.max(kinetic)),
        "energy_balance": float(np.max(np.abs(run["energy_error_[J]"])) / np.max(kinetic)),
        "vertical_momentum": float(np.max(np.abs(L[:, 1] - L[0, 1])) / np.max(np.abs(L))),
        "constraints": float(np.max(run["constraint_error_[-]"])),
        "largest_turn": float(np.max(np.abs(np.diff(joint)))),
        "angle_gap": float(np.max(np.abs((joint - joint[0]) - (counted - counted[0])))),
        "strain_share": float(np.max(run["strain_energy_[J]"][free] / kinetic[free])),
        "newton": float(np.mean(run["newton_iterations"][1:])),
        "hours": float(run["wall_time_[s]"][-1] / 3600.0),
    }


def simulate(folder, end=END, comm=MPI.COMM_WORLD, resume=False):
    """Run the case into a folder up to a time [s]; returns what `evaluate` does, on all ranks."""
    folder.mkdir(parents=True, exist_ok=True)
    case = Case.parse(CASE | {"time": {"step": STEP, "end": end}})
    angles = recorder(comm, folder / "angles.csv")
    summary = run_case(case, folder, comm, "log", [angles], resume=resume)
    found = evaluate(folder) if comm.rank == 0 else None
    return comm.bcast(found) | {"halved_steps": summary["halved_steps"]}


def main():
    """Run and write ``result.toml``."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--out", type=Path, default=Path("out/thousand_revolutions"))
    parser.add_argument("--resume", action="store_true", help="go on with a run that was ended")
    options = parser.parse_args()
    found = simulate(options.out, resume=options.resume)
    if MPI.COMM_WORLD.rank == 0:
        lines = [f"{name} = {value!r}" for name, value in found.items()]
        path = Path(__file__).with_name("result.toml")
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
