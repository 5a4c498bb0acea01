"""The interface of a body that deforms, however it is discretised.

Its motion is that of its nodes, see `BodyNodes`.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, Protocol

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.system.body_nodes import BodyNodes
from turbine_fenicsx.system.bound_section_loads import BoundSectionLoads
from turbine_fenicsx.system.mass_damper import MassDamper


class BodyModel(BodyNodes, Protocol):
    """Mass, energy and forces of a body as functions of its nodes, without a time step.

    Vectors of nodal values are distributed, with three numbers for each node.

    Attributes:
        forces: The forces on it, in the order of their works.
        nodal_mass: int rho phi_k dV of the owned nodes with their functions phi_k, shape
            (n_owned,) [kg]; negative for some.
        weights: Positive masses of the owned nodes, to measure motions, shape (n_owned,) [kg].
        section_loads: Loads on its sections.
        mass_damper: What dampens in proportion to its mass; None if nothing does.
        meaning: Hash of the basis that nodal values belong to; empty for those of a mesh.
    """

    forces: tuple[Any, ...]
    nodal_mass: Array
    weights: Array
    section_loads: tuple[BoundSectionLoads, ...]
    mass_damper: MassDamper | None
    meaning: str

    @property
    def is_small(self) -> bool:
        """Whether its tangent is small and dense."""
        return self.dense_block > 0

    @property
    def has_node_loads(self) -> bool:
        """Whether `add_forces` adds something."""
        return bool(self.section_loads) or self.mass_damper is not None

    def inertia(self) -> Array:
        """Mass, first and second moments about the origin in the initial configuration. Collective.

        Returns:
            int rho (1, X) (1, X)^T dV, shape (4, 4) [kg, kg m, kg m^2].
        """
        arms, momenta, own = self.new_vector(), self.new_vector(), np.zeros((4, 4))
        arms.array[:] = self.positions.ravel()
        self.momentum(arms, momenta)
        own[0, 0] = self.is_point @ self.nodal_mass
        own[0, 1:] = own[1:, 0] = self.nodal_mass @ self.positions
        own[1:, 1:] = self.positions.T @ momenta.array_r.reshape(-1, 3)
        arms.destroy()
        momenta.destroy()
        return sum_over_ranks(self.comm, own)

    def add_forces(self, u: Array, v: Array, time: float, factor: float, out: Array) -> None:
        """Add loads on sections, and what dampens in proportion to the mass. Collective.

        Args:
            u: Displacements of the owned nodes, shape (3 n_owned,) [m].
            v: Their velocities, shape (3 n_owned,) [m/s].
            time: Time of the loads [s].
            factor: Factor of the forces.
            out: What they are added to, shape (3 n_owned,).
        """
        for loads in self.section_loads:
            loads.add_forces(u, v, time, factor, out)
        if self.mass_damper is not None:
            self.mass_damper.add_forces(u, v, factor, out)

    @property
    @abstractmethod
    def is_viscous(self) -> bool:
        """Whether a stress depends on the strain rate."""

    @property
    @abstractmethod
    def is_conservative(self) -> bool:
        """Whether the stiffness K is symmetric for certain."""

    @property
    @abstractmethod
    def has_surface_energy(self) -> bool:
        """Whether forces on the surface, such as contact, have an energy."""

    def new_vector(self) -> PETSc.Vec:
        """New distributed vector of nodal values without ghosts, zero. Collective."""
        size = (3 * self.n_owned, 3 * self.size_global)
        vector = PETSc.Vec().createMPI(size, bsize=3, comm=self.comm)
        vector.set(0.0)
        return vector

    @abstractmethod
    def contact_nodes(self, coupling: Coupling) -> IntArray:
        """Owned nodes that a coupling of the body holds, sorted. Collective."""

    @abstractmethod
    def momentum(self, v: PETSc.Vec, p: PETSc.Vec) -> None:
        """Nodal momenta p = M v [kg m/s] of nodal velocities v, into p. Collective."""

    @abstractmethod
    def mass_matrix(self, tensor: npt.ArrayLike | None = None) -> PETSc.Mat:
        """New consistent mass matrix M [kg]. Collective.

        Args:
            tensor: A tensor A of shape (3, 3) that multiplies all accelerations a, as in
                int rho w.A a dV; the unit tensor if None.
        """

    @abstractmethod
    def add_mass(self, tensor: npt.ArrayLike, out: PETSc.Mat) -> None:
        """Add the consistent mass matrix with a tensor, as of `mass_matrix`, to out. Collective.

        Args:
            tensor: The tensor A, shape (3, 3).
            out: Matrix such as of `new_stiffness`.
        """

    @abstractmethod
    def static_forces(self, u: PETSc.Vec, gravity: Array, time: float, out: PETSc.Vec) -> None:
        """Forces [N] that the nodes lack for equilibrium, stresses minus applied forces, into out.

        Args:
            u: Displacement.
            gravity: Acceleration of gravity, shape (3,) [m/s^2].
            time: Time of the forces [s].
            out: Vector of nodal values.

        Note:
            Collective.
        """

    @abstractmethod
    def new_stiffness(self) -> PETSc.Mat:
        """New matrix for `assemble_stiffness`. Collective."""

    @abstractmethod
    def assemble_stiffness(self, u: PETSc.Vec, time: float, out: PETSc.Mat) -> None:
        """Derivative K of the forces at rest with respect to u [N/m], into out. Collective."""

    @abstractmethod
    def damping_matrix(self, u: PETSc.Vec, time: float) -> PETSc.Mat | None:
        """Derivative D of the forces with respect to the velocity at rest [N s/m]. Collective.

        Args:
            u: Displacement.
            time: Time of the forces [s].

        Returns:
            A new matrix; None if no force depends on the velocity.
        """

    @abstractmethod
    def integrals(self, u: PETSc.Vec, v: PETSc.Vec) -> Array:
        """This rank's part of the energies and momenta of a motion. Collective.

        Args:
            u: Displacement.
            v: Velocity.

        Returns:
            Kinetic energy [J], linear [kg m/s] and angular momentum [kg m^2/s], and strain energy
            [J], shape (8,).
        """

    @abstractmethod
    def surface_energy(self, u: PETSc.Vec, time: float) -> float:
        """This rank's part of the energy of forces on the surface [J]. Collective.

        Args:
            u: Displacement.
            time: Time of the forces [s].
        """

    @abstractmethod
    def initial_displacement(self) -> Array:
        """Displacements that the body starts with, shape (n_owned, 3) [m]. Collective.

        Raises:
            ModelError: if they have another shape, are not finite or turn cells inside out, on all
                ranks.
        """

    @abstractmethod
    def initial_velocity(self) -> Array | None:
        """Velocities of the body's own field, shape (n_owned, 3) [m/s]; None if it has none.

        Raises:
            ModelError: if they have another shape or are not finite, on all ranks.

        Note:
            Collective.
        """
