"""Claims about files of BeamDyn: axis, twist, matrices, damping, and what is refused."""

import numpy as np
import pytest
from beamdyn_files import INERTIA, KEY_POINTS, STIFFNESS, write_beamdyn

from turbine_fenicsx.beam_files.beamdyn import list_parts, read_beamdyn
from turbine_fenicsx.foundation.errors import FileError, InputError


def test_the_axis_and_the_directors_are_those_of_the_file(tmp_path):
    blade = read_beamdyn(write_beamdyn(tmp_path))
    assert blade.line.length == pytest.approx(10.0)
    s = np.array([0.0, 2.5, 10.0])
    r, d = blade.line.at(s)
    assert r == pytest.approx(np.outer(s, [0.0, 0.0, 1.0]), abs=1e-12)
    phi = np.radians(9.0 * s)  # twist turns sections by -phi about z
    wanted = np.column_stack([np.cos(phi), -np.sin(phi), 0.0 * phi])
    assert d[:, 0] == pytest.approx(wanted, abs=1e-9)
    assert np.array_equal(blade.sections.stations, [0.0, 10.0])
    assert np.array_equal(blade.sections.stiffness, [STIFFNESS, STIFFNESS])
    assert np.array_equal(blade.sections.inertia, [INERTIA, INERTIA])
    assert tuple(blade.sections.viscosity) == (1e-3, 1.1e-3, 1.2e-3, 1.4e-3, 2.2e-3, 2.2e-3)
    assert blade.warnings == ()


def test_sections_of_a_bent_axis_are_at_right_angles_to_it(tmp_path):
    z = np.linspace(0.0, 10.0, 9)
    bent = np.column_stack([0.02 * z**2, -0.01 * z**2, z, 10.0 - z])
    line = read_beamdyn(write_beamdyn(tmp_path, bent)).line
    s = np.linspace(0.0, line.length, 7)
    r, d = line.at(s)
    step = 1e-5
    t = (line.at(s[1:-1] + step)[0] - line.at(s[1:-1] - step)[0]) / (2.0 * step)
    assert np.abs(np.einsum("kai,ki->ka", d[1:-1], t)).max() < 1e-7
    assert r[-1] == pytest.approx([2.0, -1.0, 10.0], abs=1e-9)


def test_three_key_points_make_the_axis_of_bd_curved_beam(tmp_path):
    """Length and nodes of the summary that BeamDyn writes of this test."""
    points = [[0.0, 0.0, 0.0, 0.0], [7.61205, 0.0, 38.2683, 0.0], [29.2893, 0.0, 70.7107, 0.0]]
    line = read_beamdyn(write_beamdyn(tmp_path, points)).line
    assert line.length == pytest.approx(78.566, abs=1e-3)
    r = line.at(np.linspace(0.0, line.length, 2000))[0]
    for x, z in ((-0.0923219, 2.3334), (6.34916, 35.3554), (22.9428, 63.0910)):
        assert np.interp(z, r[:, 2], r[:, 0]) == pytest.approx(x, abs=2e-4)


def test_what_is_not_followed_is_said(tmp_path):
    blade = read_beamdyn(write_beamdyn(tmp_path, kind=2, actuator="True"))
    assert [sentence.split(": ")[1] for sentence in blade.warnings] == [
        "UsePitchAct is left out; [pitch] says how blades pitch",
        "damping of modes (damp_type = 2) is left out",
    ]
    assert not np.any(blade.sections.viscosity)
    assert list_parts(tmp_path / "bar.dat") == [str(tmp_path / "bar_blade.dat")]


def cut(text):
    """Leave the last five rows out."""
    return "\n".join(text.rstrip().splitlines()[:-5])


SKEW = STIFFNESS.copy()
SKEW[0, 1] = 1e9


@pytest.mark.parametrize(
    ("files", "change", "sentence"),
    [
        ({"points": KEY_POINTS[:2]}, None, "line 8: kp_total must be 3 or more, got 2"),
        (
            {"points": (*KEY_POINTS, KEY_POINTS[-1])},
            None,
            "kp_zr of key points must rise, it is 10 m at 3",
        ),
        (
            {"matrices": ((0.0, STIFFNESS, INERTIA), (0.9, STIFFNESS, INERTIA))},
            None,
            "stations must rise from 0 to 1, got 0 to 0.9",
        ),
        (
            {"matrices": ((0.0, STIFFNESS, INERTIA), (1.0, SKEW, INERTIA))},
            None,
            "stiffness of the beam at 10 m is not symmetric: entry 1, 2",
        ),
        ({}, cut, "expected 2 stations with two matrices of 6 rows each, and it ends in station 2"),
        ({}, lambda t: t.replace("2.500000000E+10", "x", 1), "line 14: expected 6 numbers, got"),
        ({}, lambda t: t.replace("Distributed", "Other"), "it has no distributed properties"),
        ({}, lambda t: t.replace("station_total", "stations"), "no file of BeamDyn: it has no"),
    ],
)
def test_wrong_files_are_refused_with_line_or_station(tmp_path, files, change, sentence):
    path = write_beamdyn(tmp_path, **files)
    if change is not None:
        blade = tmp_path / "bar_blade.dat"
        blade.write_text(change(blade.read_text()))
    with pytest.raises(InputError) as caught:
        read_beamdyn(path)
    assert sentence in str(caught.value)


def test_a_missing_blade_file_is_named(tmp_path):
    path = write_beamdyn(tmp_path)
    (tmp_path / "bar_blade.dat").unlink()
    with pytest.raises((InputError, FileError), match=r"bar_blade\.dat"):
        read_beamdyn(path)
