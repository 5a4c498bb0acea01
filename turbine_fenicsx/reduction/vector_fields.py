"""Displacements of a body whose components become functions of a basis.

They are static shapes between moving interfaces, then modes with the interfaces at rest, then
responses to smooth forces along its longest axis. These release the membrane strain of bending and
twist, which modes alone do not.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, eigsh

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.linear_solvers.factor import to_petsc
from turbine_fenicsx.linear_solvers.symmetric import SymmetricFactor
from turbine_fenicsx.reduction.gathered_body import WholeBody
from turbine_fenicsx.reduction.interfaces import rigid_motions
from turbine_fenicsx.reduction.long_axis import LongAxis

SHIFT = 0.1
"""Share of a frequency's square that keeps the factor of a free body from being singular."""


class HeldBody:
    """A body whose interfaces are at rest, on rank 0.

    Args:
        surfaces: Nodes of each interface; without any the body is free.
        origins: X_s, shape (S, 3).
    """

    def __init__(
        self, whole: WholeBody, surfaces: Sequence[IntArray], origins: Array, axis: LongAxis
    ) -> None:
        self._whole, self._surfaces, self._origins = whole, surfaces, origins
        self._axis = axis
        held = np.concatenate([np.zeros(0, np.int64), *surfaces])
        n = len(whole.positions)
        self._free = np.setdiff1d(np.arange(n), held)
        if not self._free.size:
            raise ModelError("all nodes of the body are held: nothing is left to be reduced")
        count, component = connected_components(whole.mass, directed=False)
        if count > 1 and np.unique(component[held]).size < count:
            raise ModelError(
                f"the mesh has {count} parts that do not touch, and couplings do not hold all: a "
                "basis needs them to"
            )
        dofs = (3 * self._free[:, None] + np.arange(3)).ravel()
        self._dofs, rows = dofs, whole.stiffness[dofs]
        self._K, self._rows = rows[:, dofs], rows
        self._rigid = np.zeros((0, n, 3)) if surfaces else self._find_rigid_modes()
        shift = 0.0 if surfaces else SHIFT * self._estimate_square()
        of_free = whole.mass[self._free][:, self._free]
        self._shift, self._M = shift, sparse.kron(of_free, sparse.identity(3), "csr")
        self._matrix = to_petsc((self._K + shift * self._M).tocsr())
        self._factor = SymmetricFactor(self._matrix, "reduction_")
        with one_thread():
            self._factor.update()

    def destroy(self) -> None:
        """Free the factor."""
        self._factor.destroy()
        self._matrix.destroy()

    def follow_interfaces(self) -> list[Array]:
        """Static shapes when each interface but the first moves as if rigid, six for each."""
        found = []
        for nodes, origin in zip(self._surfaces[1:], self._origins[1:], strict=True):
            for motion in rigid_motions(self._whole.positions, origin):
                u = np.zeros_like(motion)
                u[nodes] = motion[nodes]
                forces = self._rows @ u.ravel()
                u[self._free] -= self._solve(forces).reshape(-1, 3)
                found.append(u)
        return found

    def modes(self, count: int) -> tuple[Array, Array]:
        """Modes with the modal mass one, the lowest first.

        Returns:
            Squares of angular frequencies, shape (count,) [1/s^2], and shapes (count, N, 3).
        """
        k = count + len(self._rigid)
        if not count:
            return np.zeros(0), np.zeros((0, *self._whole.positions.shape))
        if k >= len(self._dofs):
            raise ModelError(
                f"modes must be fewer than the {len(self._dofs)} coordinates of the body, got "
                f"{count}"
            )
        inverse = LinearOperator(self._K.shape, self._solve, dtype=float)
        start = np.random.default_rng(0).standard_normal(self._K.shape[0])
        with one_thread():
            squares, shapes = eigsh(
                self._K, k, self._M, sigma=-self._shift, OPinv=inverse, v0=start
            )
        elastic = np.argsort(squares)[len(self._rigid) :]
        return squares[elastic], np.array([self._expand(shape) for shape in shapes.T[elastic]])

    def responses(self, count: int, squares: Array, modes: Array) -> list[Array]:
        """Displacements under smooth forces, those with the largest energy beyond that of modes.

        Args:
            count: Number of fields; there are as many as forces at most.
            squares: Squares of the angular frequencies of the modes, shape (k,).
            modes: The modes, shape (k, N, 3).
        """
        loads = [self._load(field) for field in self._list_forces()]
        with one_thread():
            solutions = self._factor.solve_many(np.column_stack(loads))
        u = np.array([self._expand(solution) for solution in solutions.T])
        forces = np.array([self._expand(load) for load in loads])
        shifted = squares + self._shift
        in_modes = np.tensordot(forces, modes, ((1, 2), (1, 2))) / shifted
        u -= np.tensordot(in_modes, modes, 1)
        compliance = np.tensordot(u, forces, ((1, 2), (1, 2)))
        energies, weights = np.linalg.eigh(0.5 * (compliance + compliance.T))
        best = np.argsort(energies)[::-1][:count]
        return list(np.tensordot(weights[:, best].T, u, 1))

    def _list_forces(self) -> list[Array]:
        """Accelerations of six kinds, times polynomials along the axis, shape (N, 3) each.

        Three push along the axes of inertia, three turn the sections about the line of their
        centres, with the same size at the distance of the radius of gyration.
        """
        X, mass = self._whole.positions, np.asarray(self._whole.mass.sum(axis=1)).ravel()
        arms, axes = self._axis.arms(X), self._axis.axes.T
        size = np.sqrt(np.abs(mass) @ np.sum(arms * arms, axis=1) / np.abs(mass).sum())
        kinds = [np.broadcast_to(axis, X.shape) for axis in axes]
        kinds += [np.cross(axis, arms) / size for axis in axes]
        along = self._axis.polynomials(X).T
        return [kind * factor[:, None] for factor in along for kind in kinds]

    def _load(self, accelerations: Array) -> Array:
        """Forces of accelerations on the free nodes; a free body is not pushed as a whole."""
        forces = self._whole.mass @ accelerations
        for mode in self._rigid:
            forces -= np.sum(mode * forces) * (self._whole.mass @ mode)
        load: Array = forces[self._free].ravel()
        return load

    def _find_rigid_modes(self) -> Array:
        """Six rigid motions with the mass one, orthogonal to each other."""
        motions = rigid_motions(self._whole.positions, self._origins[0])
        mass = np.array([[np.sum(a * (self._whole.mass @ b)) for b in motions] for a in motions])
        return np.tensordot(np.linalg.inv(np.linalg.cholesky(mass)), motions, 1)

    def _estimate_square(self) -> float:
        """Square of a frequency near the first, from bending along the axis."""
        estimates = []
        for force in self._list_forces():
            u = force.copy()
            for mode in self._rigid:
                u -= np.sum(mode * (self._whole.mass @ u)) * mode
            mass = np.sum(u * (self._whole.mass @ u))
            if mass > 1e-6 * np.sum(force * (self._whole.mass @ force)):
                energy = u.ravel() @ (self._whole.stiffness @ u.ravel())
                estimates.append(float(energy / mass))
        return min(estimates)

    def _solve(self, forces: Array) -> Array:
        """Displacements of the free nodes under forces on them, both flat."""
        with one_thread():
            found: Array = self._factor.solve_many(np.asarray(forces).reshape(-1, 1))[:, 0]
        return found

    def _expand(self, values: Array) -> Array:
        """Values of all nodes, zero on the interfaces, shape (N, 3)."""
        found = np.zeros(self._whole.positions.shape)
        found[self._free] = np.asarray(values).reshape(-1, 3)
        return found
