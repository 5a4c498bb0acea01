"""The built-in controller of a windIO file holds its rotor, with rigid blades, in a rising wind."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from windio_files import IEA_15, find_turbine

from turbine_fenicsx import run_case
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.turbine.case.case import Case

DEMO = Path(__file__).parents[4] / "demos" / "iea15" / "iea15_rigid.toml"
RISE = "time [s], speed [m/s]\n0, 14\n5, 14\n6, 16\n90, 16\n"


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    """Columns of a run by their names."""
    from mpi4py import MPI

    comm, file = MPI.COMM_WORLD, str(find_turbine(IEA_15))
    folder = on_rank0(comm, lambda: tmp_path_factory.mktemp("control"))
    on_rank0(comm, lambda: (folder / "rise.csv").write_text(RISE))
    design = Case.parse({"turbine": {"file": file}, "control": {"kind": "pi"}})
    data = tomllib.loads(DEMO.read_text())
    del data["generator"], data["wind"]["speed"]
    data["wind"].update(file=str(folder / "rise.csv"), shear=0.0)
    data["turbine"].update(tilt=0.0, rotor_speed=design.control.pitch.speed)
    data["control"] = design.control.model_dump(exclude={"library", "input"})
    pitch = design.pitch.model_dump(include={"drive", "frequency", "damping_ratio"})
    data["pitch"] = {**pitch, "initial": "10.5 deg"}
    data["time"] = {"step": 0.2, "end": 90.0}
    data["aero"] = {"file": file, "stations": 12}
    summary = run_case(Case.parse(data), folder / "out", comm, "none")
    lines = [line.split() for line in (folder / "out" / "history.out").read_text().splitlines()]
    head = next(k for k, line in enumerate(lines) if line[:1] == ["Time"])
    values = np.array([[float(x) for x in line] for line in lines[head + 2 :]]).T
    return summary, dict(zip(lines[head], values, strict=True))


def test_power_and_speed_are_rated_before_and_after(course):
    _, found = course
    at = {time: np.argmin(np.abs(found["Time"] - time)) for time in (4.8, 90.0)}
    for time, pitch in ((4.8, 10.5), (90.0, 13.3)):
        assert found["GenPwr"][at[time]] == pytest.approx(15000.0, rel=5e-3)
        assert found["GenSpeed"][at[time]] == pytest.approx(7.56, rel=5e-3)
        assert found["BldPitch1"][at[time]] == pytest.approx(pitch, abs=0.1)


def test_the_speed_rises_once_and_comes_back_without_swinging(course):
    """Damping ratio 1: 2 m/s more within a second, less than the limit of 9.07 rpm."""
    _, found = course
    late = found["Time"] > 5.0
    speed = found["GenSpeed"][late]
    peak = int(np.argmax(speed))
    assert 8.0 < speed[peak] < 8.6
    assert speed[peak:].min() > 7.54


def test_the_balance_of_energy_closes(course):
    summary, _ = course
    assert summary["worst_energy_error_[J]"] <= 1e-9 * summary["largest_energy_[J]"]
