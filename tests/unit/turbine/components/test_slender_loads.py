"""Claims about loads in sections of blades and towers: at the ends they are known.

Beam blades are tested with their turbine, and what loads balance with `OutboardLoads`.
"""

from pathlib import Path

import numpy as np
import pytest
from windio_files import small_turbine, write_turbine

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records.output_folder import read_history
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.run.run import run_case

FILE = {"file": "small.yaml"}
KINDS = {
    "full": {"mesh": {"elements": [1, 1, 6]}},
    "reduced": {"turbine": FILE, "blade": {"model": "reduced"}, "tower": {"model": "reduced"}},
    "rigid": {"turbine": {"model": "rigid"}, "tower": {"model": "beam"}},
}


@pytest.fixture(scope="module", params=KINDS)
def seen(request, comm, tmp_path_factory):
    """History and folder of a tilted rotor that turns under its weight, and the kind of blades."""
    folder = Path(comm.bcast(str(tmp_path_factory.mktemp("slender"))))
    on_rank0(comm, lambda: write_turbine(small_turbine(), folder))
    case = {
        "turbine": {"tilt": "-5 deg", "rotor_speed": "10 rpm"},
        "tower": {"flexible": True, "elements": [4, 1, 4], "top_mass": 5e3},
        "mesh": {"span": 5, "around": 16},
        "time": {"step": 0.02, "end": 0.1, "start": "turning"},
        "output": {"fields_every": 0.0, "tower_sections": [0.0, 0.5, 1.0]},
    }
    if request.param != "rigid":
        case["output"]["sections"] = [0.0, 0.45, 1.0]
    for table, keys in KINDS[request.param].items():
        case[table] = case.get(table, {}) | keys
    run_case(Case.parse(case, folder), folder / "out", comm, progress="none")
    return read_history(folder / "out" / "history.csv").columns, folder / "out", request.param


def vectors(history, name, unit):
    """Vectors of all rows after the first."""
    return np.column_stack([history[f"{name}_{axis}_[{unit}]"][1:] for axis in "xyz"])


@pytest.mark.parallel
def test_at_the_root_they_are_those_of_the_root_and_at_the_tip_none(seen):
    history, _, kind = seen
    if kind == "rigid":
        pytest.skip("rigid blades have no sections")
    for blade in (1, 2, 3):
        for what, unit in (("force", "N"), ("moment", "Nm")):
            root = vectors(history, f"root_{what}_{blade}", unit)
            found, outer, tip = (
                vectors(history, f"section_{what}_{blade}_at_{place}", unit)
                for place in ("0", "0.45", "1")
            )
            size = np.abs(root).max()
            assert np.allclose(found, root, rtol=0.0, atol=1e-5 * size)
            assert np.abs(outer - root).max() > 0.05 * size
            assert np.abs(tip).max() < 1e-3 * size


@pytest.mark.parallel
def test_the_tower_carries_what_is_above(seen):
    history, _, kind = seen
    for what, unit in (("force", "N"), ("moment", "Nm")):
        base = vectors(history, f"tower_base_{what}", unit)
        found, middle, top = (
            vectors(history, f"tower_{what}_at_{place}", unit) for place in ("0", "0.5", "1")
        )
        close = (0.05 if kind == "rigid" else 1e-3) * np.abs(base).max()
        assert np.allclose(found, base, rtol=0.0, atol=close)
        if what == "force":
            sizes = [np.abs(x[:, 2].mean()) for x in (top, middle, found)]
            assert sizes[0] < sizes[1] < sizes[2]
            # the weight of the body at the top is between
            bearing = vectors(history, "yaw_bearing_force", unit)
            assert np.allclose((top - bearing)[:, 2], -5e3 * 9.81, rtol=0.0, atol=close)


def test_channels_of_openfast_are_these_loads(seen):
    history, folder, kind = seen
    lines = [line.split() for line in (folder / "history.out").read_text().splitlines()]
    start = next(k for k, line in enumerate(lines) if line and line[0] == "Time")
    out = dict(zip(lines[start], np.array(lines[start + 2 :], dtype=float).T, strict=True))
    pairs = {
        "TwHt2FLzt": "tower_force_at_0.5_z_[N]",
        "TwHt3MLyt": "tower_moment_at_1_y_[Nm]",
        "Spn2FLxb3": "section_force_3_at_0.45_x_[N]",
        "Spn2MLyb1": "section_moment_1_at_0.45_y_[Nm]",
    }
    for name, column in pairs.items():
        if kind != "rigid" or name.startswith("TwHt"):
            size = np.abs(history[column]).max()
            assert np.allclose(1e3 * out[name], history[column][1:], rtol=0.0, atol=1e-5 * size)


def test_places_count_for_flexible_parts_and_steps_with_forces_in_the_middle():
    with pytest.raises(
        InputError, match=r"output\.sections\.0 = 1\.5: must be less than or equal to 1"
    ):
        Case.parse({"output": {"sections": [1.5]}})
    with pytest.raises(InputError, match=r"tower_sections.* different places, got 0\.5 twice"):
        Case.parse({"tower": {"flexible": True}, "output": {"tower_sections": [0.5, 0.1, 0.5]}})
    both = {"output": {"sections": [0.5], "tower_sections": [0.5]}}
    for table, words in (
        ({"turbine": {"model": "rigid"}}, 'with turbine.model = "rigid"'),
        ({"time": {"scheme": "generalised_alpha"}}, 'with time.scheme = "generalised_alpha"'),
    ):
        warnings = Case.parse({**both, **table}).warnings
        assert f"output.sections has no effect {words}" in warnings
        assert "output.tower_sections has no effect without tower.flexible = true" in warnings
