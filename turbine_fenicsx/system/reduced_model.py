"""A reduced body: mass, energy and forces of a few vectors, without a time step.

With the vectors z_k and the functions F_k of `ReducedBasis`, all copies of the body together,

    sum_l M_kl z_l'' + sum_l S_kl y_l = m_k g + sum F_k(X) f,       M_kl = int rho F_k F_l dV,

where m_k = int rho F_k dV, and S follows from the strain, see `GramStrain`. M is constant, and
whoever turns all vectors turns the body (Zwoelfer and Gerstmayr 2019 use modes in all
orientations for that). So the momenta are sums over vectors as over nodes of a mesh.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.reduced_body import ReducedBody
from turbine_fenicsx.bodies.surface_points import find_surface_points
from turbine_fenicsx.forces.body_force import BodyForce
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.node_force import NodeForce
from turbine_fenicsx.forces.rayleigh_damping import RayleighDamping
from turbine_fenicsx.forces.section_loads import SectionLoads
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.memo import Memo
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.bound_section_loads import BoundSectionLoads
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.gram_strain import GramStrain, add_to_components
from turbine_fenicsx.system.mass_damper import DampedPart, MassDamper, find_frame
from turbine_fenicsx.system.nearest_vectors import find_nearest_vectors
from turbine_fenicsx.system.nodal_forces import find_nodal_forces
from turbine_fenicsx.system.own_fields import evaluate_field
from turbine_fenicsx.system.reduced_checks import check_forces, check_mesh


class ReducedModel(BodyModel):
    """Mass, strain and forces of a reduced body; rank 0 owns all vectors.

    Args:
        body: The body.
        forces: Forces on nodes and masses of its mesh, and on sections.
        damping: Rayleigh damping; None is none.
        couplings: The couplings that hold it, which make the directors of their interfaces rigid.

    Attributes:
        copies: Number of copies.
        mass: M of one copy, shape (n, n).
        strain: The strain of all copies.
        losses: Times Z of each law that dissipates by its name, shape (r,) [s].
        loss: Their sum.
        mass_damper: Rayleigh damping in proportion to the mass; None if there is none.

    Raises:
        ModelError: for forces that a reduced body cannot have.
    """

    body: ReducedBody

    def __init__(
        self,
        body: ReducedBody,
        forces: Sequence[NodeForce | BodyForce | SectionLoads],
        damping: RayleighDamping | None,
        couplings: Sequence[Coupling],
    ) -> None:
        self.body, self.comm = body, body.full.mesh.comm
        check_forces(body, forces)
        of_sections = [x for x in forces if isinstance(x, SectionLoads)]
        of_vectors = [x for x in forces if not isinstance(x, SectionLoads)]
        basis, n = body.basis, body.basis.functions.shape[1]
        self.forces = (*of_vectors, *of_sections)
        self.copies, self._n = len(body.placements), n
        self.size_global, self.dense_block = n * self.copies, 3 * n
        self._is_owner = self.comm.rank == 0
        self.n_owned = self.size_global if self._is_owner else 0
        self.mass = basis.mass
        self.meaning = basis.fingerprint
        self.space = _compat.vector_space(body.full.mesh, body.full.degree)
        check_mesh(body, self.space)
        h = basis.is_point
        self.positions = np.concatenate([p.place(basis.vectors, h) for p in body.placements])
        moments = np.tile(basis.mass @ h, self.copies)
        weights = np.tile(np.abs(np.diag(basis.mass)), self.copies)
        h = np.tile(h, self.copies)
        self.positions, self.is_point, self.nodal_mass, self.weights = (
            x[: self.n_owned] for x in (self.positions, h, moments, weights)
        )
        self._interfaces = {c: self._find_interface(c) for c in couplings}
        rigid = range(3) if self._holds_first_interface() else range(0)
        L = basis.strain_vectors
        self.strain = GramStrain(basis.strain_factor, L, L @ basis.vectors, rigid)
        self.strain_at = Memo(self._find_strain)  # for the balance, then for the next step
        self.losses: dict[str, Array] = {}
        if basis.viscosity.size:
            self.losses["viscosity"] = basis.viscosity
        if damping is not None:
            times = np.full(self.strain.size, float(damping.stiffness))
            self.losses["structural damping"] = times
        self.loss: Array = sum(self.losses.values(), np.zeros(self.strain.size))
        self.mass_damper = self._make_mass_damper(damping)
        self._of_nodes = find_nodal_forces(self, of_vectors)
        self.section_loads = tuple(BoundSectionLoads(x, self) for x in of_sections)

    def _make_mass_damper(self, damping: RayleighDamping | None) -> MassDamper | None:
        """Make the damper in proportion to the mass, see `RayleighDamping`. Collective."""
        if damping is None or damping.mass == 0.0:
            return None
        if len(damping.held) != 1:
            raise ModelError(
                f"held of {damping.name!r} must be one surface of the mesh of {self.body.name!r}, "
                "which is reduced"
            )
        parts, facets = [], damping.held[0].facets
        for copy in range(self.copies):
            nodes = copy * self._n + np.arange(self._n if self._is_owner else 0)
            masses = damping.mass * self.mass[: len(nodes), : len(nodes)]
            parts.append(DampedPart(nodes, masses, find_frame(self, damping.name, facets, copy)))
        return MassDamper(self, parts)

    def _holds_first_interface(self) -> bool:
        """Whether couplings hold the first interface of all copies."""
        held = {(c.copy, s) for c, s in self._interfaces.items()}
        return all((copy, 0) in held for copy in range(self.copies))

    def _find_interface(self, coupling: Coupling) -> int:
        """The interface that a coupling holds. Collective."""
        body = self.body
        found = find_surface_points(self.space, coupling.name, coupling.facets)
        if not len(found):
            raise ModelError(
                f"coupling {coupling.name!r} holds no node: its surface has no facets on "
                f"{body.name!r}"
            )
        interface = body.basis.find_interface(found)
        if interface is None:
            raise ModelError(
                f"the basis of {body.name!r} has no interface where coupling {coupling.name!r} "
                "holds it: reduce the body in a system that holds the same surface"
            )
        return interface

    def contact_nodes(self, coupling: Coupling) -> IntArray:
        """The point and the directors of the interface that a coupling holds."""
        first = coupling.copy * self._n + 4 * self._interfaces[coupling]
        nodes: IntArray = np.arange(first, first + 4, dtype=np.int64)
        return nodes[: 4 if self._is_owner else 0]

    @property
    def is_viscous(self) -> bool:
        """Whether a stress depends on the strain rate."""
        return bool(self.losses)

    @property
    def is_conservative(self) -> bool:
        """Forces on nodes do not depend on the motion."""
        return True

    @property
    def has_surface_energy(self) -> bool:
        """No force acts on the surface."""
        return False

    def vectors(self, u: Array) -> Array:
        """Vectors z of all copies that this rank owns, shape (copies or 0, n, 3).

        Args:
            u: Displacements of the owned vectors, shape (3 n_owned,).
        """
        z: Array = (self.positions + u.reshape(-1, 3)).reshape(-1, self._n, 3)
        return z

    def split(self, values: Array) -> Array:
        """Values of vectors by copies, shape (copies or 0, n, 3)."""
        return values.reshape(-1, self._n, 3)

    def forces_at(self, time: float) -> list[tuple[slice, Array]]:
        """Degrees of freedom and values [N] of each force of a fixed direction. Collective."""
        return [force.at(self.comm, time) for force in self._of_nodes]

    def find_slopes(self, u: Array, v: Array, times: StepTimes) -> Array:
        """Derivative of `add_forces` with respect to the increments of a step. Collective.

        Args:
            u: Displacements of the owned vectors in its middle, shape (3 n_owned,).
            v: Their velocities there, shape (3 n_owned,).
            times: The step.

        Returns:
            Shape (copies or 0, 3 n, 3 n) [N/m], not symmetric.
        """
        found = np.zeros((self.copies if self._is_owner else 0, 3 * self._n, 3 * self._n))
        for loads in self.section_loads:
            slopes = loads.find_slopes(u, v, times)
            if self._is_owner:
                loads.transfer.add_slopes(slopes, found)
        if self.mass_damper is not None:
            found -= self.mass_damper.part_matrices(u) / times.dt
        return found

    def applied_forces(self, gravity: Array, time: float) -> Array:
        """Weight and forces, shape (copies or 0, n, 3) [N]. Collective."""
        forces = np.outer(self.nodal_mass, gravity).ravel()
        for dofs, force in self.forces_at(time):  # all ranks hear of a function that fails
            forces[dofs] += force
        return self.split(forces)

    @cached_property
    def full(self) -> FlexibleModel:
        """The body on its mesh. Collective."""
        return FlexibleModel(self.body.full)  # type: ignore[arg-type]  # see check_forces

    def rows(self, copy: int, nodes: IntArray, weights: Array | csr_matrix) -> csr_matrix:
        """The weights times the functions at the nodes, for the vectors of the copy."""
        of_copy = np.atleast_2d(weights @ self.functions_at(nodes))
        found = np.zeros((len(of_copy), self.copies, self._n))
        found[:, copy] = of_copy
        return csr_matrix(found.reshape(len(found), -1)[:, : self.n_owned])

    def mesh_displacements(self, u: PETSc.Vec, copy: int) -> Array:
        """Sums of the functions, turned back."""
        R, _ = self.body.placements[copy].frame()
        z = self.split(self.comm.bcast(np.array(u.array_r)))[copy]
        found: Array = self.mesh_functions @ (z @ R)
        return found

    @property
    def mesh_masses(self) -> Array:
        """Those of the basis."""
        own = np.arange(*self.space.dofmap.index_map.local_range)
        found: Array = self.body.basis.masses[self._row_of_node[own]]
        return found

    def gather_forces(self, forces: Array, copy: int) -> Array:
        """Sums of the functions times the forces."""
        found = np.zeros((self.copies, self._n, 3))
        found[copy] = self.mesh_functions.T @ forces
        return sum_over_ranks(self.comm, found).reshape(-1, 3)[: self.n_owned]

    @cached_property
    def mesh_functions(self) -> Array:
        """The functions at the nodes of the mesh that this rank owns, shape (k, n). Collective."""
        return self.functions_at(np.arange(*self.space.dofmap.index_map.local_range))

    def functions_at(self, nodes: IntArray) -> Array:
        """The functions at nodes of the mesh, counted over all ranks, shape (k, n). Collective."""
        found: Array = self.body.basis.functions[self._row_of_node[nodes]]
        return found

    @cached_property
    def _row_of_node(self) -> IntArray:
        """Row of the functions of the basis for each node of the mesh, of all ranks. Collective."""
        owned = self.space.dofmap.index_map.size_local
        positions = self.space.tabulate_dof_coordinates()[:owned]
        positions = np.concatenate(self.comm.allgather(positions))
        rows: IntArray = cKDTree(self.body.basis.points).query(positions)[1]
        return rows

    def momentum(self, v: PETSc.Vec, p: PETSc.Vec) -> None:
        """Momenta p = M v of the vectors, into p."""
        p.array[:] = (self.mass @ self.split(v.array_r)).ravel()

    def mass_matrix(self, tensor: npt.ArrayLike | None = None) -> PETSc.Mat:
        """New mass matrix M [kg]."""
        out = self.new_stiffness()
        self.add_mass(np.eye(3) if tensor is None else tensor, out)
        return out

    def add_mass(self, tensor: npt.ArrayLike, out: PETSc.Mat) -> None:
        """Add the mass matrix with a tensor, as of `mass_matrix`, to out."""
        A = np.kron(self.mass, np.asarray(tensor, dtype=float))
        self.fill(out, np.broadcast_to(A, (self.copies, *A.shape)), add=True)

    def _find_strain(self, u: Array) -> tuple[Array, Array]:
        """Vectors y = L z and strain coordinates c of displacements."""
        y = self.strain.vectors(self.vectors(u))
        return y, self.strain.strain(y)

    def static_forces(self, u: PETSc.Vec, gravity: Array, time: float, out: PETSc.Vec) -> None:
        """Forces [N] that the vectors lack for equilibrium, into out."""
        y, c = self.strain_at(u.array_r)
        forces = self.strain.forces(self.strain.stress(c), y)
        out.array[:] = (forces - self.applied_forces(gravity, time)).ravel()
        for loads in self.section_loads:
            loads.start_step_at(StepTimes.at_rest(time), u.array_r)
            loads.add_forces(u.array_r, np.zeros(3 * self.n_owned), time, -1.0, out.array)

    def new_stiffness(self) -> PETSc.Mat:
        """New matrix with a dense block for each copy, zero."""
        local, k = 3 * self.n_owned, 3 * self._n
        rows = np.arange(0, local * k + 1, k, dtype=PETSc.IntType)
        columns = np.arange(local, dtype=PETSc.IntType).reshape(-1, k)
        csr = (rows, np.repeat(columns, k, axis=0).ravel(), np.zeros(local * k))
        matrix = PETSc.Mat().createAIJ(((local, None), (local, None)), csr=csr, comm=self.comm)
        matrix.assemble()
        return matrix

    def fill(self, out: PETSc.Mat, blocks: Array, add: bool = False) -> None:
        """Set the blocks of a matrix of `new_stiffness`, or add to them. Collective.

        Args:
            out: The matrix.
            blocks: Shape (copies, 3 n, 3 n).
            add: Whether they are added.
        """
        if self._is_owner:
            rows, columns, values = out.getValuesCSR()
            values = values + blocks.ravel() if add else blocks.ravel()
            out.setValuesCSR(rows, columns, values)
        out.assemble()

    def assemble_stiffness(self, u: PETSc.Vec, time: float, out: PETSc.Mat) -> None:
        """Derivative K of the forces at rest with respect to u [N/m], into out."""
        y, c = self.strain_at(u.array_r)
        J = self.strain.jacobian(y)
        K = J.swapaxes(1, 2) @ J
        add_to_components(K, self.strain.geometric(self.strain.stress(c)), 1.0)
        self.fill(out, K)

    def damping_matrix(self, u: PETSc.Vec, time: float) -> PETSc.Mat | None:
        """Derivative D of the forces with respect to the velocity at rest [N s/m]."""
        if not self.losses:
            return None
        J, out = self.strain.jacobian(self.strain_at(u.array_r)[0]), self.new_stiffness()
        self.fill(out, (J.swapaxes(1, 2) * self.loss) @ J)
        if self.mass_damper is not None:
            of_masses = self.mass_damper.matrix(u.array_r)
            out.axpy(1.0, of_masses)
            of_masses.destroy()
        return out

    def integrals(self, u: PETSc.Vec, v: PETSc.Vec) -> Array:
        """This rank's part of the energies and momenta of a motion."""
        z, z_dot = self.vectors(u.array_r), self.split(v.array_r)
        p = self.mass @ z_dot
        _, c = self.strain_at(u.array_r)
        linear = (self.nodal_mass @ z_dot.reshape(-1, 3))[None]
        angular = np.cross(z, p).reshape(-1, 3).sum(axis=0)
        kinetic, strain = 0.5 * np.sum(z_dot * p), 0.5 * np.sum(c * c)
        return np.concatenate([[kinetic], linear.ravel(), angular, [strain]])

    def surface_energy(self, u: PETSc.Vec, time: float) -> float:
        """No force acts on the surface."""
        return 0.0

    def expand(self, values: PETSc.Vec) -> Array:
        """Displacements, or velocities, of all nodes of the mesh from those of the vectors.

        Args:
            values: Of the vectors, `State.u` or `State.v` of the body.

        Returns:
            Those of the nodes `ReducedBody.points`, shape (copies, N, 3), equal on all ranks.

        Note:
            Collective.
        """
        z = self.split(self.comm.bcast(np.array(values.array_r)))
        expanded: Array = self.body.basis.functions @ z
        return expanded

    def initial_displacement(self) -> Array:
        """Displacements that the vectors start with, shape (n_owned, 3) [m]."""
        field = self.body.displacement
        what = f"displacement of {self.body.name!r}"
        if field is None:
            return np.zeros_like(self.positions)
        if not callable(field):
            X = np.zeros((self.size_global, 3))
            return evaluate_field(self.comm, what, X, field)[: self.n_owned]
        values = evaluate_field(self.comm, what, self.body.points.reshape(-1, 3), field)
        free = np.ones((self.copies, self._n), dtype=bool)
        for coupling, interface in self._interfaces.items():
            free[coupling.copy, 4 * interface : 4 * interface + 4] = False
        return self._fit(values, free)

    def initial_velocity(self) -> Array | None:
        """Velocities of the body's own field, shape (n_owned, 3) [m/s]; None if it has none."""
        field, what = self.body.velocity, f"velocity of {self.body.name!r}"
        if field is None:
            return None
        values = evaluate_field(self.comm, what, self.body.points.reshape(-1, 3), field)
        return self._fit(values, np.ones((self.copies, self._n), dtype=bool))

    def _fit(self, values: Array, free: Array) -> Array:
        """Owned vectors whose motion is nearest to one of the nodes, see `find_nearest_vectors`."""
        found = find_nearest_vectors(self.body.basis, values, free)
        return found.reshape(-1, 3)[: self.n_owned]
