"""Claims about turbulence boxes: where each number of the files is in the wind, and when."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import FileError, InputError, ModelError
from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.mann import read_mann_box, write_mann_box

POINTS, SPACING = (64, 8, 6), (5.0, 20.0, 25.0)
MEAN = SteadyWind(10.0, 100.0, shear=0.2)
Y = 70.0 - 20.0 * np.arange(8)  # the first points of the files are at the left, positive y
Z = 37.5 + 25.0 * np.arange(6)


@pytest.fixture(scope="module")
def box():
    return np.random.default_rng(3).normal(size=(3, *POINTS)).astype("<f4")


@pytest.fixture
def paths(box, tmp_path):
    found = [tmp_path / f"{name}.bin" for name in "uvw"]
    for path, values in zip(found, box, strict=True):
        values.tofile(path)
    return found


def read(paths, **change):
    given = {"points": POINTS, "spacing": SPACING, "mean": MEAN, "periodic": True, **change}
    return read_mann_box(paths, **given)


def test_each_number_of_the_files_comes_through_the_rotor_once(paths, box):
    wind = read(paths)
    y, z = np.meshgrid(Y, Z, indexing="ij")
    for k in (0, 1, 37, 63):
        for x in (0.0, 15.0, -20.0):
            places = np.stack([np.full(y.shape, x), y, z], axis=-1)
            found = wind.velocity(places, time=(k * 5.0 + x) / 10.0)
            found = found - MEAN.velocity(places, 0.0)
            assert found == pytest.approx(np.moveaxis(box[:, k], 0, -1), abs=1e-6)


def test_a_box_that_is_written_is_the_one_that_was_read(paths, tmp_path):
    copies = [tmp_path / f"copy_{k}.bin" for k in "uvw"]
    write_mann_box(copies, read(paths))
    assert [x.read_bytes() for x in copies] == [x.read_bytes() for x in paths]


def test_a_periodic_box_begins_anew_and_another_one_ends(paths):
    place = np.array([[0.0, 3.0, 90.0]])
    periodic, once = read(paths), read(paths, periodic=False)
    assert periodic.velocity(place, 1.3) == pytest.approx(periodic.velocity(place, 33.3), rel=1e-6)
    # it leads by 7 s, the time of half its width
    assert once.velocity(place, 1.3) == pytest.approx(periodic.velocity(place, 8.3), rel=1e-6)
    with pytest.raises(InputError, match=r"the wind field lasts from -7 to 24.5 s"):
        once.velocity(place, 25.0)


def test_what_does_not_fit_the_run_or_the_rotor_is_said_with_sizes(paths):
    centre = np.array([-10.0, 0.0, 100.0])
    assert read(paths).list_mistakes(600.0, centre, 60.0) == []
    short = read(paths, periodic=False).list_mistakes(600.0, centre, 60.0)
    assert short[0].startswith("the wind field lasts 31.5 s, 582.5 s less than the run")
    narrow = read(paths).list_mistakes(1.0, centre, 80.0)
    assert "from 37.5 to 162.5 m above ground, the rotor from 20 to 180 m" in narrow[0]
    assert "140 m wide, the rotor 160 m" in narrow[1]


def test_fluctuations_can_be_scaled(paths):
    place = np.array([[3.0, 3.0, 90.0]])
    mean = MEAN.velocity(place, 0.0)
    plain, scaled = read(paths), read(paths, scale=(2.0, 0.0, 1.0))
    expected = (plain.velocity(place, 1.0) - mean) * [2.0, 0.0, 1.0]
    assert scaled.velocity(place, 1.0) - mean == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"points": (64, 8, 7)}, r"u.bin has 12288 bytes, but .* 64 x 8 x 7 points has 14336"),
        ({"points": (64, 8, 5)}, r"u.bin has 12288 bytes, but .* 64 x 8 x 5 points has 10240"),
        ({"points": (64, 8, 1)}, "points of a turbulence box must be whole, two or more"),
        ({"points": (64.5, 8, 6)}, "points of a turbulence box must be whole, two or more"),
        ({"points": (10**5, 10**4, 6)}, r"a turbulence box of 67.1 GiB is too large, at most 4"),
        (
            {"spacing": (5.0, 0.0, 1.0)},
            r"spacing of a turbulence box must be between 0.001 and 100000 m, got \(5",
        ),
        ({"spacing": (5.0, 1e-30, 1.0)}, "spacing of a turbulence box must be between"),
        ({"spacing": (5.0, 1.0)}, "spacing of a turbulence box must be three distances"),
        ({"scale": 2.0}, "scale of a turbulence box must be three factors, got 2.0"),
        ({"mean": SteadyWind(10.0, 100.0, direction=0.1)}, "must blow along x with a positive"),
        ({"mean": SteadyWind(0.0, 100.0)}, "must blow along x with a positive speed"),
    ],
)
def test_boxes_that_cannot_be_are_refused(paths, change, words):
    with pytest.raises((InputError, ModelError), match=words):
        read(paths, **change)


def test_files_that_are_no_box_are_refused(paths):
    with pytest.raises(ModelError, match="needs three files, of u, v and w"):
        read(paths[:2])
    with pytest.raises(ModelError, match="needs three files, of u, v and w"):
        read("uvw")
    np.full(POINTS, np.nan, dtype="<f4").tofile(paths[1])
    with pytest.raises(InputError, match=r"v.bin has values that are not finite"):
        read(paths)
    np.full(POINTS, -1e30, dtype="<f4").tofile(paths[1])
    with pytest.raises(InputError, match=r"v.bin has fluctuations of 1e\+30 m/s, at most 200 m/s"):
        read(paths)
    paths[1].unlink()
    with pytest.raises(FileError, match=r"v.bin"):
        read(paths)
