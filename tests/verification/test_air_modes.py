"""Claims about modes in the air: rotation has no stiffness, frames agree, runs decay so."""

from mpi4py import MPI

import numpy as np
import pytest
from beam_turbines import CONTROLLED, write_beam_case
from reduced_turbines import COMM
from scipy.linalg import null_space
from scipy.optimize import least_squares

from turbine_fenicsx import Case, EnergyMomentum, PrescribedMotion, Simulation
from turbine_fenicsx.analysis.air_modes import AirModel, AirProblem
from turbine_fenicsx.analysis.feedback import Feedback
from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.records.conventions import OPENFAST_SIGNS
from turbine_fenicsx.turbine.components import model as turbine_model
from turbine_fenicsx.turbine.components.component import Component
from turbine_fenicsx.turbine.components.nacelle import ROTOR
from turbine_fenicsx.turbine.components.pitch import BEARINGS
from turbine_fenicsx.turbine.modes.symmetric_turbine import SymmetricTurbine, make_symmetric
from turbine_fenicsx.turbine.modes.wind_modes import WindModesWanted, find_wind_modes
from turbine_fenicsx.turbine.steady import steady_turbine
from turbine_fenicsx.turbine.steady.operating_states import OperatingState

WIND, SPEED, PITCH = 9.0, 2.6, 0.05
HUB = ["turbine.hub.centre=[0.0, 0.0, 0.0]", "turbine.hub.inertia=[900.0, 900.0, 1500.0, 0, 0, 0]"]
FULL = AirModel()
EXACT = {"tolerance": 1e-10, "max_iterations": 200}


class Drive(Component):
    """A motor that keeps the speed of the rotor."""

    def parts(self, assembly):
        return [PrescribedMotion(ROTOR, lambda t: SPEED * t)]


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """Path of a case with beam blades, the same on all ranks."""
    return write_beam_case(COMM.bcast(tmp_path_factory.mktemp("beams")))


@pytest.fixture(scope="module")
def build(path):
    """A small turbine with beam blades in uniform wind, and the state in which it turns."""
    built = {}
    patch = pytest.MonkeyPatch()
    patch.setattr(steady_turbine, "TURNING", {**steady_turbine.TURNING, **EXACT})

    def make(tower="flexible=false", driven=False):
        if (tower, driven) not in built:
            case = Case.load(path, [f"tower.{tower}", "aero.dynamic_stall=oeye", *HUB])
            more = [Drive()] if driven else []
            listed = turbine_model.list_components
            with pytest.MonkeyPatch.context() as own:
                own.setattr(steady_turbine, "list_components", lambda c: [*listed(c), *more])
                rotor = SymmetricTurbine(make_symmetric(case), COMM, ["yaw"])
            state = rotor.solve(OperatingState(WIND, SPEED, PITCH, PITCH))
            built[tower, driven] = rotor, state
        return built[tower, driven]

    yield make
    patch.undo()
    for _, state in built.values():
        state.destroy()


def find(rotor, state, count=12, air=FULL, blades=3):
    problem = AirProblem(rotor.turbine.system, ROTOR, SPEED, state, blades, motions=400)
    try:
        return problem.find(count, air).modes
    finally:
        problem.destroy()


def values(modes):
    return np.array([mode.eigenvalue for mode in modes])


def test_loads_of_the_air_turn_with_the_rotor(build):
    rotor, state = build()
    problem = AirProblem(rotor.turbine.system, ROTOR, SPEED, state, 3, motions=60)
    # structure and air have opposite stiffness for the rotation
    turned, terms = problem.turned, problem.terms[0]
    air = turned @ terms.by_motion @ turned
    assert abs(turned @ problem.stiffness @ turned - air) < 1e-6 * abs(air)
    assert np.linalg.norm(terms.rates_by_motion @ turned) < 1e-5
    problem.destroy()


@pytest.mark.parametrize(
    "air", [FULL, AirModel(("wake",)), AirModel(("wake",), ("stall", "shed wake"))]
)
def test_blades_see_the_same_motions_from_the_ground_and_from_the_rotor(build, air):
    rotor, state = build()
    from_ground, from_rotor = (find(rotor, state, 12, air, blades) for blades in (3, None))
    shifts = {"forward": -1j, "backward": 1j, "collective": 0j}
    seen = np.array([m.eigenvalue + SPEED * shifts[m.whirl.name] for m in from_ground])
    seen = np.where(seen.imag < 0.0, seen.conj(), seen)
    # those far below the largest that was asked for are in both sets
    there = values(from_rotor)
    compared = [s for s in seen if abs(s) < 0.9 * np.max(np.abs(there))]
    assert len(compared) >= 5
    for s in compared:
        assert np.min(np.abs(there - s)) < 1e-6 * abs(s)


def test_a_tower_moves_with_the_rotor_and_is_damped_by_the_air(build):
    rotor, state = build("model=beam")
    modes = find(rotor, state, 4)
    problem = AirProblem(rotor.turbine.system, ROTOR, SPEED, state, 3)
    still = problem.find_still(4).modes
    problem.destroy()
    # fore-aft is damped by the thrust, side-side hardly
    assert max(m.damping_ratio for m in modes[:2]) > 1.5 * max(m.damping_ratio for m in still[:2])


def test_a_state_that_is_no_equilibrium_is_refused(build):
    rotor, state = build()
    rotor.wind.set_speed(1.3 * WIND)
    with pytest.raises(ModelError, match=r"not in equilibrium with the air.* forces lack \d+ %"):
        find(rotor, state, 3)
    rotor.wind.set_speed(WIND)


def test_the_pitch_changes_the_torque_as_between_steady_states(build):
    rotor, state = build("model=beam")
    none = np.zeros((1, 1))
    feedback = Feedback(
        {ROTOR: 1.0},
        {name: OPENFAST_SIGNS[name] for name in BEARINGS},
        none,
        none[0],
        np.zeros((3, 1)),
    )
    problem = AirProblem(rotor.turbine.system, ROTOR, SPEED, state, motions=400, feedback=feedback)
    (terms,), turned, n = problem.terms, problem.turned, problem.generator
    problem.destroy()
    # everything but the rotor follows a pitch of 1 rad at rest, and so does the air
    balance = -np.linalg.solve(terms.rates_by_states + terms.whirl, terms.rates_by_motion)
    stiffness = problem.stiffness - terms.by_motion - terms.by_states @ balance
    others = null_space(turned[None, :-1])
    motion = np.append(
        -others
        @ np.linalg.solve(others.T @ stiffness[:-1, :-1] @ others, others.T @ stiffness[:-1, -1]),
        1.0,
    )
    found = -(turned @ stiffness @ motion) / (turned @ n)
    change, torques = 2e-4, []
    for pitch in (PITCH + change, PITCH - change):
        operating = OperatingState(WIND, SPEED, pitch, pitch)
        near = rotor.solve(operating, state)
        torques.append(rotor.find_power(near, operating) / SPEED)
        near.destroy()
    rotor.solve(OperatingState(WIND, SPEED, PITCH, PITCH), state).destroy()
    assert found == pytest.approx((torques[0] - torques[1]) / (2.0 * change), rel=1e-3)


def test_a_run_that_is_kicked_decays_as_its_mode(build):
    rotor, state = build(driven=True)
    system, h = rotor.turbine.system, 0.01
    mode = min(find(rotor, state, 9), key=lambda m: m.damping_ratio)
    body, axis = system.flexible_models[0], turning_frame(system, ROTOR, SPEED, state).axis
    shape = mode.real.u[0].array_r.reshape(-1, 3)
    mine = slice(0, body.dense_block // 3)

    def run(kick):
        start = state.copy()
        start.v[0].array[:] += kick * mode.real.u[0].array_r
        start.q_dot[:] += kick * mode.real.q
        start.joint_rates[:] += kick * mode.real.joint_coordinates
        seen = []

        class Record:
            def start(self, snapshot, resumed):
                self.observe(snapshot)

            def observe(self, snapshot):
                now = snapshot.state
                x = (body.positions + now.u[0].array_r.reshape(-1, 3))[mine]
                seen.append(
                    np.sum(shape[mine] * (body.mass @ (x @ rotation_about(axis, SPEED * now.time))))
                )

            def finish(self):
                pass

        stepper = EnergyMomentum(system)
        Simulation(system, h, 4.0, observers=[Record()], start=start, stepper=stepper).run()
        start.destroy()
        return np.array(seen)

    motion = run(1.0) - run(0.0)
    t = h * np.arange(len(motion))
    late = t > 1.0
    t, motion = t[late], motion[late] / np.max(np.abs(motion[late]))

    def miss(p):
        return p[0] * np.exp(p[1] * t) * np.cos(p[2] * t + p[3]) + p[4] - motion

    s = mode.eigenvalue
    shift = {"forward": -SPEED, "backward": SPEED, "collective": 0.0}[mode.whirl.name]
    fits = [
        least_squares(miss, [1.0, s.real, s.imag + shift, phase, 0.0]) for phase in (0.0, 2.0, 4.0)
    ]
    p = min(fits, key=lambda fit: fit.cost).x
    # the step's own share is undone
    found = 2.0 / h * np.tanh(complex(p[1], p[2]) * h / 2.0)
    assert found.real == pytest.approx(s.real, rel=0.01)


@pytest.mark.parallel
def test_all_numbers_of_ranks_find_the_same(path):
    given, wanted = (
        Case.load(path, [*HUB, "tower.model=beam", *CONTROLLED]),
        WindModesWanted((12.0,), 5, locked=("yaw",), controlled=True),
    )
    (together,), _ = find_wind_modes(given, None, COMM, wanted)
    (alone,), _ = find_wind_modes(given, None, MPI.COMM_SELF, wanted)
    for a, b in zip(together.rows, alone.rows, strict=True):
        assert a.name == b.name
        assert (a.frequency, a.damping_ratio) == pytest.approx(
            (b.frequency, b.damping_ratio), rel=1e-5
        )
