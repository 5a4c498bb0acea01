"""A generator without a controller: it keeps its speed, or its torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from turbine_fenicsx.forces.joint_torque import JointTorque
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.joints.prescribed_motion import PrescribedMotion
from turbine_fenicsx.turbine.case.aero_blade import load_aero_blade
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.component import Assembly, Component
from turbine_fenicsx.turbine.components.nacelle import ROTOR
from turbine_fenicsx.wind.rotor import Operation, Performance, Rotor, find_performance

SECTORS = 24
"""Azimuths over which loads are averaged."""


@dataclass(frozen=True)
class SteadyTurn:
    """The angle of what turns steadily, as a function of time.

    Args:
        start: Angle at t = 0 [rad].
        rate: Speed [rad/s].
    """

    start: float
    rate: float

    def __call__(self, time: float) -> float:
        """Angle at a time [rad]."""
        return self.start + self.rate * time


@dataclass(frozen=True)
class Generator(Component):
    """A prescribed rotation of the rotor, or a constant torque between rotor and nacelle."""

    def parts(self, assembly: Assembly) -> list[Any]:
        """The motion of the rotor, or the torque named ``generator``."""
        case, turbine = assembly.case, assembly.case.turbine
        if case.generator.keeps == "speed":
            return [PrescribedMotion(ROTOR, SteadyTurn(turbine.azimuth, turbine.rotor_speed))]
        torque = case.generator.torque
        if torque is None:
            torque = on_rank0(assembly.comm, lambda: find_steady_loads(case).torque)
        return [JointTorque("generator", ROTOR, -torque)]


@dataclass
class SteadyTorque(Component):
    """A torque between rotor and nacelle that may be changed between equilibria.

    Args:
        value: The torque, negative where it brakes [N m].
    """

    value: float = 0.0

    def parts(self, assembly: Assembly) -> list[Any]:
        """The torque named ``generator``."""
        return [JointTorque("generator", ROTOR, 1.0, lambda _: self.value)]


def find_steady_loads(case: Case) -> Performance:
    """Mean loads of the steady wind of a case on a rotor of stiff blades, without its gusts.

    Args:
        case: A case with ``wind.speed`` and a positive speed of the rotor.
    """
    t, w = case.turbine, case.wind
    assert w.speed
    rotor = Rotor(
        load_aero_blade(case),
        precone=-t.precone,
        tilt=-t.tilt,
        hub_height=case.hub_height,
        induction=case.aero.induction,
    )
    operation = Operation(
        w.speed * float(np.cos(w.inclination)),
        t.rotor_speed,
        pitch=float(np.mean(case.pitch.initial)) if case.has_pitch_bearings else 0.0,
        yaw=w.direction,
        shear=w.shear,
        density=w.density,
    )
    return find_performance(rotor, operation, SECTORS)
