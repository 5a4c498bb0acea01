"""Claims about the files of the motion of reduced bodies."""

import json

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import InputError, ModelWarning
from turbine_fenicsx.records import motion_file
from turbine_fenicsx.records.motion_file import (
    MotionFile,
    MovedBody,
    count_rows,
    describe_rows,
    read_motion,
)

COMM = MPI.COMM_SELF
BODY = MovedBody("blades", 2, 5, "abc")
HEAD = describe_rows(["hub"], [BODY])


def row(t):
    return np.concatenate([[t], t + np.arange(24 + 2 * BODY.width)])


@pytest.fixture
def path(tmp_path):
    file = MotionFile(COMM, tmp_path / "motion.bin", ["hub"], [BODY], None)
    for t in (0.0, 0.1, 0.2):
        file.append(row(t))
    assert file.sync() == 3
    return tmp_path / "motion.bin"


def test_rows_are_read_by_what_they_are(path):
    motion = read_motion(path)
    assert motion.rigid == ("hub",)
    assert motion.bodies == (BODY,)
    assert motion.times.tolist() == [0.0, 0.1, 0.2]
    assert motion.q[1].tolist() == (0.1 + np.arange(12)).tolist()
    assert motion.q_dot[1].tolist() == (0.1 + np.arange(12, 24)).tolist()
    z, v = motion.vectors["blades"], motion.velocities["blades"]
    assert z.shape == v.shape == (3, 2, 5, 3)
    assert z[2].ravel().tolist() == (0.2 + np.arange(24, 54)).tolist()
    assert v[2].ravel().tolist() == (0.2 + np.arange(54, 84)).tolist()


def test_vectors_are_read_when_they_are_asked_for_in_any_rows(path, monkeypatch):
    monkeypatch.setattr(motion_file, "BLOCK", 1)  # row by row
    motion = read_motion(path)
    z = motion.vectors["blades"]
    whole = z[:]
    assert len(z) == 3 and whole.shape == z.shape
    for key in (1, -1, slice(1, 3), slice(0, 3, 2), slice(2, 1), slice(-2, None)):
        assert np.array_equal(z[key], whole[key]), key
        assert np.array_equal(z[key, 1], whole[key, 1]), key
    with pytest.raises(IndexError):
        z[3]
    with path.open("r+b") as file:
        file.truncate(100)
    with pytest.raises(InputError, match="has become shorter since it was opened"):
        z[2]


def test_a_row_that_a_crash_cut_off_is_left_out(path):
    with path.open("ab") as file:
        file.write(row(0.3).tobytes()[:-5])
    with pytest.warns(ModelWarning, match="motion.bin is whole up to row 3; those from there on"):
        assert len(read_motion(path).times) == 3
    file = MotionFile(COMM, path, ["hub"], [BODY], 0.2)
    assert file.rows == 2
    file.append(row(0.2))
    assert read_motion(path).times.tolist() == [0.0, 0.1, 0.2]


@pytest.mark.parametrize("bad", [0.0 * row(0.3), np.nan * row(0.3), row(0.1)])
def test_rows_from_one_on_that_a_power_cut_left_are_left_out(path, bad):
    with path.open("ab") as file:
        file.write(np.concatenate([bad, row(0.4)]).tobytes())
    with pytest.warns(ModelWarning, match="motion.bin is whole up to row 3; those from there on"):
        assert read_motion(path).times.tolist() == [0.0, 0.1, 0.2]
    assert count_rows(path, 1.0, HEAD) == 3
    assert MotionFile(COMM, path, ["hub"], [BODY], 1.0).rows == 3
    assert read_motion(path).times.tolist() == [0.0, 0.1, 0.2]


def test_rows_before_a_time_are_counted(path):
    assert count_rows(path, 0.15, HEAD) == 2
    path.unlink()
    assert count_rows(path, 0.15, HEAD) == 0


def test_a_file_whose_meaning_is_missing_is_named_and_continued(path):
    head = path.with_suffix(".json")
    text = head.read_text()
    head.unlink()
    with pytest.raises(InputError, match=r"cannot read '.*motion\.json': No such file"):
        read_motion(path)
    assert count_rows(path, 0.15, HEAD) == 2
    assert MotionFile(COMM, path, ["hub"], [BODY], 0.2).rows == 2
    assert head.read_text() == text
    with pytest.raises(InputError, match=r"is a folder, name the motion\.bin in it"):
        read_motion(path.parent)


def test_files_of_other_bodies_are_not_continued(path):
    other = MovedBody("blades", 3, 5, "abc")
    with pytest.raises(InputError, match="holds the motion of other bodies"):
        MotionFile(COMM, path, ["hub"], [other], 0.1)


@pytest.mark.parametrize(
    "change",
    [
        lambda head: head | {"version": 2},
        lambda head: head | {"byte_order": "middle"},
        lambda head: {"version": 1},
        lambda head: head | {"bodies": [{"name": "blades"}]},
        lambda head: head | {"bodies": [vars(BODY) | {"copies": -1}]},
        lambda head: head | {"bodies": [vars(BODY) | {"vectors": 0}]},
        lambda head: [head],
        lambda head: head | {"rigid_bodies": 3},
    ],
)
def test_heads_that_are_wrong_are_refused(path, change):
    head = path.with_suffix(".json")
    head.write_text(json.dumps(change(json.loads(head.read_text()))))
    with pytest.raises(InputError, match="is not the motion of a run"):
        read_motion(path)
    head.write_text("{")
    with pytest.raises(InputError, match="is not the motion of a run"):
        read_motion(path)
    head.unlink()
    with pytest.raises(InputError, match="cannot read"):
        read_motion(path)
