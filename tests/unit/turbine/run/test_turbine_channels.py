"""Claims about the directions and signs of OpenFAST's channels."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.rotations import E1, E2, E3
from turbine_fenicsx.meshing import RotorLayout
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.axes import blade_axes
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.components.nacelle import Nacelle
from turbine_fenicsx.turbine.components.pitch import Pitch
from turbine_fenicsx.turbine.run.run import make_stepper, turbine_channels


def angle(R, axis):
    """Angle of a small rotation about an axis [degrees]."""
    skew = 0.5 * (R - R.T)
    return np.degrees(np.arcsin(axis @ [skew[2, 1], skew[0, 2], skew[1, 0]]))


@pytest.fixture(scope="module")
def rows():
    """Columns, rows and directors of the rigid turbine's bodies, thirty steps under both torques.

    The yaw torque is large enough to make the blades pitch visibly.
    """
    from mpi4py import MPI

    loads = {"rotor_torque": 3.6e7, "yaw_torque": 3.6e8, "duration": 0.5}
    case = Case.parse({"turbine": {"model": "rigid"}, "loads": loads})
    turbine = build_turbine(case, MPI.COMM_WORLD)
    found = turbine_channels(
        turbine, make_stepper(turbine.case, turbine.system), stress=False
    ).openfast
    rows, directors = [], []

    class Seen:
        def start(self, snapshot, resumed):
            self.observe(snapshot)

        def observe(self, s):
            rows.append([x for channel in found for x in channel.values(s)])
            directors.append(s.state.q.reshape(-1, 4, 3)[:, 1:].transpose(0, 2, 1).copy())

        def finish(self):
            pass

    Simulation(turbine.system, 0.02, 0.6, [Seen()]).run()
    start = directors[0]
    R = np.array([d @ start.transpose(0, 2, 1) for d in directors])  # of each body since t = 0
    return [c for channel in found for c in channel.columns], np.array(rows), R


def test_azimuth_and_speed_count_clockwise_seen_from_upwind(rows):
    """Downwind is +e3: the hub stands on the other side of the tower."""
    _, values, R = rows
    relative = np.array([nacelle.T @ hub for nacelle, hub in R[:, :2]])
    azimuth = [angle(r, E3) for r in relative]
    assert azimuth[-1] > 1.0
    # blade 2 is up at first, and blade 1 at 240 degrees
    assert np.allclose(values[:, 0], np.add(azimuth, 240.0), rtol=0, atol=1e-10)
    speed = np.diff(azimuth) / 360.0 / (0.02 / 60.0)
    assert np.allclose(values[1:, 1], speed, rtol=0, atol=1e-8)


def test_nacelle_yaw_counts_counter_clockwise_seen_from_above(rows):
    _, values, R = rows
    yaw = [angle(nacelle, E2) for nacelle in R[:, 0]]
    assert yaw[-1] < -1.0  # the paper's torque acts about -e2
    assert np.allclose(values[:, 2], yaw, rtol=0, atol=1e-10)


def test_pitch_counts_towards_feather(rows):
    """The leading edge, at -y, turns upwind, to -x: negative about the outward span."""
    names, values, R = rows
    layout = plan_rotor(Case.parse({})).layout
    for k in (1, 2, 3):
        x, y, span = blade_axes(layout, k)
        relative = np.array([r[1].T @ r[1 + k] for r in R])
        pitch = values[:, names.index(f"BldPitch{k}_[deg]")]
        assert np.max(np.abs(pitch)) > 0.1
        assert np.allclose(pitch, [-angle(r, span) for r in relative], rtol=0, atol=1e-10)
        last = relative[-1] @ -y
        assert np.sign(last @ -x) == np.sign(pitch[-1])


def test_a_rotor_that_turns_backwards_has_azimuths_below_360():
    from types import SimpleNamespace

    state = SimpleNamespace(
        joint_coordinates=np.array([0.1, -0.5]), joint_rates=np.array([0.0, -np.pi])
    )
    system = SimpleNamespace(joint_coordinate_names=("yaw", "rotor"))
    turbine = SimpleNamespace(system=system)
    channels = [c for part in (Nacelle(), Pitch()) for c in part.channels(turbine).openfast]
    values = [x for channel in channels for x in channel.values(SimpleNamespace(state=state))]
    assert np.allclose(values, [240.0 - np.degrees(0.5), -30.0, -np.degrees(0.1), 0, 0, 0])


def test_frame_of_the_upright_blade():
    """x downwind, z to the tip, y to the trailing edge: where blade 2 comes from."""
    axes = blade_axes(RotorLayout(), 2)
    assert np.array_equal(axes, [E3, E1, E2])
    velocity = np.cross(E3, E2)  # of its tip, when the rotor turns clockwise
    assert velocity @ axes[1] == -1.0
