"""Gravity, and the torques on the bearings: hats, or tables over the time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mpi4py import MPI

from turbine_fenicsx.forces.gravity import Gravity
from turbine_fenicsx.forces.joint_torque import JointTorque
from turbine_fenicsx.forces.time_functions import Hat, Product, Ramp, Table
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.component import Assembly, Component
from turbine_fenicsx.turbine.components.nacelle import ROTOR, YAW
from turbine_fenicsx.turbine.tables.loads import LoadsCase, load_torques

Course = Callable[[float], float]
"""A function of time [s]."""


def make_hat(loads: LoadsCase, ramp: float) -> Course:
    """The course of all torques in time, of the height one: a hat, which may set in smoothly.

    Args:
        ramp: Time in which it sets in [s]; 0 for a sudden start.
    """
    hat = Hat(1.0, loads.duration)
    return Product(hat, Ramp(1.0, ramp, smooth=True)) if ramp else hat


def read_torques(case: Case, comm: MPI.Intracomm) -> dict[str, Course]:
    """Torques of the file of a case over the time [N m], by their keys. Collective."""
    file = case.loads.file
    if file is None:
        return {}
    table = on_rank0(comm, lambda: load_torques(file))
    found: dict[str, Course] = {}
    for name, values in table.columns.items():
        course = Table(table.times.tolist(), values.tolist())
        ramp = case.time.ramp
        found[name] = Product(course, Ramp(1.0, ramp, smooth=True)) if ramp else course
    return found


def make_torque(
    name: str, coordinate: str, sign: float, peak: float, hat: Course, table: Course | None
) -> JointTorque:
    """A torque on a bearing.

    Args:
        peak: Of the hat [N m].
        hat: Course of the torque where there is no table.
        table: Course of the torque with a table [N m].
    """
    if table is None:
        return JointTorque(name, coordinate, sign * peak, hat)
    return JointTorque(name, coordinate, sign, table)


@dataclass(frozen=True)
class Loads(Component):
    """Gravity, and torques on rotor and yaw: hat functions, eq. (60), or those of a table."""

    def parts(self, assembly: Assembly) -> list[Any]:
        """Torques are named after their bearings; gravity acts along -e2."""
        loads, hat = assembly.case.loads, make_hat(assembly.case.loads, assembly.case.time.ramp)
        table = read_torques(assembly.case, assembly.comm)
        return [
            Gravity((0.0, -loads.gravity, 0.0)),
            *(
                make_torque(f"torque on {place}", place, 1.0, peak, hat, table.get(key))
                for key, place, peak in (
                    ("rotor_torque", ROTOR, loads.rotor_torque),
                    ("yaw_torque", YAW, loads.yaw_torque),
                )
            ),
        ]
