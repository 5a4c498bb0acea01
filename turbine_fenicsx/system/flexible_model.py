"""A flexible body as discretised by finite elements, without a time step.

With nodal displacements u and velocities v, the test functions w, and the reference density rho,

    int rho v' . w dV + int F (S + S_v) : grad w dV = int rho g . w dV + int t . w dA,

where S = 2 dW/dC is the elastic stress and S_v(E') that of a viscous material and of Rayleigh
damping, and t are the forces on surfaces.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import fem
from scipy.sparse import csr_matrix

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.facets import check_facets
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.owned_nodes import nodes_of_cells, nodes_of_facets
from turbine_fenicsx.forces.body_force import BodyForce
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.node_force import NodeForce
from turbine_fenicsx.forces.prescribed_force import SurfaceForce
from turbine_fenicsx.forces.rayleigh_damping import RayleighDamping
from turbine_fenicsx.forces.section_loads import SectionLoads
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.kinematics import deformation_gradient, right_cauchy_green
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.bound_section_loads import BoundSectionLoads
from turbine_fenicsx.system.cell_numbers import CellNumbers
from turbine_fenicsx.system.linear_form import LinearForm
from turbine_fenicsx.system.mass_damper import DampedPart, MassDamper, find_frame
from turbine_fenicsx.system.nodal_forces import find_nodal_forces
from turbine_fenicsx.system.own_fields import check_cells, evaluate_field
from turbine_fenicsx.system.weak_form import WeakForm


class FlexibleModel(WeakForm, BodyModel):
    """Function space, mass, energy, stress and forces of a flexible body.

    Args:
        body: The body.
        forces: Forces on surfaces, nodes, masses and sections.
        damping: Rayleigh damping; None is none.

    Attributes:
        forces: Those on surfaces, then those on nodes and masses, then those on sections.
        local_positions: Initial positions X of the owned nodes, then of the ghosts [m].
        nodal_forces: Degrees of freedom and values [N] of each force on nodes or masses, set by
            `set_time`.
        mass_damper: Its part in proportion to the mass; None if there is none.
    """

    body: FlexibleBody
    dense_block = 0
    meaning = ""

    def __init__(
        self,
        body: FlexibleBody,
        forces: Sequence[SurfaceForce | NodeForce | BodyForce | SectionLoads] = (),
        damping: RayleighDamping | None = None,
    ) -> None:
        of_nodes = [x for x in forces if isinstance(x, NodeForce | BodyForce)]
        section_loads = [x for x in forces if isinstance(x, SectionLoads)]
        others = NodeForce | BodyForce | SectionLoads
        surface_forces = [x for x in forces if not isinstance(x, others)]
        self.forces: tuple[Any, ...] = (*surface_forces, *of_nodes, *section_loads)
        super().__init__(body, surface_forces, damping)
        V, index_map = self.space, self.space.dofmap.index_map
        self.comm = body.mesh.comm
        self.n_owned, self.size_global = index_map.size_local, index_map.size_global
        self._work = PETSc.Vec().createGhost(
            index_map.ghosts.astype(PETSc.IntType),
            size=(3 * self.n_owned, 3 * self.size_global),
            bsize=3,
            comm=self.comm,
        )
        self._x = fem.Function(V)
        self._x.interpolate(lambda x: x)
        self.local_positions = self._x.x.array.reshape(-1, 3).copy()
        self.positions = self.local_positions[: self.n_owned]
        self.is_point = np.ones(self.n_owned)
        self.nodal_forces: list[tuple[slice, Array]] = []
        self._compile()
        ones = self.new_vector()
        ones.set(1.0)
        self.momentum(ones, ones)
        self.nodal_mass = ones.array.reshape(-1, 3)[:, 0].copy()
        self.weights = np.abs(self.nodal_mass)
        ones.destroy()
        self._of_nodes = find_nodal_forces(self, of_nodes)
        self.mass_damper = self._make_mass_damper()
        self.section_loads = tuple(BoundSectionLoads(x, self) for x in section_loads)

    def _make_mass_damper(self) -> MassDamper | None:
        """Make the damper in proportion to the mass, see `RayleighDamping`."""
        if self.damping is None or self.damping.mass == 0.0:
            return None
        matrix = self.mass_matrix()
        diagonal = matrix.getDiagonal()
        masses = diagonal.array_r.reshape(-1, 3)[:, 0].copy()
        matrix.destroy()
        diagonal.destroy()
        ends = np.array([self.nodal_mass.sum(), masses.sum()])
        mass, size = sum_over_ranks(self.comm, ends)
        masses *= self.damping.mass * mass / size
        parts = []
        for part in self.damping.held:
            nodes = np.arange(self.n_owned)
            if part.cells is not None:
                nodes = nodes_of_cells(self.space, part.cells)
            frame = find_frame(self, self.damping.name, part.facets)
            parts.append(DampedPart(nodes, masses[nodes], frame))
        return MassDamper(self, parts)

    def _compile(self) -> None:
        """Compile what every run needs: momenta and energies."""
        w, v, mesh = ufl.TestFunction(self.space), self._v, self.body.mesh
        F = deformation_gradient(self._u)
        self._momentum = LinearForm(self.inertia_term(v, w))
        p = self.density * v
        L = ufl.cross(self._x, p)
        moving = [0.5 * ufl.dot(v, p), *(p[i] for i in range(3)), *(L[i] for i in range(3))]
        W = self.energy(right_cauchy_green(F))
        self._sums = CellNumbers(mesh, (moving, self.dx_mass), ([W], self.dx_stress))

    def set_time(self, time: float) -> None:
        """Set the functions of time of all forces [s]."""
        self.surface.set_time(time)
        self.nodal_forces = [force.at(self.comm, time) for force in self._of_nodes]

    def contact_nodes(self, coupling: Coupling) -> IntArray:
        """Owned nodes on the facets of a coupling, sorted."""
        facets = check_facets(coupling.name, self.body.mesh, coupling.facets)
        return nodes_of_facets(self.space, facets)

    @property
    def full(self) -> FlexibleModel:
        """The model itself."""
        return self

    def rows(self, copy: int, nodes: IntArray, weights: Array | csr_matrix) -> csr_matrix:
        """The weights of the owned ones among the nodes."""
        first, end = self.space.dofmap.index_map.local_range
        found = csr_matrix(weights).tocoo()
        node = nodes[found.col]
        own = (node >= first) & (node < end)
        places = found.row[own], node[own] - first
        return csr_matrix((found.data[own], places), shape=(found.shape[0], self.n_owned))

    def mesh_displacements(self, u: PETSc.Vec, copy: int) -> Array:
        """Those of the nodes."""
        return np.array(u.array_r).reshape(-1, 3)

    @property
    def mesh_masses(self) -> Array:
        """Those of the nodes."""
        found: Array = self.nodal_mass
        return found

    def gather_forces(self, forces: Array, copy: int) -> Array:
        """The forces themselves."""
        return forces

    def momentum(self, v: PETSc.Vec, p: PETSc.Vec) -> None:
        """Nodal momenta p = M v [kg m/s] of nodal velocities v, into p."""
        self.copy_to(self._v, v)
        self.assemble(self._momentum, p)

    def mass_matrix(self, tensor: npt.ArrayLike | None = None) -> PETSc.Mat:
        """New consistent mass matrix M [kg]."""
        A = np.eye(3) if tensor is None else np.asarray(tensor, dtype=float)
        form = self.mass_form(A)
        full = _compat.create_matrix(form)
        _compat.assemble_matrix(full, form)
        matrix = _keep_directions(full, A != 0.0)
        full.destroy()
        return matrix

    def add_mass(self, tensor: npt.ArrayLike, out: PETSc.Mat) -> None:
        """Add the consistent mass matrix with a tensor, as of `mass_matrix`, to out."""
        _compat.assemble_matrix(out, self.mass_form(np.asarray(tensor, dtype=float)), add=True)

    def static_forces(self, u: PETSc.Vec, gravity: Array, time: float, out: PETSc.Vec) -> None:
        """Forces [N] that the nodes lack for equilibrium, into out."""
        self.set_time(time)
        self.copy_to(self._u, u)
        self.assemble(self.static_forms.forces, out)
        out.array[:] -= (self.nodal_mass[:, None] * gravity).ravel()
        for dofs, force in self.nodal_forces:
            out.array[dofs] -= force
        for loads in self.section_loads:
            loads.start_step_at(StepTimes.at_rest(time), u.array_r)
            loads.add_forces(u.array_r, np.zeros(3 * self.n_owned), time, -1.0, out.array)

    def new_stiffness(self) -> PETSc.Mat:
        """New matrix for `assemble_stiffness`."""
        return _compat.create_matrix(self.static_forms.stiffness)

    @property
    def is_conservative(self) -> bool:
        """Whether K is symmetric for certain: no force acts on a surface, which it may follow."""
        return not self.surface.forces

    def assemble_stiffness(self, u: PETSc.Vec, time: float, out: PETSc.Mat) -> None:
        """Derivative K of the forces at rest with respect to u [N/m], into out."""
        self.set_time(time)
        self.copy_to(self._u, u)
        _compat.assemble_matrix(out, self.static_forms.stiffness)

    def damping_matrix(self, u: PETSc.Vec, time: float) -> PETSc.Mat | None:
        """Derivative D of the forces with respect to the velocity at rest [N s/m]."""
        damper = self.mass_damper
        if self.damping_form is None:
            return None if damper is None else damper.matrix(u.array_r)
        self.set_time(time)
        self.copy_to(self._u, u)
        self._v.x.array[:] = 0.0
        matrix = _compat.create_matrix(self.damping_form)
        _compat.assemble_matrix(matrix, self.damping_form)
        if damper is not None:
            of_masses = damper.matrix(u.array_r)
            matrix.axpy(1.0, of_masses)
            of_masses.destroy()
        return matrix

    def integrals(self, u: PETSc.Vec, v: PETSc.Vec) -> Array:
        """This rank's part of the energies and momenta of a motion."""
        self.copy_to(self._u, u)
        self.copy_to(self._v, v)
        self._x.x.array[:] = self.local_positions.ravel() + self._u.x.array
        return self._sums.sums()

    def surface_energy(self, u: PETSc.Vec, time: float) -> float:
        """This rank's part of the energy of forces on the surface [J]."""
        return self.surface.energy(u.array_r, time)

    @property
    def has_surface_energy(self) -> bool:
        """Whether forces on the surface, such as contact, have an energy."""
        return any(self.surface.has_energy)

    def initial_displacement(self) -> Array:
        """Displacements that the body starts with, shape (n_owned, 3) [m]."""
        if self.body.displacement is None:
            return np.zeros_like(self.positions)
        found = self._evaluate("displacement", self.body.displacement)
        u = self.new_vector()
        u.array[:] = found.ravel()
        check_cells(self.body, self.space, self.local_positions, self.nodal_values(u))
        u.destroy()
        return found

    def initial_velocity(self) -> Array | None:
        """Velocities of the body's own field, shape (n_owned, 3) [m/s]; None if it has none."""
        field = self.body.velocity
        return None if field is None else self._evaluate("velocity", field)

    def _evaluate(self, what: str, field: Any) -> Array:
        """Values of a field of the body at the owned nodes."""
        return evaluate_field(self.comm, f"{what} of {self.body.name!r}", self.positions, field)

    def strain_energy(self, u: PETSc.Vec) -> float:
        """This rank's part of the strain energy [J]. Collective."""
        return float(self.integrals(u, u)[7])

    def sum_at_owners(self, values: Array) -> Array:
        """Sum of nodal values that several ranks hold parts of. Collective.

        Args:
            values: Values at all local nodes, ghosts included, shape (nodes, 3).

        Returns:
            Sums at the owned nodes, shape (n_owned, 3).
        """
        if self.comm.size == 1:
            return values
        with self._work.localForm() as local:
            local.array[:] = values.ravel()
        self._work.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        nodal: Array = self._work.array_r.reshape(-1, 3).copy()
        return nodal

    def nodal_values(self, vector: PETSc.Vec) -> Array:
        """Values of a vector at all local nodes, ghosts included, shape (nodes, 3)."""
        self.copy_to(self._v, vector)
        return np.array(self._v.x.array).reshape(-1, 3)

    def assemble(self, form: Any, out: PETSc.Vec) -> None:
        """Assemble a linear form, a `LinearForm` or a compiled one, and copy the owned entries."""
        if isinstance(form, LinearForm):
            form.assemble(self._work)
        else:
            _compat.assemble_vector(self._work, form)
        out.array[:] = self._work.array_r

    def copy_to(self, function: Any, values: PETSc.Vec) -> None:
        """Copy a vector into a function, ghosts included."""
        function.x.array[: 3 * self.n_owned] = values.array_r
        function.x.scatter_forward()


def _keep_directions(full: PETSc.Mat, kept: npt.NDArray[np.bool_]) -> PETSc.Mat:
    """The entries of a matrix that couple some directions, as a matrix without the others.

    Args:
        kept: Whether the entries between two directions stay, shape (3, 3).
    """
    starts, columns, values = full.getValuesCSR()
    rows = np.repeat(np.arange(starts.size - 1), np.diff(starts))
    stay = kept[rows % 3, columns % 3]
    lengths = np.bincount(rows[stay], minlength=starts.size - 1)
    starts = np.concatenate([[0], np.cumsum(lengths)]).astype(PETSc.IntType)
    csr = (starts, columns[stay], values[stay])
    matrix = PETSc.Mat().createAIJ(full.getSizes(), csr=csr, comm=full.getComm())
    matrix.assemble()
    return matrix
