"""Claims about wrong input in Python: a sentence that says what was given and what is wanted."""

import re
from fractions import Fraction

import numpy as np
import pytest
from dolfinx import mesh

from turbine_fenicsx import Gravity, JointSpring, Pressure, StVenantKirchhoff
from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.simulation.observers.history import Channel, History, energy_channel
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.own_fields import evaluate_field
from turbine_fenicsx.system.system import MultibodySystem

SVK = StVenantKirchhoff(1.0, 1.0)


@pytest.mark.parametrize(
    "acceleration",
    [9.81, (0.0, -9.81), (0.0, np.nan, 0.0), (np.inf, 0, 0), "down", None, [1, [2]], list("100")],
)
def test_gravity_is_a_vector(acceleration):
    words = (
        f"acceleration of gravity must be three numbers in .*, got {re.escape(repr(acceleration))}"
    )
    with pytest.raises(ValueError, match=words):
        Gravity(acceleration)


@pytest.mark.parametrize("what", ["position", "velocity", "angular_velocity"])
@pytest.mark.parametrize("value", [(0.0, 1.0), (0.0, np.nan, 0.0), 3.0, "here", np.zeros((2, 3))])
def test_vectors_of_a_rigid_body_are_three_numbers(what, value):
    words = f"{what.replace('_', ' ')} of 'b' must be three numbers, got {re.escape(repr(value))}"
    with pytest.raises(ValueError, match=words):
        RigidBody("b", 1.0, (1, 1, 1), **{what: value})


@pytest.mark.parametrize("euler", [(1.0, 1.0, np.inf), "large", (1.0, None, 2.0)])
def test_euler_values_are_finite_numbers(euler):
    with pytest.raises(ValueError, match="Euler values of rigid body 'b' must be three numbers"):
        RigidBody("b", 1.0, euler)


@pytest.mark.parametrize("mass", ["heavy", "1", b"1", 1j, (1.0, 2.0), None])
def test_a_mass_is_a_number(mass):
    words = f"mass of rigid body 'b' must be positive, got {re.escape(repr(mass))}"
    with pytest.raises(ValueError, match=words):
        RigidBody("b", mass, (1, 1, 1))


@pytest.mark.parametrize("rest", ["1", np.array("1"), 1j, np.nan, (0.5,), None])
def test_a_rest_angle_is_a_number(rest):
    words = f"rest of 's' must be a number, got {re.escape(repr(rest))}"
    with pytest.raises(ValueError, match=words):
        JointSpring("s", "hinge", 1.0, rest)


@pytest.mark.parametrize("rest", [1, 0.5, np.float32(0.5), np.array(2), Fraction(1, 2)])
def test_numbers_of_all_kinds_are_numbers(rest):
    assert JointSpring("s", "hinge", 1.0, rest).rest == rest


def box(comm, cells=(2, 1, 1)):
    return mesh.create_box(comm, [[0, 0, 0], [2, 1, 1]], cells, mesh.CellType.hexahedron)


def test_a_mesh_is_three_dimensional(comm):
    flat = mesh.create_unit_square(comm, 2, 2)
    words = "mesh of 'b' must be three-dimensional, .* got triangle cells in 2 dimensions"
    with pytest.raises(ValueError, match=words):
        FlexibleBody("b", flat, SVK, 1.0)


def test_cells_of_a_mesh_are_hexahedra_or_tetrahedra(comm):
    prisms = mesh.create_unit_cube(comm, 2, 2, 2, mesh.CellType.prism)
    with pytest.raises(ValueError, match="of hexahedron or tetrahedron cells; got prism cells"):
        FlexibleBody("b", prisms, SVK, 1.0)


def test_a_velocity_is_a_function(comm):
    with pytest.raises(TypeError, match="velocity of 'b' must be a function of positions, got"):
        FlexibleBody("b", box(comm), SVK, 1.0, velocity=(1.0, 0.0, 0.0))


def starting(comm, velocity, cells=(2, 1, 1)):
    body = FlexibleBody("b", box(comm, cells), SVK, 1.0, velocity=velocity)
    return MultibodySystem(comm, [body]).initial_state()


@pytest.mark.parametrize(
    "velocity",
    [
        lambda x: np.vstack([-x[1], x[0], 0.0 * x[2]]),  # DOLFINx's convention
        lambda x: x.T,
        lambda x: np.array([1.0, 0.0, 0.0]),
        lambda x: x[:, 0],
        lambda x: 1.0,
    ],
)
def test_a_velocity_field_has_a_row_per_point(comm, velocity):
    words = r"velocity of 'b' must have one row per point, shape \(\d+, 3\) .*; it has shape"
    with pytest.raises(ValueError, match=words):
        starting(comm, velocity)


@pytest.mark.parallel
def test_a_velocity_field_of_a_rank_with_three_nodes_is_not_mistaken(comm):
    """Of three points both conventions have the same shape."""

    def values(velocity):
        return evaluate_field(comm, "velocity of 'b'", np.arange(9.0).reshape(3, 3), velocity)

    assert np.array_equal(values(lambda x: x), np.arange(9.0).reshape(3, 3))
    with pytest.raises(ValueError, match=r"shape \(4, 3\) .*; it has shape \(3, 4\)"):
        values(np.transpose)


@pytest.mark.parallel
def test_a_velocity_field_is_finite(comm):
    with pytest.raises(ValueError, match="velocity of 'b' must be finite"):
        starting(comm, lambda x: np.where(x > 1.9, np.nan, x))


@pytest.mark.parallel
def test_what_a_velocity_field_raises_on_one_rank_is_raised_on_all(comm):
    def velocity(x):
        if np.any(x[:, 0] > 1.9):
            raise KeyError("far")
        return x

    with pytest.raises(KeyError, match="far"):
        starting(comm, velocity, (8, 1, 1))


def test_facets_are_numbers_of_facets(comm):
    body = FlexibleBody("b", box(comm), SVK, 1.0)
    for facets in ([0.5], [[0, 1]], "all", None):
        with pytest.raises(ValueError, match="facets of 'c' must be a list of numbers of facets"):
            MultibodySystem(comm, [body, Coupling("c", body, facets, None)])
    for facets in ([-1], [10**6]):
        words = f"must be below \\d+, the number of facets of .*, got {facets[0]} to {facets[0]}"
        for part in (Coupling("c", body, facets, None), Pressure("p", body, facets, 1.0)):
            with pytest.raises(ValueError, match=words):
                MultibodySystem(comm, [body, part])


@pytest.mark.parallel
def test_facets_that_are_wrong_on_one_rank_are_refused_on_all(comm):
    body = FlexibleBody("b", box(comm), SVK, 1.0)
    facets = [10**6] if comm.rank == comm.size - 1 else [0]
    with pytest.raises(ValueError, match="facets of 'c' must be below"):
        MultibodySystem(comm, [body, Coupling("c", body, facets, None)])


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (None, "None"),
        ("a", "str 'a'"),
        (RigidBody, "the class RigidBody"),
        (RigidBody("hub", 1.0, (1, 1, 1)), "RigidBody 'hub'"),
        (np.eye(9), "an object of type ndarray"),
    ],
)
def test_what_was_given_is_described_by_its_type_and_name(given, words):
    assert describe(given) == words


def test_observers_have_three_methods(comm):
    system = MultibodySystem(comm, [RigidBody("b", 1.0, (1, 1, 1))])
    words = r"an observer needs the methods start\(\), observe\(\) and finish\(\), got "
    for observer in (print, lambda snapshot: None, History):
        with pytest.raises(TypeError, match=words):
            Simulation(system, 0.1, 1.0, [observer])


def test_a_channel_is_names_and_a_function(comm, shared_tmp_path):
    with pytest.raises(TypeError, match="columns of a channel must be a tuple of names, got 'time"):
        Channel("time_[s]", lambda s: [s.state.time])
    with pytest.raises(TypeError, match=r"values of the channel \('x',\) must be a function"):
        Channel(("x",), 3.0)
    system = MultibodySystem(comm, [RigidBody("b", 1.0, (1, 1, 1))])
    channels = [energy_channel(), Channel(("x", "y"), lambda s: [0.0])]
    history = History(comm, shared_tmp_path / "history.csv", channels)
    with pytest.raises(ValueError, match=r"channel \('x', 'y'\) gave 1 numbers"):
        Simulation(system, 0.1, 0.1, [history]).run()


def test_a_start_belongs_to_the_system(comm, machine):
    m = machine()
    system = m.system()
    other = MultibodySystem(comm, [m.nacelle, m.yaw]).initial_state()
    last = Simulation(system, 0.01, 0.0).run()
    uses = (
        lambda s: Simulation(system, 0.01, 1.0, start=s),
        lambda s: equilibrium(system, [0.0], s),
    )
    for use in uses:
        with pytest.raises(ValueError, match="another system, its sizes are different"):
            use(other)
        with pytest.raises(TypeError, match=r"a run starts from a State, .* got a Snapshot"):
            use(last)
        shifted = system.initial_state()
        shifted.q[0] += 0.1
        with pytest.raises(ValueError, match=r"opens 'yaw' by 0\.1, 'rotor' by 0\.1, which"):
            use(shifted)
    assert Simulation(system, 0.01, 0.0, start=last.state).run().state.time == 0.0
