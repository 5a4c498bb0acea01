"""Claims about modes in the air: rotation has no stiffness, frames agree, runs decay so."""

from mpi4py import MPI

import numpy as np
import pytest
from beam_turbines import CONTROLLED, write_beam_case
from reduced_turbines import COMM
from scipy.linalg import null_space

from turbine_fenicsx import Case
from turbine_fenicsx.analysis.air_modes import AirModel, AirProblem
from turbine_fenicsx.analysis.feedback import Feedback
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.records.conventions import OPENFAST_SIGNS
from turbine_fenicsx.turbine.components.nacelle import ROTOR
from turbine_fenicsx.turbine.components.pitch import BEARINGS
from turbine_fenicsx.turbine.modes.kicked_run import DampingWanted, find_damping
from turbine_fenicsx.turbine.modes.symmetric_turbine import SymmetricTurbine, make_symmetric
from turbine_fenicsx.turbine.modes.wind_modes import WindModesWanted, find_wind_modes
from turbine_fenicsx.turbine.steady import steady_turbine
from turbine_fenicsx.turbine.steady.operating_states import OperatingState

WIND, SPEED, PITCH = 9.0, 2.6, 0.05
HUB = ["turbine.hub.centre=[0.0, 0.0, 0.0]", "turbine.hub.inertia=[900.0, 900.0, 1500.0, 0, 0, 0]"]
CONSERVING = "turbine.numerical_dissipation=0"
FULL = AirModel()
EXACT = {"tolerance": 1e-10, "max_iterations": 200}


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

    def make(tower="flexible=false"):
        if tower not in built:
            case = Case.load(path, [f"tower.{tower}", "aero.dynamic_stall=oeye", *HUB])
            rotor = SymmetricTurbine(make_symmetric(case), COMM, ["yaw"])
            built[tower] = rotor, rotor.solve(OperatingState(WIND, SPEED, PITCH, PITCH))
        return built[tower]

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


def test_models_that_the_air_does_not_have_are_refused(build):
    rotor, state = build()
    with pytest.raises(ModelError, match=r"no model 'wakes'; there are \['shed wake', 'stall', "):
        find(rotor, state, 3, AirModel(("wakes",)))


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


def kick(path, comm, mode, cycles, *changes):
    """The damping of a mode of the small turbine on a beam tower."""
    case = Case.load(path, [*HUB, "tower.model=beam", CONSERVING, *changes])
    modes = WindModesWanted((9.0,), 8, locked=("yaw",))
    damping, _ = find_damping(case, None, comm, DampingWanted(modes, mode, cycles=cycles))
    return damping


@pytest.mark.parametrize(
    ("mode", "cycles"), [("first edge, backward whirl", 8.0), ("first flap, forward whirl", 4.0)]
)
def test_runs_that_are_kicked_decay_as_their_modes(path, mode, cycles):
    found = kick(path, COMM, mode, cycles, "time.step=0.01")
    s = found.eigenvalue
    assert found.decay.eigenvalue.real == pytest.approx(s.real, rel=0.002)
    assert found.decay.eigenvalue.imag == pytest.approx(s.imag, rel=0.001)
    assert found.decay.miss < 0.001
    work = found.work
    assert work.air + work.structure + work.drive == pytest.approx(-s.real, rel=1e-12)
    assert sum(np.sum(part) for part in work.sections) == pytest.approx(work.air, rel=0.05)
    assert work.structure > 0.0 and work.air > 0.0


def test_the_works_of_a_rotor_on_a_rigid_tower_are_its_whole_decay(build):
    rotor, state = build()
    problem = AirProblem(rotor.turbine.system, ROTOR, SPEED, state, 3, motions=400)
    for mode in problem.find(8).modes:
        assert abs(problem.find_work(mode).drive) < 1e-6 * abs(mode.eigenvalue.real)
    problem.destroy()


@pytest.mark.parallel
def test_all_numbers_of_ranks_measure_the_same_decay(path):
    together, alone = (
        kick(path, comm, "first edge, backward whirl", 0.5, "time.step=0.05")
        for comm in (COMM, MPI.COMM_SELF)
    )
    assert together.decay.measured == pytest.approx(alone.decay.measured, abs=1e-5)
    assert together.work.air == pytest.approx(alone.work.air, rel=1e-5)
    assert together.work.structure == pytest.approx(alone.work.structure, rel=1e-5)


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
