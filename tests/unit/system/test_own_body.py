"""Claims about kinds of bodies of one's own: a bar of four vectors, in this file alone."""

from dataclasses import dataclass
from typing import Any

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import pytest
from dolfinx import mesh
from scipy.sparse import csr_matrix
from seen import Seen

from turbine_fenicsx import FlexibleBody, Simulation, StVenantKirchhoff
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.simulation.observers.points import Point, Points
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.make_model import make_model
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.body_step_interface import MemorylessStep
from turbine_fenicsx.time_stepping.energy_momentum import make_step

HEXAHEDRON = mesh.CellType.hexahedron
SIZE = np.array([1.0, 0.2, 0.1])
SPIN = np.array([0.3, 0.2, 2.0])


@dataclass(frozen=True, eq=False)
class Bar(DeformableBody):
    """A box x = phi + X_j d_j, whose stiffness keeps the directors orthonormal."""

    name: str
    full: Any
    stiffness: float


def strain(d, e):
    """Products of directors, symmetric, of two sets of rows d_j."""
    return 0.25 * (d @ e.T + e @ d.T)


class BarModel(BodyModel):
    """Four nodes: phi and the directors."""

    full, forces, section_loads, mass_damper, meaning = None, (), (), None, ""
    is_viscous, is_conservative, has_surface_energy = False, True, False
    n_owned = size_global = 4
    dense_block = 12

    def __init__(self, body, forces, damping, couplings):
        self.body, self.comm = body, body.full.mesh.comm
        self.positions = np.concatenate([np.zeros((1, 3)), np.eye(3)])
        self.is_point = np.array([1.0, 0.0, 0.0, 0.0])
        mass = float(body.full.density * SIZE.prod())
        self.weights = np.array([mass, *(mass * SIZE**2 / 12.0)])
        self.nodal_mass = self.weights * self.is_point

        self.full = make_model(body.full, (), None, ())
        self.space = self.full.space

    def stress(self, d):
        return self.body.stiffness * (strain(d, d) - 0.5 * np.eye(3))

    def integrals(self, u, v):
        z, v = self.positions + u.array_r.reshape(4, 3), v.array_r.reshape(4, 3)
        p, d = self.weights[:, None] * v, z[1:]
        energy = 0.5 * np.sum(self.stress(d) * (strain(d, d) - 0.5 * np.eye(3)))
        return np.array([0.5 * np.sum(p * v), *p[0], *np.cross(z, p).sum(axis=0), energy])

    def momentum(self, v, p):
        p.array[:] = np.repeat(self.weights, 3) * v.array_r

    def initial_displacement(self):
        return np.zeros((4, 3))

    def initial_velocity(self):
        return np.cross(SPIN, self.positions) + self.is_point[:, None] * [1.0, 2.0, 0.0]

    def surface_energy(self, u, time):
        return 0.0

    def contact_nodes(self, coupling):
        return np.arange(4)

    def rows(self, copy, nodes, weights):
        X = self.full.positions[nodes]
        return csr_matrix(np.atleast_2d(weights) @ np.column_stack([np.ones(len(X)), X]))

    def mesh_displacements(self, u, copy):
        X = self.full.positions
        return np.column_stack([np.ones(len(X)), X]) @ u.array_r.reshape(4, 3)

    def gather_forces(self, forces, copy):
        X = self.full.positions
        return np.column_stack([np.ones(len(X)), X]).T @ forces

    def _not_here(self, *_):
        raise NotImplementedError

    mass_matrix = add_mass = static_forces = new_stiffness = assemble_stiffness = _not_here
    damping_matrix = _not_here


class BarStep(MemorylessStep):
    """M (du - dt v_n) + dt^2/2 (S_n + S_{n+1})/2 d_mid, with its tangent."""

    losses, round_off = (), 0.0

    def __init__(self, model, stress, numerical_dissipation):
        self.model, self.midpoint = model, self
        self.tangent = PETSc.Mat().createDense((12, 12), comm=model.comm)
        self.tangent.setUp()
        self.tangent.assemble()

    def start_step(self, u, v, times, gravity):
        self._d = (self.model.positions + u.array_r.reshape(4, 3))[1:]
        self._h, self._dt_v = times.half_dt2, times.dt * v.array_r

    def _middle(self, du):
        end = self._d + du.array_r.reshape(4, 3)[1:]
        S = 0.5 * (self.model.stress(self._d) + self.model.stress(end))
        return end, 0.5 * (self._d + end), S

    def residual(self, du, R):
        _, middle, S = self._middle(du)
        R.array[:] = np.repeat(self.model.weights, 3) * (du.array_r - self._dt_v)
        R.array[3:] += self._h * (S @ middle).ravel()

    def assemble_tangent(self, du):
        end, middle, S = self._middle(du)
        k, one = 0.25 * self.model.body.stiffness, np.eye(3)
        slope = 0.5 * np.einsum("ij,ab->iajb", S, one)
        slope += k * np.einsum("il,jb,ja->ialb", one, end, middle)
        slope += k * np.einsum("ib,la->ialb", end, middle)
        A = np.diag(np.repeat(self.model.weights, 3))
        A[3:, 3:] += self._h * slope.reshape(9, 9)
        self.tangent.getDenseArray()[:] = A
        self.tangent.assemble()

    def assemble_at_rest(self):
        du = self.model.new_vector()
        self.assemble_tangent(du)
        du.destroy()

    def term_scale(self, du):
        return float(np.sum((np.repeat(self.model.weights, 3) * np.abs(self._dt_v)) ** 2))

    def works(self, du):
        return np.zeros(0), np.zeros(0)


make_model.register(Bar, BarModel)
make_step.register(BarModel, BarStep)


def throw():
    box = mesh.create_box(MPI.COMM_SELF, [-0.5 * SIZE, 0.5 * SIZE], [1, 1, 1], HEXAHEDRON)
    full = FlexibleBody("box", box, StVenantKirchhoff(1e6, 1e6), 3.0)
    return MultibodySystem(MPI.COMM_SELF, [Bar("bar", full, 1.0)])


def test_energy_and_momenta_of_a_bar_in_flight_are_conserved():
    system = throw()
    seen = Seen(lambda snapshot: snapshot.balance)
    Simulation(system, 0.01, 1.0, [seen]).run()
    start, *others = seen.values
    strains = [balance.strain for balance in others]
    assert max(strains) > 1e-3 * start.kinetic  # the bar is not rigid
    for balance in others:
        assert balance.total == pytest.approx(start.total, rel=1e-9)
        assert balance.linear == pytest.approx(start.linear, rel=1e-9, abs=1e-12)
        assert balance.angular == pytest.approx(start.angular, rel=1e-9, abs=1e-12)


def test_points_of_its_mesh_follow_it():
    system, corner = throw(), 0.5 * SIZE
    (bar,) = system.flexible_bodies
    points = Points(system, [Point("corner", bar, corner)])
    seen = Seen(lambda snapshot: (points.at(snapshot)[0, 0], snapshot.state.u[0].array_r.copy()))
    Simulation(system, 0.01, 0.5, [seen]).run()
    for place, u in seen.values:
        phi, *directors = system.flexible_models[0].positions + u.reshape(4, 3)
        assert place == pytest.approx(phi + corner @ directors, abs=1e-12)


def test_a_kind_without_a_model_is_named():
    class Other(DeformableBody):
        name, full = "other", None

    with pytest.raises(
        TypeError, match=r"Other 'other' has no model; make_model\.register adds one"
    ):
        MultibodySystem(MPI.COMM_SELF, [Other()])
