"""Claims about turbulent wind from files of TurbSim."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import FileError, InputError
from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.turbsim import (
    HEADER,
    read_turbsim,
    read_turbsim_height,
    write_turbsim,
)
from turbine_fenicsx.wind.turbulent_wind import carry_box

N_T, N_Z, N_Y, N_TOWER = 50, 5, 4, 2
DT, DZ, DY, SPEED, BOTTOM = 0.25, 20.0, 30.0, 12.0, 60.0
RANGE = 40.0


def field(seed=0):
    """Velocities, shape (times, heights, widths, 3), that whole numbers of the file can be."""
    steps = np.random.default_rng(seed).integers(-20000, 20000, (N_T, N_Z, N_Y, 3))
    return steps * RANGE / 65536.0


def write(path, values, *, kind=7, cut=0, **change):
    head = np.zeros(1, HEADER)
    text = b"made by a test"
    given = {
        **{"kind": kind, "n_z": N_Z, "n_y": N_Y, "n_tower": N_TOWER, "n_t": N_T, "dz": DZ},
        **{"dy": DY, "dt": DT, "u_hub": SPEED, "z_hub": 100.0, "z_bottom": BOTTOM},
        **{"scales": [[65536.0 / RANGE, 0.0]] * 3, "n_text": len(text), **change},
    }
    for name, value in given.items():
        head[name] = value
    raw = np.round(values * 65536.0 / RANGE).astype("<i2").reshape(N_T, -1)
    rows = np.concatenate([raw, np.full((N_T, 3 * N_TOWER), 7, "<i2")], axis=1)
    content = head.tobytes() + text + rows.tobytes()
    path.write_bytes(content[: len(content) - cut])
    return path


def points():
    """Places of the grid at x = 0, shape (heights, widths, 3)."""
    y = (np.arange(N_Y) - 1.5) * DY
    z = BOTTOM + np.arange(N_Z) * DZ
    return np.stack(np.broadcast_arrays(0.0, y[None, :], z[:, None]), axis=-1)


def test_on_its_grid_the_wind_is_that_of_the_file(tmp_path, comm):
    values = field(comm.rank)
    wind = read_turbsim(write(tmp_path / f"{comm.rank}.bts", values))
    assert wind.lead == pytest.approx(45.0 / SPEED)  # half the width
    for k in (15, 16, 48):
        found = wind.velocity(points(), k * DT - wind.lead)
        assert found == pytest.approx(values[k], abs=1e-6)


@pytest.mark.parametrize("kind", [7, 8])
def test_a_place_that_is_no_number_has_a_wind_that_is_none(tmp_path, comm, kind):
    """As in an attempt of a step that diverges."""
    wind = read_turbsim(write(tmp_path / f"{comm.rank}.bts", field(), kind=kind))
    places = np.array([[0.0, 0.0, 100.0], [np.nan, np.nan, np.nan]])
    with np.errstate(invalid="ignore"):
        here, nowhere = wind.velocity(places, 1.0)
    assert here == pytest.approx(wind.velocity(places[0], 1.0))
    assert np.isnan(nowhere).all()


def test_a_field_is_looked_up_where_it_lies_in_memory(tmp_path, comm):
    wind = read_turbsim(write(tmp_path / f"{comm.rank}.bts", field()))
    assert np.shares_memory(wind.values.reshape(-1, 3), wind.values)


def test_between_points_it_is_linear_and_moves_with_the_mean_wind(tmp_path, comm):
    values = field(comm.rank)
    wind = read_turbsim(write(tmp_path / f"{comm.rank}.bts", values))
    place = np.array([0.0, -1.5 * DY + 0.25 * DY, BOTTOM + 1.5 * DZ])
    corners = 0.5 * (values[20, 1] + values[20, 2])
    expected = 0.75 * corners[0] + 0.25 * corners[1]
    time = 20 * DT - wind.lead
    assert wind.velocity(place, time) == pytest.approx(expected, abs=1e-6)
    downwind = place + np.array([SPEED * 3.0, 0.0, 0.0])
    assert wind.velocity(downwind, time + 3.0) == pytest.approx(expected, abs=1e-6)


def test_openfast_io_reads_the_same(tmp_path, comm):
    module = pytest.importorskip("openfast_io.turbsim_file")
    path = write(tmp_path / f"{comm.rank}.bts", field())
    theirs, ours = module.TurbSimFile(str(path)), read_turbsim(path)
    found = np.moveaxis(theirs["u"], 0, -1).swapaxes(1, 2)  # theirs: 3, times, widths, heights
    assert (ours.values - ours.intercept) / ours.slope == pytest.approx(found, abs=1e-5)
    assert ours.y == pytest.approx(theirs["y"]) and ours.z == pytest.approx(theirs["z"])


def test_a_periodic_field_goes_on_for_ever(tmp_path, comm):
    values = field()
    wind = read_turbsim(write(tmp_path / f"{comm.rank}.bts", values, kind=8))
    assert wind.lead == 0.0 and wind.duration == N_T * DT
    late = 7 * wind.duration + 3 * DT
    assert wind.velocity(points(), late) == pytest.approx(values[3], abs=1e-6)
    last = wind.velocity(points(), (N_T - 0.5) * DT)
    assert last == pytest.approx(0.5 * (values[-1] + values[0]), abs=1e-6)


def test_beside_the_grid_is_its_edge_and_below_the_wind_falls_to_the_ground(tmp_path, comm):
    values = field()
    wind = read_turbsim(write(tmp_path / f"{comm.rank}.bts", values, kind=8))
    outside = np.array([[0.0, 500.0, 500.0], [0.0, -500.0, 30.0], [0.0, 0.0, 0.0]])
    found = wind.velocity(outside, 0.0)
    assert found[0] == pytest.approx(values[0, -1, -1])
    assert found[1] == pytest.approx(0.5 * values[0, 0, 0])
    assert not np.any(found[2])


def test_a_run_or_a_rotor_that_the_field_does_not_cover_is_named(tmp_path, comm):
    wind = read_turbsim(write(tmp_path / f"{comm.rank}.bts", field()))
    assert wind.list_mistakes(5.0, np.array([0.0, 0.0, 100.0]), 40.0) == []
    too_long, too_low, too_wide = wind.list_mistakes(60.0, np.array([0.0, 0.0, 95.0]), 50.0)
    assert "lasts 12.25 s" in too_long
    assert (
        too_low == "the wind field goes from 60 to 140 m above ground, the rotor from 45 to 145 m"
    )
    assert too_wide == "the wind field is 90 m wide, the rotor 100 m"
    with pytest.raises(InputError, match=r"lasts from -3.75 to 8.5 s; at 9 s the turbine needs"):
        wind.velocity(np.array([0.0, 0.0, 100.0]), 9.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"kind": 3}, "no full-field file of TurbSim: it begins with 3, expected 7 or 8"),
        ({"cut": 10}, "is cut off: it has 49 of the 50 planes"),
        ({"n_y": 1}, "n_y must be at least 2, got 1"),
        ({"n_t": 2**31 - 1, "n_y": 4000, "n_z": 4000}, "GiB, at most 4 are read"),
        ({"n_tower": 2**31 - 1}, "GiB, at most 4 are read"),
        ({"n_tower": 10**6}, "is cut off: it has 0 of the 50 planes"),
        ({"dt": 0.0}, "dt must be between 1e-06 and 1e"),
        ({"dt": 1e30}, "dt must be between .* s, got 1e"),
        ({"dy": 1e-30}, "dy must be between 0.001 and 100000 m, got 1e-30"),
        ({"u_hub": np.nan}, "u_hub must be between 0.01 and 200 m/s, got nan"),
        ({"u_hub": 1e30}, "u_hub must be between .* m/s, got 1e"),
        ({"z_hub": np.nan}, "z_hub must be between 0 and 10000 m, got nan"),
        ({"z_bottom": np.inf}, "z_bottom must be between -10000 and 10000 m, got inf"),
        ({"scales": np.zeros((3, 2))}, "slopes of its velocities must be finite and not zero"),
        (
            {"scales": np.array([[1e-6, 0.0]] * 3)},
            "has a wind of .* m/s, at most 200 m/s are taken",
        ),
        ({"n_text": -5}, "n_text must be at least 0, got -5"),
    ],
)
def test_files_that_are_none_are_refused(tmp_path, comm, change, words):
    path = write(tmp_path / f"{comm.rank}.bts", field(), **change)
    with pytest.raises(InputError, match=words):
        read_turbsim(path)


def test_files_that_are_short_or_missing_are_refused(tmp_path, comm):
    path = tmp_path / f"{comm.rank}.bts"
    with pytest.raises(FileError, match="cannot read"):
        read_turbsim(path)
    path.write_bytes(b"\x07\x00")
    with pytest.raises(InputError, match="it is too short"):
        read_turbsim(path)


@pytest.mark.parametrize("periodic", [True, False])
def test_a_wind_that_is_written_is_read_by_us_and_by_openfast(tmp_path, periodic):
    file = pytest.importorskip("openfast_io.turbsim_file").TurbSimFile
    values = np.random.default_rng(1).normal(size=(24, 5, 4, 3)).astype(np.float32)
    wind = carry_box(values, (3.0, DY, DZ), SteadyWind(SPEED, 100.0, shear=0.2), periodic)
    path = tmp_path / "box.bts"
    write_turbsim(path, wind, "made for a test")
    again, theirs = read_turbsim(path), file(str(path))
    assert (again.periodic, again.lead) == (periodic, pytest.approx(wind.fluctuations.lead))
    assert read_turbsim_height(path) == 100.0
    places = points()
    for k in (5, 11, 20):
        time = k * DT - again.lead
        assert again.velocity(places, time) == pytest.approx(wind.velocity(places, time), abs=1e-3)
        # components, times, widths, heights
        planes = np.moveaxis(theirs["u"][:, k], 0, -1).transpose(1, 0, 2)
        assert again.velocity(places, time) == pytest.approx(planes, abs=1e-3)
    assert theirs["zRef"] == 100.0 and theirs["uRef"] == SPEED and "made for" in theirs["info"]
