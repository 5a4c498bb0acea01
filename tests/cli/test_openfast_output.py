"""``history.out`` of a run, as the wind community reads it."""

import csv

import numpy as np
import pytest
from openfast_io.FAST_output_reader import FASTOutputFile

ANGLES = ["Azimuth", "RotSpeed", "NacYaw", "BldPitch1", "BldPitch2", "BldPitch3"]
TIPS = [f"TipD{a}b{k}" for k in (1, 2, 3) for a in "xyz"]
TIPS += [f"TipClrnc{k}" for k in (1, 2, 3)]
LOADS = [f"Root{q}{a}b{k}" for k in (1, 2, 3) for q in "FM" for a in "xyz"]


def read(folder):
    """Columns of ``history.out`` and of ``history.csv`` without its first row, by name."""
    with (folder / "history.csv").open(newline="") as file:
        header, _, *rows = csv.reader(file)
    output = FASTOutputFile(str(folder / "history.out"))
    names, units = output.info["attribute_names"], output.info["attribute_units"]
    csv_columns = dict(zip(header, np.array(rows, dtype=float).T, strict=True))
    columns = dict(zip(names, output.data.T, strict=True))
    return columns, csv_columns, dict(zip(names, units, strict=True))


SETTINGS = ("output.fields_every=0", "loads.yaw_torque=-3.6e6")


@pytest.fixture(scope="module")
def folders(command_line, demo, tmp_path_factory):
    """Output folders of the stiff turbine on 1 and 2 ranks."""
    found = {}
    for ranks in (1, 2):
        found[ranks] = out = tmp_path_factory.mktemp("out")
        arguments = ("-o", out, "--progress", "none", "--set", "time.end=0.1", *SETTINGS)
        result = command_line("run", demo("hybrid_stiff.toml"), *arguments, ranks=ranks)
        assert result.returncode == 0, result.stderr
    return found


@pytest.fixture(scope="module")
def runs(folders):
    """What they hold."""
    return {ranks: read(out) for ranks, out in folders.items()}


@pytest.mark.slow
def test_channels_and_units_are_those_of_openfast(runs):
    out, _, units = runs[1]
    assert {"Time", *ANGLES, *TIPS, *LOADS} <= set(out)
    assert [units[name] for name in ("Time", *ANGLES)] == ["s", "deg", "rpm", *["deg"] * 4]
    assert {units[name] for name in TIPS} == {"m"}
    assert {units[name] for name in LOADS if name[4] == "F"} == {"kN"}
    assert {units[name] for name in LOADS if name[4] == "M"} == {"kN-m"}


def test_both_histories_say_the_same(runs):
    out, h, _ = runs[1]
    assert out["Time"] == pytest.approx(h["time_[s]"], rel=1e-12)
    azimuth = (np.degrees(h["angle_rotor_[rad]"]) - 120.0) % 360.0  # blade 2 is up at first
    digits = {"rel": 1e-6, "abs": 1e-15}  # seven digits are written
    assert out["Azimuth"] == pytest.approx(azimuth, **digits)
    assert out["NacYaw"] == pytest.approx(-np.degrees(h["angle_yaw_[rad]"]), **digits)
    for k in (1, 2, 3):
        tip = np.linalg.norm([out[f"TipD{a}b{k}"] for a in "xyz"], axis=0)
        assert tip == pytest.approx(h[f"tip_deflection_{k}_[m]"], rel=1e-6)
        assert out[f"TipClrnc{k}"] == pytest.approx(h[f"tip_clearance_{k}_[m]"], rel=1e-6)
        for a in "xyz":
            force, moment = h[f"root_force_{k}_{a}_[N]"], h[f"root_moment_{k}_{a}_[Nm]"]
            assert out[f"RootF{a}b{k}"] == pytest.approx(1e-3 * force, **digits)
            assert out[f"RootM{a}b{k}"] == pytest.approx(1e-3 * moment, **digits)


def test_signs_are_those_of_openfast(runs):
    """The weight, on average: the upright blade 2 presses onto the hub, the other two pull.

    Blade 1 hangs on the side of +e1, where its y axis points down, blade 3 opposite.
    """
    out = runs[1][0]
    mean = {name: values.mean() for name, values in out.items()}
    assert mean["RootFzb2"] < -100.0 < 100.0 < min(mean["RootFzb1"], mean["RootFzb3"])
    assert mean["TipDzb2"] < 0.0 < min(mean["TipDzb1"], mean["TipDzb3"])
    assert mean["RootFyb3"] < -100.0 < 100.0 < mean["RootFyb1"]
    assert mean["TipDyb3"] < 0.0 < mean["TipDyb1"]
    assert mean["RootMxb1"] < -100.0 < 100.0 < mean["RootMxb3"]  # z x y = -x
    assert mean["RotSpeed"] < 0.0 < out["Azimuth"][0] - 239.0  # the paper's torque


def test_ranks_agree(runs):
    reference = runs[1][1]
    columns = [c for c in reference if c.startswith("root_")]
    assert len(columns) == 18
    for kind in ("force", "moment"):
        mine = [c for c in columns if kind in c]
        scale = max(np.max(np.abs(reference[c])) for c in mine)
        worst = max(np.max(np.abs(runs[2][1][c] - reference[c])) for c in mine)
        assert worst <= 1e-9 * scale, (kind, worst / scale)


def test_the_rigid_turbine_has_angles_and_root_loads(command_line, demo, tmp_path):
    settings = ("time.end=0.04", "output.fields_every=0")
    result = command_line("run", demo("rigid.toml"), "-o", tmp_path, "--set", *settings)
    assert result.returncode == 0, result.stderr
    names = list(read(tmp_path)[0])
    others = [n for n in names if not n.startswith(("Root", "YawBr", "LSS", "Rot", "Gen"))]
    assert others == ["Time", *(n for n in ANGLES if n != "RotSpeed")]
    assert sum(n.startswith("Root") for n in names) == 18


def test_a_file_that_cannot_be_written_is_refused(command_line, demo, tmp_path):
    (tmp_path / "history.out").mkdir()
    result = command_line("run", demo("rigid.toml"), "-o", tmp_path)
    assert result.returncode == 2
    assert result.stderr.startswith(f"error: cannot write {tmp_path / 'history.out'}: ")


def test_a_restarted_run_goes_on_in_the_same_file(command_line, demo, folders, tmp_path):
    """Loads too: the middle of the first new step needs the state before it, which was stored."""
    begin = ("run", demo("hybrid_stiff.toml"), "-o", tmp_path)
    for command, end in (
        (begin, ("time.end=0.04", *SETTINGS)),
        (("restart", tmp_path), ["time.end=0.1"]),
    ):
        result = command_line(*command, "--set", *end)
        assert result.returncode == 0, result.stderr
    whole, parts = ((out / "history.out").read_text() for out in (folders[1], tmp_path))
    assert parts == whole
