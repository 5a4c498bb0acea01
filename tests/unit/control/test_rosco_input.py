"""Claims about input files of ROSCO: how the turbine is run, and the best ratio of a table."""

import numpy as np
import pytest

from turbine_fenicsx.control.rosco_input import read_best_ratio, read_rosco_input
from turbine_fenicsx.foundation.errors import FileError, InputError

INPUT = """! Controller parameter input file
{mode}          ! VS_ControlMode  - Generator torque control mode (0- none, 1- k*omega^2)
1          ! PS_Mode         - Pitch saturation mode
0.02       ! PC_FinePit	- Record 5: Below-rated pitch angle set-point, [rad]
120.0      ! PC_RefSpd	- Desired (reference) HSS speed for pitch controller, [rad/s].
94.0       ! VS_GenEff	- Generator efficiency [should match VS_RtPwr]
60.0       ! VS_MinOMSpd	- Minimum generator speed [rad/s]
5.0E+06    ! VS_RtPwr	- Wind turbine rated power [W]
7.5        ! VS_TSRopt	- Power-maximizing region 2 tip-speed-ratio
100.0      ! WE_GearboxRatio - Gearbox ratio [>=1],  [-]
"table.txt" ! PerfFileName - File containing rotor performance tables (Cp,Ct,Cq)
3          ! PS_BldPitchMin_N  - Number of values in minimum blade pitch lookup table
3.0 8.0 11.0     ! PS_WindSpeeds     - Wind speeds
0.06 0.0 0.05    ! PS_BldPitchMin    - Minimum blade pitch angles [rad]
"""


def write_table(folder):
    """C_P with its largest value at 8.2 and a pitch of 0, at 7.2 and a pitch of 2 degrees."""
    ratios, pitches = np.arange(4.0, 12.0, 0.5), np.array([-2.0, 0.0, 2.0])
    rows = [0.48 - 0.01 * (r - 8.2 + 0.5 * np.abs(pitches)) ** 2 for r in ratios]
    lines = ["# ----- Rotor performance tables -----", "# Pitch angle vector, 3 entries (deg)"]
    lines += [" ".join(map(str, pitches)), "# TSR vector, 16 entries", " ".join(map(str, ratios))]
    lines += ["# Wind speed vector", "10.7", "", "#  Power coefficient", ""]
    lines += [" ".join(f"{x:.8f}" for x in row) for row in rows]
    path = folder / "table.txt"
    path.write_text("\n".join([*lines, "", "#  Thrust coefficient", "", "0.5 0.5 0.5"]))
    return path


def write_input(folder, mode=2, old="", new=""):
    path = folder / "DISCON.IN"
    assert old in INPUT
    path.write_text(INPUT.replace(old, new).format(mode=mode) if old else INPUT.format(mode=mode))
    return path


def test_speeds_are_those_of_the_rotor_and_power_that_of_the_shaft(tmp_path):
    found = read_rosco_input(write_input(tmp_path))
    assert (found.least_speed, found.rated_speed) == pytest.approx((0.6, 1.2))
    assert found.rated_power == pytest.approx(5e6 / 0.94)
    assert (found.tip_speed_ratio, found.fine_pitch) == (7.5, 0.02)
    assert found.least_pitch.tolist() == [[3.0, 0.06], [8.0, 0.0], [11.0, 0.05]]
    old = "1          ! PS_Mode"
    assert not len(
        read_rosco_input(write_input(tmp_path, 2, old, old.replace("1", "0"))).least_pitch
    )


def test_a_torque_by_the_square_of_the_speed_takes_the_ratio_of_the_performance(tmp_path):
    path = write_table(tmp_path)
    assert read_best_ratio(path, 0.0) == pytest.approx(8.2)
    assert read_best_ratio(path, np.radians(2.0)) == pytest.approx(7.2)
    half = read_rosco_input(write_input(tmp_path, mode=1)).tip_speed_ratio
    assert 7.2 < half < 8.2


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("VS_RtPwr\t", "VS_Power\t", "is no input of ROSCO: it has no VS_RtPwr"),
        ("94.0 ", "0.0 ", "line 6: VS_GenEff must be positive, got 0"),
        ("3.0 8.0 11.0", "3.0 8.0", "line 13: expected 3 numbers, got '3.0 8.0"),
        ("3.0 8.0 11.0", "3.0 9.0 8.0", "PS_WindSpeeds must rise"),
        ("3          ! PS_B", "1e9        ! PS_B", "must be positive, at most 10000, got 1e"),
        ("120.0 ", "fast ", "line 5: expected a number, got 'fast"),
    ],
)
def test_wrong_files_are_refused(tmp_path, old, new, sentence):
    with pytest.raises(InputError) as error:
        read_rosco_input(write_input(tmp_path, 2, old, new))
    assert sentence in str(error.value)


def test_wrong_tables_of_performance_are_refused(tmp_path):
    path = write_input(tmp_path)
    with pytest.raises(
        InputError, match="is no file of ROSCO's performance: it has no pitch angle"
    ):
        read_best_ratio(path, 0.0)
    table = write_table(tmp_path)
    table.write_text(table.read_text().replace("-2.0 0.0 2.0", "2.0 0.0 -2.0"))
    with pytest.raises(InputError, match="pitch angles must rise"):
        read_best_ratio(table, 0.0)
    with pytest.raises(FileError, match=r"nothing\.txt"):
        read_best_ratio(tmp_path / "nothing.txt", 0.0)
