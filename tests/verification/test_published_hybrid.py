"""Hybrid benchmarks of ``demos/verification``: short versions of them."""

import numpy as np
import pytest
from runs import comm

PINNED = 1e-9


def test_flexible_coupler_bends_like_a_chain_of_rigid_pieces(published):
    run = published.load("flexible_coupler")
    solid, errors = run.solid((8, 1, 1), steps=150)
    chain = {n: run.chain(n, steps=150) for n in (4, 8)}
    limit = (4.0 * chain[8] - chain[4]) / 3.0
    size = np.max(np.abs(limit))
    assert size > 0.002  # [m]; it does bend
    # measured: 1.2 %, most of it the coarse mesh of the solid
    assert np.max(np.abs(solid - limit)) < 0.02 * size
    assert [solid[-1], chain[8][-1]] == pytest.approx([0.00117070182, 0.00117723768], abs=PINNED)
    # forces and moments on the ends by Newton's laws; measured: 1e-11
    assert np.max(errors) < 1e-10


def test_reactions_are_compared_with_what_they_should_be(published):
    run = published.load("flexible_coupler")
    system, couplings = run.parts.with_solid(comm, (8, 1, 1))
    balance = run.Balance(system, couplings[:1])  # the other end is left out
    run.run(system, 10, [balance])
    # measured: 0.16; with both ends 2e-11
    assert np.min(np.max(balance.errors, axis=0) / np.max(balance.sizes, axis=0)) > 0.1


def test_three_revolutions_of_the_turbine(published, shared_tmp_path):
    compute = published.load("thousand_revolutions", "compute")
    found = compute.simulate(shared_tmp_path, end=22.0, comm=comm)
    assert found["revolutions"] == pytest.approx(3.0362534504, abs=PINNED)
    assert found["halved_steps"] == 0
    assert found["largest_turn"] < 0.07  # 99 steps per revolution
    # round-off; measured: 4e-15, 1e-13, 1e-13, 1e-14, 3e-15
    assert found["angle_gap"] < 1e-13
    assert found["energy_drift"] < 1e-11
    assert found["energy_balance"] < 1e-11
    assert found["vertical_momentum"] < 1e-11
    assert found["constraints"] < 1e-12


def test_thousand_revolutions_were_run_as_they_would_be_now(published):
    run, compute = (published.load("thousand_revolutions", n) for n in ("run", "compute"))
    found = published.read_long_run("thousand_revolutions")
    assert found["steps"] == round(compute.END / compute.STEP)
    assert found["step"] == pytest.approx(compute.STEP, rel=1e-12)
    assert found["revolutions"] > 1000.0
    assert found["halved_steps"] == 0
    assert found["largest_turn"] < 0.07
    for row in run.main():
        assert row.holds, row.quantity
