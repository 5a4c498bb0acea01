"""Claims about the node-by-node coupling of a flexible body to rigid bodies."""

import re

import numpy as np
import pytest

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.flexible_model import FlexibleModel

KINDS = [("hexahedron", 1, 4), ("hexahedron", 2, 9), ("tetrahedron", 1, 4), ("tetrahedron", 2, 9)]
"""Cell, degree, and nodes on a face of the beam, which is one cell (or two triangles) wide."""
RIGID_SIZE, FIRST = 40, 12
ROUND_OFF = 2e-15
"""Sums of four products of numbers of order one."""

all_kinds = pytest.mark.parametrize(("cell", "degree", "nodes"), KINDS)


def coupled(machine, cell="hexahedron", degree=1, carriers=("hub",)):
    """The machine and the couplings of its beam: root first, then tip."""
    m = machine(cell=cell, degree=degree)
    ends = zip(("root", "tip"), (0.5, 1.5), carriers, strict=False)
    couplings = [
        Coupling(name, m.beam, m.facets(x), None if c is None else getattr(m, c))
        for name, x, c in ends
    ]
    first = {m.nacelle: 0, m.hub: FIRST}
    block = FlexibleModel(m.beam)
    return m, block, CouplingBlock(block, couplings, first, RIGID_SIZE)


def coordinates(m):
    return {b: b.coordinates for b in (m.nacelle, m.hub)}


def random_like(vector, seed):
    """The same numbers whatever the number of ranks does: entry by entry from its global index."""
    start, end = vector.getOwnershipRange()
    vector.array[:] = np.sin(seed + 1.7 * np.arange(start, end) ** 2)
    return vector


@pytest.mark.parallel
@all_kinds
def test_coupling_holds_every_node_of_the_face_once(comm, machine, cell, degree, nodes):
    _, block, coupling = coupled(machine, cell, degree)
    assert comm.allreduce(coupling.nodes.size) == nodes
    assert np.all(coupling.nodes < block.n_owned)
    assert np.allclose(block.positions[coupling.nodes, 0], 0.5, rtol=0, atol=1e-14)
    assert coupling.C.getSize() == (3 * nodes, block.new_vector().getSize())
    assert coupling.B.getSize() == (3 * nodes, RIGID_SIZE)
    assert coupling.columns.tolist() == list(range(FIRST, FIRST + 12))


@all_kinds
def test_gap_vanishes_initially(machine, cell, degree, nodes):
    m, block, coupling = coupled(machine, cell, degree)
    gap = coupling.gap(coordinates(m), block.new_vector())
    assert gap.shape == (3 * coupling.nodes.size,)
    assert np.max(np.abs(gap), initial=0.0) <= ROUND_OFF


@all_kinds
def test_gap_vanishes_when_carrier_and_nodes_move_together(machine, cell, degree, nodes):
    m, block, coupling = coupled(machine, cell, degree)
    R, shift = rotation_about((1.0, 0.3, 2.0), 2.0), np.array([1.0, -2.0, 0.5])
    q = m.hub.coordinates.reshape(4, 3) @ R.T
    q[0] += shift
    u = block.new_vector()
    u.array[:] = (block.positions @ R.T + shift - block.positions).ravel()
    gap = coupling.gap({m.hub: q.ravel()}, u)
    assert np.max(np.abs(gap), initial=0.0) <= 4 * ROUND_OFF


def test_gap_is_where_the_carrier_is_minus_where_the_node_is(machine):
    m, block, coupling = coupled(machine)
    u = block.new_vector()
    u.array[:] = np.tile([0.01, 0.02, 0.03], block.n_owned)
    gap = coupling.gap(coordinates(m), u).reshape(-1, 3)
    assert np.allclose(gap, [-0.01, -0.02, -0.03], rtol=0, atol=ROUND_OFF)


@pytest.mark.parallel
@all_kinds
@pytest.mark.parametrize("carriers", [("hub",), ("hub", "nacelle"), (None, "hub"), ("hub", "hub")])
def test_matrices_are_the_derivatives_of_the_gap(machine, cell, degree, nodes, carriers):
    """The gap is linear: its change over any increment is C du + B dr."""
    m, block, coupling = coupled(machine, cell, degree, carriers)
    u, du = (random_like(block.new_vector(), seed) for seed in (1, 2))
    dr = random_like(coupling.B.createVecRight(), 3)
    change = coupling.C.createVecLeft()
    coupling.C.mult(du, change)
    coupling.B.multAdd(dr, change, change)
    step = block.body.mesh.comm.bcast(np.array(dr.array_r))  # rank 0 owns all of r
    assert step.size == RIGID_SIZE
    q0 = coordinates(m)
    q1 = {m.nacelle: q0[m.nacelle] + step[:12], m.hub: q0[m.hub] + step[FIRST : FIRST + 12]}
    expected = coupling.gap(q1, u + du) - coupling.gap(q0, u)
    assert change.norm() > 0.1
    assert np.allclose(change.array_r, expected, rtol=0, atol=10 * ROUND_OFF)


def test_every_node_hangs_on_the_carrier_of_its_own_coupling(comm, machine):
    m, block, coupling = coupled(machine, carriers=("hub", "nacelle"))
    assert coupling.carriers == (m.hub, m.nacelle)
    assert coupling.columns.tolist() == [*range(12, 24), *range(12)]
    moved = coordinates(m)
    moved[m.nacelle] = moved[m.nacelle] + np.repeat([1.0, 0, 0, 0], 3)
    gap = coupling.gap(moved, block.new_vector()).reshape(-1, 3)
    root, tip = (gap[s] for s in coupling.slices)
    assert comm.allreduce(len(root)) == comm.allreduce(len(tip)) == 4
    assert np.max(np.abs(root), initial=0.0) <= ROUND_OFF
    assert np.allclose(tip, 1.0, rtol=0, atol=ROUND_OFF)


@pytest.mark.parametrize("carriers", [("hub",), ("hub", "nacelle"), (None, "hub"), (None,)])
def test_rigid_extension_moves_contact_nodes_with_their_carriers(machine, carriers):
    """And with a single carrier, all nodes."""
    m, block, coupling = coupled(machine, carriers=carriers)
    Y = coupling.rigid_extension(block)
    assert Y.shape == (3 * block.n_owned, 12 * len([c for c in carriers if c]))
    assert np.array_equal(Y[coupling.dofs], coupling.B_local)
    rest = np.delete(Y, coupling.dofs, axis=0)
    if carriers == ("hub",):
        dq = np.sin(np.arange(12.0))
        expected = dq[:3] + m.hub.body_coordinates(block.positions) @ dq[3:].reshape(3, 3)
        assert np.allclose((Y @ dq).reshape(-1, 3), expected, rtol=0, atol=4 * ROUND_OFF)
    else:
        assert np.count_nonzero(rest) == 0


def test_two_couplings_may_share_a_carrier(machine):
    m, _, coupling = coupled(machine, carriers=("hub", "hub"))
    assert coupling.carriers == (m.hub,)
    assert coupling.columns.size == 12


def test_nodes_coupled_to_the_ground_must_not_move(comm, machine):
    _, block, coupling = coupled(machine, carriers=(None,))
    assert coupling.carriers == () and coupling.columns.size == 0
    assert comm.allreduce(coupling.B.getInfo()["nz_used"]) == 0
    u = random_like(block.new_vector(), 4)
    gap = coupling.gap({}, u).reshape(-1, 3)
    assert np.array_equal(gap, -u.array_r.reshape(-1, 3)[coupling.nodes])


def test_a_body_without_coupling_has_none(comm, machine):
    m, block, _ = coupled(machine)
    coupling = CouplingBlock(block, [], {m.hub: 0}, RIGID_SIZE)
    assert coupling.nodes.size == coupling.columns.size == 0
    assert coupling.C.getSize() == (0, block.new_vector().getSize())
    assert coupling.gap(coordinates(m), block.new_vector()).size == 0


@pytest.mark.parallel
def test_facets_may_come_from_one_side_of_a_process_boundary_only(comm, machine):
    """A facet on the boundary between two ranks is a ghost on one of them, and may be left out."""
    m = machine()
    facets = m.facets(0.5)
    owned = facets[facets < m.beam.mesh.topology.index_map(2).size_local]
    coupling = CouplingBlock(
        FlexibleModel(m.beam), [Coupling("root", m.beam, owned, m.hub)], {m.hub: 0}, RIGID_SIZE
    )
    assert comm.allreduce(coupling.nodes.size) == 4


def refused(comm, message, make):
    """All ranks raise the same: one that did not would wait for the others for ever."""
    said = None
    try:
        make()
    except ValueError as error:
        said = str(error)
    assert all(re.search(message, str(words)) for words in comm.allgather(said))


@pytest.mark.parallel
def test_a_coupling_without_nodes_is_refused_on_all_ranks(comm, machine):
    m = machine()
    block = FlexibleModel(m.beam)
    empty = Coupling("empty", m.beam, np.zeros(0, dtype=np.int32), m.hub)
    message = "coupling 'empty' holds no node: its surface has no facets on 'beam'"
    for couplings in ([empty], [m.root, empty]):
        refused(comm, message, lambda c=couplings: CouplingBlock(block, c, {m.hub: 0}, RIGID_SIZE))


@pytest.mark.parallel
def test_a_node_in_two_couplings_is_refused_on_all_ranks(comm, machine):
    m = machine()
    block = FlexibleModel(m.beam)
    again = Coupling("again", m.beam, m.facets(0.5), m.nacelle)
    first = {m.hub: 0, m.nacelle: 12}
    refused(
        comm,
        "4 nodes of 'beam' belong to two couplings",
        lambda: CouplingBlock(block, [m.root, again], first, RIGID_SIZE),
    )
