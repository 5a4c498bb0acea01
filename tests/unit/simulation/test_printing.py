"""Claims about what users read who print an object: a few lines, on each rank alone."""

import numpy as np
import pytest
from bricks import body_system, brick

from turbine_fenicsx import Simulation, modes

pytestmark = pytest.mark.parallel


def test_a_system_lists_its_parts(machine):
    system = machine().system()
    lines = repr(system).splitlines()
    unknowns = system.rigid_model.size + sum(system.coupling_blocks[0].C.getSize())
    assert lines[0] == f"MultibodySystem with {unknowns} unknowns"
    assert "  rigid bodies      2: nacelle, hub" in lines
    assert len(lines) <= 9


def test_a_snapshot_tells_energies_and_errors(machine):
    last = Simulation(machine().system(), 0.01, 0.02).run()
    lines = repr(last).splitlines()
    assert lines[0].startswith("Snapshot of step 2 at t = 0.02 s, ")
    assert f"energy {last.balance.total:.6g} J" in lines[1]
    assert "energy error" in lines[2]
    assert len(lines) == 4
    assert repr(last.state).startswith("State at t = 0.02 s: 2 rigid bodies, 2 joint coordinates")
    assert len(repr(last.state)) < 100


def test_modes_are_a_short_table(comm):
    pytest.importorskip("slepc4py")
    system = body_system(comm, brick(comm))
    found = modes(system, count=8)
    lines = repr(found).splitlines()
    assert lines[0] == "Modes: 8"
    assert np.isclose(float(lines[1].split()[2]), found.modes[0].frequency, rtol=1e-4)
    assert lines[-1] == "  and 2 more"
