"""The block of one flexible body in an energy-momentum step.

Unknown: the increment du = u_{n+1} - u_n of all nodal displacements. With v_{n+1} = 2 du/dt - v_n
the step (55), (57), multiplied by dt^2/2, is

    int rho (du - dt v_n) . w dV + dt^2/2 int F_mid (S_alg + S_dis) : grad w dV
        = dt^2/2 int rho g . w dV + dt^2/2 int t . w dA

with the surface loads t. The stress S_dis takes energy out: that of a viscous material, which is a
function of dE/dt with dE = E_{n+1} - E_n, and chi/2 D_0 : dE of the energy-decaying variant, with
the elasticity D_0 of the material at rest. A step dissipates exactly int S_dis : dE dV, which is
not negative; momenta are conserved for any symmetric S_dis.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from petsc4py import PETSc

import numpy as np
import ufl
from dolfinx import fem

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.nearest_node import nearest_node
from turbine_fenicsx.forces.load import SurfaceLoad
from turbine_fenicsx.forces.node_force import NodeForce
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.base import Viscous, second_piola_kirchhoff
from turbine_fenicsx.materials.cell_fields import is_field, on_mesh
from turbine_fenicsx.materials.kinematics import deformation_gradient, right_cauchy_green
from turbine_fenicsx.system.discrete_gradients import (
    AlgorithmicStress,
    discrete_gradient_stress,
    stiffness_at_rest,
    strain_increment,
)
from turbine_fenicsx.system.force_round_off import ForceRoundOff, smallest_edges
from turbine_fenicsx.system.surface_forms import surface_integrals


class FlexibleBlock:
    """Function space and compiled forms of a flexible body.

    Args:
        body: The body.
        stress: Algorithmic stress; the exact discrete gradient of the material if None.
        loads: Surface loads and forces on nodes.
        numerical_dissipation: chi >= 0. A linear mode of the frequency omega loses the part
            chi (omega dt)^2/2 of its energy per step while omega dt is small. The spectral radius
            falls from 1 to (2 - chi)/(2 + chi) at omega dt = 4/chi, and rises again beyond. The
            scheme is then of first order.

    Attributes:
        loads: The surface loads, then the forces on nodes.
        dissipations: What dissipates in this body, names.
        space: Space of the displacement.
        n_owned: Number of nodes owned by this rank.
        positions: Initial positions X of the owned nodes, shape (n_owned, 3) [m].
        local_positions: The same with those of the ghosts after them.
        nodal_mass: int rho phi_a dV of the owned nodes, shape (n_owned,) [kg].
        tangent: Matrix of the tangent, filled by `assemble_tangent`.
        round_off: This rank's sum of the squares of the round-off of the residual of the step
            [(kg m)^2], set by `begin`.
    """

    def __init__(
        self,
        body: FlexibleBody,
        stress: AlgorithmicStress | None = None,
        loads: Sequence[SurfaceLoad | NodeForce] = (),
        numerical_dissipation: float = 0.0,
    ) -> None:
        """Compile the forms."""
        if not 0.0 <= numerical_dissipation < np.inf:
            raise ValueError(f"numerical_dissipation must be >= 0, got {numerical_dissipation:g}")
        self.body = body
        surface_loads = [x for x in loads if not isinstance(x, NodeForce)]
        node_forces = [x for x in loads if isinstance(x, NodeForce)]
        self.loads: tuple[SurfaceLoad | NodeForce, ...] = (*surface_loads, *node_forces)
        mesh = body.mesh
        self.space = V = _compat.vector_space(mesh, body.degree)
        self.n_owned = V.dofmap.index_map.size_local
        self._u_n, self._du, self._u, self._v = (fem.Function(V) for _ in range(4))
        self._dt_v = fem.Function(V)
        self._half_dt2 = fem.Constant(mesh, PETSc.ScalarType(0.0))
        self._dt = fem.Constant(mesh, PETSc.ScalarType(1.0))
        self._gravity = fem.Constant(mesh, np.zeros(3, dtype=PETSc.ScalarType))

        def parameter(value: Any) -> Any:
            if is_field(value):
                return on_mesh(value, mesh, body.name)
            return fem.Constant(mesh, np.array(value, dtype=PETSc.ScalarType, order="C"))

        def energy(C: Any) -> Any:
            return body.material.strain_energy(C, parameter)

        dx_mass, dx_stress = (
            ufl.dx(domain=mesh, metadata={"quadrature_degree": q}) for q in _quadrature(body)
        )
        rho, h, g = parameter(body.density), self._half_dt2, self._gravity
        w, delta = ufl.TestFunction(V), ufl.TrialFunction(V)
        if stress is None:
            stress = discrete_gradient_stress(body.material.quadratic)
        F_mid = deformation_gradient(self._u_n + 0.5 * self._du)
        D = ufl.grad(self._du)
        S, dE = stress(energy, F_mid, D), strain_increment(F_mid, D)
        dissipative = {}
        if isinstance(body.material, Viscous):
            dissipative["viscosity"] = body.material.viscous_stress(dE / self._dt, parameter)
        if numerical_dissipation:
            chi = parameter(numerical_dissipation)
            dissipative["numerical dissipation"] = 0.5 * chi * stiffness_at_rest(energy, dE)
        for S_dis in dissipative.values():
            S += S_dis
        R = rho * ufl.dot(self._du - self._dt_v - h * g, w) * dx_mass
        R += h * ufl.inner(F_mid * S, ufl.grad(w)) * dx_stress
        self._factors = [fem.Constant(mesh, PETSc.ScalarType(0.0)) for _ in surface_loads]
        works = []
        if surface_loads:
            integrals = surface_integrals(
                mesh, surface_loads, self._factors, F_mid, parameter, 2 * body.degree + 1
            )
            for integral in integrals(w):
                R -= h * integral
            works = integrals(self._du)
        F = deformation_gradient(self._u)
        S = second_piola_kirchhoff(energy, right_cauchy_green(F))
        sigma = F * S * F.T / ufl.det(F)

        compile_form = _compat.compile_form
        self.dissipations = tuple(dissipative)
        self._dissipated = [
            compile_form(ufl.inner(S_dis, dE) * dx_stress) for S_dis in dissipative.values()
        ]
        self._works = [compile_form(work) for work in works]
        self._residual = compile_form(R)
        self._tangent = compile_form(ufl.derivative(R, self._du, delta))
        self._strain_energy = compile_form(energy(right_cauchy_green(F)) * dx_stress)
        self._momentum = compile_form(rho * ufl.dot(self._v, w) * dx_mass)
        norms = [ufl.sqrt(a * ufl.inner(s, s)) for a, s in ((1.0, sigma), (1.5, ufl.dev(sigma)))]
        self._stresses = fem.Function(_compat.cellwise_space(mesh, (2,)))
        self._stresses_now = _compat.expression(ufl.as_vector(norms), self._stresses.function_space)
        self._fibre_now = None
        if body.fibre is not None:
            a = F * body.fibre
            self._fibre = fem.Function(_compat.cellwise_space(mesh, (3,)))
            self._fibre_now = _compat.expression(
                a / ufl.sqrt(ufl.dot(a, a)), self._fibre.function_space
            )

        self.tangent = _compat.create_matrix(self._tangent)
        self._half_dt2.value = 1.0
        index_map = V.dofmap.index_map
        self._work = PETSc.Vec().createGhost(
            index_map.ghosts.astype(PETSc.IntType),
            size=(3 * self.n_owned, 3 * index_map.size_global),
            bsize=3,
            comm=mesh.comm,
        )
        X = fem.Function(V)
        X.interpolate(lambda x: x)
        self.local_positions = X.x.array.reshape(-1, 3).copy()
        self.positions = self.local_positions[: self.n_owned]
        self._round_off = self._force_round_off()  # its tangents also fix the sparsity
        ones = self.new_vector()
        ones.set(1.0)
        self.momentum(ones, ones)
        self.nodal_mass = ones.array.reshape(-1, 3)[:, 0].copy()
        self._masses = np.repeat(np.abs(self.nodal_mass), 3)
        self._fixed_terms, self.round_off = np.zeros_like(self._masses), 0.0
        ones.destroy()
        self._node_forces = [(load, self._node_at(load.point), load.force) for load in node_forces]
        self._nodal_forces: list[tuple[slice, Array]] = []

    def new_vector(self) -> PETSc.Vec:
        """New distributed vector of nodal values without ghosts, zero."""
        vector = PETSc.Vec().createMPI(
            (3 * self.n_owned, 3 * self.space.dofmap.index_map.size_global),
            bsize=3,
            comm=self.body.mesh.comm,
        )
        vector.set(0.0)
        return vector

    def begin(
        self, u: PETSc.Vec, v: PETSc.Vec, dt: float, gravity: Array, time: float = 0.0
    ) -> None:
        """Set the state at t_n, the step [s], gravity [m/s^2] and the middle of the step [s]."""
        self._set(self._u_n, u)
        self._set(self._dt_v, v)
        self._dt_v.x.array[:] *= dt
        self._half_dt2.value = 0.5 * dt * dt
        self._dt.value = dt
        self._gravity.value[:] = gravity
        for factor, load in zip(self._factors, self.loads, strict=False):
            factor.value = load.function(time)
        self._nodal_forces = [
            (dofs, load.function(time) * np.asarray(force, dtype=float))
            for load, dofs, force in self._node_forces
        ]
        dt_v_owned = self._dt_v.x.array[: 3 * self.n_owned]
        self.round_off = (0.5 * dt * dt) ** 2 * self._round_off.square(dt_v_owned, dt)
        dt_v = np.abs(dt_v_owned)
        self._fixed_terms = self._masses * (dt_v + 0.5 * dt * dt * np.linalg.norm(gravity))

    def residual(self, du: PETSc.Vec, R: PETSc.Vec) -> None:
        """Assemble the residual [kg m] for the increment du into R."""
        self._set(self._du, du)
        self._assemble(self._residual, R)
        for dofs, force in self._nodal_forces:
            R.array[dofs] -= self._half_dt2.value * force[: dofs.stop - dofs.start]

    def assemble_tangent(self, du: PETSc.Vec) -> None:
        """Assemble the derivative of the residual [kg] into `tangent`."""
        self._set(self._du, du)
        _compat.assemble_matrix(self.tangent, self._tangent)

    def works(self, du: PETSc.Vec) -> Array:
        """This rank's part of the work of each load [J] in the increment du."""
        if self.loads:
            self._set(self._du, du)
        works = [float(fem.assemble_scalar(work)) for work in self._works]
        for dofs, force in self._nodal_forces:
            works.append(float(np.sum(force[: dofs.stop - dofs.start] * du.array_r[dofs])))
        return np.array(works)

    def dissipated(self, du: PETSc.Vec) -> Array:
        """This rank's part of what each of `dissipations` takes out [J] in the increment du."""
        if self._dissipated:
            self._set(self._du, du)
        return np.array([float(fem.assemble_scalar(form)) for form in self._dissipated])

    def momentum(self, v: PETSc.Vec, p: PETSc.Vec) -> None:
        """Nodal momenta p = M v [kg m/s] of nodal velocities v, into p."""
        self._set(self._v, v)
        self._assemble(self._momentum, p)

    def strain_energy(self, u: PETSc.Vec) -> float:
        """This rank's part of the strain energy [J] of the displacement u."""
        self._set(self._u, u)
        return float(fem.assemble_scalar(self._strain_energy))

    def sum_at_owners(self, values: Array) -> Array:
        """Sum of nodal values that several ranks hold parts of. Collective.

        Args:
            values: Values at all local nodes, ghosts included, shape (nodes, 3).

        Returns:
            Sums at the owned nodes, shape (n_owned, 3).
        """
        if self.body.mesh.comm.size == 1:
            return values
        with self._work.localForm() as local:
            local.array[:] = values.ravel()
        self._work.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        return self._work.array_r.reshape(-1, 3).copy()

    def nodal_values(self, vector: PETSc.Vec) -> Array:
        """Values of a vector at all local nodes, ghosts included, shape (nodes, 3)."""
        self._set(self._v, vector)
        return self._v.x.array.reshape(-1, 3).copy()

    def cauchy_stress_norm(self, u: PETSc.Vec) -> Array:
        """Norm of the Cauchy stress at the cell centres [Pa], eqs (69)-(70).

        Args:
            u: Displacement.

        Returns:
            Shape (local cells,), ghosts included.
        """
        return self.cauchy_stresses(u)[0]

    def cauchy_stresses(self, u: PETSc.Vec) -> tuple[Array, Array]:
        """Norm of the Cauchy stress, and von Mises stress, at the cell centres [Pa].

        Args:
            u: Displacement.

        Returns:
            Shapes (local cells,), ghosts included.
        """
        self._set(self._u, u)
        self._stresses.interpolate(self._stresses_now)
        norm, von_mises = self._stresses.x.array.reshape(-1, 2).T.copy()
        return norm, von_mises

    def fibre_directions(self, u: PETSc.Vec | None = None) -> Array | None:
        """Unit vectors along the deformed fibres at the cell centres, None without fibres.

        Args:
            u: Displacement; zero if None.

        Returns:
            Shape (local cells, 3), ghosts included.
        """
        if self._fibre_now is None:
            return None
        if u is None:
            self._u.x.array[:] = 0.0
        else:
            self._set(self._u, u)
        self._fibre.interpolate(self._fibre_now)
        return self._fibre.x.array.reshape(-1, 3).copy()

    def term_scale(self, du: PETSc.Vec) -> float:
        """This rank's sum of the squares of the inertia and gravity terms of the residual."""
        terms = self._masses * np.abs(du.array_r) + self._fixed_terms
        return float(np.dot(terms, terms))

    def _force_round_off(self) -> ForceRoundOff:
        """The round-off of the forces, from tangents at rest for dt^2/2 = 1."""

        def diagonal(dt: float) -> Array:
            self._dt.value = dt
            _compat.assemble_matrix(self.tangent, self._tangent)
            vector = self.tangent.getDiagonal()
            values = np.array(vector.array_r).reshape(-1, 3)
            vector.destroy()
            return values

        stiffness = diagonal(np.inf)  # no strain rate
        viscous = "viscosity" in self.dissipations
        viscosity = diagonal(1.0) - stiffness if viscous else np.zeros_like(stiffness)
        edges = smallest_edges(self.space, self.local_positions)[: self.n_owned]
        return ForceRoundOff(edges, stiffness, viscosity)

    def _node_at(self, point: Any) -> slice:
        """Degrees of freedom of the node nearest to a point; empty on all ranks but its owner's."""
        node = nearest_node(self.body.mesh.comm, self.positions, point)
        return slice(0, 0) if node is None else slice(3 * node, 3 * node + 3)

    def _assemble(self, form: Any, out: PETSc.Vec) -> None:
        """Assemble a linear form and copy the owned entries."""
        _compat.assemble_vector(self._work, form)
        out.array[:] = self._work.array_r

    def _set(self, function: Any, values: PETSc.Vec) -> None:
        """Copy a vector into a function, ghosts included."""
        function.x.array[: 3 * self.n_owned] = values.array_r
        function.x.scatter_forward()


def _quadrature(body: FlexibleBody) -> tuple[int, int]:
    """Quadrature degrees of the inertia terms and of the stress terms.

    Hexahedra take p + 1 Gauss points a direction for both. Tetrahedra take the degree that is
    exact for inertia, and one point (P1) or four points (P2) for the stress; their weights are
    positive, so that the strain energy is. Energy is conserved exactly for any choice, as energy
    and stress use the same points.
    """
    p = body.degree
    if _compat.cell_name(body.mesh) == "hexahedron":
        return 2 * p + 1, 2 * p + 1
    return 2 * p, p
