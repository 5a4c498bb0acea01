"""The NREL 5 MW turbine under control: where rotor, pitch and power come to rest in steady wind.

The rotor is one inertia with the torque of steady blade-element momentum theory. The expected
numbers are those of ROSCO 2.10.6 on such a rotor.
"""

from mpi4py import MPI

import numpy as np
import pytest
from rosco_blades import nrel_blade, without_moments
from rosco_files import rosco_files

from turbine_fenicsx.control.discon import Discon
from turbine_fenicsx.control.foreign import ForeignController
from turbine_fenicsx.control.interface import Measurements
from turbine_fenicsx.control.pi import PIController
from turbine_fenicsx.wind.rotor import Operation, Rotor, find_performance

RPM, RATIO, INERTIA, EFFICIENCY = np.pi / 30.0, 97.0, 43702538.057, 0.944
DT, END = 0.1, 120.0

# wind [m/s]: grid of rotor speeds [rpm] and pitch angles [deg] that the turbine stays in
GRIDS = {
    8.0: ((8.0, 9.0, 9.6, 10.5), (0.0, 0.5, 1.0)),
    12.0: ((11.0, 11.7, 12.4, 13.2), (1.0, 2.5, 3.5, 4.5, 6.0, 8.0)),
    18.0: ((11.0, 11.7, 12.4, 13.2), (12.5, 14.0, 15.0, 16.0, 18.0)),
}
# rotor speed [rpm], pitch [deg], electrical power [MW]
EXPECTED = {8.0: (9.23, 0.0, 1.793), 12.0: (12.10, 3.92, 5.0), 18.0: (12.10, 14.94, 5.0)}


@pytest.fixture(scope="module")
def torque_tables():
    """Aerodynamic torque [N m] over rotor speed and pitch, by wind speed."""
    rotor = Rotor(without_moments(nrel_blade()), precone=np.radians(2.5), hub_height=90.0)
    return {
        wind: [
            [
                find_performance(rotor, Operation(wind, w * RPM, np.radians(p)), sectors=1).torque
                for p in pitches
            ]
            for w in speeds
        ]
        for wind, (speeds, pitches) in GRIDS.items()
    }


def make_controller(kind, folder):
    if kind == "pi":
        return PIController()
    library, infile = rosco_files()
    return ForeignController(MPI.COMM_SELF, lambda: Discon(library, infile, folder), "ROSCO")


def settle(controller, wind, table):
    """Rotor speed [rpm], pitch [deg] and power [MW] after the start of a run.

    The pitch drives follow at once.
    """
    from scipy.interpolate import RectBivariateSpline

    speeds, pitches = GRIDS[wind]
    kx, ky = min(3, len(speeds) - 1), min(2, len(pitches) - 1)
    torque_of = RectBivariateSpline(speeds, pitches, table, kx=kx, ky=ky)
    w, pitch = 0.97 * EXPECTED[wind][0] * RPM, np.radians(max(EXPECTED[wind][1] - 0.7, 0.0))
    generator_torque, power = 0.0, 0.0
    for k in range(int(END / DT)):
        measured = Measurements(
            k * DT,
            DT,
            k == 0,
            RATIO * w,
            w,
            0.0,
            (pitch,) * 3,
            generator_torque,
            power,
            wind,
        )
        commands = controller.command(measured)
        generator_torque, pitch = commands.generator_torque, commands.pitch[0]
        power = EFFICIENCY * generator_torque * RATIO * w
        Q = float(torque_of(w / RPM, np.degrees(pitch))[0, 0])
        w += DT * (Q - RATIO * generator_torque) / INERTIA
    controller.finish()
    return w / RPM, np.degrees(pitch), 1e-6 * power


@pytest.mark.parametrize("wind", GRIDS)
@pytest.mark.parametrize("kind", ["discon", "pi"])
def test_speed_pitch_and_power_are_those_that_are_known(kind, wind, torque_tables, tmp_path):
    speed, pitch, power = settle(make_controller(kind, tmp_path), wind, torque_tables[wind])
    expected = EXPECTED[wind]
    assert abs(speed - expected[0]) < 0.05
    assert abs(pitch - expected[1]) < 0.1
    assert abs(power / expected[2] - 1.0) < 5e-3
