"""turbine_fenicsx: the rigid turbine of the paper, 600 steps of 0.02 s.

Usage: rigid.py RESULT MODEL writes the result, and the model for exudyn_turbine.py.
"""

from __future__ import annotations

import json
import sys
import time

from mpi4py import MPI

import measure
import numpy as np

from turbine_fenicsx import Gravity, Hat, JointTorque, MultibodySystem, RigidBody, Simulation
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import assemble
from turbine_fenicsx.turbine.components.nacelle import Nacelle
from turbine_fenicsx.turbine.components.pitch import Pitch
from turbine_fenicsx.turbine.components.rigid_blades import RigidBlades

TORQUE, DURATION, DT, STEPS = -3.6e7, 3.0, 0.02, 600


def describe(parts):
    """Bodies and joints as plain data."""
    bodies = [p for p in parts if isinstance(p, RigidBody)]
    joints = [p for p in parts if not isinstance(p, RigidBody)]
    return {
        "torque": TORQUE,
        "duration": DURATION,
        "dt": DT,
        "steps": STEPS,
        "bodies": [
            {
                "name": b.name,
                "mass": b.mass,
                "euler": list(b.euler),
                "position": np.asarray(b.position).tolist(),
                "directors": np.asarray(b.directors).tolist(),
            }
            for b in bodies
        ],
        "joints": [
            {
                "bodies": ["ground" if b is None else b.name for b in j.bodies],
                "point": np.asarray(j.point).tolist(),
                "axis": np.asarray(j.axis).tolist(),
            }
            for j in joints
        ],
    }


def main():
    result, model = sys.argv[1:3]
    parts = assemble(
        Case.parse({"turbine": {"model": "rigid"}}),
        [Nacelle(), RigidBlades(), Pitch()],
        MPI.COMM_SELF,
    ).parts
    with open(model, "w", encoding="utf-8") as file:
        json.dump(describe(parts), file, indent=1)
    loads = [Gravity(), JointTorque("torque on rotor", "rotor", TORQUE, Hat(1.0, DURATION))]
    system = MultibodySystem(MPI.COMM_SELF, [*parts, *loads])
    simulation = Simulation(system, DT, STEPS * DT)
    start = time.perf_counter()
    last = simulation.run()
    seconds = time.perf_counter() - start
    angle = dict(zip(system.joint_coordinate_names, last.state.joint_coordinates, strict=True))[
        "rotor"
    ]
    with open(result, "w", encoding="utf-8") as file:
        data = {
            "seconds": seconds,
            "angle": float(np.arctan2(np.sin(angle), np.cos(angle))),
            "energy_error": last.energy_error / last.balance.total,
            "versions": measure.versions("turbine_fenicsx"),
        }
        json.dump(data, file, indent=1)


if __name__ == "__main__":
    main()
