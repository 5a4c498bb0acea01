"""Claims about the cyclic shift of a rotor and what generates its whirl."""

import numpy as np
import pytest
from small_rotor import Rotor

from turbine_fenicsx.analysis.bordered_solver import blocks_of
from turbine_fenicsx.analysis.cyclic_shift import cyclic_shift, joint_rates
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import build_turbine

pytestmark = pytest.mark.parallel


def blades_of_the_paper(comm, cell="hexahedron", azimuth=0.0):
    """The paper's turbine, turned, its shift, and its matrices."""
    elements = {"elements": [1, 1, 3]} if cell == "hexahedron" else {"size": 4.0}
    system = build_turbine(Case.parse({"mesh": {"cell": cell} | elements}), comm).system
    state = system.initial_state()
    frame = turning_frame(system, "rotor", 1.0, state)
    frame.turn(state, azimuth)
    return system, state, cyclic_shift(frame, state, 3)


def change(A, x, y):
    """Size of x - y over that of y."""
    difference = x.copy()
    difference.axpy(-1.0, y)
    return difference.norm() / y.norm()


@pytest.mark.parametrize("azimuth", [0.0, 0.7])
def test_shift_and_generator_of_the_papers_blades(comm, azimuth):
    """C^3 = 1, J skew, J^3 = -J, and both commute with mass and stiffness."""
    system, state, shift = blades_of_the_paper(comm, azimuth=azimuth)
    linear = LinearSystem(system, state)
    (C,), (J,) = shift.bodies, shift.body_generators
    x, y, z = C.createVecRight(), C.createVecRight(), C.createVecRight()
    x.setRandom()
    for matrix, times, sign in ((C, 3, 1.0), (J, 2, None)):
        x.copy(z)
        for _ in range(times):
            matrix.mult(z, y)
            y.copy(z)
        if sign:
            assert change(matrix, z, x) <= 1e-14
    J.mult(z, y)  # J^3 x
    J.mult(x, z)
    z.scale(-1.0)
    assert change(J, y, z) <= 1e-14
    J.multTranspose(x, y)
    assert change(J, y, z) <= 1e-14
    for A in (blocks_of(linear.mass)[0], blocks_of(linear.stiffness)[0]):
        for matrix in (C, J):
            w = x.copy()
            A.mult(x, y)
            matrix.mult(y, z)
            matrix.mult(x, y)
            A.mult(y, w)
            assert change(A, w, z) <= 1e-12
    linear.destroy()
    shift.destroy()


def test_a_shift_takes_the_motion_of_one_blade_to_the_next(comm):
    system, state, shift = blades_of_the_paper(comm)
    (model,), (C,) = system.flexible_models, shift.bodies
    R = rotation_about((0.0, 0.0, 1.0), 2.0 * np.pi / 3.0)

    def field(X):
        return np.column_stack([np.sin(0.1 * X[:, 0]), X[:, 1] ** 2, X[:, 2] * X[:, 0]])

    x, y = model.new_vector(), model.new_vector()
    x.array[:] = field(model.positions).ravel()
    C.mult(x, y)
    expected = field(model.positions @ R) @ R.T
    assert y.array_r == pytest.approx(expected.ravel(), rel=1e-10, abs=1e-9)
    state.destroy()
    shift.destroy()


@pytest.mark.parametrize("blades", [3, 4, 5, 6])
def test_the_generator_whirls_what_has_cyclic_index_one(comm, blades):
    """Its eigenvalues are +-i where those of C are exp(+-2 pi i/N), and zero elsewhere."""
    system = Rotor(blades, yaw=1.0).system(comm)
    state = system.initial_state()
    shift = cyclic_shift(turning_frame(system, "rotor", 1.0, state), state, blades)
    turning = np.s_[12:]
    C, J = shift.rigid[turning, turning], shift.rigid_generator[turning, turning]
    assert np.linalg.matrix_power(C, blades) == pytest.approx(np.eye(len(C)), abs=1e-12)
    assert J.T == pytest.approx(-J, abs=1e-14) and J @ C == pytest.approx(C @ J, abs=1e-14)
    values, vectors = np.linalg.eig(C)
    index = np.round(np.angle(values) * blades / (2.0 * np.pi)) % blades
    expected = np.where(index == 1, 1j, np.where(index == blades - 1, -1j, 0.0))
    assert J @ vectors == pytest.approx(vectors * expected, abs=1e-12)
    assert not np.any(shift.rigid[:12]) and not np.any(shift.rigid[:, :12])


def test_of_a_hub_the_generator_is_a_rotation_of_what_is_normal_to_the_axis(comm):
    system = Rotor(3, yaw=1.0).system(comm)
    state = system.initial_state()
    frame = turning_frame(system, "rotor", 1.0, state)
    J = cyclic_shift(frame, state, 3).rigid_generator[12:24, 12:24]
    d = state.q[15:24].reshape(3, 3)

    def tilt(theta):
        """Motion of the hub by a shift and a rotation."""
        return np.concatenate([theta, *(np.cross(theta, x) for x in d)])

    for k in range(3):
        theta = np.eye(3)[k]
        assert J @ tilt(theta) == pytest.approx(tilt(np.cross(frame.axis, theta)), abs=1e-12)


def test_joint_coordinates_follow_the_bodies(comm):
    system = Rotor(3, yaw=1.0).system(comm)
    state = system.initial_state()
    state.q_dot = np.zeros_like(state.q)
    frame = turning_frame(system, "rotor", 2.5, state)
    frame.set_velocities(state)
    rates = joint_rates(system.rigid_model, state) @ state.q_dot
    assert rates == pytest.approx(state.joint_rates, abs=1e-12)


def test_blades_of_tetrahedra_that_are_not_copies_are_refused_or_shift(comm):
    """Meshes by gmsh are copies of one blade, too."""
    _, state, shift = blades_of_the_paper(comm, "tetrahedron")
    state.destroy()
    shift.destroy()


def test_a_mesh_that_does_not_come_to_lie_on_itself_is_refused(comm):
    system = build_turbine(Case.parse({"mesh": {"elements": [1, 1, 3]}}), comm).system
    state = system.initial_state()
    frame = turning_frame(system, "rotor", 1.0, state)
    with pytest.raises(ModelError, match="mesh of 'blades' does not come to lie on itself"):
        cyclic_shift(frame, state, 4)
