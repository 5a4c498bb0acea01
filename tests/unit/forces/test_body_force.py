"""Claims about forces on the mass of a flexible body."""

from mpi4py import MPI

import numpy as np
import pytest
from dolfinx import mesh

from turbine_fenicsx import BodyForce, FlexibleBody, StVenantKirchhoff
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep

pytestmark = pytest.mark.parallel

SIZE, DENSITY, DT = np.array([2.0, 1.0, 3.0]), 1.5, 0.1


@pytest.fixture(params=[(mesh.CellType.hexahedron, 2), (mesh.CellType.tetrahedron, 1)])
def block(comm, request):
    cell, degree = request.param
    box = mesh.create_box(comm, [np.zeros(3), SIZE], [2, 1, 2], cell)
    return FlexibleBody("block", box, StVenantKirchhoff(20.0, 30.0), DENSITY, degree)


def lever(X):
    return np.cross((0.0, 0.0, 2.0), X)


def test_the_resultant_is_the_integral_of_the_field(comm, block):
    model = FlexibleModel(block, [BodyForce("x", block, field=lever, function=lambda t: 3 * t)])
    out, u = model.new_vector(), model.new_vector()
    model.static_forces(u, np.zeros(3), 2.0, out)
    mass = DENSITY * np.prod(SIZE)
    total = comm.allreduce(-out.array_r.reshape(-1, 3).sum(axis=0))
    assert np.allclose(total, 6.0 * mass * lever(0.5 * SIZE), rtol=1e-12)


def test_a_constant_field_is_gravity_and_its_work_is_exact(comm, block):
    g = np.array([0.4, -9.81, 1.0])
    forces = [BodyForce("x", block, field=lambda X: np.broadcast_to(g, X.shape))]
    residuals = []
    for loads, gravity in ((forces, np.zeros(3)), ((), g)):
        step = FlexibleStep(FlexibleModel(block, loads))
        u, du, R = (step.model.new_vector() for _ in range(3))
        du.array[:] = (0.01 * step.model.positions[:, ::-1]).ravel()
        step.start_step(u, u, StepTimes(DT, 0.5 * DT, DT), gravity)
        step.residual(du, R)
        residuals.append(R.array_r.copy())
        if loads:
            works = comm.allreduce(step.midpoint.works(du)[0])
            weights = step.model.nodal_mass[:, None] * g
            done = comm.allreduce(np.sum(weights.ravel() * du.array_r))
            assert works == pytest.approx([done], rel=1e-12)
    size = comm.allreduce(np.max(np.abs(residuals[1])), op=MPI.MAX)
    assert np.allclose(*residuals, rtol=0.0, atol=1e-12 * size)


def test_mistakes_are_refused_in_a_sentence(comm, block):
    with pytest.raises(TypeError, match="field of 'x' must be a function of positions, got float"):
        BodyForce("x", block, field=3.0)
    with pytest.raises(TypeError, match="'x' needs a function of time"):
        BodyForce("x", block, field=lever, function=1.0)
    with pytest.raises(ValueError, match="field of 'x' must have one row per point"):
        FlexibleModel(block, [BodyForce("x", block, field=lambda X: X[:, 0])])
    with pytest.raises(ValueError, match="field of 'x' must be finite"):
        FlexibleModel(block, [BodyForce("x", block, field=lambda X: np.inf * X)])
