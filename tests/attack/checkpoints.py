"""The newest checkpoint with bits flipped, cut, or filled with zeros or garbage."""

import json
import logging

from mpi4py import MPI

import numpy as np

from tests.attack._runs import RIGID, command
from tests.attack._tally import Tally

TRIES = 6000


def attack(tries, random, folder):
    """Damage, read, compare with what was written; only the one before may come in its place."""
    from turbine_fenicsx.records.checkpoint_file import list_checkpoints
    from turbine_fenicsx.simulation.checkpoint import Checkpoints
    from turbine_fenicsx.turbine.case.case import Case
    from turbine_fenicsx.turbine.components.model import build_turbine

    logging.disable(logging.WARNING)  # each try is warned of
    tally, out = Tally(), folder / "run"
    changes = ("time.end=0.06", "output.checkpoint_every=0.02")
    result = command("run", RIGID, "-o", out, "--quiet", "--set", *changes)
    assert result.returncode == 0, result.stderr
    system = build_turbine(Case.load(RIGID, changes), MPI.COMM_SELF).system
    checkpoints = out / "checkpoints"
    newest = list_checkpoints(checkpoints)[0]
    whole = newest.read_bytes()

    def read():
        data = Checkpoints(system, checkpoints).load()
        return json.dumps(data.numbers), data.arrays

    intact = read()
    newest.unlink()
    older = read()
    for k in range(tries):
        data, what = damage(whole, random)
        newest.write_bytes(data)
        try:
            found = read()
        except Exception as error:
            tally.break_(f"try {k}, {what}: {type(error).__name__}: {error}")
            continue
        if same(found, older):
            tally.hold("passed over, the one before was taken")
        elif data == whole and same(found, intact):
            tally.hold("not damaged at all")
        else:
            tally.break_(f"try {k}, {what}: taken for intact")
    logging.disable(logging.NOTSET)
    return tally


def same(a, b):
    """Whether two checkpoints hold the same, bit for bit."""
    return (
        a[0] == b[0]
        and a[1].keys() == b[1].keys()
        and all(np.array_equal(a[1][name], b[1][name]) for name in b[1])
    )


def damage(whole, random):
    """A damaged copy of the bytes of a file, and what was done."""
    data, n = bytearray(whole), len(whole)
    kind = random.choice(["flip", "flips", "cut", "zeros", "garbage", "swap"])
    at, length = int(random.integers(n)), int(random.integers(1, 200))
    if kind in ("flip", "flips"):
        for bit in random.integers(0, 8 * n, 1 if kind == "flip" else length):
            data[int(bit) // 8] ^= 1 << int(bit) % 8
    elif kind == "cut":
        del data[at:]
    elif kind == "swap":
        other = int(random.integers(n))
        data[at : at + length], data[other : other + length] = (
            data[other : other + length],
            data[at : at + length],
        )
    else:
        span = slice(at, min(n, at + length))
        size = span.stop - span.start
        data[span] = bytes(size) if kind == "zeros" else random.bytes(size)
    return bytes(data), f"{kind} at {at} of {n}"
