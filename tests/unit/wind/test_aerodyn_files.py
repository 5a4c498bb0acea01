"""Claims about polars and blades in files of AeroDyn."""

import re

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import FileError, InputError
from turbine_fenicsx.wind.aerodyn_files import read_aerodyn_blade, read_aerodyn_polar

POLAR = """! ------------ AirfoilInfo ------------
"DEFAULT"     InterpOrd
3   NumAlf            ! Number of data lines in the following table
!    Alpha      Cl      Cd        Cm
-180.00    0.000   0.0407   0.0000
   0.00    0.500   0.0100   -0.1
 180.00    0.000   0.0407   0.0000
"""
BLADE = """--- AERODYN v15 BLADE ---
A blade
======  Blade Properties ====
   3   NumBlNds
  BlSpn  BlCrvAC  BlSwpAC  BlCrvAng  BlTwist  BlChord  BlAFID
   (m)   (m)  (m)  (deg)  (deg)  (m)  (-)
0.0 0.0 0.0 0.0 13.0 3.5 1
10.0 -0.1 0.0 0.0 5.0 4.0 2
20.0 -0.4 0.0 0.0 0.0 1.0 2
"""


@pytest.fixture
def write(tmp_path, comm):
    def write(text, name="p.dat"):
        path = tmp_path / f"{comm.rank}_{name}"
        path.write_text(text)
        return path

    return write


def test_a_polar_is_read_in_radians(write):
    polar = read_aerodyn_polar(write(POLAR))
    assert polar.angle == pytest.approx([-np.pi, 0.0, np.pi])
    assert polar.lift.tolist() == [0.0, 0.5, 0.0]
    assert polar.moment.tolist() == [0.0, -0.1, 0.0]


def test_a_blade_is_read_with_its_polars(write):
    polars = [read_aerodyn_polar(write(POLAR)), read_aerodyn_polar(write(POLAR, "q.dat"))]
    blade = read_aerodyn_blade(write(BLADE, "blade.dat"), 2.0, polars)
    assert blade.radius == pytest.approx([2.0, 12.0, 22.0], abs=2e-4)
    assert blade.twist == pytest.approx(np.radians([13.0, 5.0, 0.0]))
    assert blade.chord.tolist() == [3.5, 4.0, 1.0]
    assert blade.prebend.tolist() == [0.0, -0.1, -0.4]
    assert blade.polars == (polars[0], polars[1], polars[1])
    assert blade.tip_radius == 22.0


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("NumAlf", "Number", "is no file of AeroDyn 15: it has no NumAlf"),
        ("3   NumAlf", "x   NumAlf", "NumAlf must be a number of rows that the file has, got 'x'"),
        (
            "3   NumAlf",
            "99   NumAlf",
            "NumAlf must be a number of rows that the file has, got '99'",
        ),
        ("0.500", "half", "a row of its table is wrong"),
        ("0.500", "nan", "has numbers that are not finite"),
        ("-180.00", "-90.00", "must go from -180 to 180 degrees, got -90 to 180"),
        ("   0.00    0.500   0.0100   -0.1\n", "", "must have 3 rows of at least 3 numbers"),
    ],
)
def test_files_that_are_no_polars_are_refused(write, old, new, words):
    assert old in POLAR
    with pytest.raises(InputError, match=words):
        read_aerodyn_polar(write(POLAR.replace(old, new)))


def test_a_blade_that_names_a_polar_too_many_is_refused(write):
    polar = read_aerodyn_polar(write(POLAR))
    with pytest.raises(InputError, match="names polar 2 in column BlAFID, but 1 polars are given"):
        read_aerodyn_blade(write(BLADE, "blade.dat"), 2.0, [polar])


@pytest.mark.parametrize("number", ["1.5", "1e308", "0"])
def test_a_blade_names_polars_by_whole_numbers(write, number):
    lines = BLADE.rstrip().split("\n")
    lines[-1] = f"{lines[-1].rsplit(maxsplit=1)[0]} {number}"
    polars = 2 * [read_aerodyn_polar(write(POLAR))]
    words = re.escape(f"names polar {float(number):g} in column BlAFID")
    with pytest.raises(InputError, match=words):
        read_aerodyn_blade(write("\n".join(lines), "blade.dat"), 2.0, polars)


@pytest.mark.parametrize("count", ["²", "9" * 5000])
def test_a_count_that_python_does_not_take_is_refused(write, count):
    with pytest.raises(InputError, match="NumAlf must be a number of rows"):
        read_aerodyn_polar(write(POLAR.replace("3   NumAlf", f"{count}   NumAlf")))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileError, match=r"cannot read .*none\.dat: No such file"):
        read_aerodyn_polar(tmp_path / "none.dat")
