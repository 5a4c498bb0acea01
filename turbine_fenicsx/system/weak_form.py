"""The weak form of a flexible body, and what is differentiated from it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import fem
from ufl.algorithms import expand_derivatives

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.facets import check_facets
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.forces.prescribed_force import SurfaceForce, SurfacePotential, has_energy
from turbine_fenicsx.forces.rayleigh_damping import RayleighDamping
from turbine_fenicsx.forces.surface_point import SurfacePoint
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.own_code import evaluate_function, name_errors
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.foundation.ufl_shapes import check_ufl_shape
from turbine_fenicsx.materials.base import Viscous, second_piola_kirchhoff, stress_at_rest
from turbine_fenicsx.materials.cell_fields import parameters_on
from turbine_fenicsx.materials.kinematics import (
    deformation_gradient,
    right_cauchy_green,
    strain_rate,
)
from turbine_fenicsx.system.quadrature import make_measures


class SurfaceIntegrals:
    """Virtual works of forces on the surface of a body. Collective.

    Facets are numbered by the forces that act on them, because a form can have one set of surface
    numbers only.

    Args:
        parameter: Turns numbers and arrays into UFL constants.
    """

    def __init__(
        self,
        space: Any,
        forces: Sequence[SurfaceForce],
        parameter: Callable[[Any], Any],
        quadrature_degree: int,
    ) -> None:
        self._space, mesh = space, space.mesh
        self.forces, self._parameter = tuple(forces), parameter
        self.has_energy = tuple(has_energy(force) for force in forces)
        self._factors = [fem.Constant(mesh, PETSc.ScalarType(0.0)) for _ in forces]
        self._time = fem.Constant(mesh, PETSc.ScalarType(0.0))
        self._tags_of_force: list[tuple[int, ...]] = []
        if forces:
            facets, tags, self._tags_of_force = _number_facets(mesh, forces)
            ds = _compat.facet_measure(mesh, facets, tags)
            self._ds = ds(metadata={"quadrature_degree": quadrature_degree})

    def set_time(self, time: float) -> None:
        """Set the time of the forces [s]."""
        self._time.value = time
        for factor, force in zip(self._factors, self.forces, strict=True):
            what, comm = f"factor of {force.name!r}", self._space.mesh.comm
            factor.value = evaluate_function(comm, what, force.function, time)

    def integrals(self, u: Any, v: Any, w: Any, ends: tuple[Any, Any] | None = None) -> list[Any]:
        """One form per force: the integral of its traction times w.

        Args:
            ends: Displacements at the ends of the step; those of u if None.
        """
        return [
            ufl.dot(_traction(force, self._point(k, u, v, ends or (u, u))), w) * self._ds(mine)
            for k, (force, mine) in enumerate(zip(self.forces, self._tags_of_force, strict=True))
        ]

    def energy(self, displacements: Array, time: float) -> float:
        """This rank's part of the energies of all forces that have one [J]. Collective.

        Args:
            displacements: Those of the owned nodes, shape (3 n_owned,) [m].
            time: Time [s].
        """
        if not any(self.has_energy):
            return 0.0
        u, form = self._energy
        u.x.array[: displacements.size] = displacements
        u.x.scatter_forward()
        self.set_time(time)
        return float(fem.assemble_scalar(form))

    @cached_property
    def _energy(self) -> tuple[Any, Any]:
        """The displacement and the integral of all energies for it; compiled on first use."""
        u = fem.Function(self._space)
        total = 0
        for k, (force, mine) in enumerate(zip(self.forces, self._tags_of_force, strict=True)):
            if isinstance(force, SurfacePotential) and self.has_energy[k]:
                at = self._point(k, u, ufl.zero(3), (u, u))
                what = f"energy() of {describe(force)}"
                with name_errors(what):
                    density = check_ufl_shape(what, force.energy(at), ())
                total += density * self._ds(mine)
        return u, _compat.compile_form(total)

    def _point(self, k: int, u: Any, v: Any, ends: tuple[Any, Any]) -> SurfacePoint:
        """A point of the surface as the force number k sees it."""
        X, N = ufl.SpatialCoordinate(self._space.mesh), ufl.FacetNormal(self._space.mesh)
        x0, x1 = (X + end for end in ends)
        F, factor = deformation_gradient(u), self._factors[k]
        return SurfacePoint(X, X + u, x0, x1, v, F, N, self._time, factor, self._parameter)


def _traction(force: SurfaceForce, at: SurfacePoint) -> Any:
    """The traction of a force [N/m^2], a vector."""
    what = f"traction() of {describe(force)}"
    with name_errors(what):
        return check_ufl_shape(what, force.traction(at), (3,))


Facets = npt.NDArray[np.int32]


def _number_facets(
    mesh: Any, forces: Sequence[SurfaceForce]
) -> tuple[Facets, Facets, list[tuple[int, ...]]]:
    """One number for each set of forces that act together on some facet.

    Returns:
        Loaded facets of this rank, the number of each, and the numbers that each force acts on.
    """
    comm, tdim = mesh.comm, mesh.topology.dim
    exterior = _compat.exterior_facets(mesh)
    n_owned = mesh.topology.index_map(tdim - 1).size_local
    acting: dict[int, tuple[int, ...]] = {}
    for k, force in enumerate(forces):
        mine = check_facets(force.name, mesh, force.facets)
        owned = mine[mine < n_owned]
        inside = comm.allreduce(int(np.count_nonzero(~np.isin(owned, exterior))))
        if inside:
            raise ModelError(
                f"{inside} facets of force {force.name!r} are not on the surface of "
                f"{force.flexible.name!r}"
            )
        if not comm.allreduce(owned.size):
            raise ModelError(f"force {force.name!r} has no facets on {force.flexible.name!r}")
        for facet in owned.tolist():
            acting[facet] = (*acting.get(facet, ()), k)
    sets = sorted(set().union(*comm.allgather(set(acting.values()))))
    number = {chosen: n + 1 for n, chosen in enumerate(sets)}
    facets = np.array(sorted(acting), dtype=np.int32)
    tags = np.array([number[acting[f]] for f in facets.tolist()], dtype=np.int32)
    return (
        facets,
        tags,
        [tuple(number[chosen] for chosen in sets if k in chosen) for k in range(len(forces))],
    )


class StaticForms(NamedTuple):
    """Forces of the body at rest, without gravity, and their derivative, as compiled forms."""

    forces: Any
    stiffness: Any


class WeakForm:
    """Energy, stresses and virtual work of a flexible body as UFL expressions.

    Args:
        damping: Rayleigh damping; None is none.

    Attributes:
        parameter: Turns a number, an array or a `cell_field` into a UFL coefficient on the mesh.
        damping: Rayleigh damping, or None.
    """

    def __init__(
        self,
        body: FlexibleBody,
        surface_forces: Sequence[SurfaceForce],
        damping: RayleighDamping | None,
    ) -> None:
        self.body, self.damping = body, damping
        self.space = V = _compat.vector_space(body.mesh, body.degree)
        self._u, self._v = fem.Function(V), fem.Function(V)
        self.parameter = parameters_on(body.mesh, body.name)
        self.density = self.parameter(body.density)
        self.dx_mass, self.dx_stress = make_measures(body)
        self.surface = SurfaceIntegrals(V, surface_forces, self.parameter, 2 * body.degree + 1)

    def energy(self, C: Any) -> Any:
        """Strain energy per reference volume [J/m^3] as a UFL expression."""
        return self.body.material.strain_energy(C, self.parameter)

    @property
    def is_viscous(self) -> bool:
        """Whether a stress depends on the strain rate."""
        return self.damping is not None or isinstance(self.body.material, Viscous)

    def viscous_stresses(self, E_dot: Any) -> dict[str, Any]:
        """Second Piola-Kirchhoff stresses [Pa] that dissipate, by the names of what does.

        Args:
            E_dot: Rate of the Green-Lagrange strain [1/s], a UFL expression.
        """
        material, found = self.body.material, {}
        if isinstance(material, Viscous):
            found["viscosity"] = material.viscous_stress(E_dot, self.parameter)
        if self.damping is not None:
            S_beta = stress_at_rest(self.energy, E_dot, material.quadratic)
            found["structural damping"] = self.parameter(self.damping.stiffness) * S_beta
        return found

    def inertia_term(self, a: Any, w: Any) -> Any:
        """The term int rho a . w dV of accelerations a."""
        return self.density * ufl.dot(a, w) * self.dx_mass

    def stress_term(self, F: Any, S: Any, w: Any) -> Any:
        """The term int F S : grad w dV of second Piola-Kirchhoff stresses S."""
        return ufl.inner(F * S, ufl.grad(w)) * self.dx_stress

    def traction_term(self, u: Any, v: Any, w: Any, ends: tuple[Any, Any] | None = None) -> Any:
        """The term int t . w dA of the tractions t of all forces on the surface.

        Args:
            v: Velocity.
            ends: Displacements at the ends of the step; those of u if None.
        """
        return sum(self.surface.integrals(u, v, w, ends))

    def virtual_work(self, u: Any, v: Any, w: Any) -> Any:
        """The virtual work of stresses minus that of forces on surfaces, without gravity.

        Args:
            v: Velocity, a UFL expression; None at rest, where viscosity does not act.
        """
        F = deformation_gradient(u)
        S = second_piola_kirchhoff(self.energy, right_cauchy_green(F))
        if v is not None:
            S += sum(self.viscous_stresses(strain_rate(F, ufl.grad(v))).values(), ufl.zero(3, 3))
        return self.stress_term(F, S, w) - self.traction_term(u, ufl.zero(3) if v is None else v, w)

    @cached_property
    def static_forms(self) -> StaticForms:
        """Forces at rest and their derivative; compiled on first use."""
        w, delta = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        F = self.virtual_work(self._u, None, w)
        return StaticForms(
            _compat.compile_form(F), _compat.compile_form(ufl.derivative(F, self._u, delta))
        )

    @cached_property
    def damping_form(self) -> Any | None:
        """Derivative of the virtual work with respect to the velocity; compiled on first use."""
        w, delta = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        D = expand_derivatives(
            ufl.derivative(self.virtual_work(self._u, self._v, w), self._v, delta)
        )
        return None if D.empty() else _compat.compile_form(D)

    def mass_form(self, A: Array) -> Any:
        """The form of int rho w.A a dV."""
        w, delta = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        return _compat.compile_form(self.inertia_term(ufl.dot(self.parameter(A), delta), w))
