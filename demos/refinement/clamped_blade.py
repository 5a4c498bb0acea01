"""One blade, clamped at its root: deflection under its weight and natural frequencies.

With strain energy W(C) and weight density rho g, the deflected blade is a stationary point of

    Pi(u) = int W(C(u)) dV - int rho g . u dV,        C = F^T F,  F = I + grad u,

and small vibrations about the undeformed blade are

    K phi = omega^2 M phi,        K = Pi''(0),  M = int rho phi_a phi_b dV.

Both come from the strain energy by differentiation. Quadrature is that of the time step, see
`turbine_fenicsx.system.flexible_model`, so that K and M are the solver's own matrices.
"""

from dataclasses import dataclass

from petsc4py import PETSc
from slepc4py import SLEPc

import dolfinx.fem.petsc
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import locate_entities_boundary, meshtags

from turbine_fenicsx import BladeGeometry, Case, _compat
from turbine_fenicsx.materials.kinematics import deformation_gradient, right_cauchy_green
from turbine_fenicsx.meshing import RotorLayout, load_arrays, mesh_rotor

LAYOUT = RotorLayout(centre=(0.0, 0.0, 0.0), azimuths=(0.0,))  # a single blade that points up
SPAN, CHORD, THICKNESS = LAYOUT.frame(1)
FRAME = tuple(ufl.as_vector(list(axis)) for axis in (SPAN, CHORD, THICKNESS))


@dataclass(frozen=True)
class Modes:
    """First natural frequencies of bending.

    Attributes:
        flap: In the thickness direction [Hz].
        edge: In the chord direction [Hz].
    """

    flap: float
    edge: float


class ClampedBlade:
    """The paper's blade with its root held fast.

    Args:
        comm: Communicator.
        options: Cell type, fineness and geometry degree of the mesh (`MeshOptions`).
        degree: Polynomial degree of the displacement.
        material: The material as in a case file; the paper's stiff blade if None.

    Attributes:
        unknowns: Number of free displacements.
        volume: Of the mesh [m^3].
        free: Global rows of the free displacements (index set).
    """

    def __init__(self, comm, options, degree, material=None):
        """Compile the forms and find the free displacements."""
        geometry = BladeGeometry()
        loaded = load_arrays(comm, lambda: mesh_rotor(geometry, LAYOUT, options), "blade")
        mesh = self.mesh = loaded.mesh
        self.volume = loaded.report.volumes["blade_1"]
        V = _compat.vector_space(mesh, degree)
        self.u, self.weight = fem.Function(V), fem.Constant(mesh, np.zeros(3))
        w, delta = ufl.TestFunction(V), ufl.TrialFunction(V)

        material = material or Case().material
        law = material.make(FRAME)

        def parameter(value):
            return fem.Constant(mesh, np.array(value, dtype=float, order="C"))

        def dx(q):
            return ufl.dx(domain=mesh, metadata={"quadrature_degree": q})

        p = degree
        dx_mass, dx_stress = (
            (dx(2 * p + 1),) * 2 if options.cell == "hexahedron" else (dx(2 * p), dx(p))
        )
        C = right_cauchy_green(deformation_gradient(self.u))
        potential = law.strain_energy(C, parameter) * dx_stress
        potential -= ufl.dot(self.weight, self.u) * dx_mass
        R = ufl.derivative(potential, self.u, w)
        rho = self.density = material.density
        self._residual = _compat.compile_form(R)
        self._stiffness = _compat.compile_form(ufl.derivative(R, self.u, delta))
        self._mass = _compat.compile_form(rho * ufl.dot(w, delta) * dx_mass)

        end = geometry.hub_radius + geometry.length
        tip = np.sort(locate_entities_boundary(mesh, 2, lambda x: np.isclose(SPAN @ x, end)))
        tags = meshtags(mesh, 2, tip, np.ones(len(tip), dtype=np.int32))
        ds = ufl.Measure("ds", domain=mesh, subdomain_data=tags)(1)
        self._tip_area = _compat.compile_form(parameter(1.0) * ds)
        self._tip_motion = _compat.compile_form(ufl.dot(self.u, parameter(THICKNESS)) * ds)

        self._local_free = _free_displacements(V, loaded.facets("root_1"))
        first = 3 * V.dofmap.index_map.local_range[0]
        self.free = PETSc.IS().createGeneral(
            (first + self._local_free).astype(PETSc.IntType), comm=comm
        )
        self.unknowns = self.free.getSize()

    def deflection(self, gravity=9.81):
        """Mean motion of the tip face when the weight acts along the thickness.

        Args:
            gravity: Acceleration of gravity [m/s^2].

        Returns:
            The deflection [m].
        """
        self.weight.value[:] = self.density * gravity * THICKNESS
        self.u.x.array[:] = 0.0
        K = _compat.create_matrix(self._stiffness)
        _compat.assemble_matrix(K, self._stiffness)
        K_free = K.createSubMatrix(self.free, self.free)
        K_free.setOption(PETSc.Mat.Option.SPD, True)
        x, f = K_free.createVecs()

        def residual(snes, x, f):
            self._set(x)
            full = dolfinx.fem.petsc.assemble_vector(self._residual)
            full.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
            part = full.getSubVector(self.free)
            part.copy(f)
            full.restoreSubVector(self.free, part)
            full.destroy()

        def tangent(snes, x, J, P):
            self._set(x)
            _compat.assemble_matrix(K, self._stiffness)
            K.createSubMatrix(self.free, self.free, J)

        snes = PETSc.SNES().create(self.mesh.comm)
        snes.setOptionsPrefix("static_")
        snes.setFunction(residual, f)
        snes.setJacobian(tangent, K_free)
        snes.setTolerances(rtol=1e-12, atol=0.0, stol=1e-6, max_it=30)
        # Full steps: bending first lengthens the blade, so that the forces grow before they fall.
        PETSc.Options().setValue("static_snes_linesearch_type", "basic")
        PETSc.Options().setValue("static_snes_divergence_tolerance", 1e30)
        _direct(snes.getKSP())
        snes.setFromOptions()
        snes.solve(None, x)
        if snes.reason <= 0:
            raise RuntimeError(f"the static solution did not converge (SNES reason {snes.reason})")
        self._set(x)
        for item in (snes, K, K_free, x, f):
            item.destroy()
        comm = self.mesh.comm
        motion, area = (
            comm.allreduce(fem.assemble_scalar(form)) for form in (self._tip_motion, self._tip_area)
        )
        return motion / area

    def frequencies(self):
        """First natural frequencies of bending about the undeformed blade, see `Modes`."""
        self.u.x.array[:] = 0.0
        K, M = self.stiffness_and_mass()
        eps = SLEPc.EPS().create(self.mesh.comm)
        eps.setOptionsPrefix("modes_")
        eps.setOperators(K, M)
        eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
        eps.setDimensions(4)
        eps.setTarget(0.0)
        eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
        eps.setTolerances(1e-10)
        eps.getST().setType(SLEPc.ST.Type.SINVERT)
        _direct(eps.getST().getKSP())
        eps.setFromOptions()
        eps.solve()
        if eps.getConverged() < 4:
            raise RuntimeError("the natural frequencies did not converge")
        found = {}
        phi = K.createVecRight()
        for k in range(4):
            hertz = np.sqrt(eps.getEigenpair(k, phi).real) / (2.0 * np.pi)
            self._set(phi)
            motion = self.u.x.array.reshape(-1, 3)
            square = [float(np.sum((motion @ axis) ** 2)) for axis in (THICKNESS, CHORD)]
            flap, edge = (self.mesh.comm.allreduce(s) for s in square)
            found.setdefault("flap" if flap > edge else "edge", float(hertz))
        for item in (eps, phi, K, M):
            item.destroy()
        return Modes(**found)

    def stiffness_and_mass(self):
        """K at the present displacement [N/m] and M [kg] of the free displacements."""
        matrices = []
        for form in (self._stiffness, self._mass):
            full = _compat.create_matrix(form)
            _compat.assemble_matrix(full, form)
            matrices.append(full.createSubMatrix(self.free, self.free))
            matrices[-1].setOption(PETSc.Mat.Option.SPD, True)
            full.destroy()
        return matrices

    def _set(self, x):
        """Put the free displacements into the function u."""
        self.u.x.array[self._local_free] = x.array_r
        self.u.x.scatter_forward()


def _direct(ksp):
    """Factorise, as matrices here are symmetric positive definite."""
    ksp.setType("preonly")
    ksp.getPC().setType("cholesky")
    ksp.getPC().setFactorSolverType("mumps")


def _free_displacements(V, facets):
    """Local numbers of the displacements of all owned nodes that do not lie on the facets."""
    V.mesh.topology.create_connectivity(2, 3)
    clamped = fem.locate_dofs_topological(V, 2, facets)
    free = np.ones(V.dofmap.index_map.size_local, dtype=bool)
    free[clamped[clamped < len(free)]] = False
    return (3 * np.flatnonzero(free)[:, None] + np.arange(3)).ravel()
