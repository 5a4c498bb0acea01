"""Claims about the table of OpenFAST's channels, and about how channels are chosen."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from aero_files import write_aerodyn

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records.names import split_unit
from turbine_fenicsx.records.openfast_names import AXES, find_row, list_equal, read_rows
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.components.openfast_channel import (
    choose_channels,
    choose_columns,
    in_openfast,
)
from turbine_fenicsx.turbine.run.run import make_stepper, turbine_channels

UNITS = {"-", "N", "N-m", "N/m", "W", "deg", "deg/s", "deg/s^2", "kN", "kN-m", "kW", "m", "m/s"}


def test_rows_of_the_table_are_whole_and_no_name_comes_twice():
    names = [name for row in read_rows() for equal in row.expand() for name in equal]
    assert len(names) == len(set(names)) > 500
    for row in read_rows():
        assert row.unit in UNITS | {"m/s^2", "m^2", "rpm"}
        assert row.axes in AXES and row.meaning and row.source
    assert find_row("RootMyc3").unit == "kN-m" and find_row("Nothing") is None
    assert list_equal("LSShftFxa") == ("RotThrust", "LSShftFxa", "LSShftFxs")


def test_a_turbine_has_every_channel_of_the_table_and_no_other(comm, tmp_path):
    case = Case.parse(
        {
            "turbine": {"model": "hybrid", "rotor_speed": "11 rpm"},
            "mesh": {"elements": [1, 1, 8]},
            "wind": {"speed": 9.0, "hub_height": 90.0},
            "aero": {"file": str(write_aerodyn(tmp_path)), "stations": 7},
            "tower": {"flexible": True, "elements": [3, 1, 2]},
            "pitch": {"bearings": True, "drive": "actuator"},
            "control": {"kind": "pi"},
            "output": {"fields_every": 0, "sections": [0.0, 0.4], "tower_sections": [0.5]},
        }
    )
    turbine = build_turbine(case, comm)
    stepper = make_stepper(case, turbine.system)
    channels = turbine_channels(turbine, stepper, stress=False).openfast
    given = [split_unit(column)[0] for channel in channels for column in channel.columns]
    known = [equal[0] for row in read_rows() for equal in row.expand()]
    assert len(given) == len(set(given))
    counts = {r"B\dN(\d+)": 7, r"Spn(\d+)": 2, r"TwHt(\d+)": 1}
    numbers = {name: [(re.match(x, name), n) for x, n in counts.items()] for name in known}
    assert set(given) == {
        name
        for name, found in numbers.items()
        if all(match is None or int(match[1]) <= n for match, n in found)
    }


def channel(*names):
    return in_openfast(names, lambda s: np.arange(1.0, 1.0 + len(names)))


def test_patterns_choose_columns_and_what_is_left_is_never_evaluated():
    def fail(snapshot):
        raise AssertionError

    snapshot = SimpleNamespace()
    given = [
        channel("RotThrust", "LSShftFys", "RotTorq"),
        in_openfast(("RotAccel",), fail),
        Channel(("Mine_[m]",), lambda s: [7.0]),
    ]
    chosen = choose_channels(given, ["lsshft*", "default"])
    columns = [c for x in chosen for c in x.columns]
    assert columns == [
        *(f"{n}_[kN]" for n in ("RotThrust", "LSShftFxa", "LSShftFxs", "LSShftFys")),
        *(f"{n}_[kN-m]" for n in ("RotTorq", "LSShftTq", "LSShftMxa", "LSShftMxs")),
        "Mine_[m]",
    ]
    values = [v for x in chosen for v in x.row(snapshot)]
    assert values == pytest.approx([*[1e-3] * 3, 2e-3, *[3e-3] * 4, 7.0])
    again = choose_columns(given, columns)
    assert [x.columns for x in again] == [x.columns for x in chosen]
    assert [c for x in choose_channels(given, []) for c in x.columns] == ["Mine_[m]"]
    with pytest.raises(InputError, match=r"output\.channels: this turbine has no .* 'TwrBs\*'"):
        choose_channels(given, ["default", "TwrBs*"])


def test_names_that_no_turbine_has_are_refused_with_the_nearest_one():
    with pytest.raises(InputError, match=r"output\.channels.*'RotThrst'.*mean 'RotThrust'"):
        Case.parse({"output": {"channels": ["default", "RotThrst"]}})


def test_statistics_need_a_time_after_the_transient():
    with pytest.raises(InputError, match=r"output\.transient = 20: expected less than time\.end"):
        Case.parse({"output": {"transient": 20.0}, "time": {"end": 10.0}})
