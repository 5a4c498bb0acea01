"""Claims about works and dissipation by name, from the step to the columns of the history."""

import csv

import numpy as np
import pytest
from seen import Seen

from turbine_fenicsx import (
    Gravity,
    JointDamper,
    JointSpring,
    JointTorque,
    PointForce,
    PointSpring,
    PrescribedMotion,
    Torque,
)
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.simulation.observers.history import (
    History,
    angle_channel,
    energy_channel,
    work_channel,
)
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum

pytestmark = pytest.mark.parallel

WORKS = (
    "work_of_torque_on_rotor_[J]",
    "work_of_gust_[J]",
    "work_of_brake_[J]",
    "work_of_motion_of_yaw_[J]",
)


def loaded(comm, m):
    """The rigid part of the machine with one of everything; four works, one dissipation."""
    parts = [m.nacelle, m.hub, m.yaw, m.rotor, Gravity()]
    parts += [
        JointTorque("torque on rotor", "rotor", 4.0),
        PointForce("gust", m.hub, point=(0, 1, -1), force=(2, 0, 1)),
    ]
    parts += [Torque("brake", m.hub, (0, 0, -1.0)), PrescribedMotion("yaw", lambda t: t**3)]
    parts += [JointSpring("spring", "rotor", 3.0), JointDamper("rotor damper", "rotor", 0.5)]
    return MultibodySystem(comm, parts)


def simulate(system, end=0.5, more=lambda stepper: ()):
    """What each observation saw, and the names of what dissipated."""
    recorder = Seen(
        lambda s: (
            *(s.state.time, s.balance.total, s.works),
            *(s.dissipated, s.external_work, s.energy_error),
        )
    )
    stepper = EnergyMomentum(system)
    Simulation(system, 0.02, end, [recorder, *more(stepper)], stepper).run()
    names = stepper.dissipation_names
    stepper.destroy()
    return recorder.values, names


def test_works_and_dissipation_add_up_to_the_change_of_energy(comm, machine):
    system = loaded(comm, machine(spin=2.0))
    seen, names = simulate(system)
    assert names == ("rotor damper",)
    start = seen[0][1]
    assert np.all(seen[0][2] == 0.0) and np.all(seen[0][3] == 0.0)
    for _, total, works, dissipated, external, error in seen:
        assert works.shape == (5,) and dissipated.shape == (1,)
        assert works[system.work_names.index("gravity")] == 0.0
        assert external == pytest.approx(works.sum(), rel=1e-14)
        assert total == pytest.approx(start + works.sum() - dissipated.sum(), abs=1e-11)
        assert abs(error) <= 1e-11
    for name, work in zip(system.work_names, seen[-1][2], strict=True):
        assert name == "gravity" or abs(work) > 1e-3
    assert seen[-1][3] > 1e-2


def test_history_has_a_column_for_each_work_and_dissipation(comm, machine, shared_tmp_path):
    system = loaded(comm, machine(spin=2.0))

    def history(stepper):
        channels = [energy_channel(), angle_channel(system), work_channel(stepper)]
        return [History(comm, shared_tmp_path / "history.csv", channels)]

    seen, _ = simulate(system, 0.1, history)
    with (shared_tmp_path / "history.csv").open(newline="") as file:
        names, *rows = csv.reader(file)
    assert tuple(names[-6:]) == ("spring_energy_[J]", *WORKS, "dissipated_by_rotor_damper_[J]")
    table = dict(zip(names, np.array(rows, dtype=float).T, strict=True))
    works = [name for name in names if name.startswith("work_of_")]
    parts = [table[f"{k}_energy_[J]"] for k in ("kinetic", "strain", "potential", "spring")]
    total, lost = table["total_energy_[J]"], table["dissipated_by_rotor_damper_[J]"]
    assert np.allclose(sum(parts), total, rtol=1e-14, atol=1e-14)
    gained = sum(table[name] for name in works)
    assert np.allclose(gained, table["external_work_[J]"], rtol=1e-13, atol=1e-15)
    assert np.allclose(total - total[0], gained - lost, rtol=0, atol=1e-11)
    assert np.allclose(table["work_of_gust_[J]"], [x[2][2] for x in seen], rtol=0, atol=0)


def test_what_a_system_does_not_have_has_no_column(comm, machine):
    m = machine()
    spring = PointSpring(
        "s", m.hub, None, first_point=(0, 1, 0), second_point=(0, 2, 0), stiffness=1.0
    )
    for part, columns in ((Gravity(), ()), (spring, ("spring_energy_[J]",))):
        stepper = EnergyMomentum(m.system(part))
        assert work_channel(stepper).columns == columns
        stepper.destroy()


def test_displacements_and_angles_have_units_of_their_own(comm):
    from turbine_fenicsx.joints.cylindrical import Cylindrical

    body = RigidBody("a", 1.0, (1, 1, 1))
    joint = Cylindrical("j", None, body, point=(0, 0, 0), axis=(0, 0, 1))
    columns = angle_channel(MultibodySystem(comm, [body, joint])).columns
    assert columns == ("angle_j.angle_[rad]", "displacement_j.displacement_[m]")
