"""Claims about loads on the sections of reduced bodies."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from dolfinx import mesh
from reduced_beams import COMM, SIZE, beam, clamped, clamped_basis, on_hub, rotor

from turbine_fenicsx import (
    EnergyMomentum,
    ReducedBody,
    RestartData,
    SectionLoads,
    StationLine,
    equilibrium,
)
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.reduced_model import ReducedModel
from turbine_fenicsx.system.section_transfer import SectionTransfer

pytestmark = pytest.mark.parallel

STATIONS = np.array([0.4, 1.2, 2.6, 3.6])
EXACT = 1e-12


@dataclass
class Drag:
    """A wind across the sections, which pitch too, with a wake that follows slowly."""

    stations: int = 4
    wake: np.ndarray = field(default=None)

    def __post_init__(self):
        self.restore(None)

    def start_step(self, times):
        pass

    def loads(self, motion, time):
        relative = np.array([3.0, 1.0, 0.5]) * (1.0 + np.sin(time)) - motion.velocity - self.wake
        force = 2.0 * np.linalg.norm(relative, axis=1)[:, None] * relative
        return force, 0.2 * np.cross(motion.axes[:, :, 2], force) - 0.1 * motion.angular_velocity

    def accept(self, motion, times):
        self.wake = self.wake + times.dt * (0.02 * self.loads(motion, times.middle)[0] - self.wake)

    def save(self):
        return RestartData(arrays={"wake": self.wake.copy()})

    def restore(self, data):
        self.wake = data.arrays["wake"].copy() if data else np.zeros((self.stations, 3))


def skin(body):
    """The skin of a beam without its ends."""
    return mesh.locate_entities_boundary(
        body.mesh, 2, lambda x: ~np.isclose(x[2], 0.0) & ~np.isclose(x[2], SIZE[2])
    )


def line(copy=0, place=None, stations=STATIONS):
    """Stations of a copy."""
    R, t = (np.eye(3), np.zeros(3)) if place is None else (place.rotation, place.position)
    return StationLine(
        skin(beam()), origin=t, axis=np.asarray(R)[:, 2], stations=stations, copy=copy
    )


def blown(body, source=None, name="wind"):
    """Loads on all copies of a body."""
    places = getattr(body, "placements", [None])
    lines = [line(k, place) for k, place in enumerate(places)]
    return SectionLoads(name, body, lines, source or Drag(4 * len(lines)))


class Sections:
    """The transfer of a reduced body, for values of all its vectors on all ranks."""

    def __init__(self, body, loads=None):
        self.model = ReducedModel(body, (), None, ())
        self._transfer = SectionTransfer(self.model, loads or blown(body))

    def motion(self, z, rates):
        nodes = self._transfer.nodes
        return self._transfer.motion(z[nodes], rates[nodes])

    def forces(self, F, M):
        f = np.zeros((self.model.size_global, 3))
        f[self._transfer.nodes] = self._transfer.forces(F, M)
        return COMM.bcast(f)


def own(values):
    """Vectors of rank 0, nothing elsewhere."""
    return values if COMM.rank == 0 else values[:0]


def vectors(body):
    """Vectors of all copies at rest."""
    z = body.basis.vectors
    h = np.zeros((len(z), 1))
    h[: 4 * len(body.basis.origins) : 4] = 1.0
    places = [(np.asarray(p.rotation), np.asarray(p.position)) for p in body.placements]
    return np.concatenate([z @ R.T + h * t for R, t in places])


def test_rigid_motions_of_the_vectors_are_those_of_all_sections():
    body = rotor()
    found, z = Sections(body), vectors(body)
    h = np.zeros((len(z), 1))
    h[:: len(body.basis.vectors)] = 1.0
    at_rest = found.motion(z, 0 * z)
    assert at_rest.position == pytest.approx(at_rest.initial, abs=EXACT)
    assert at_rest.axes == pytest.approx(np.broadcast_to(np.eye(3), (12, 3, 3)), abs=EXACT)
    Q = rotation_about((0.3, -0.5, 0.8), 2.6)
    shift, v, omega = np.array([30.0, -4.0, 7.0]), np.array([1.0, 2.0, -3.0]), [0.5, -1.0, 2.0]
    moved = z @ Q.T + h * shift
    motion = found.motion(moved, h * v + np.cross(omega, moved))
    assert motion.position == pytest.approx(at_rest.initial @ Q.T + shift, abs=1e-11)
    assert motion.axes == pytest.approx(np.broadcast_to(Q, (12, 3, 3)), abs=EXACT)
    expected = v + np.cross(omega, motion.position)
    assert motion.velocity == pytest.approx(expected, abs=1e-11)
    assert motion.angular_velocity == pytest.approx(np.broadcast_to(omega, (12, 3)), abs=1e-11)


def test_resultant_moment_and_power_are_those_of_the_loads():
    body, rng = rotor(), np.random.default_rng(4)
    found, z = Sections(body), vectors(body)
    h = np.zeros((len(z), 1))
    h[:: len(body.basis.vectors)] = 1.0
    z = z + 0.05 * rng.standard_normal(z.shape)  # strained, not only turned
    rates = rng.standard_normal(z.shape)
    motion = found.motion(z, rates)
    F, M = rng.standard_normal((2, 12, 3))
    f = found.forces(F, M)
    size = EXACT * np.abs(f).sum()
    assert np.sum(h * f, axis=0) == pytest.approx(F.sum(axis=0), abs=size)
    moment = M.sum(axis=0) + np.cross(motion.position, F).sum(axis=0)
    assert np.cross(z, f).sum(axis=0) == pytest.approx(moment, abs=10.0 * size)
    power = np.sum(F * motion.velocity) + np.sum(M * motion.angular_velocity)
    assert np.sum(f * rates) == pytest.approx(power, abs=10.0 * size)


def test_sections_move_as_those_of_the_full_body():
    body = ReducedBody("r", beam(), clamped_basis())
    full = FlexibleModel(beam())
    of_mesh = SectionTransfer(full, blown(beam()))
    found, z, rng = Sections(body), vectors(body), np.random.default_rng(5)
    z = (z + 0.05 * rng.standard_normal(z.shape)) @ rotation_about((1.0, 2.0, 3.0), 1.1).T
    rates = rng.standard_normal(z.shape)
    F = found.model.mesh_functions[of_mesh.nodes]
    a, b = found.motion(z, rates), of_mesh.motion(F @ z, F @ rates)
    for name in ("position", "axes", "velocity", "angular_velocity", "initial"):
        assert getattr(a, name) == pytest.approx(getattr(b, name), rel=1e-11, abs=1e-11), name


def test_an_equilibrium_in_wind_comes_near_that_of_the_full_body():
    tips = []
    for body in (beam(), ReducedBody("r", beam(), clamped_basis(36))):
        system = clamped(body, blown(body))
        state = equilibrium(system)
        loads = system.section_loads["wind"]
        model = system.flexible_models[0]
        u = state.u[0].array_r
        tips.append(
            loads.loads_at(u, 0.0 * u, 0.0).motion.position
            - loads.loads_at(0.0 * u, 0.0 * u, 0.0).motion.position
        )
        assert model.is_conservative
    assert np.linalg.norm(tips[0][-1]) > 0.03
    assert tips[1] == pytest.approx(tips[0], abs=2e-3 * np.abs(tips[0]).max())


def test_the_work_of_the_wind_is_the_gain_of_energy():
    body = rotor()
    system = on_hub([body], blown(body), speed=2.0)
    stepper, state = EnergyMomentum(system), system.initial_state()
    out, done, first = system.initial_state(), 0.0, system.balance(state).total
    for _ in range(40):
        report = stepper.advance(state, 0.02, out)
        done += sum(report.works)
        state, out = out, state
    gain = system.balance(state).total - first
    assert abs(done) > 1.0
    assert gain == pytest.approx(done, abs=1e-9 * abs(first))
    last = system.section_loads["wind"].last
    power = np.sum(last.force * last.motion.velocity + last.moment * last.motion.angular_velocity)
    assert 0.02 * power == pytest.approx(sum(report.works), rel=1e-9)


def test_loads_of_a_wrong_copy_are_refused():
    body = rotor()
    with pytest.raises(ValueError, match="copy of 'wind' must be one of the 3 copies of 'blades'"):
        SectionLoads("wind", body, [line(3)], Drag())
    with pytest.raises(ValueError, match="copy of 'wind' must be one of the 1 copies of 'beam'"):
        SectionLoads("wind", beam(), [line(1)], Drag())


def test_stations_may_be_closer_than_nodes():
    """Rotations and velocities of rigid motions, power and moments are still exact."""
    body, rng = ReducedBody("r", beam(), clamped_basis()), np.random.default_rng(4)
    places = np.linspace(0.2, 3.9, 30)
    loads = SectionLoads("wind", body, [line(stations=places)], Drag(30))
    found, z = Sections(body, loads), vectors(body)
    h = np.zeros((len(z), 1))
    h[0] = 1.0
    Q, v, omega = rotation_about((0.3, -0.5, 0.8), 0.6), np.array([1.0, 2.0, -3.0]), [0.5, -1, 2]
    moved = z @ Q.T
    motion = found.motion(moved, h * v + np.cross(omega, moved))
    assert motion.initial[1:-1, 2] == pytest.approx(places[1:-1], abs=0.3)
    assert np.all(np.diff(motion.initial[:, 2]) > -EXACT)
    assert motion.axes == pytest.approx(np.broadcast_to(Q, (30, 3, 3)), abs=EXACT)
    assert motion.velocity == pytest.approx(v + np.cross(omega, motion.position), abs=1e-11)
    assert motion.angular_velocity == pytest.approx(np.broadcast_to(omega, (30, 3)), abs=1e-11)
    F, M = rng.standard_normal((2, 30, 3))
    f = found.forces(F, M)
    moment = M.sum(axis=0) + np.cross(motion.position, F).sum(axis=0)
    assert np.sum(h * f, axis=0) == pytest.approx(F.sum(axis=0), abs=EXACT * np.abs(f).sum())
    assert np.cross(moved, f).sum(axis=0) == pytest.approx(moment, abs=1e-11 * np.abs(f).sum())


def test_a_line_without_nodes_is_refused():
    body = ReducedBody("r", beam(), clamped_basis())
    none = StationLine(skin(beam())[:0], origin=(0, 0, 0), axis=(0, 0, 1), stations=STATIONS)
    with pytest.raises(ValueError, match=r"station 1 of 'wind' at 0\.4 m has no three nodes"):
        clamped(body, SectionLoads("wind", body, [none], Drag()))


def test_the_step_is_announced_to_the_source():
    body = ReducedBody("r", beam(), clamped_basis())
    source = Drag()
    system = clamped(body, blown(body, source))
    times = StepTimes.from_start(0.0, 0.1)
    (loads,) = system.section_loads.values()
    u = np.zeros(3 * system.flexible_models[0].n_owned)
    loads.start_step_at(times, u)
    loads.work(u, u, times, u)
    loads.start_step_at(StepTimes.from_start(0.1, 0.1), u)
    assert np.max(np.abs(source.wake)) > 0.0


@dataclass
class Stations(Drag):
    """A drag that every station has for itself, and a moment that brings it back."""

    def loads(self, motion, time):
        force, moment = super().loads(motion, time)
        back = np.cross(motion.axes[:, :, 0], [1.0, 0.3, 0.0])
        return force - 3.0 * motion.position, moment + 5.0 * back


def test_slopes_are_the_derivative_of_the_forces_in_a_step():
    body = rotor()
    system = on_hub([body], blown(body, Stations(12)))
    model, rng = system.flexible_models[0], np.random.default_rng(6)
    times = StepTimes.from_start(0.3, 0.05)

    def random(size):
        return own(size * rng.standard_normal((model.size_global, 3))).ravel()

    z = model.positions
    turn = np.cross((0.5, -1.0, 0.3), z) + model.is_point[:, None] * (1.0, 2.0, 0.5)
    u, du, way = random(1e-4), times.dt * turn.ravel(), random(1.0)

    def forces(change):
        out = np.zeros_like(u)
        moved = du + change * way
        model.add_forces(u + 0.5 * moved, moved / times.dt, times.middle, 1.0, out)
        return out

    slopes = model.find_slopes(u + 0.5 * du, du / times.dt, times)
    change = 1e-5
    wanted = (forces(change) - forces(-change)) / (2.0 * change)
    found = (slopes @ way.reshape(-1, slopes.shape[-1], 1)).ravel()
    # slopes leave out how spins and forces follow arms that change
    assert np.linalg.norm(found - wanted) <= 0.1 * np.linalg.norm(wanted)
