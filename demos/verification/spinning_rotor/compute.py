"""The long run of this benchmark; takes half an hour.

    python demos/verification/spinning_rotor/compute.py -o out/spinning_rotor

It writes the usual output folder of a run, with checkpoints, and ``result.toml`` beside this file.
Ended too early, it goes on with ``--resume``.
"""

import argparse
from pathlib import Path

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.records.output_folder import read_history
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.run.run import run_case

LOADED = 1.0  # the hat of torque ends [s]
END = 752.0  # [s]; 100 revolutions

CASE = {
    "title": "a hollow rotor that spins freely",
    "time": {"step": 0.1, "end": END, "start": "turning"},
    "turbine": {"file": "IEA-22-280-RWT.yaml", "rotor_speed": "8 rpm"},
    "tower": {"flexible": False},
    "mesh": {"span": 6, "around": 16},
    "blade": {"damping": 0},
    "yaw": {"drive": "free"},
    "loads": {"rotor_torque": -1e6, "duration": LOADED, "gravity": 0.0},
    "solver": {"tolerance": 1e-12},
    "output": {"fields_every": 0.0, "checkpoint_every": 50.0},
}


def evaluate(folder):
    """What a run conserved, and how much it vibrated.

    Args:
        folder: Its output folder.

    Returns:
        Numbers by name.
    """
    run = read_history(folder / "history.csv").columns
    t, turned = run["time_[s]"], run["angle_rotor_[rad]"]
    free = t >= LOADED * (1.0 - 1e-9)
    H, kinetic = run["total_energy_[J]"], run["kinetic_energy_[J]"]
    strain = run["strain_energy_[J]"][free]
    L = np.column_stack([run[f"angular_momentum_{i}_[Nms]"] for i in (1, 2, 3)])
    size = np.max(np.linalg.norm(L, axis=1))
    swings = {
        name: max(np.ptp(run[f"tip_{name}_{k}_[m]"][free]) for k in (1, 2, 3))
        for name in ("flap", "edge")
    }
    return {
        "steps": len(t) - 1,
        "step": float(t[1] - t[0]),
        "revolutions": float(abs(turned[-1] - turned[0]) / (2.0 * np.pi)),
        "energy_drift": float(np.max(np.abs(H[free] - H[free][0])) / np.max(kinetic)),
        "energy_balance": float(np.max(np.abs(run["energy_error_[J]"])) / np.max(kinetic)),
        "vertical_momentum": float(np.max(np.abs(L[:, 1] - L[0, 1])) / size),
        "constraints": float(np.max(run["constraint_error_[-]"])),
        "strain_swing": float(np.ptp(strain) / np.mean(strain)),
        "flap_swing": float(swings["flap"]),
        "edge_swing": float(swings["edge"]),
        "newton": float(np.mean(run["newton_iterations"][1:])),
        "hours": float(run["wall_time_[s]"][-1] / 3600.0),
    }


def simulate(folder, end=END, comm=MPI.COMM_WORLD, resume=False):
    """Run the case into a folder up to a time [s]; returns what `evaluate` does, on all ranks."""
    case = Case.parse(CASE | {"time": CASE["time"] | {"end": end}})
    summary = run_case(case, folder, comm, "log", resume=resume)
    found = comm.bcast(evaluate(folder) if comm.rank == 0 else None)
    counts = {name: summary[name] for name in ("halved_steps", "solver_fallbacks")}
    return found | {"displacements": summary["unknowns"]["displacements"]} | counts


def main():
    """Run and write ``result.toml``."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--out", type=Path, default=Path("out/spinning_rotor"))
    parser.add_argument("--resume", action="store_true", help="go on with a run that was ended")
    options = parser.parse_args()
    found = simulate(options.out, resume=options.resume)
    if MPI.COMM_WORLD.rank == 0:
        lines = [f"{name} = {value!r}" for name, value in found.items()]
        path = Path(__file__).with_name("result.toml")
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
