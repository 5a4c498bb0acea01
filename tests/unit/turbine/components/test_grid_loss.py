"""Overspeed after the grid is lost, against two equations for rotor and generator."""

from itertools import pairwise

import numpy as np
import pytest
from test_turbine_control import TRAIN, read

from turbine_fenicsx import Case, build_turbine, run_case
from turbine_fenicsx.turbine.run.summary import rotor_inertia

pytestmark = pytest.mark.parallel

CONSTANT = """
class Constant:
    def __call__(self, measured):
        return 40e3, (0.0, 0.0, 0.0)
"""
DT, END, LOSS, TORQUE, DURATION = 0.02, 3.0, 1.0, 5e6, 6.0


def integrate(J1, J2, k, d, N, speed, times):
    """Speeds of rotor and generator on the slow side, by Runge-Kutta's method.

    J1 w1' = Q(t) + k phi + d phi',   J2 w2' = -k phi - d phi' - N T(t),   phi' = w2 - w1
    """

    def slope(t, y, T):
        phi, w1, w2 = y
        Q = TORQUE * (1.0 - abs(2.0 * t / DURATION - 1.0))
        M = k * phi + d * (w2 - w1)
        return np.array([w2 - w1, (Q + M) / J1, (-M - N * T) / J2])

    y, found, n = np.array([0.0, speed, speed]), [], 20
    for t0, t1 in pairwise(times):
        h, T = (t1 - t0) / n, 40e3 if t0 < LOSS - 1e-9 else 0.0
        for m in range(n):
            t = t0 + m * h
            a = slope(t, y, T)
            b = slope(t + 0.5 * h, y + 0.5 * h * a, T)
            c = slope(t + 0.5 * h, y + 0.5 * h * b, T)
            e = slope(t + h, y + h * c, T)
            y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + e)
        found.append(y)
    return np.array(found)


def test_the_rotor_speeds_up_as_two_equations_say(comm, shared_tmp_path):
    if comm.rank == 0:
        (shared_tmp_path / "constant.py").write_text(CONSTANT)
    comm.barrier()
    case = Case.parse(
        {
            "turbine": {"model": "rigid", "rotor_speed": "12.1 rpm", "blade_arm": "29.25 m"},
            "pitch": {"drive": "actuator"},
            "yaw": {"drive": "lock"},
            "drivetrain": TRAIN,
            "control": {"kind": f"python:{shared_tmp_path / 'constant.py'}:Constant"},
            "event": {"grid": {"kind": "grid_loss", "time": LOSS}},
            "loads": {"rotor_torque": TORQUE, "duration": DURATION, "gravity": 0.0},
            "time": {"step": DT, "end": END},
            "output": {"fields_every": 0.0},
        }
    )
    run_case(case, shared_tmp_path / "out", comm, "none")
    comm.barrier()
    history = read(shared_tmp_path / "out")
    J1, J2 = rotor_inertia(build_turbine(case, comm)), 97.0**2 * 534.116
    times, speed = history["time_[s]"], 12.1 * np.pi / 30.0
    k, d = 867.637e6, 6.215e6
    phi, w1, _ = integrate(J1, J2, k, d, 97.0, speed, times).T
    rotor = np.diff(history["angle_rotor_[rad]"]) / DT  # mean speed of each step
    start = np.concatenate([[speed], w1])
    # the error of the step: 3.4e-4 rad/s and 2.1e-4 rad, with half the step a quarter of it
    assert np.allclose(rotor, 0.5 * (start[1:] + start[:-1]), rtol=0.0, atol=4e-4)
    assert np.allclose(history["angle_shaft_[rad]"][1:], phi, rtol=0.0, atol=3e-4)
    lost = int(np.argmin(np.abs(times - LOSS)))
    assert w1[-1] > 1.04 * w1[lost]  # it does speed up
