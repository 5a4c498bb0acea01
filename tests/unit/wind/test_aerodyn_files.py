"""Claims about polars and blades in files of AeroDyn."""

import re

import numpy as np
import pytest

from turbine_fenicsx.case.files import hash_files
from turbine_fenicsx.foundation.errors import FileError, InputError
from turbine_fenicsx.turbine.tables.tables import Tables
from turbine_fenicsx.wind.aerodyn_files import (
    PolarColumns,
    read_aerodyn,
    read_aerodyn_blade,
    read_aerodyn_polar,
)

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


@pytest.mark.parametrize("number", ["1.5", "1e30", "0"])
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


WILD = """! remarks
3   NumAlf  ! rows
!    Alpha      Cl      Cd        Cm

-179.9999,    0.0,   4.07D-02,   0.0   at the back
# a remark of its own
   0.00    +.500   1.00d-2   -1E-1  ! behind a row

 179.9999    0.000   0.0407   0.0000 # 3 words more
"""


def test_a_polar_may_have_remarks_empty_lines_commas_and_fortran_numbers(write):
    polar = read_aerodyn_polar(write(WILD))
    assert np.degrees(polar.angle) == pytest.approx([-179.9999, 0.0, 179.9999])
    assert polar.lift.tolist() == [0.0, 0.5, 0.0]
    assert polar.drag.tolist() == [0.0407, 0.01, 0.0407]
    assert polar.moment.tolist() == [0.0, -0.1, 0.0]


def test_what_is_wrong_in_a_table_is_told_with_its_line(write):
    with pytest.raises(InputError, match=r"line 7: .*expected 4 numbers, got '0\.00 .* many'"):
        read_aerodyn_polar(write(WILD.replace("1.00d-2   -1E-1  ! behind a row", "many")))


def test_columns_of_a_polar_may_be_swapped_and_moments_left_out(write):
    polar = read_aerodyn_polar(write(POLAR), PolarColumns(Cl=3, Cd=2, Cm=0))
    assert polar.lift.tolist() == [0.0407, 0.01, 0.0407]
    assert polar.drag.tolist() == [0.0, 0.5, 0.0]
    assert not polar.moment.any()
    with pytest.raises(InputError, match="expected 5 numbers"):
        read_aerodyn_polar(write(POLAR), PolarColumns(Cm=5))


def test_columns_of_a_blade_are_found_by_their_names(write):
    lines = BLADE.splitlines()
    for k in (4, 6, 7, 8):  # BlCrvAng before the span, BlTwist last
        words = lines[k].split()
        words.insert(0, words.pop(3))
        words.append(words.pop(4))
        lines[k] = " ".join(words)
    polars = 2 * [read_aerodyn_polar(write(POLAR))]
    found = read_aerodyn_blade(write("\n".join(lines), "moved.dat"), 2.0, polars)
    plain = read_aerodyn_blade(write(BLADE, "blade.dat"), 2.0, polars)
    for what in ("radius", "twist", "chord", "prebend"):
        assert np.array_equal(getattr(found, what), getattr(plain, what))
    lines[4] = lines[4].replace("BlChord", "Chord")
    with pytest.raises(InputError, match="line 5: the table of the blade has no column BlChord"):
        read_aerodyn_blade(write("\n".join(lines), "moved.dat"), 2.0, polars)


def test_aerodynamic_centres_lie_where_the_file_has_them(write):
    polars = 2 * [read_aerodyn_polar(write(POLAR))]
    swept = BLADE.replace("10.0 -0.1 0.0", "10.0 -0.1 -0.5")
    blade = read_aerodyn_blade(write(swept, "blade.dat"), 2.0, polars)
    # from the reference on the span to the centre, towards the leading edge
    forward = (blade.reference - blade.aerodynamic_centre) * blade.chord
    theta = blade.twist
    assert blade.prebend - forward * np.sin(theta) == pytest.approx([0.0, -0.1, -0.4])
    assert -forward * np.cos(theta) == pytest.approx([0.0, -0.5, 0.0])
    steep = swept.replace("0.0 5.0 4.0", "0.0 61.0 4.0")
    with pytest.raises(InputError, match="below 60 degrees where BlSwpAC is not zero"):
        read_aerodyn_blade(write(steep, "blade.dat"), 2.0, polars)


@pytest.fixture
def primary(tmp_path, comm):
    """Write a primary file with settings above its list of polars."""

    def write(*settings, polar=POLAR, blades=("blade.dat",)):
        folder = tmp_path / f"{comm.rank}"
        folder.mkdir(exist_ok=True)
        (folder / "polar.dat").write_text(polar)
        (folder / "blade.dat").write_text(BLADE)
        (folder / "other.dat").write_text(BLADE.replace("4.0", "4.5"))
        names = [f'"{name}" ADBlFile({k + 1}) - a blade' for k, name in enumerate(blades)]
        polars = ["2 NumAFfiles - number", '"polar.dat" AFNames - names', '"polar.dat"']
        path = folder / "rotor.dat"
        path.write_text("\n".join(["--- AERODYN ---", *settings, *polars, *names, ""]))
        return path

    return write


def test_a_primary_file_says_where_coefficients_are(primary):
    path = primary("1 InCol_Alfa - column", "3 InCol_Cl", "2 InCol_Cd", "0 InCol_Cm")
    polar = read_aerodyn(path, 2.0).polars[0]
    assert polar.lift.tolist() == [0.0407, 0.01, 0.0407]
    assert not polar.moment.any()
    assert not read_aerodyn(primary("False UseBlCm"), 2.0).polars[0].moment.any()
    assert read_aerodyn(primary("True UseBlCm"), 2.0).polars[0].moment.any()


def test_blade_and_polars_are_parts_of_a_primary_file(primary):
    path = primary(blades=("blade.dat", "blade.dat", "unused"))
    data = {"aero": {"file": str(path)}}
    before = hash_files(data, Tables)
    for name in ("polar.dat", "blade.dat"):
        part = path.with_name(name)
        part.write_text(part.read_text() + "\n")
        assert hash_files(data, Tables) != before
        before = hash_files(data, Tables)


def test_tables_of_several_reynolds_numbers_are_refused_where_they_are_interpolated(primary):
    several = "3 NumTabs ! Reynolds numbers\n" + POLAR
    assert len(read_aerodyn(primary("1 AFTabMod", polar=several), 2.0).polars) == 3
    with pytest.raises(InputError, match=r"line 1: it has 3 tables, between which AFTabMod"):
        read_aerodyn(primary("2 AFTabMod", polar=several), 2.0)
    assert len(read_aerodyn(primary("2 AFTabMod"), 2.0).polars) == 3


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("9 AFTabMod", "line 2: AFTabMod must be 1, 2 or 3, got '9'"),
        ("x InCol_Cl", "line 2: InCol_Cl must be a number of a column from 1 to 100, got 'x'"),
        ("0 InCol_Cd", "line 2: InCol_Cd must be a number of a column from 1 to 100, got '0'"),
    ],
)
def test_settings_that_cannot_be_are_refused(primary, setting, words):
    with pytest.raises(InputError, match=words):
        read_aerodyn(primary(setting), 2.0)


def test_blades_that_differ_are_refused(primary):
    assert read_aerodyn(primary(blades=("blade.dat", "blade.dat")), 2.0)
    with pytest.raises(InputError, match=r"blade 'other.dat' differs from 'blade.dat'"):
        read_aerodyn(primary(blades=("blade.dat", "other.dat")), 2.0)
