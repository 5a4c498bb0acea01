"""Exudyn: the rigid turbine of the paper, five bodies and five revolute joints.

Generalised alpha with its default damping, index 2, Euler parameters, modified Newton: its
settings for fast runs. Reads the bodies from the file that rigid.py writes.
"""

from __future__ import annotations

import json
import sys
import time

import exudyn
import measure
import numpy as np
from exudyn.utilities import RigidBodyInertia


def build(data):
    """The model; returns it with the number of the hub."""
    mbs = exudyn.SystemContainer().AddSystem()
    bodies = {"ground": mbs.CreateGround()}
    for body in data["bodies"]:
        E = np.array(body["euler"])
        bodies[body["name"]] = mbs.CreateRigidBody(
            inertia=RigidBodyInertia(body["mass"], np.diag(E.sum() - E)),
            referencePosition=body["position"],
            referenceRotationMatrix=np.array(body["directors"]),
            gravity=[0.0, -9.81, 0.0],
        )
    for joint in data["joints"]:
        mbs.CreateRevoluteJoint(
            itemNumbers=[bodies[name] for name in joint["bodies"]],
            position=joint["point"],
            axis=joint["axis"],
        )

    def torque(sign):
        def vector(mbs, t, load):
            hat = max(0.0, 1.0 - abs(2.0 * t / data["duration"] - 1.0))
            return [0.0, 0.0, sign * data["torque"] * hat]

        return vector

    for name, sign in (("hub", 1.0), ("nacelle", -1.0)):
        mbs.CreateTorque(
            itemNumber=bodies[name],
            loadVector=[0.0, 0.0, 1.0],
            bodyFixed=True,
            loadVectorUserFunction=torque(sign),
        )
    mbs.Assemble()
    return mbs, bodies["hub"]


def main():
    source, target = sys.argv[1:3]
    with open(source, encoding="utf-8") as file:
        data = json.load(file)
    mbs, hub = build(data)
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.numberOfSteps = data["steps"]
    settings.timeIntegration.endTime = data["steps"] * data["dt"]
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.solution.file.write = False
    settings.timeIntegration.verboseMode = 0
    start = time.perf_counter()
    mbs.SolveDynamic(settings)
    seconds = time.perf_counter() - start
    R = mbs.GetObjectOutputBody(hub, exudyn.OutputVariableType.RotationMatrix, [0.0, 0.0, 0.0])
    result = {
        "seconds": seconds,
        "angle": float(np.arctan2(R[3], R[0])),
        "versions": measure.versions("exudyn"),
    }
    with open(target, "w", encoding="utf-8") as file:
        json.dump(result, file, indent=1)


if __name__ == "__main__":
    main()
