"""Claims about what is in checkpoints, which are read, and which are refused."""

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx import Gravity, Hat, JointTorque, Revolute
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.records.checkpoint_file import (
    list_checkpoints,
    read_arrays,
    read_head,
    write_checkpoint,
)
from turbine_fenicsx.simulation.checkpoint import (
    KEPT_CHECKPOINTS,
    Checkpoints,
    restore_state,
    save_state,
)
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel


def test_everything_comes_back_bit_for_bit(system, example, shared_tmp_path):
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


def test_another_number_of_ranks_finds_its_nodes(comm, machine, shared_tmp_path):
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


def test_nodes_in_another_order_are_found_by_position(system, example, shared_tmp_path):
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


def test_the_last_two_are_kept_and_nothing_else(system, example, shared_tmp_path):
    checkpoints = Checkpoints(system, shared_tmp_path)
    for index in (0, 3, 9, 10, 100):
        checkpoints.write(index, 0.02 * index, 0.0, example)
    system.comm.barrier()
    names = sorted(p.name for p in shared_tmp_path.iterdir())
    assert names == ["checkpoint_00000010.npz", "checkpoint_00000100.npz"]
    assert [p.name for p in list_checkpoints(shared_tmp_path)] == names[::-1]
    assert len(names) == KEPT_CHECKPOINTS == 2


def test_those_of_an_earlier_run_can_be_removed(system, example, shared_tmp_path):
    checkpoints = Checkpoints(system, shared_tmp_path)
    for index in (0, 3):
        checkpoints.write(index, 0.0, 0.0, example)
    Checkpoints(system, shared_tmp_path).clear()
    assert not list_checkpoints(shared_tmp_path)
    with pytest.raises(InputError, match="there is no checkpoint in"):
        Checkpoints(system, shared_tmp_path).load()


def test_a_newest_one_that_is_incomplete_is_passed_over(system, example, shared_tmp_path):
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


def test_one_flipped_bit_is_enough_to_pass_one_over(system, example, shared_tmp_path, caplog):
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
            assert said.startswith("resuming from checkpoint_00000001.npz: checkpoint_00000002")
            assert "checksum" in said
        system.comm.barrier()
    if rank == 0:
        path.write_bytes(whole)
    system.comm.barrier()
    assert Checkpoints(system, shared_tmp_path).load().numbers["index"] == 2


def test_one_that_was_written_anew_by_hand_is_refused(system, example, shared_tmp_path):
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


def test_numbers_count_and_not_their_digits(system, example, shared_tmp_path):
    """The run of more than a hundred million steps."""
    checkpoints = Checkpoints(system, shared_tmp_path)
    for index in (99_999_998, 99_999_999, 100_000_000):
        checkpoints.write(index, 1.0, 0.0, example)
    names = [p.name for p in list_checkpoints(shared_tmp_path)]
    assert names == ["checkpoint_100000000.npz", "checkpoint_99999999.npz"]


def test_those_of_later_steps_are_removed_when_the_run_goes_on_before_them(
    system, example, shared_tmp_path
):
    """Or they would be gone on from later, though they belong to another past."""
    checkpoints = Checkpoints(system, shared_tmp_path)
    for index in (3, 5):
        checkpoints.write(index, 0.1 * index, 0.0, example)
    Checkpoints(system, shared_tmp_path).write(3, 0.3, 0.0, example)
    assert [p.name for p in list_checkpoints(shared_tmp_path)] == ["checkpoint_00000003.npz"]


def test_if_none_can_be_read_that_is_said(system, shared_tmp_path):
    if system.comm.rank == 0:
        for index in (1, 2):
            (shared_tmp_path / f"checkpoint_0000000{index}.npz").write_bytes(b"")
    system.comm.barrier()
    with pytest.raises(InputError, match=r"no checkpoint in .* can be used"):
        Checkpoints(system, shared_tmp_path).load()


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
def test_one_of_another_mesh_is_refused(comm, machine, shared_tmp_path, cell):
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


def test_labels_must_be_those_written(system, example, shared_tmp_path):
    Checkpoints(system, shared_tmp_path, {"mesh": "abc"}).write(1, 0.0, 0.0, example)
    for labels in (None, {"mesh": "abc"}):
        assert Checkpoints(system, shared_tmp_path, labels).load()
    words = "the mesh has changed, it was abc and is def"
    with pytest.raises(InputError, match=words):  # on all ranks
        Checkpoints(system, shared_tmp_path, {"mesh": "def"}).load()


def test_one_of_other_parts_is_refused(machine, example, system, shared_tmp_path):
    Checkpoints(system, shared_tmp_path).write(1, 0.0, 0.0, example)
    other = machine().system(Gravity(), JointTorque("torque on rotor", "rotor", 1.0, Hat(1.0, 1.0)))
    with pytest.raises(InputError, match=r"cannot resume .*: the list of parts has changed"):
        Checkpoints(other, shared_tmp_path).load()


def test_one_of_the_same_names_but_other_joints_is_refused(comm, shared_tmp_path):
    """Three parallel hinges have one more redundant constraint than two and one across."""

    def simulation(axis):
        a, b = (
            RigidBody(n, 1.0, (1, 1, 1), position=x)
            for n, x in (("a", (1, 0, 0)), ("b", (3, 0, 0)))
        )
        hinges = [
            Revolute("first", None, a, point=(0, 0, 0), axis=(0, 0, 1)),
            Revolute("second", a, b, point=(2, 0, 0), axis=(0, 0, 1)),
            Revolute("third", b, None, point=(4, 0, 0), axis=axis),
        ]
        system = MultibodySystem(comm, [a, b, *hinges])
        checkpoints = Checkpoints(system, shared_tmp_path)
        return Simulation(system, 0.01, 0.01, checkpoints=checkpoints)

    simulation((0, 0, 1)).run()
    with pytest.raises(InputError, match="another system, with 26 multipliers and not 27"):
        simulation((0, 1, 0)).resume()
