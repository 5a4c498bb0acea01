"""A run that goes on from a checkpoint is the run that was never stopped."""

import copy
import gc
import os
import shutil
from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx.forces import Gravity, JointTorque
from turbine_fenicsx.forces.time_functions import Hat
from turbine_fenicsx.foundation.errors import FileError, InputError
from turbine_fenicsx.linear_solvers import FrozenElimination, QuasiNewton, quasi_newton
from turbine_fenicsx.simulation.checkpoint import (
    KEPT,
    Checkpoints,
    restore_state,
    save_state,
    write_restart_data,
)
from turbine_fenicsx.simulation.checkpoint_file import (
    list_checkpoints,
    read_arrays,
    read_head,
    write_checkpoint,
)
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.simulation.step_error import StepError
from turbine_fenicsx.system.restart_data import RestartData
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.extrapolation import Extrapolation
from turbine_fenicsx.time_stepping.newton import SolverOptions
from turbine_fenicsx.time_stepping.stepper import StepFailure


class Keeper:
    """Stands for `Checkpoints`: keeps the restart data of every step."""

    def __init__(self):
        self.saved = {}

    def due(self, time, wall_time):
        return True

    def write(self, index, time, wall_time, data):
        self.saved[index] = copy.deepcopy(data)


class Recorder:
    """Writes down what observers see, but for wall times."""

    def __init__(self):
        self.seen = {}

    def start(self, snapshot, resumed):
        self.observe(snapshot)

    def observe(self, s):
        state, b = s.state, s.balance
        vectors = [x.array.copy() for x in (*state.u, *state.v, *state.coupling)]
        arrays = [state.q, state.q_dot, state.angles, state.angle_rates, state.multipliers]
        numbers = [state.time, b.total, s.external_work, s.energy_error, s.constraint_error]
        self.seen[s.index] = (numbers, [x.copy() for x in arrays], vectors, s.report)

    def finish(self):
        pass


def equal(a, b):
    """Whether two records of a step are the same bit for bit, but for a missing report."""
    same = a[0] == b[0] and (a[3] == b[3] or None in (a[3], b[3]))
    return same and all(
        np.array_equal(x, y) for k in (1, 2) for x, y in zip(a[k], b[k], strict=True)
    )


class Fussy:
    """A step solver that fails where ``fails(time, dt)`` says so, else the real one."""

    def __init__(self, solver, fails):
        self.solver, self.fails = solver, fails

    def __getattr__(self, name):
        return getattr(self.solver, name)

    def advance(self, state, dt, out):
        if self.fails(state.time, dt):
            raise StepFailure(f"no solution from t = {state.time}")
        return self.solver.advance(state, dt, out)


@pytest.fixture
def flexible(machine):
    """The machine under gravity and torques, strongly deformed."""
    loads = [Gravity(), JointTorque("rotor", Hat(40.0, 0.4)), JointTorque("yaw", Hat(5.0, 1.0))]
    return machine(spin=3.0).system(*loads)


def simulate(system, data=None, *, step=0.02, end=0.16, fails=None, **options):
    """Run from the start or from restart data; returns what it recorded and saved, and itself."""
    recorder, keeper = Recorder(), Keeper()
    options = {"checkpoints": keeper} | options
    simulation = Simulation(system, step, end, [recorder], **options)
    if fails is not None:
        simulation.stepper = Fussy(simulation.stepper, fails)
    simulation.run(data)
    return recorder.seen, keeper.saved, simulation


def goes_on_everywhere(system, make_options, every=1):
    """A run, and the same from each of its checkpoints on. Returns the run and what it saved."""
    whole, saved, simulation = simulate(system, **make_options())
    last = max(whole)
    for index in range(0, last + 1, every):
        part, _, again = simulate(system, saved[index], **make_options())
        assert sorted(part) == list(range(index, last + 1)), index
        for k, record in part.items():
            assert equal(record, whole[k]), (index, k)
        assert again.halvings == simulation.halvings
        again.stepper.destroy()
    return whole, saved, simulation


@pytest.mark.parametrize("name", ["frozen", "iterative", "lu", "monolithic"])
def test_a_run_goes_on_bit_for_bit_with_any_linear_solver(flexible, name):
    def stepper(chosen=name):
        return EnergyMomentum(flexible, options=SolverOptions(linear_solver=chosen))

    whole, *_ = goes_on_everywhere(flexible, lambda: {"stepper": stepper()}, every=3)
    if name == "frozen":  # without its factor it would not be the same
        other, *_ = simulate(flexible, stepper=stepper("lu"))
        assert not equal(whole[8], other[8])


def test_a_run_goes_on_with_the_factor_it_had(flexible, monkeypatch):
    """The factor of a later state gives other digits: it must be the one of the whole run."""
    whole, saved, _ = simulate(flexible)
    monkeypatch.setattr(QuasiNewton, "restore", lambda self, data: None)
    part, *_ = simulate(flexible, saved[5])
    assert not equal(part[6], whole[6])


def test_a_run_goes_on_bit_for_bit_after_and_before_a_refreshed_factor(flexible, monkeypatch):
    """A step of many iterations is followed by a refresh, with or without a stop in between."""
    refreshed = []
    real_begin = QuasiNewton.begin

    def begin(self):
        refreshed.append(self._excess >= quasi_newton.RENEWAL)
        real_begin(self)

    monkeypatch.setattr(QuasiNewton, "begin", begin)
    monkeypatch.setattr(quasi_newton, "ORDINARY", 5)
    monkeypatch.setattr(quasi_newton, "RENEWAL", 3)
    _, saved, _ = goes_on_everywhere(flexible, dict)
    assert 0 < sum(refreshed[:8]) < 8  # sometimes, but not always
    due = [saved[k].numbers["solver.linear.excess"] >= 3 for k in range(1, 9)]
    assert set(due) == {True, False}  # checkpoints just before a refresh, and others


def test_a_run_goes_on_bit_for_bit_while_the_exact_solver_stands_in(flexible, monkeypatch):
    """Which solver goes first, and for how long, is part of what a run saves."""
    real = FrozenElimination.solve

    def poor_solve(self, b, x):
        real(self, b, x)
        if self._step.start.state.time < 0.045:
            x.scale(-1e9)

    monkeypatch.setattr(FrozenElimination, "solve", poor_solve)
    _, saved, simulation = goes_on_everywhere(flexible, dict)
    assert simulation.stepper.fallbacks >= 2
    waits = [data.numbers["solver.attempts.wait"] for data in saved.values()]
    assert 0 < min(filter(None, waits)) and 0 in waits


def test_a_run_goes_on_bit_for_bit_in_the_middle_of_halved_steps(flexible):
    def options():
        return {"fails": lambda t, dt: 0.045 < t < 0.12 and dt > 0.003, "end": 0.18}

    _, saved, simulation = goes_on_everywhere(flexible, options, every=2)
    assert simulation.halvings >= 3
    assert len({m.numbers["level"] for m in saved.values()}) >= 3
    assert sum(m.numbers["ticks"] > 0 for m in saved.values()) >= 5


@pytest.fixture
def rigid(comm, machine):
    """The rigid part of the machine; its first guesses come from the last steps."""
    m = machine(spin=3.0)
    torque = JointTorque("rotor", Hat(40.0, 0.2))
    return MultibodySystem(comm, [m.nacelle, m.hub, m.yaw, m.rotor, Gravity(), torque])


def test_a_rigid_run_goes_on_bit_for_bit(rigid, monkeypatch):
    whole, saved, _ = goes_on_everywhere(rigid, lambda: {"end": 0.3})
    monkeypatch.setattr(Extrapolation, "restore", lambda self, data: None)
    part, *_ = simulate(rigid, saved[9], end=0.3)
    assert not equal(part[10], whole[10])  # from another guess it would not be the same


def test_a_rigid_run_goes_on_bit_for_bit_in_the_middle_of_halved_steps(rigid):
    def options():
        return {"fails": lambda t, dt: 0.145 < t < 0.2 and dt > 0.003, "end": 0.3}

    _, _, simulation = goes_on_everywhere(rigid, options, every=2)
    assert simulation.halvings >= 3


def test_a_rigid_run_goes_on_bit_for_bit_from_a_file(rigid, shared_tmp_path):
    whole, saved, _ = simulate(rigid, end=0.3)
    Checkpoints(rigid, shared_tmp_path).write(9, 0.18, 0.0, saved[9])
    part, *_ = simulate(rigid, Checkpoints(rigid, shared_tmp_path).load(), end=0.3)
    assert all(equal(record, whole[k]) for k, record in part.items())


def test_a_run_goes_on_bit_for_bit_with_steps_that_follow_a_tolerance(comm, flexible):
    def options():
        return {"step_error": StepError(comm, 5e-5, 5e-5), "step": 0.04}

    _, saved, _ = goes_on_everywhere(flexible, options, every=3)
    assert len({m.numbers["level"] for m in saved.values()}) >= 2
    assert sum(m.numbers["ticks"] > 0 for m in saved.values()) >= 5


@pytest.mark.parametrize("step", [0.02, 0.1])
@pytest.mark.parametrize("n", [3, 7])
def test_a_run_that_is_extended_is_as_long_from_the_start(comm, machine, step, n):
    """Also where n dt is not quite the end that the user wrote, such as 0.3 and 3 * 0.1."""
    m = machine(spin=3.0)
    system = MultibodySystem(comm, [m.nacelle, m.hub, m.yaw, m.rotor, Gravity()])
    whole, *_ = simulate(system, step=step, end=round(10 * step, 9))
    first, saved, _ = simulate(system, step=step, end=round(n * step, 9))
    rest, *_ = simulate(system, saved[n], step=step, end=round(10 * step, 9))
    for k in range(11):
        for part in (first, rest):
            assert k not in part or equal(part[k], whole[k]), k


def test_an_end_between_two_steps_can_be_extended(flexible):
    first, saved, _ = simulate(flexible, end=0.05)
    rest, *_ = simulate(flexible, saved[3], end=0.1)
    assert first[3][0][0] == 0.05
    times = [rest[k][0][0] for k in sorted(rest)]
    assert times == pytest.approx([0.05, 0.07, 0.09, 0.1], rel=1e-14)
    assert times[0] == 0.05 and times[-1] == 0.1
    assert abs(rest[6][0][3]) <= 1e-10  # the energy balances over the whole run


def test_the_step_can_change_when_a_run_goes_on(flexible):
    _, saved, _ = simulate(flexible, end=0.06)
    rest, *_ = simulate(flexible, saved[3], step=0.01, end=0.1)
    times = [rest[k][0][0] for k in sorted(rest)]
    assert times == pytest.approx([0.06, 0.07, 0.08, 0.09, 0.1], rel=1e-14)
    assert abs(rest[7][0][3]) <= 1e-10


def test_the_linear_solver_can_change_when_a_run_goes_on(flexible):
    whole, saved, _ = simulate(flexible)
    for name in ("frozen", "lu"):
        other = EnergyMomentum(flexible, options=SolverOptions(linear_solver=name))
        rest, *_ = simulate(flexible, saved[4], stepper=other)
        assert rest[8][1][0] == pytest.approx(whole[8][1][0], abs=1e-9)


@pytest.mark.parametrize("end", [0.06, 0.03])
def test_a_run_that_is_at_its_end_or_beyond_stays_there(flexible, end):
    _, saved, _ = simulate(flexible, end=0.06)
    rest, *_ = simulate(flexible, saved[3], end=end)
    assert sorted(rest) == [3]
    assert rest[3][0][0] == 0.06


def test_a_step_that_fails_leaves_a_checkpoint_of_the_last_good_one(flexible):
    keeper, recorder = Keeper(), Recorder()
    keeper.due = lambda time, wall_time: False
    simulation = Simulation(
        flexible, 0.02, 0.16, [recorder], smallest_step=0.25, checkpoints=keeper
    )
    simulation.stepper = Fussy(simulation.stepper, lambda t, dt: t > 0.05)
    with pytest.raises(StepFailure, match="Steps are not halved below"):
        simulation.run()
    assert sorted(keeper.saved) == [0, max(recorder.seen)]
    rest, _, again = simulate(flexible, keeper.saved[max(recorder.seen)], smallest_step=0.25)
    assert rest[max(rest)][0][0] == 0.16
    assert again.halvings == 2  # those of the failed run


class TestFiles:
    """What is in the folder."""

    @pytest.fixture
    def system(self, machine):
        return machine(spin=3.0).system(Gravity())

    @pytest.fixture
    def example(self, system):
        """A state with a different number everywhere, as restart data."""
        state = system.initial_state()
        random = np.random.default_rng(5 + system.comm.rank)
        for vector in (*state.u, *state.v, *state.coupling):
            vector.array[:] = random.uniform(-1.0, 1.0, vector.getLocalSize())
        random = np.random.default_rng(4)
        for name in ("q", "q_dot", "angles", "angle_rates", "multipliers"):
            values = getattr(state, name)
            values[:] = random.uniform(-1.0, 1.0, values.shape)
        state.time = 0.1 + 0.2  # not 0.3
        data = RestartData({"index": 7, "work": 1.0 / 3.0})
        data.add("state", save_state(system, state))
        return data

    def test_everything_comes_back_bit_for_bit(self, system, example, shared_tmp_path):
        Checkpoints(system, shared_tmp_path / "new" / "folder").write(7, 0.3, 1.0, example)
        data = Checkpoints(system, shared_tmp_path / "new" / "folder").load()
        assert data.numbers == example.numbers
        assert data.arrays.keys() == example.arrays.keys()
        assert data.nodal.keys() == example.nodal.keys()
        for name, values in example.arrays.items():
            assert np.array_equal(data.arrays[name], values), name
        for name, bodies in example.nodal.items():
            for mine, theirs in zip(data.nodal[name], bodies, strict=True):
                assert np.array_equal(mine, theirs), name
        state = restore_state(system, data.part("state"))
        again = save_state(system, state)
        assert again.numbers == {"time": 0.1 + 0.2}
        for name, bodies in again.nodal.items():
            assert all(map(np.array_equal, bodies, example.part("state").nodal[name])), name

    def test_another_number_of_ranks_finds_its_nodes(self, comm, machine, shared_tmp_path):
        """Values are functions of the position. Rank 0 reads alone what all wrote, and all read
        what it wrote alone."""

        def nodal_data(system):
            X = system.flexible_models[0].positions
            return RestartData(nodal={"u": (np.sin(3.0 * X),), "v": (X**2 - X,)})

        def check(system, folder):
            found = Checkpoints(system, folder).load()
            for name, (values,) in nodal_data(system).nodal.items():
                assert found.nodal[name][0] == pytest.approx(values, abs=1e-12), name

        all_ranks, alone = machine().system(), machine(comm=MPI.COMM_SELF).system()
        folder = shared_tmp_path / "all"
        Checkpoints(all_ranks, folder).write(0, 0.0, 0.0, nodal_data(all_ranks))
        check(alone, folder)
        if comm.rank == 0:
            Checkpoints(alone, shared_tmp_path / "one").write(0, 0.0, 0.0, nodal_data(alone))
        comm.barrier()
        check(all_ranks, shared_tmp_path / "one")

    def test_nodes_in_another_order_are_found_by_position(self, system, example, shared_tmp_path):
        """As if another partition had written them."""
        Checkpoints(system, shared_tmp_path).write(7, 0.3, 1.0, example)
        path = shared_tmp_path / "checkpoint_00000007.npz"
        if system.comm.rank == 0:
            head, data = read_head(path), read_arrays(path)
            order = np.random.default_rng(1).permutation(len(data["positions.0"]))
            for name in data:
                if name.startswith(("positions.", "nodal.")):
                    data[name] = data[name][order]
            write_checkpoint(path, head, data)
        system.comm.barrier()
        data = Checkpoints(system, shared_tmp_path).load()
        for name, (values,) in example.nodal.items():
            assert np.array_equal(data.nodal[name][0], values), name

    def test_the_last_two_are_kept_and_nothing_else(self, system, example, shared_tmp_path):
        checkpoints = Checkpoints(system, shared_tmp_path)
        for index in (0, 3, 9, 10, 100):
            checkpoints.write(index, 0.02 * index, 0.0, example)
        system.comm.barrier()
        names = sorted(p.name for p in shared_tmp_path.iterdir())
        assert names == ["checkpoint_00000010.npz", "checkpoint_00000100.npz"]
        assert [p.name for p in list_checkpoints(shared_tmp_path)] == names[::-1]
        assert len(names) == KEPT == 2

    def test_what_another_program_left_half_written_is_removed(
        self, system, example, shared_tmp_path
    ):
        """A program that was killed while it wrote cannot tidy up; a later one can."""
        if system.comm.rank == 0:
            (shared_tmp_path / "checkpoint_00000001.tmp").write_bytes(b"PK")
        system.comm.barrier()
        checkpoints = Checkpoints(system, shared_tmp_path)
        for index in (2, 3):
            checkpoints.write(index, 0.0, 0.0, example)
        system.comm.barrier()
        assert not list(shared_tmp_path.glob("*.tmp"))

    def test_those_of_an_earlier_run_can_be_removed(self, system, example, shared_tmp_path):
        checkpoints = Checkpoints(system, shared_tmp_path)
        for index in (0, 3):
            checkpoints.write(index, 0.0, 0.0, example)
        Checkpoints(system, shared_tmp_path).clear()
        assert not list_checkpoints(shared_tmp_path)
        with pytest.raises(InputError, match="there is no checkpoint in"):
            Checkpoints(system, shared_tmp_path).load()

    def test_a_newest_one_that_is_incomplete_is_passed_over(self, system, example, shared_tmp_path):
        checkpoints = Checkpoints(system, shared_tmp_path)
        checkpoints.write(1, 0.02, 0.0, example)
        checkpoints.write(2, 0.04, 0.0, RestartData({"index": 2}))
        rank, path = system.comm.rank, shared_tmp_path / "checkpoint_00000002.npz"
        whole = system.comm.bcast(path.read_bytes() if rank == 0 else None)
        random = np.random.default_rng(2)
        n = len(whole)
        cuts = [0, 1, 4, 30, 100, n // 2, n - 22, n - 1, *random.integers(0, n, 12)]
        damaged = [whole[: int(cut)] for cut in cuts] + [bytes(n), b"x" * n]
        middle = n // 3
        damaged.append(whole[:middle] + bytes(50) + whole[middle + 50 :])
        for data in damaged:
            if rank == 0:
                path.write_bytes(data)
            system.comm.barrier()
            assert Checkpoints(system, shared_tmp_path).load().numbers["index"] == 7
            system.comm.barrier()

    def test_one_flipped_bit_is_enough_to_pass_one_over(
        self, system, example, shared_tmp_path, caplog
    ):
        """Wherever it is; numbers, names, the head and the checksum itself."""
        checkpoints = Checkpoints(system, shared_tmp_path)
        checkpoints.write(1, 0.02, 0.0, example)
        checkpoints.write(2, 0.04, 0.0, RestartData({"index": 2}))
        rank, path = system.comm.rank, shared_tmp_path / "checkpoint_00000002.npz"
        whole = system.comm.bcast(path.read_bytes() if rank == 0 else None)
        random = np.random.default_rng(6)
        bits = [
            *random.integers(0, 8 * len(whole), 150),
            *range(8 * len(whole) - 8, 8 * len(whole)),
        ]
        for bit in bits:
            damaged = bytearray(whole)
            damaged[int(bit) // 8] ^= 1 << int(bit) % 8
            if rank == 0:
                path.write_bytes(damaged)
            system.comm.barrier()
            caplog.clear()
            assert Checkpoints(system, shared_tmp_path).load().numbers["index"] == 7
            if rank == 0:
                (said,) = (r.getMessage() for r in caplog.records if r.levelname == "WARNING")
                assert said.startswith("going on from checkpoint_00000001.npz: checkpoint_00000002")
                assert "checksum" in said
            system.comm.barrier()
        if rank == 0:
            path.write_bytes(whole)
        system.comm.barrier()
        assert Checkpoints(system, shared_tmp_path).load().numbers["index"] == 2

    def test_one_that_was_written_anew_by_hand_is_refused(self, system, example, shared_tmp_path):
        """As those of the format before this one were: without a checksum, maybe incomplete."""
        Checkpoints(system, shared_tmp_path).write(7, 0.3, 1.0, example)
        path = shared_tmp_path / "checkpoint_00000007.npz"
        if system.comm.rank == 0:
            with np.load(path) as file:
                data = {name: file[name] for name in file.files if name != "array.state.q"}
            np.savez(path, **data)
        system.comm.barrier()
        with pytest.raises(InputError, match=r"00000007.npz was written in an earlier format"):
            Checkpoints(system, shared_tmp_path).load()

    def test_numbers_count_and_not_their_digits(self, system, example, shared_tmp_path):
        """The run of more than a hundred million steps."""
        checkpoints = Checkpoints(system, shared_tmp_path)
        for index in (99_999_998, 99_999_999, 100_000_000):
            checkpoints.write(index, 1.0, 0.0, example)
        names = [p.name for p in list_checkpoints(shared_tmp_path)]
        assert names == ["checkpoint_100000000.npz", "checkpoint_99999999.npz"]

    def test_those_of_later_steps_are_removed_when_the_run_goes_on_before_them(
        self, system, example, shared_tmp_path
    ):
        """Or they would be gone on from later, though they belong to another past."""
        checkpoints = Checkpoints(system, shared_tmp_path)
        for index in (3, 5):
            checkpoints.write(index, 0.1 * index, 0.0, example)
        Checkpoints(system, shared_tmp_path).write(3, 0.3, 0.0, example)
        assert [p.name for p in list_checkpoints(shared_tmp_path)] == ["checkpoint_00000003.npz"]

    def test_a_folder_that_is_deleted_during_the_run_is_not_made_anew(
        self, system, example, shared_tmp_path
    ):
        folder = shared_tmp_path / "checkpoints"
        checkpoints = Checkpoints(system, folder)
        checkpoints.write(1, 0.0, 0.0, example)
        system.comm.barrier()
        if system.comm.rank == 0:
            shutil.rmtree(folder)
        system.comm.barrier()
        with pytest.raises(FileError, match=r"cannot write .*checkpoint_00000002.npz: No such"):
            checkpoints.write(2, 0.0, 0.0, example)
        assert not folder.exists()

    def test_everything_is_on_the_disk_before_a_file_gets_its_name(
        self, system, example, shared_tmp_path, monkeypatch
    ):
        """And the name itself before an older one is removed."""
        checkpoints, calls = Checkpoints(system, shared_tmp_path), []
        for index in (1, 2):
            checkpoints.write(index, 0.0, 0.0, example)

        def spy(name):
            real = getattr(os, name)

            def call(*arguments):
                what = arguments[-1]
                path = Path(os.readlink(f"/proc/self/fd/{what}") if name == "fsync" else what)
                calls.append((name, path.name))
                return real(*arguments)

            monkeypatch.setattr(os, name, call)

        for name in ("fsync", "replace", "unlink"):
            spy(name)
        checkpoints.write(3, 0.0, 0.0, example)
        if system.comm.rank == 0:
            new, old = "checkpoint_00000003.npz", "checkpoint_00000001.npz"
            order = [("fsync", f"{new}.tmp"), ("replace", new), ("fsync", shared_tmp_path.name)]
            assert [call for call in calls if call[0] != "unlink"] == order
            assert calls[-1] == ("unlink", old)

    def test_if_none_can_be_read_that_is_said(self, system, shared_tmp_path):
        if system.comm.rank == 0:
            for index in (1, 2):
                (shared_tmp_path / f"checkpoint_0000000{index}.npz").write_bytes(b"")
        system.comm.barrier()
        with pytest.raises(InputError, match=r"no checkpoint in .* can be used"):
            Checkpoints(system, shared_tmp_path).load()

    @pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
    def test_one_of_another_mesh_is_refused(self, comm, machine, shared_tmp_path, cell):
        """Of other nodes, or of as many nodes elsewhere."""
        system = machine().system()
        block = system.flexible_models[0]
        Checkpoints(system, shared_tmp_path).write(
            1, 0.0, 0.0, RestartData({}, {}, {"u": (np.zeros((block.n_owned, 3)),)})
        )
        if cell == "hexahedron":
            other = machine()
            other.beam.mesh.geometry.x[:, 1] *= 1.001
        else:
            other = machine(degree=2)
        with pytest.raises(InputError, match="the checkpoint belongs to another mesh of 'beam'"):
            Checkpoints(other.system(), shared_tmp_path).load()

    def test_labels_must_be_those_written(self, system, example, shared_tmp_path):
        Checkpoints(system, shared_tmp_path, {"mesh": "abc"}).write(1, 0.0, 0.0, example)
        for labels in (None, {"mesh": "abc"}):
            assert Checkpoints(system, shared_tmp_path, labels).load()
        words = "the mesh has changed, it was abc and is def"
        with pytest.raises(InputError, match=words):  # on all ranks
            Checkpoints(system, shared_tmp_path, {"mesh": "def"}).load()

    def test_one_of_other_parts_is_refused(self, machine, example, system, shared_tmp_path):
        Checkpoints(system, shared_tmp_path).write(1, 0.0, 0.0, example)
        other = machine().system(Gravity(), JointTorque("rotor", Hat(1.0, 1.0)))
        with pytest.raises(
            InputError, match=r"cannot go on with .*: the list of parts has changed"
        ):
            Checkpoints(other, shared_tmp_path).load()

    @pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
    def test_a_failed_one_leaves_the_earlier_ones_alone(self, system, example, shared_tmp_path):
        """The end of the disk is where a limit for files is."""
        resource = pytest.importorskip("resource")
        checkpoints = Checkpoints(system, shared_tmp_path)
        checkpoints.write(1, 0.0, 0.0, example)
        soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
        try:
            with pytest.raises(OSError, match=r"cannot write .*checkpoint_00000002.npz: File too"):
                checkpoints.write(2, 0.02, 0.0, example)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        gc.collect()  # and no noise from what was half written
        system.comm.barrier()
        assert [p.name for p in shared_tmp_path.iterdir()] == ["checkpoint_00000001.npz"]
        assert Checkpoints(system, shared_tmp_path).load().numbers["index"] == 7
        checkpoints.write(2, 0.02, 0.0, example)  # there is room again
        assert len(list_checkpoints(shared_tmp_path)) == 2

    @pytest.mark.parametrize("what", ["folder", "old"])
    def test_what_cannot_be_done_on_rank_0_is_an_error_everywhere(
        self, system, example, shared_tmp_path, what
    ):
        """A file is where the folder should be; folders are where old checkpoints should be."""
        folder = shared_tmp_path / "checkpoints"
        if system.comm.rank == 0:
            if what == "folder":
                folder.write_text("mine")
            for index in (1, 2) if what == "old" else ():
                (folder / f"checkpoint_0000000{index}.npz").mkdir(parents=True)
        system.comm.barrier()
        raised = False
        try:
            Checkpoints(system, folder).write(3, 0.0, 0.0, example)
        except OSError:
            raised = True
        assert system.comm.allgather(raised) == [True] * system.comm.size

    def test_a_file_is_complete_when_it_gets_its_name(
        self, system, example, shared_tmp_path, monkeypatch
    ):
        seen, replace = [], os.replace

        def spy(source, target):
            with np.load(source) as file:  # all of it is there
                seen.append((sorted(file.files), os.path.exists(target)))
            replace(source, target)

        monkeypatch.setattr(os, "replace", spy)
        write_restart_data(shared_tmp_path / "checkpoint_00000001.npz", system, example, {})
        if system.comm.rank == 0:
            ((names, existed),) = seen
            assert not existed
            assert "head" in names and "nodal.state.u.0" in names


@pytest.mark.parametrize(
    ("every", "times", "expected"),
    [
        (0.0, [0.02, 1.0, 50.0], [False, False, False]),
        (0.1, [0.02, 0.08, 0.1, 0.12, 0.18, 0.2], [False, False, True, False, False, True]),
        (0.3, [0.1 + 0.2, 3 * 0.1, 0.6, 0.9], [True, False, True, True]),  # not quite 0.3
        (0.1, [0.1, 0.2, 0.3], [True, True, True]),  # 0.3 / 0.1 is not quite 3
        (0.05, [0.02, 0.04, 0.06, 0.08, 0.1], [False, False, True, False, True]),
    ],
)
def test_checkpoints_are_due_after_simulated_time(flexible, tmp_path, every, times, expected):
    checkpoints = Checkpoints(flexible, tmp_path, every=every)
    checkpoints._written = 0  # nothing is to be written here
    found = []
    for time in times:
        found.append(checkpoints.due(time, 1e9))
        if found[-1]:
            checkpoints.write(0, time, 0.0, RestartData())
    assert found == expected


def test_checkpoints_are_due_after_wall_time(flexible, tmp_path):
    checkpoints = Checkpoints(flexible, tmp_path, every_wall=10.0)
    checkpoints._written = 0
    assert [checkpoints.due(0.0, t) for t in (0.0, 9.9, 10.1)] == [False, False, True]
    checkpoints.write(0, 0.0, 10.1, RestartData())
    assert [checkpoints.due(0.0, t) for t in (10.2, 20.0, 20.2)] == [False, False, True]
