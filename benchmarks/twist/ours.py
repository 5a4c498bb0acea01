"""The same blade with this package: hollow solid, beams of section matrices, prisms.

Displacements and loads are in the axes of the windIO file: x to the suction side, y to the
trailing edge, z along the span, from the root.
"""

import sys
from dataclasses import dataclass, replace
from pathlib import Path

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.spatial import cKDTree
from section_motion import STIFF, tributary

from turbine_fenicsx.foundation.section_matrices import interpolate_matrices
from turbine_fenicsx.turbine.blades.wall_rows import WallRows
from turbine_fenicsx.turbine.blades.windio_sections import find_sections
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.windio import find_turbine_file, read_turbine
from turbine_fenicsx.windio.section_properties import SectionProperties

sys.path.append(str(Path(__file__).parents[2] / "demos" / "verification"))
from published import load as load_demo

demo = {name: load_demo("iea22_blade", name) for name in ("exact", "solid")}
AXES = demo["solid"].AXES


@dataclass(frozen=True)
class Solid:
    """A clamped blade as a hollow solid of laminates, as `section_motion` wants it.

    Attributes:
        made: Its system and mesh.
        nodes: Shape (n, 3) [m].
        rows: Nodes of the skin at the ends of rows of cells, with the lengths that they stand for.
        stations: Span fractions of these.
        axis: Points of the axis there, shape (len(stations), 3) [m].
    """

    made: object
    nodes: np.ndarray
    rows: list
    stations: np.ndarray
    axis: np.ndarray

    def solve(self, loads):
        """Displacements under small forces, (len(loads), n, 3); the tip is rigid."""
        T = self._motions()
        right = [T.T @ (force @ AXES).ravel() for force in loads]
        K = self._linearise(T, np.zeros(self.nodes.size))[1]
        return [(T @ x).reshape(-1, 3) @ AXES.T for x in solve_sparse(K, right)]

    def bend(self, force, factors):
        """Displacements under multiples of forces that keep their direction; the tip is free.

        Returns:
            Shape (len(factors), n, 3) [m].
        """
        T = self._motions(stiff_tip=False)
        u, found = np.zeros(self.nodes.size), []
        for factor in factors:
            for _ in range(30):
                inner, K = self._linearise(T, u)
                missing = T.T @ (factor * (force @ AXES).ravel() - inner)
                step = T @ solve_sparse(K, [missing])[0]
                u = u + step
                if np.abs(step).max() < 1e-6:
                    break
            else:
                raise RuntimeError(f"no equilibrium at {factor:g} times the load")
            found.append(u.reshape(-1, 3) @ AXES.T)
            print(f"solid: {factor:g} of the load", flush=True)
        return np.array(found)

    def _linearise(self, T, u):
        """Inner forces at displacements, and their derivative for the free motions."""
        system = self.made.system()
        model = system.flexible_models[0]
        at = system.initial_state().u[0]
        at.array[:] = u
        forces, K = at.duplicate(), model.new_stiffness()
        model.static_forces(at, np.zeros(3), 0.0, forces)
        model.assemble_stiffness(at, 0.0, K)
        indptr, indices, data = K.getValuesCSR()
        found = forces.array_r.copy(), T.T @ (csr_matrix((data, indices, indptr)) @ T)
        K.destroy()
        return found

    def _motions(self, stiff_tip=True):
        """Columns by which nodes can move with a clamped root; sparse, (3 n, m)."""
        z = self.nodes[:, 2]
        clamped, stiff = z < 1e-6, self._beyond() & stiff_tip
        free = np.flatnonzero(np.repeat(~(clamped | stiff), 3))
        entries = [(free, np.arange(len(free)), np.ones(len(free)))]
        r = (self.nodes - self.axis[-1]) @ AXES
        own = np.flatnonzero(stiff)
        for d in range(3 * stiff_tip):
            unit = np.eye(3)[d]
            for column, v in ((d, np.tile(unit, (len(own), 1))), (3 + d, np.cross(unit, r[own]))):
                dofs = (3 * own[:, None] + np.arange(3)).ravel()
                entries.append((dofs, np.full(len(dofs), len(free) + column), v.ravel()))
        rows, columns, values = (np.concatenate([e[k] for e in entries]) for k in range(3))
        shape = r.size, len(free) + 6 * stiff_tip
        return coo_matrix((values, (rows, columns)), shape).tocsr()

    def _beyond(self):
        """Whether nodes are beyond the span fraction where the stiff tip begins."""
        first = int(np.flatnonzero(self.stations > STIFF)[0])
        normal = self.axis[first] - self.axis[first - 1]
        skin = self.nodes[self.rows[first][0]]
        return (self.nodes - skin.mean(axis=0)) @ normal > -1e-3 * np.linalg.norm(normal)


def solve_sparse(K, right):
    """Solutions with a symmetric matrix of scipy."""
    A = PETSc.Mat().createAIJ(K.shape, csr=(K.indptr, K.indices, K.data), comm=PETSc.COMM_SELF)
    solver = PETSc.KSP().create(PETSc.COMM_SELF)
    solver.setOperators(A)
    solver.setType("preonly")
    solver.pc.setType("cholesky")
    solver.pc.setFactorSolverType("mumps")
    found = []
    for b in right:
        b = PETSc.Vec().createWithArray(b, comm=PETSc.COMM_SELF)
        x = b.duplicate()
        solver.solve(b, x)
        found.append(x.array_r.copy())
    solver.destroy()
    A.destroy()
    return found


def make_solid(file, span, around):
    """The solid of a windIO file with so many cells along the span and around a section."""
    blade = replace(read_turbine(find_turbine_file(file)).blade, closed_tip=False)
    made = demo["solid"].make_solid(MPI.COMM_SELF, blade, (span, around), True)
    model = made.system().flexible_models[0]
    start = np.array([blade.hub_radius, 0.0, 0.0])
    points = made.block.points
    number = cKDTree(model.positions).query(points)[1]
    walls = WallRows(None, made.block, None)
    panels = np.flatnonzero(
        np.array([made.block.parts[k] in blade.panels for k in made.block.part])
    )
    span = made.block.span[panels]
    rows, stations = [], []
    for s in np.unique(np.concatenate([span, span.mean(axis=1, keepdims=True)], axis=1).round(9)):
        at = np.abs(np.column_stack([span[:, 0], span.mean(axis=1), span[:, 1]]) - s) < 2e-9
        end = int(at.any(axis=0).argmax())
        edge = walls.nodes_at([(end, 0, 2), (end, 1, 2), (end, 2, 2)])[panels[at[:, end]]]
        ids, length = _weigh(points, edge)
        rows.append((number[ids], length))
        stations.append(s)
    axis = blade.axis_at(np.array(stations)) - start
    return Solid(made, (model.positions - start) @ AXES.T, rows, np.array(stations), axis @ AXES.T)


def _weigh(points, edges):
    """Nodes of curved edges, and the lengths that they stand for (Simpson's rule)."""
    length = np.linalg.norm(points[edges[:, 2]] - points[edges[:, 0]], axis=1)
    weight = np.outer(length, [1.0, 4.0, 1.0]) / 6.0
    ids, inverse = np.unique(edges, return_inverse=True)
    return ids, np.bincount(inverse.ravel(), weight.ravel())


def make_beams(file, stations=70, around=40):
    """Beams by name: of the matrices of the file, and of sections of the layup."""
    turbine = read_turbine(find_turbine_file(file))
    case = Case.model_validate(
        {"turbine": {"file": str(find_turbine_file(file))}, "blade": {"layup": "laminate"}}
    )
    found = find_sections(case, stations, around).sections
    grid = found.stations / found.length
    wide = np.concatenate([[0.0], grid, [1.0]])
    ends = np.concatenate([[0], np.arange(len(grid)), [len(grid) - 1]])
    given = turbine.blade_sections
    term = interpolate_matrices(
        given.grid, wide, np.append(found.inclination[ends[:-1]], np.zeros((1, 6, 6)), axis=0)
    )
    kinds = {
        "file": given,
        "file with the term": SectionProperties(given.grid, given.stiffness + term, given.inertia),
        "prisms": SectionProperties(wide, found.stiffness[ends], found.inertia[ends]),
        "inclined": SectionProperties(
            wide, (found.stiffness + found.inclination)[ends], found.inertia[ends]
        ),
    }
    shape = turbine.blade.outer_shape
    exact = demo["exact"]
    return {
        name: exact.make_beam(exact.Blade(shape.axis, shape.twist, sections), 400)
        for name, sections in kinds.items()
    }


def bend_beam(beam, s, tip=None, line=None):
    """Displacements and rotations of a beam's axis at span fractions, (len(s), 6)."""
    force = np.zeros((len(beam.nodes), 6))
    if tip is not None:
        force[-1] = tip
    if line is not None:
        force += np.outer(tributary(beam.nodes), line)
    u = beam.bend(force)
    grid = np.linspace(0.0, 1.0, len(u))
    return np.array([np.interp(s, grid, column) for column in u.T]).T
