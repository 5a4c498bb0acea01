"""Claims about loads on flexible bodies: tractions, pressures, forces on nodes.

All blocks have a traction on the tip and a pressure on a surface that holds the tip, so that one
compiled form serves them all. States are functions of the position only.
"""

from mpi4py import MPI

import numpy as np
import pytest
from dolfinx import mesh
from small_body import affine, wild

from turbine_fenicsx import NodeForce, Pressure, StepTimes, StVenantKirchhoff, SurfaceTraction
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.forces.prescribed_force import SurfaceForce
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep

pytestmark = pytest.mark.parallel

KINDS = [("hexahedron", 1), ("tetrahedron", 2)]
SIZE, DT = np.array([1.0, 0.5, 0.4]), 0.6
HALF_DT2 = 0.5 * DT**2
FORCE, P = np.array([2.0, -1.0, 3.0]), 7.0
TIP_AREA = SIZE[1] * SIZE[2]
EPS = np.finfo(float).eps

all_kinds = pytest.mark.parametrize(("cell", "degree"), KINDS)


class Loaded:
    """A cuboid under both loads, each with a factor that tests may change."""

    def __init__(self, comm, cell, degree, closed=True):
        cells = mesh.create_box(comm, [[0, 0, 0], SIZE], [2, 1, 1], getattr(mesh.CellType, cell))
        self.body = FlexibleBody("b", cells, StVenantKirchhoff(6.0, 4.0), 3.0, degree)
        self.comm, self.factors = comm, [1.0, 1.0]
        self.traction = SurfaceTraction(
            "t", self.body, self.facets(lambda x: np.isclose(x[0], 1)), FORCE, self.factor(0)
        )
        surface = self.facets(lambda x: x[0] > -1)
        if not closed:
            surface = np.append(self.traction.facets, self.facets(lambda x: np.isclose(x[1], 0.5)))
        self.pressure = Pressure("p", self.body, surface, P, self.factor(1))
        self.model = FlexibleModel(self.body, [self.traction, self.pressure])
        self.step = FlexibleStep(self.model)

    def factor(self, k):
        return lambda time: self.factors[k] * time

    def facets(self, on):
        return mesh.locate_entities_boundary(self.body.mesh, 2, on)

    def nodal(self, values):
        vector = self.model.new_vector()
        vector.array[:] = np.asarray(values(self.model.positions), dtype=float).ravel()
        return vector

    def residual(self, u, du, time=1.0):
        R = self.model.new_vector()
        self.step.start_step(u, 0 * u, StepTimes(DT, time, time + 0.5 * DT), np.zeros(3))
        self.step.residual(du, R)
        return R

    def forces(self, u, du, traction, pressure):
        """Nodal forces of the loads alone, shape (nodes, 3)."""
        self.factors[:] = traction, pressure
        R = self.residual(u, du)
        self.factors[:] = 0.0, 0.0
        R -= self.residual(u, du)
        self.factors[:] = 1.0, 1.0
        return -R.array_r.reshape(-1, 3) / HALF_DT2

    def total(self, values):
        return self.comm.allreduce(np.asarray(values).sum(axis=0))

    def works(self, u, du, time=1.0):
        self.step.start_step(u, 0 * u, StepTimes(DT, time, time + 0.5 * DT), np.zeros(3))
        return self.comm.allreduce(self.step.midpoint.works(du)[0])


@pytest.fixture(scope="module")
def make():
    made = {}

    def loaded(cell, degree, comm=MPI.COMM_WORLD):
        if (comm.size, cell) not in made:
            made[comm.size, cell] = Loaded(comm, cell, degree)
        return made[comm.size, cell]

    return loaded


@all_kinds
def test_surface_loads_are_surface_loads(make, cell, degree):
    x = make(cell, degree)
    assert isinstance(x.traction, SurfaceForce) and isinstance(x.pressure, SurfaceForce)
    assert x.model.forces == (x.traction, x.pressure)


@all_kinds
def test_resultant_of_a_traction_is_traction_times_area_however_deformed(make, cell, degree):
    x = make(cell, degree)
    u, du = x.nodal(wild(1, 0.05)), x.nodal(wild(2, 0.05))
    for factor in (1.0, -2.5):
        f = x.total(x.forces(u, du, factor, 0.0))
        assert np.allclose(f, factor * TIP_AREA * FORCE, rtol=1e-12, atol=1e-13)


@all_kinds
def test_pressure_pushes_inwards_on_the_present_area(comm, make, cell, degree):
    """On two sides of a body that is turned and stretched, by their present normals and areas."""
    x = Loaded(comm, cell, degree, closed=False)
    R, stretch = rotation_about((1, 2, 0.5), 1.1), np.diag([1.3, 1.2, 0.7])
    u = x.nodal(affine(R @ stretch - np.eye(3), (1.0, 2.0, 3.0)))
    f = x.total(x.forces(u, 0 * u, 0.0, 1.0))
    expected = -P * R @ [TIP_AREA * 1.2 * 0.7, SIZE[0] * SIZE[2] * 1.3 * 0.7, 0.0]
    assert np.allclose(f, expected, rtol=0, atol=1e-12)


@all_kinds
def test_pressure_on_a_closed_surface_has_neither_resultant_nor_moment(make, cell, degree):
    x = make(cell, degree)
    u, du = x.nodal(wild(3, 0.05)), x.nodal(wild(4, 0.05))
    f = x.forces(u, du, 0.0, 1.0)
    size = x.total(np.abs(f)).sum()
    middle = x.model.positions + (u + 0.5 * du).array_r.reshape(-1, 3)
    assert size > 1.0
    assert np.max(np.abs(x.total(f))) <= 1e-13 * size
    assert np.max(np.abs(x.total(np.cross(middle, f)))) <= 1e-13 * size


@all_kinds
def test_loads_on_the_same_facets_add_up(make, cell, degree):
    """The tip carries both."""
    x = make(cell, degree)
    u, du = x.nodal(wild(5, 0.05)), x.nodal(wild(6, 0.05))
    apart = x.forces(u, du, 1.0, 0.0) + x.forces(u, du, 0.0, 1.0)
    assert np.allclose(x.forces(u, du, 1.0, 1.0), apart, rtol=0, atol=1e-12)


@all_kinds
def test_work_is_exactly_force_times_increment_load_by_load(make, cell, degree):
    x = make(cell, degree)
    u, du = x.nodal(wild(7, 0.05)), x.nodal(wild(8, 0.05))
    steps = du.array_r.reshape(-1, 3)
    by_hand = [
        x.comm.allreduce(np.sum(x.forces(u, du, *factors) * steps))
        for factors in ((1.0, 0.0), (0.0, 1.0))
    ]
    assert x.works(u, du) == pytest.approx(by_hand, rel=1e-10, abs=1e-12)
    assert x.works(u, du, 3.0) == pytest.approx([3 * w for w in by_hand], rel=1e-10, abs=1e-12)


@all_kinds
def test_work_of_pressure_is_pressure_times_loss_of_volume_to_second_order(make, cell, degree):
    """Per step it is wrong by a third of the cube of the increment at most: det of (dF)."""
    x = make(cell, degree)
    G = np.array([[1.1, 0.2, 0.0], [-0.1, 0.9, 0.3], [0.0, 0.1, 1.2]])
    H, volume = np.array([[0.3, 0.1, -0.2], [0.2, -0.4, 0.1], [0.0, 0.3, 0.2]]), np.prod(SIZE)
    errors = []
    for size in (1.0, 0.5, 0.25):
        u, du = x.nodal(affine(G - np.eye(3))), x.nodal(affine(size * H))
        loss = volume * (np.linalg.det(G) - np.linalg.det(G + size * H))
        errors.append(abs(x.works(u, du)[1] - P * loss))
    # the midpoint rule misses a quarter of the cubic term det(H)
    assert errors[0] == pytest.approx(0.25 * P * volume * abs(np.linalg.det(H)), rel=1e-9)
    assert errors[0] / errors[1] == pytest.approx(8.0, rel=1e-7)
    assert errors[1] / errors[2] == pytest.approx(8.0, rel=1e-5)


@all_kinds
def test_tangent_with_loads_agrees_with_finite_differences(make, cell, degree):
    x = make(cell, degree)
    u, du, w = (x.nodal(wild(k, s)) for k, s in ((9, 0.02), (10, 0.02), (11, 1.0)))
    late = StepTimes.from_start(50.0, DT)  # so that the loads count
    x.step.start_step(u, 0 * u, late, np.zeros(3))
    x.step.assemble_tangent(du)
    exact, ends, h = x.model.new_vector(), [], 1e-6
    x.step.tangent.mult(w, exact)
    for sign in (1, -1):
        ends.append(x.model.new_vector())
        x.step.residual(du + sign * h * w, ends[-1])
    difference = (ends[0] - ends[1]) * (0.5 / h)
    assert (difference - exact).norm() <= 2e-7 * exact.norm()
    x.step.start_step(u, 0 * u, StepTimes(DT, 0.0, 0.5 * DT), np.zeros(3))
    x.step.assemble_tangent(du)
    unloaded = x.model.new_vector()
    x.step.tangent.mult(w, unloaded)
    assert (unloaded - exact).norm() > 1e-2 * exact.norm()


@all_kinds
def test_numbers_do_not_depend_on_the_number_of_ranks(make, cell, degree):
    found = []
    for comm in (MPI.COMM_WORLD, MPI.COMM_SELF):
        x = make(cell, degree, comm=comm)
        u, du = x.nodal(wild(12, 0.05)), x.nodal(wild(13, 0.05))
        found.append([x.residual(u, du).norm(), *x.works(u, du)])
    assert np.allclose(*found, rtol=1e-12, atol=0)


# --- in a system


def refused(comm, error, words, parts):
    """All ranks raise the same: one that did not would wait for the others for ever."""
    said = ""
    try:
        MultibodySystem(comm, parts)
    except error as raised:
        said = str(raised)
    assert comm.allgather(said) == [words] * comm.size


def test_a_load_without_facets_is_refused_on_all_ranks(comm, machine):
    m = machine()
    nowhere = m.facets(77.0)
    for load in (
        SurfaceTraction("wind", m.beam, nowhere, FORCE),
        Pressure("wind", m.beam, nowhere, P),
    ):
        refused(comm, ValueError, "force 'wind' has no facets on 'beam'", [*m.parts, load])


def test_loads_need_a_flexible_body_of_the_system(comm, machine):
    m, facets = machine(), machine().facets(1.5)
    words = "'wind' needs a flexible body, got RigidBody 'hub'"
    stranger = FlexibleBody("stranger", m.beam.mesh, m.beam.material, 1.0)
    missing = "'wind' refers to body 'stranger', which is not among the parts"
    for make in (
        lambda body: SurfaceTraction("wind", body, facets, FORCE),
        lambda body: Pressure("wind", body, facets, P),
        lambda body: NodeForce("wind", body, point=(1, 0, 0), force=FORCE),
    ):
        refused(comm, TypeError, words, [*m.parts, make(m.hub)])
        refused(comm, ValueError, missing, [*m.parts, make(stranger)])


def test_names_of_loads_on_bodies_must_be_unique(comm, machine):
    m = machine()
    loads = [
        NodeForce("wind", m.beam, point=(1, 0, 0), force=FORCE),
        Pressure("wind", m.beam, m.facets(1.5), P),
    ]
    words = "names must be unique, but ['wind'] occur more than once"
    refused(comm, ValueError, words, [*m.parts, *loads])


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda b: SurfaceTraction("x", b, [], 3.0), ValueError, "force of 'x' must be three"),
        (
            lambda b: NodeForce("x", b, point=(1, 0), force=FORCE),
            ValueError,
            "point of 'x' must be three",
        ),
        (lambda b: Pressure("x", b, [], FORCE), ValueError, "pressure of 'x' must be a number"),
        (lambda b: Pressure("x", b, [], np.nan), ValueError, "must be a number, got nan"),
        (lambda b: Pressure("x", b, [], P, 2.0), TypeError, "'x' needs a function of time"),
        (
            lambda b: NodeForce("x", b, point=FORCE, force=FORCE, function=2.0),
            TypeError,
            "needs a function of time",
        ),
        (lambda b: SurfaceTraction("x", b, [], FORCE, 2.0), TypeError, "a function of time"),
    ],
)
def test_mistakes_are_refused_in_a_sentence(machine, make, error, words):
    with pytest.raises(error, match=words):
        make(machine().beam)


def test_force_on_a_node_acts_on_one_node_of_one_rank(comm, machine):
    """On the node nearest to the point, in the middle between two of them on any."""
    m = machine()
    for point, nearest in (((1.52, 0.3, -0.8), [1.5, 0.25, -0.8]), ((1.5, 0.0, -0.8), None)):
        load = NodeForce("n", m.beam, point=point, force=FORCE, function=lambda t: 2 * t)
        model = FlexibleModel(m.beam, [load])
        step = FlexibleStep(model)
        u, R = model.new_vector(), model.new_vector()
        step.start_step(u, u, StepTimes(DT, 1.5, 1.5 + 0.5 * DT), np.zeros(3))
        step.residual(u, R)
        forces = -R.array_r.reshape(-1, 3) / HALF_DT2
        at = comm.allgather(model.positions[np.linalg.norm(forces, axis=1) > 1e-12])
        (place,) = np.concatenate(at)
        assert nearest is None or np.allclose(place, nearest, rtol=0, atol=1e-12)
        assert np.allclose(comm.allreduce(forces.sum(axis=0)), 3 * FORCE, rtol=1e-13, atol=1e-13)
        du = model.new_vector()
        du.array[:] = (model.positions @ np.diag([1.0, 2.0, -1.0])).ravel()
        work = comm.allreduce(step.midpoint.works(du)[0])
        assert work == pytest.approx([3 * FORCE @ (place * [1, 2, -1])], rel=1e-13)
