"""Gauges at the roots of the blades and the accelerometer at the tower's top."""

from types import SimpleNamespace

import numpy as np
import pytest
from aero_files import write_aerodyn
from seen import Seen

from turbine_fenicsx import Case, build_turbine, run_case
from turbine_fenicsx.control.discon import Discon
from turbine_fenicsx.control.interface import Measurements
from turbine_fenicsx.foundation.rotations import E3
from turbine_fenicsx.simulation.observers.station_loads import find_loads
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.turbine.components.root_channels import RootLoads, unpitch
from turbine_fenicsx.turbine.components.sensors import TopAcceleration
from turbine_fenicsx.turbine.run.start import make_start

pytestmark = pytest.mark.parallel

PITCH = np.radians(4.0)
WATCH = """
from turbine_fenicsx.control.interface import Commands

class Watch:
    def __call__(self, m):
        with open({path!r}, "a") as file:
            print(m.time, *m.flap_moments, *m.edge_moments, *m.top_acceleration, file=file)
        return Commands(0.0, m.pitch)
"""


def test_gauges_of_rigid_blades_tell_the_moments_of_the_air(comm, shared_tmp_path):
    if comm.rank == 0:
        write_aerodyn(shared_tmp_path)
    comm.barrier()
    case = Case.parse(
        {
            "turbine": {"model": "rigid", "rotor_speed": "11 rpm"},
            "wind": {"speed": 9.0, "shear": 0.0, "hub_height": 90.0},
            "aero": {"file": str(shared_tmp_path / "rotor.dat")},
            "pitch": {"drive": "prescribed", "initial": "4 deg"},
            "generator": {"keeps": "speed"},
            "yaw": {"drive": "lock"},
            "loads": {"gravity": 0.0},
        }
    )
    turbine = build_turbine(case, comm)
    state = make_start(case, turbine.system)
    roots = RootLoads(turbine)
    gauges = Seen(lambda snapshot: unpitch(roots.mean_at(snapshot)[:, 1], (PITCH,) * 3))
    last = Simulation(turbine.system, 0.01, 0.1, observers=[gauges], start=state).run()
    loads = find_loads(turbine.system, "wind", last.state)
    centre = np.asarray(turbine.rotor.layout.centre)
    # moments about the roots, in the axes downwind and across the span
    n, expected = len(loads.force) // 3, []
    for k in range(3):
        rows = slice(n * k, n * (k + 1))
        x = loads.motion.position[rows] - centre
        span = x[-1] / np.linalg.norm(x[-1])
        arms = x - case.blade.hub_radius * span
        M = np.cross(arms, loads.force[rows]).sum(axis=0) + loads.moment[rows].sum(axis=0)
        expected.append([M @ E3, M @ np.cross(span, E3)])
    edge, flap = np.array(expected).T
    assert np.all(flap > 1e6) and np.all(edge > 1e4)
    # a speed that is kept lets the one at the ends of steps alternate: two steps have no inertia
    found = np.mean(gauges.values[-2:], axis=0)[:, :2]
    assert np.allclose(found.T, [edge, flap], rtol=1e-3)
    state.destroy()


def test_a_controller_sees_what_the_columns_of_flexible_blades_show(comm, shared_tmp_path):
    seen = shared_tmp_path / "seen.txt"
    if comm.rank == 0:
        (shared_tmp_path / "watch.py").write_text(WATCH.format(path=str(seen)))
    comm.barrier()
    case = Case.parse(
        {
            "control": {"kind": f"python:{shared_tmp_path / 'watch.py'}:Watch"},
            "turbine": {"rotor_speed": "8 rpm"},
            "mesh": {"elements": [1, 1, 4]},
            "pitch": {"bearings": True, "drive": "actuator", "initial": "20 deg"},
            "tower": {"flexible": True, "elements": [4, 1, 2], "degree": 1},
            "yaw": {"drive": "lock"},
            "time": {"step": 0.02, "end": 0.1},
            "output": {"fields_every": 0.0},
        }
    )
    run_case(case, shared_tmp_path / "out", comm, "none")
    comm.barrier()
    table = np.genfromtxt(shared_tmp_path / "out" / "history.csv", delimiter=",", names=True)
    measured = np.loadtxt(seen)
    assert np.allclose(measured[:, 0], table["time_s"])
    c, s = np.cos(np.radians(20.0)), np.sin(np.radians(20.0))
    for k in (1, 2, 3):  # the columns are in axes that pitch
        x, y = (table[f"root_moment_{k}_{axis}_Nm"][1:] for axis in "xy")
        assert np.allclose(measured[1:, k], c * y - s * x, rtol=1e-6)
        assert np.allclose(measured[1:, 3 + k], c * x + s * y, rtol=1e-6)
    place = table["tower_top_displacement_x_m"]
    expected = np.diff(place, 2) / 0.02**2
    assert np.allclose(measured[2:, 7], expected, atol=1e-9 + 1e-6 * np.max(np.abs(expected)))
    assert np.max(np.abs(expected)) > 1e-3


def make_accelerometer():
    support = object()
    system = SimpleNamespace(first_coordinate={support: 3})
    return TopAcceleration(SimpleNamespace(find=lambda name: support, system=system))


def test_the_accelerometer_differentiates_twice_and_goes_on_as_it_was():
    def state(t):  # 0.6 m/s^2 downwind, 0.2 to the left
        place = [0.1 * t * t, 5.0, 0.3 * t * t + t]
        return SimpleNamespace(q=np.concatenate([np.ones(3), place]), time=t)

    times, forward = [0.0, 0.1, 0.2, 0.25, 0.35], np.array([0.0, 0.1, 0.995])
    whole, half = make_accelerometer(), make_accelerometer()
    found = [whole.at(state(t), forward) for t in times]
    assert found[:2] == [(0.0, 0.0)] * 2
    assert found[2:] == [pytest.approx((0.6, 0.2))] * 3
    for t in times[:3]:
        half.at(state(t), forward)
    again = make_accelerometer()
    again.rates.restore(half.rates.save())
    again.rates.follow(state(times[2]))
    assert again.at(state(times[3]), forward) == found[3]


def test_discon_gets_them_in_the_records_of_bladed():
    measured = Measurements(
        *(1.0, 0.1, False, 120.0, 1.2, 0.0, (0.1,) * 3, 4e4, 5e6),
        flap_moments=(1.0, 2.0, 3.0),
        edge_moments=(4.0, 5.0, 6.0),
        top_acceleration=(0.7, 0.8),
    )
    assert Measurements.from_row(measured.to_row()) == measured
    records = Discon._fill(SimpleNamespace(_limits=(0.0, 1.5)), measured)
    expected = {30: 1.0, 31: 2.0, 32: 3.0, 53: 0.7, 54: 0.8, 69: 4.0, 70: 5.0, 71: 6.0}
    assert {k: records[k] for k in expected} == expected
