"""Claims about functions of time."""

import pickle

import numpy as np
import pytest

from turbine_fenicsx.forces.time_functions import Constant, Hat, Ramp, Sine, Table


def test_hat_rises_to_its_peak_at_half_the_duration_and_falls_back():
    hat = Hat(-3.6e7, 3.0)
    assert hat(1.5) == -3.6e7
    for t in (0.3, 0.75, 1.2):
        assert hat(t) == pytest.approx(-3.6e7 * t / 1.5, rel=1e-15)
        assert hat(3.0 - t) == pytest.approx(hat(t), rel=1e-14)


def test_hat_is_exactly_zero_outside_its_duration():
    hat = Hat(2.0, 3.0)
    assert [hat(t) for t in (-1.0, -1e-9, 0.0, 3.0, 3.0 + 1e-9, 1e6)] == [0.0] * 6


def test_area_under_the_hat_is_half_peak_times_duration():
    t = (np.arange(3000) + 0.5) * 1e-3  # midpoint rule, exact as the kink lies on the grid
    assert sum(map(Hat(4.0, 3.0), t)) * 1e-3 == pytest.approx(6.0, rel=1e-13)


@pytest.mark.parametrize("duration", [0.0, -1.0, float("nan")])
def test_duration_of_a_hat_must_be_positive(duration):
    with pytest.raises(ValueError, match=f"duration of a hat function .* got {duration} s"):
        Hat(1.0, duration)


def test_constant_is_the_same_at_all_times():
    assert {Constant(2.5)(t) for t in (-1.0, 0.0, 1e9)} == {2.5}


@pytest.mark.parametrize("smooth", [False, True])
def test_ramp_is_zero_before_its_start_and_final_after_its_end(smooth):
    ramp = Ramp(-4.0, duration=0.5, start=1.0, smooth=smooth)
    assert [ramp(t) for t in (-1.0, 0.0, 1.0)] == [0.0] * 3
    assert [ramp(t) for t in (1.5, 1.5 + 1e-9, 1e9)] == [-4.0] * 3
    assert ramp(1.25) == pytest.approx(-2.0, rel=1e-15)
    assert Ramp(2.0, 4.0, smooth=smooth)(2.0) == pytest.approx(1.0, rel=1e-15)  # starts at zero


def test_ramp_is_a_straight_line():
    ramp = Ramp(3.0, 2.0, 0.5)
    assert [ramp(t) for t in (0.9, 1.7, 2.3)] == pytest.approx([0.6, 1.8, 2.7], rel=1e-15)


def test_smooth_ramp_has_two_continuous_derivatives_and_no_third_one():
    """Across both ends, one-sided differences over h = 1e-3 with an error of 60 h, 360 h; the
    second derivative is as large as 5.8 between, and the third one jumps by 60."""
    ramp, h = Ramp(1.0, 1.0, smooth=True), 1e-3
    for end, value in ((0.0, 0.0), (1.0, 1.0)):
        for side in (-1, 1):
            f = [ramp(end + side * k * h) for k in range(4)]
            assert f[0] == value
            assert abs(f[1] - f[0]) / h <= 11 * h**2
            assert abs(f[2] - 2 * f[1] + f[0]) / h**2 <= 61 * h
            third = abs(f[3] - 3 * f[2] + 3 * f[1] - f[0]) / h**3
            inside = (side > 0) == (end == 0.0)
            assert third == pytest.approx(60.0 if inside else 0.0, abs=1.0 if inside else 1e-6)


def test_smooth_ramp_rises_throughout_and_as_steeply_as_said():
    t = np.linspace(0.0, 1.0, 2001)
    slopes = np.diff([Ramp(1.0, 1.0, smooth=True)(x) for x in t]) / np.diff(t)
    assert np.all(slopes > 0)
    assert np.max(slopes) == pytest.approx(15 / 8, rel=1e-6)


def test_sine_has_its_amplitude_frequency_and_phase():
    sine = Sine(2.0, 5.0)
    assert [sine(t) for t in (0.0, 0.05, 0.15)] == pytest.approx([0.0, 2.0, -2.0], abs=1e-14)
    assert sine(0.33) == pytest.approx(sine(0.33 + 1 / 5.0), abs=1e-13)
    assert sine(1 / 60) == pytest.approx(1.0, rel=1e-14)  # sin(30 deg) = 1/2
    assert Sine(2.0, 5.0, np.pi / 2)(0.0) == 2.0
    assert Sine(2.0, 5.0, 0.3)(0.01) == pytest.approx(2.0 * np.sin(0.1 * np.pi + 0.3), rel=1e-15)


def test_table_interpolates_between_its_points_and_holds_its_ends():
    table = Table([-1.0, 0.5, 2.0], [3.0, -1.0, -1.0])
    assert [table(t) for t in (-1.0, 0.5, 2.0)] == [3.0, -1.0, -1.0]
    assert [table(t) for t in (-0.25, 0.125)] == pytest.approx([1.0, 0.0], abs=1e-15)
    assert [table(t) for t in (-1e9, -1.0 - 1e-9, 1.234, 2.0 + 1e-9, 1e9)] == [3, 3, -1, -1, -1]
    assert {Table([1.0], [7.0])(t) for t in (0.0, 1.0, 2.0)} == {7.0}


def test_table_agrees_with_numpy():
    rng = np.random.default_rng(3)
    times, values = np.cumsum(rng.uniform(0.1, 1.0, 30)), rng.normal(size=30)
    table = Table(times, values)
    for t in (*rng.uniform(-1.0, times[-1] + 1.0, 200), *times):
        assert table(t) == pytest.approx(np.interp(t, times, values), rel=1e-12, abs=1e-14)


def test_table_keeps_its_own_numbers():
    times, values = np.array([0.0, 1.0]), np.array([0.0, 2.0])
    table = Table(times, values)
    values[1] = 5.0
    assert table(1.0) == 2.0 and isinstance(table(1.0), float)
    assert table == Table((0, 1), (0, 2)) and hash(table) == hash(Table([0, 1], [0, 2]))


@pytest.mark.parametrize(
    "text",
    [
        "0 0\n1.5 -2e3\n",
        "0,0\n1.5,-2e3",
        "0; 0\r\n1.5 ;-2e3\r\n",
        "0\t0\n  1.5\t-2e3  \n",
        "# torque of the crane\n\ntime,torque\n0,0 # rest\n\n1.5,-2e3\n",
        "time [s], torque [Nm]\n0, 0\n1.5, -2e3",
        "\ufeff0,0\n1.5,-2e3",
    ],
)
def test_table_is_read_from_a_file(tmp_path, text):
    path = tmp_path / "torque.csv"
    path.write_text(text, encoding="utf-8", newline="")
    assert Table.read(path) == Table.read(str(path)) == Table((0.0, 1.5), (0.0, -2000.0))


@pytest.mark.parametrize(
    ("text", "mistake"),
    [
        ("0 0\n1 2 3\n", r", line 2: expected a time and a value, got '1 2 3'"),
        ("# one\n\n0,0\n1\n", r", line 4: expected a time and a value, got '1'"),
        ("0,0\n1,,2\n", r", line 2: expected a time and a value, got '1,,2'"),
        ("0;0\n0,5;1,2\n", r", line 2: expected a time and a value, got '0,5;1,2'"),
        ("0 0\ntime torque\n", r", line 2: expected a time and a value, got 'time torque'"),
        ("time\ntorque\n0 0\n", r", line 2: expected a time and a value, got 'torque'"),
        ("0 O\n1 1\n", r", line 1: expected a time and a value, got '0 O'"),
        ("time torque\n", r": table needs at least one time and value, got none"),
        ("", r": table needs at least one time and value, got none"),
        ("0 0\n2 1\n2 3", r": times .* increase, got 2\.0 s after 2\.0 s as number 3"),
        ("0 0\nnan 1\n", r": time 2 of a table must be a number, got nan s"),
        ("0 0\n1 inf\n", r": value 2 of a table must be a number, got inf"),
    ],
)
def test_mistakes_in_a_file_are_named_with_their_place(tmp_path, text, mistake):
    path = tmp_path / "torque.txt"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=f"torque.txt{mistake}$"):
        Table.read(path)


def test_file_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "torque.bin"
    path.write_bytes(b"\x00\xff\xfe\x93")
    with pytest.raises(ValueError, match=r"torque.bin: this is no text file"):
        Table.read(path)
    with pytest.raises(FileNotFoundError, match=r"torque.csv"):
        Table.read(tmp_path / "torque.csv")


NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("make", "mistake"),
    [
        (lambda: Ramp(1.0, 0.0), r"duration of a ramp must be positive, got 0.0 s"),
        (lambda: Ramp(1.0, -1.0), r"duration of a ramp must be positive, got -1.0 s"),
        (lambda: Ramp(1.0, NAN), r"duration of a ramp must be positive, got nan s"),
        (lambda: Ramp(1.0, INF), r"duration of a ramp must be positive, got inf s"),
        (lambda: Ramp(NAN, 1.0), r"final value of a ramp must be a number, got nan"),
        (lambda: Ramp(1.0, 1.0, -INF), r"start of a ramp must be a number, got -inf s"),
        (lambda: Sine(1.0, 0.0), r"frequency of a sine must be positive, got 0.0 Hz"),
        (lambda: Sine(1.0, -2.0), r"frequency of a sine must be positive, got -2.0 Hz"),
        (lambda: Sine(1.0, INF), r"frequency of a sine must be positive, got inf Hz"),
        (lambda: Sine(INF, 1.0), r"amplitude of a sine must be a number, got inf"),
        (lambda: Sine(1.0, 1.0, NAN), r"phase of a sine must be a number, got nan rad"),
        (lambda: Table([0.0, 1.0], [1.0]), r"one value per time, got 2 times and 1 values"),
        (lambda: Table([], []), r"at least one time and value, got none"),
        (lambda: Table([0, 2, 1], [0, 0, 0]), r"got 1.0 s after 2.0 s as number 3"),
        (lambda: Table([0, NAN], [0, 0]), r"time 2 of a table must be a number, got nan s"),
        (lambda: Table([0, 1], [INF, 0]), r"value 1 of a table must be a number, got inf"),
    ],
)
def test_data_that_make_no_sense_are_refused(make, mistake):
    with pytest.raises(ValueError, match=f"{mistake}$"):
        make()


@pytest.mark.parametrize(
    "function",
    [Hat(1.0), Constant(2.0), Ramp(1.0, 2.0), Sine(1.0, 2.0), Table([0, 1], [2, 3])],
    ids=lambda function: type(function).__name__,
)
def test_functions_of_time_are_values(function):
    """Equal, hashable, unchangeable, and can be sent to other ranks."""
    copy = pickle.loads(pickle.dumps(function))
    assert copy == function and hash(copy) == hash(function)
    with pytest.raises(AttributeError):
        function.value = 3.0
