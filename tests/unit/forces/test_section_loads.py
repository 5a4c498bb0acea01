"""Claims about loads on sections: kinematics, resultants, power, balance, restarts."""

from dataclasses import dataclass, field

from mpi4py import MPI

import numpy as np
import pytest
from dolfinx import mesh

from turbine_fenicsx import Revolute, StepTimes, StVenantKirchhoff, SurfaceTraction
from turbine_fenicsx.analysis import statics
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.section_loads import SectionLoads, StationLine
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.section_transfer import SectionTransfer
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.generalised_alpha import GeneralisedAlpha

pytestmark = pytest.mark.parallel

SIZE = (6.0, 0.6, 0.4)
STATIONS = np.array([0.5, 2.0, 3.5, 5.5])


@dataclass
class Drag:
    """A load of a wind on each section, with a wake that follows slowly."""

    wind: np.ndarray = field(default_factory=lambda: np.array([0.0, 3.0, 9.0]))
    wake: np.ndarray = field(default_factory=lambda: np.zeros((4, 3)))
    calls: list = field(default_factory=list)

    def start_step(self, times):
        self.calls.append(("start_step", times.end))

    def loads(self, motion, time):
        relative = self.wind * np.sin(0.5 * time) + 2.0 - motion.velocity - self.wake
        force = 4.0 * np.linalg.norm(relative, axis=1)[:, None] * relative
        along = motion.axes[:, :, 0]
        return force, 0.3 * np.cross(along, force) - 0.2 * motion.angular_velocity

    def accept(self, motion, times):
        self.calls.append(("accept", times.end))
        force, _ = self.loads(motion, times.middle)
        self.wake = self.wake + times.dt * (0.02 * force - self.wake)

    def save(self):
        return RestartData(arrays={"wake": self.wake.copy()})

    def restore(self, data):
        self.wake = data.arrays["wake"].copy() if data else np.zeros((4, 3))


def beam(comm, name="beam", *, cell="hexahedron", degree=2):
    cells = mesh.create_box(comm, [(0, 0, 0), SIZE], [6, 1, 1], getattr(mesh.CellType, cell))
    return FlexibleBody(name, cells, StVenantKirchhoff(4e5, 6e5), 80.0, degree)


def skin(body):
    return mesh.locate_entities_boundary(
        body.mesh, 2, lambda x: ~np.isclose(x[0], 0.0) & ~np.isclose(x[0], SIZE[0])
    )


def loads(body, source, stations=STATIONS, name="wind"):
    line = StationLine(skin(body), origin=(0, 0.3, 0.2), axis=(1, 0, 0), stations=stations)
    return SectionLoads(name, body, [line], source)


def transfer(comm, **kind):
    body = beam(comm, **kind)
    model = FlexibleModel(body)
    wind = loads(body, Drag())
    found = SectionTransfer(model, wind)
    return found, model.positions[found.nodes]


kinds = pytest.mark.parametrize(
    ("cell", "degree"),
    [("hexahedron", 1), ("hexahedron", 2), ("tetrahedron", 1), ("tetrahedron", 2)],
)


@kinds
def test_rigid_motions_of_the_skin_are_those_of_all_sections(comm, cell, degree):
    found, X = transfer(comm, cell=cell, degree=degree)
    at_rest = found.motion(X, 0 * X)
    Q = rotation_about((0.3, -0.5, 0.8), 2.6)
    shift, v, omega = np.array([300.0, -40.0, 7.0]), np.array([1.0, 2.0, -3.0]), [0.5, -1.0, 2.0]
    x = X @ Q.T + shift
    motion = found.motion(x, v + np.cross(omega, x))
    assert motion.position == pytest.approx(at_rest.position @ Q.T + shift, rel=1e-13)
    assert motion.axes == pytest.approx(np.broadcast_to(Q, (4, 3, 3)), abs=1e-11)
    expected = v + np.cross(omega, motion.position)
    assert motion.velocity == pytest.approx(expected, rel=1e-12)
    assert motion.angular_velocity == pytest.approx(np.broadcast_to(omega, (4, 3)), abs=1e-11)


@kinds
def test_resultant_moment_and_power_are_those_of_the_loads(comm, cell, degree):
    found, X = transfer(comm, cell=cell, degree=degree)
    v = np.sin(3.0 * X) @ np.random.default_rng(3).standard_normal((3, 3))
    x = X + 0.05 * np.cos(2.0 * X) + [100.0, 0.0, 0.0]
    motion = found.motion(x, v)
    F, M = np.random.default_rng(4).standard_normal((2, 4, 3))
    f = found.forces(F, M)

    def total(values):
        return comm.allreduce(values)

    size = total(np.abs(f).sum())
    assert total(f.sum(axis=0)) == pytest.approx(F.sum(axis=0), abs=1e-14 * size)
    moment = M.sum(axis=0) + np.cross(motion.position, F).sum(axis=0)
    assert total(np.cross(x, f).sum(axis=0)) == pytest.approx(moment, abs=1e-14 * 100.0 * size)
    power = np.sum(F * motion.velocity) + np.sum(M * motion.angular_velocity)
    assert total(np.sum(f * v)) == pytest.approx(power, abs=1e-14 * size)


def test_stations_of_several_lines_are_counted_one_line_after_another(comm):
    body = beam(comm)
    model = FlexibleModel(body)
    ends = [
        StationLine(skin(body), origin=(0, 0, 0), axis=(1, 0, 0), stations=[x]) for x in (1.5, 4.5)
    ]
    both = SectionLoads("wind", body, [ends[0], loads(body, Drag()).lines[0]], Drag())
    found = SectionTransfer(model, both)
    X = model.positions[found.nodes]
    motion = found.motion(X, 0 * X)
    # a line of one station has all of the skin, from 1 to 5 m
    assert motion.position[0] == pytest.approx([3.0, 0.3, 0.2], abs=1e-12)
    alone, X = transfer(comm)
    assert motion.position[1:] == pytest.approx(alone.motion(X, 0 * X).position, abs=1e-12)


def test_stations_may_be_closer_than_nodes(comm):
    """Those of the mesh are half a metre apart."""
    model, places = FlexibleModel(beam(comm)), [2.0, 2.1, 2.2, 2.3]
    found = SectionTransfer(model, loads(model.body, Drag(), places))
    X, omega = model.positions[found.nodes], [0.5, -1.0, 2.0]
    Q = rotation_about((0.3, -0.5, 0.8), 0.6)
    motion = found.motion(X @ Q.T, np.cross(omega, X @ Q.T))
    assert np.all(np.diff(motion.initial[:, 0]) > 0.1)
    assert motion.axes == pytest.approx(np.broadcast_to(Q, (4, 3, 3)), abs=1e-12)
    assert motion.velocity == pytest.approx(np.cross(omega, motion.position), abs=1e-11)
    F, M = np.random.default_rng(4).standard_normal((2, 4, 3))
    f = found.forces(F, M)
    moment = M.sum(axis=0) + np.cross(motion.position, F).sum(axis=0)
    assert comm.allreduce(f.sum(axis=0)) == pytest.approx(F.sum(axis=0), abs=1e-11)
    assert comm.allreduce(np.cross(X @ Q.T, f).sum(axis=0)) == pytest.approx(moment, abs=1e-10)


def test_equal_line_loads_are_a_traction_on_the_skin(comm):
    tips = []
    for make in (
        lambda b: SurfaceTraction("t", b, skin(b), (0.0, 3.0, -5.0)),
        lambda b: loads(b, Constant(b), np.linspace(1.0, 5.0, 5)),
    ):
        body = beam(comm)
        clamp = Coupling("root", body, at(body, 0.0), None)
        run = Simulation(MultibodySystem(comm, [body, clamp, make(body)]), 0.05, 0.5)
        snapshot = run.run()
        tips.append(largest(comm, snapshot.state.u[0].array_r))
    assert tips[1] == pytest.approx(tips[0], rel=2e-3)


def at(body, x1):
    return mesh.locate_entities_boundary(body.mesh, 2, lambda x: np.isclose(x[0], x1))


def largest(comm, values):
    return comm.allreduce(float(np.max(np.abs(values), initial=0.0)), op=MPI.MAX)


class Constant(Drag):
    """The force per area (0, 3, -5) N/m^2 on all four sides, whose perimeter is 2 m."""

    def __init__(self, body):
        super().__init__(wake=np.zeros((5, 3)))

    def loads(self, motion, time):
        lengths = np.array([0.5, 1, 1, 1, 0.5])[:, None]
        return 2.0 * lengths * np.array([0.0, 3.0, -5.0]), np.zeros((5, 3))

    def accept(self, motion, times):
        pass


def turning(comm, source, **options):
    """A beam on a hub that turns, in a wind."""
    body, hub = beam(comm, degree=1), RigidBody("hub", 20.0, (1.0, 1.0, 1.0))
    parts = [
        body,
        hub,
        Revolute("shaft", None, hub, point=(0, 0, 0), axis=(0, 0, 1)),
        Coupling("root", body, at(body, 0.0), hub),
        loads(body, source),
    ]
    return MultibodySystem(comm, parts)


def test_wind_work_is_all_that_changes_the_energy(comm):
    run = Simulation(turning(comm, Drag()), 0.02, 1.0)
    snapshot = run.run()
    (work,) = snapshot.works
    assert abs(work) > 10.0
    assert abs(snapshot.energy_error) <= 1e-11 * snapshot.balance.kinetic


def test_each_accepted_step_moves_the_wake_on_once(comm):
    source = Drag()
    run = Simulation(turning(comm, source), 0.02, 0.1)
    run.run()
    run.stepper.save()  # the last step
    accepted = [round(t, 9) for kind, t in source.calls if kind == "accept"]
    assert accepted == [0.02, 0.04, 0.06, 0.08, 0.1]


def test_a_step_that_is_repeated_leaves_no_trace(comm):
    ends, wakes = [], []
    for lengths in ([0.02], [0.08, 0.04, 0.02]):
        source = Drag()
        stepper = EnergyMomentum(turning(comm, source))
        state, out = stepper.system.initial_state(), stepper.system.initial_state()
        stepper.advance(state, 0.02, out)
        for dt in lengths:
            end = stepper.system.initial_state()
            stepper.advance(out, dt, end)
        stepper.save()
        ends.append(end.v[0].array_r.copy())
        wakes.append(source.wake)
    assert ends[1] == pytest.approx(ends[0], abs=1e-12)
    assert np.any(wakes[0]) and wakes[1] == pytest.approx(wakes[0], rel=1e-11)


@pytest.mark.parametrize("scheme", [EnergyMomentum, GeneralisedAlpha])
def test_a_run_goes_on_bit_for_bit(comm, scheme):
    def end(parts):
        state, data = None, None
        for steps in parts:
            system = turning(comm, Drag())
            stepper = scheme(system)
            stepper.restore(data or RestartData())
            state = state or system.initial_state()
            for _ in range(steps):
                out = system.initial_state()
                stepper.advance(state, 0.02, out)
                state = out
            data = stepper.save()
        return state.u[0].array_r.copy()

    whole, halves = end([6]), end([3, 3])
    assert np.any(whole)
    assert np.array_equal(whole, halves)


def test_schemes_agree_in_the_limit(comm):
    ends = []
    for scheme in (EnergyMomentum, GeneralisedAlpha):
        system = turning(comm, Drag())
        snapshot = Simulation(system, 0.005, 0.3, stepper=scheme(system)).run()
        ends.append(snapshot.state.joint_coordinates[0])
    assert ends[1] == pytest.approx(ends[0], rel=2e-3)


def test_wind_holds_a_beam_in_equilibrium(comm):
    body = beam(comm)
    clamp = Coupling("root", body, at(body, 0.0), None)
    source = Drag()
    system = MultibodySystem(comm, [body, clamp, loads(body, source)])
    state = statics.equilibrium(system, [1.0])
    assert largest(comm, state.u[0].array_r) > 1e-4
    assert all(kind == "start_step" for kind, _ in source.calls)


class Growing(Drag):
    """A load that grows with the displacement, of which no tangent knows."""

    def loads(self, motion, time):
        return self.wind + 16.0 * (motion.position - motion.initial), np.zeros((4, 3))


def test_the_tangent_is_kept_where_loads_that_it_does_not_know_slow_newton_down(comm, monkeypatch):
    body = beam(comm)
    clamp = Coupling("root", body, at(body, 0.0), None)
    system = MultibodySystem(comm, [body, clamp, loads(body, Growing())])
    updates, update, found = [], statics.Elimination.update, []
    monkeypatch.setattr(
        statics.Elimination, "update", lambda self, x: (updates.append(1), update(self, x))
    )
    for linear in (statics.MIN_LINEAR_RATIO, 0.0):  # with the second, every tangent is new
        monkeypatch.setattr(statics, "MIN_LINEAR_RATIO", linear)
        updates.clear()
        state = statics.equilibrium(system, tolerance=1e-9)
        found.append((state.u[0], len(updates)))
    (kept, few), (new, many) = found
    assert (kept - new).norm() <= 3e-9 * new.norm()
    assert 3 * few <= 2 * many


@pytest.mark.parametrize(
    ("stations", "words"),
    [
        ([1.0, 1.0], "stations of 'wind' must be one or more rising distances"),
        ([], "stations of 'wind' must be one or more rising distances"),
        ([0.5, np.nan], "stations of 'wind' must be a list of numbers"),
    ],
)
def test_stations_that_cannot_be_are_refused(comm, stations, words):
    with pytest.raises(ModelError, match=words):
        loads(beam(comm), Drag(), stations)


def test_stations_without_nodes_are_refused_on_all_ranks(comm):
    body = beam(comm)
    line = StationLine(skin(body)[:0], origin=(0, 0, 0), axis=(1, 0, 0), stations=STATIONS)
    words = r"station 1 of 'wind' at 0.5 m has no three nodes of the skin that are not on a line"
    with pytest.raises(ModelError, match=words):
        FlexibleModel(body, [SectionLoads("wind", body, [line], Drag())])


def test_a_source_without_its_methods_is_refused(comm):
    with pytest.raises(
        TypeError, match=r"source of 'wind' needs the methods start_step\(\), loads\(\)"
    ):
        loads(beam(comm), "wind")


def test_loads_of_another_shape_are_refused(comm):
    class Wrong(Drag):
        def loads(self, motion, time):
            return np.zeros((3, 3)), np.zeros((4, 3))

    system = turning(comm, Wrong())
    with pytest.raises(ModelError, match=r"forces of 'wind' must have the shape \(4, 3\)"):
        EnergyMomentum(system).advance(system.initial_state(), 0.01, system.initial_state())


def test_at_rest_the_source_is_told_so(comm):
    source = Drag()
    body = beam(comm)
    model = FlexibleModel(body, [loads(body, source)])
    (bound,) = model.section_loads
    bound.start_step_at(StepTimes.at_rest(3.0), np.zeros(3 * model.n_owned))
    assert source.calls == [("start_step", 3.0)]
