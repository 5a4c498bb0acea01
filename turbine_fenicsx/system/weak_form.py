"""The weak form of a flexible body, and what is differentiated from it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import ufl
from dolfinx import fem
from ufl.algorithms import expand_derivatives

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.forces.prescribed_force import SurfaceForce
from turbine_fenicsx.forces.rayleigh_damping import RayleighDamping
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.base import Viscous, second_piola_kirchhoff, stress_at_rest
from turbine_fenicsx.materials.cell_fields import parameters_on
from turbine_fenicsx.materials.kinematics import (
    deformation_gradient,
    right_cauchy_green,
    strain_rate,
)
from turbine_fenicsx.system.quadrature import make_measures
from turbine_fenicsx.system.surface_forms import SurfaceIntegrals


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

    def virtual_work(self, u: Any, v: Any, w: Any) -> Any:
        """The virtual work of stresses minus that of forces on surfaces, without gravity.

        Args:
            v: Velocity, a UFL expression; None at rest, where viscosity does not act.
        """
        F = deformation_gradient(u)
        S = second_piola_kirchhoff(self.energy, right_cauchy_green(F))
        if v is not None:
            S += sum(self.viscous_stresses(strain_rate(F, ufl.grad(v))).values(), ufl.zero(3, 3))
        total = ufl.inner(F * S, ufl.grad(w)) * self.dx_stress
        for integral in self.surface.integrals(u, ufl.zero(3) if v is None else v, w):
            total -= integral
        return total

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
        Aa = ufl.dot(self.parameter(A), delta)
        return _compat.compile_form(self.density * ufl.dot(Aa, w) * self.dx_mass)
