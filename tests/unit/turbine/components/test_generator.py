"""Claims about a generator without a controller, and about starts in wind."""

from mpi4py import MPI

import numpy as np
import pytest
from aero_files import write_aerodyn
from case_mistakes import mistakes
from histories import read_rows

from turbine_fenicsx import run_case
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.simulation.observers.station_loads import find_loads
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.generator import find_steady_loads
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.components.wind import RotorLoads
from turbine_fenicsx.turbine.run.start import make_start

pytestmark = pytest.mark.parallel

RPM = np.pi / 30.0
PITCH = {"bearings": True, "drive": "actuator"}
TURNING = {"rotor_speed": "11 rpm", "tilt": "-5 deg", "precone": "-2.5 deg"}


@pytest.fixture(scope="module")
def aerodyn(tmp_path_factory):
    write = lambda: str(write_aerodyn(tmp_path_factory.mktemp("aero")))  # noqa: E731
    return on_rank0(MPI.COMM_WORLD, write)


def case(aerodyn, model="rigid", wind=None, **tables):
    data = {
        "turbine": {"model": model, **TURNING},
        "wind": {"speed": 9.0, "hub_height": 90.0, "shear": 0.1, **(wind or {})},
        "aero": {"file": aerodyn, "stations": 6},
        "pitch": {"drive": "prescribed"},
        "output": {"fields_every": 0},
        "mesh": {"elements": [1, 1, 8]},
        "time": {"step": 0.05, "end": 0.5, "start": "turning"},
    }
    return Case.parse({**data, **tables})


def run(comm, tmp_path_factory, given):
    folder = on_rank0(comm, lambda: tmp_path_factory.mktemp("run"))
    return run_case(given, folder, comm, progress="none"), read_rows(folder)


def test_a_generator_that_keeps_its_speed_takes_what_the_wind_gives(
    comm, aerodyn, tmp_path_factory
):
    keeping = case(aerodyn, generator={"keeps": "speed"}, loads={"gravity": 0})
    summary, table = run(comm, tmp_path_factory, keeping)
    assert [row["rotor_speed_[rpm]"] for row in table] == pytest.approx([11.0] * len(table))
    taken, given = table[-1]["work_of_motion_of_rotor_[J]"], table[-1]["work_of_wind_[J]"]
    assert given > 1e5
    assert -taken == pytest.approx(given, rel=2e-2)  # the rest moves the nacelle
    assert summary["worst_energy_error_[J]"] <= 1e-11 * summary["largest_energy_[J]"]


def test_the_mean_torque_of_the_wind_keeps_the_speed(comm, aerodyn, tmp_path_factory):
    given = case(aerodyn, generator={"keeps": "torque"})
    torque = find_steady_loads(given).torque
    assert torque > 5e5
    summary, table = run(comm, tmp_path_factory, given)
    turned = table[-1]["angle_rotor_[rad]"]
    assert table[-1]["work_of_generator_[J]"] == pytest.approx(-torque * turned, rel=1e-9)
    assert table[-1]["rotor_speed_[rpm]"] == pytest.approx(11.0, rel=2e-3)
    assert summary["worst_energy_error_[J]"] <= 1e-11 * summary["largest_energy_[J]"]


def test_its_torque_can_be_given(comm, aerodyn):
    given = case(aerodyn, generator={"keeps": "torque", "torque": "2 MN m"})
    system = build_turbine(given, comm).system
    assert system.sum_prescribed_forces(3.0).torques["rotor"] == -2e6


def test_blades_start_bent_by_the_wind(comm, aerodyn):
    """The air loads of the start are those of the moving state, not of a rotor at rest."""
    given = case(aerodyn, "hybrid", loads={"gravity": 0})
    turbine = build_turbine(given, comm)
    state = make_start(given, turbine.system)
    loads = find_loads(turbine.system, "wind", state)
    speed = np.linalg.norm(loads.motion.velocity, axis=1).max()
    assert speed == pytest.approx(11.0 * RPM * 52.0, rel=0.05)
    steady = find_steady_loads(given)
    air = RotorLoads(turbine).evaluate(state)
    thrust, torque = air.force[0], air.moment[0]
    assert thrust == pytest.approx(steady.thrust, rel=0.1)  # loads fall to zero at the tip there
    assert torque == pytest.approx(steady.torque, rel=0.1)  # loads fall to zero at the tip there
    still = case(aerodyn, "hybrid", {"speed": 0.0}, loads={"gravity": 0})
    other = make_start(still, build_turbine(still, comm).system)
    bend = comm.allreduce(
        float((state.u[0].array_r - other.u[0].array_r)[2::3].max(initial=0)), MPI.MAX
    )
    assert 1e-3 < bend < 1.0


def test_a_torque_that_follows_from_nothing_is_refused(aerodyn):
    found = mistakes({"generator": {"keeps": "torque"}})
    assert found == [
        'generator.keeps = "torque": expected generator.torque, or wind.speed and '
        "turbine.rotor_speed greater than 0, from which it follows"
    ]
    (found,) = mistakes(
        {"generator": {"keeps": "speed"}, "control": {"kind": "pi"}, "pitch": PITCH}
    )
    assert found.startswith('generator.keeps = "speed": expected "nothing" beside control.kind')
    unused = Case.parse({"generator": {"torque": "1 MN m"}})
    assert 'generator.torque has no effect with generator.keeps = "nothing"' in unused.warnings
