"""A flexible body in one energy-momentum step.

Unknown: the increment du = u_{n+1} - u_n of all nodal displacements. With v_{n+1} = 2 du/dt - v_n
the step (55), (57), multiplied by dt^2/2, is

    int rho (du - dt v_n) . w dV + dt^2/2 int F_mid (S_alg + S_dis) : grad w dV
        = dt^2/2 int rho g . w dV + dt^2/2 int t . w dA

with the tractions t. The stress S_dis takes energy out. It is that of a viscous material, a
function of dE/dt with dE = E_{n+1} - E_n, and chi/2 D_0 : dE of the energy-decaying variant, with
the elasticity D_0 of the material at rest. A step dissipates exactly int S_dis : dE dV, which is
not negative; momenta are conserved for any symmetric S_dis.
"""

from __future__ import annotations

from typing import Any

from petsc4py import PETSc

import numpy as np
import ufl
from dolfinx import fem

from turbine_fenicsx import _compat
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.base import second_piola_kirchhoff, stress_at_rest
from turbine_fenicsx.materials.kinematics import deformation_gradient, strain_rate
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.linear_form import LinearForm
from turbine_fenicsx.time_stepping.body_step_interface import MemorylessStep
from turbine_fenicsx.time_stepping.discrete_gradients import (
    AlgorithmicStress,
    discrete_gradient_stress,
    mean_strain,
)
from turbine_fenicsx.time_stepping.force_round_off import ForceRoundOff, smallest_edges
from turbine_fenicsx.time_stepping.midpoint_works import MidpointWorks


class FlexibleStep(MemorylessStep):
    """Compiled forms of the step of a flexible body.

    Args:
        model: The body and the forces on it.
        stress: Algorithmic stress; the exact discrete gradient of the material if None.
        numerical_dissipation: chi >= 0. A linear mode of the frequency omega loses the part
            chi (omega dt)^2/2 of its energy per step while omega dt is small. The spectral radius
            falls from 1 to (2 - chi)/(2 + chi) at omega dt = 4/chi, and rises again beyond. The
            scheme is then of first order.

    Attributes:
        midpoint: Works of forces, and what dissipates in this body.
        tangent: Matrix of the tangent, filled by `assemble_tangent`.
        round_off: This rank's sum of the squares of the round-off of the residual of the step
            [(kg m)^2], set by `start_step`.
    """

    def __init__(
        self,
        model: FlexibleModel,
        stress: AlgorithmicStress | None = None,
        numerical_dissipation: float = 0.0,
    ) -> None:
        self.model = model
        mesh, V = model.body.mesh, model.space
        self._u_n, self._du, self._dt_v = (fem.Function(V) for _ in range(3))
        self._half_dt2 = fem.Constant(mesh, PETSc.ScalarType(0.0))
        self._dt = fem.Constant(mesh, PETSc.ScalarType(1.0))
        self._gravity = fem.Constant(mesh, np.zeros(3, dtype=PETSc.ScalarType))
        self._compile(stress, numerical_dissipation)
        self.tangent = _compat.create_matrix(self._tangent)
        self._half_dt2.value = 1.0
        self._round_off = self._force_round_off()  # its tangents also fix the sparsity
        self._masses = np.repeat(model.weights, 3)
        self._fixed_terms, self.round_off = np.zeros_like(self._masses), 0.0

    def _compile(self, stress: AlgorithmicStress | None, chi: float) -> None:
        """Compile the forms."""
        model = self.model
        w, delta = ufl.TestFunction(model.space), ufl.TrialFunction(model.space)
        h, u_mid = self._half_dt2, self._u_n + 0.5 * self._du
        F_mid, D = deformation_gradient(u_mid), ufl.grad(self._du)
        more = {}
        if chi:
            S_chi = stress_at_rest(model.energy, strain_rate(F_mid, D))
            more["numerical dissipation"] = 0.5 * model.parameter(chi) * S_chi
        self.midpoint = MidpointWorks(model, self._u_n, self._du, self._dt, more)
        S = self._sum_stresses(stress, F_mid, D, chi)
        # momenta of the flexible body, eqs (55), (57)
        ends = self._u_n, self._u_n + self._du
        R = model.inertia_term(self._du - self._dt_v - h * self._gravity, w)
        R += h * model.stress_term(F_mid, S, w)
        R -= h * model.traction_term(u_mid, self._du / self._dt, w, ends)
        self._residual = LinearForm(R)
        self._tangent = _compat.compile_form(ufl.derivative(R, self._du, delta))

    def _sum_stresses(
        self, stress: AlgorithmicStress | None, F_mid: Any, D: Any, chi: float
    ) -> Any:
        """S_alg + S_dis. Of a quadratic law all parts with D_0 are one, S of C + 2 c dE."""
        model, dissipating = self.model, dict(self.midpoint.stresses)
        quadratic = model.body.material.quadratic
        dE, c = strain_rate(F_mid, D), ufl.as_ufl(0.0)
        if stress is None and quadratic:
            if model.damping is not None:
                del dissipating["structural damping"]
                c += model.parameter(model.damping.stiffness) / self._dt
            if chi:
                del dissipating["numerical dissipation"]
                c += 0.5 * model.parameter(chi)
            S = second_piola_kirchhoff(model.energy, mean_strain(F_mid, D) + 2.0 * c * dE)
        else:
            S = (stress or discrete_gradient_stress(quadratic))(model.energy, F_mid, D)
        return S + sum(dissipating.values(), ufl.zero(3, 3))

    def start_step(self, u: PETSc.Vec, v: PETSc.Vec, times: StepTimes, gravity: Array) -> None:
        """Set the state at t_n, the step, and gravity [m/s^2]."""
        model, dt, half_dt2 = self.model, times.dt, times.half_dt2
        model.copy_to(self._u_n, u)
        model.copy_to(self._dt_v, v)
        self._dt_v.x.array[:] *= dt
        self._half_dt2.value = half_dt2
        self._dt.value = dt
        self._gravity.value[:] = gravity
        model.set_time(times.middle)
        self.midpoint.start_step(times)
        dt_v = self._dt_v.x.array[: 3 * model.n_owned]
        self.round_off = half_dt2**2 * self._round_off.square(dt_v, dt)
        self._fixed_terms = self._masses * (np.abs(dt_v) + half_dt2 * np.linalg.norm(gravity))

    def residual(self, du: PETSc.Vec, R: PETSc.Vec) -> None:
        """Assemble the residual [kg m] for the increment du into R."""
        self.model.copy_to(self._du, du)
        self.model.assemble(self._residual, R)
        for dofs, force in self.model.nodal_forces:
            R.array[dofs] -= self._half_dt2.value * force
        self.midpoint.add_forces(du, -float(self._half_dt2.value), R)

    def assemble_tangent(self, du: PETSc.Vec) -> None:
        """Assemble the derivative of the residual [kg] into `tangent`."""
        self.model.copy_to(self._du, du)
        _compat.assemble_matrix(self.tangent, self._tangent)

    def assemble_at_rest(self) -> None:
        """Assemble the tangent for du = 0."""
        self._du.x.array[:] = 0.0
        _compat.assemble_matrix(self.tangent, self._tangent)

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
        model = self.model
        viscosity = diagonal(1.0) - stiffness if model.is_viscous else np.zeros_like(stiffness)
        edges = smallest_edges(model.space, model.local_positions)[: model.n_owned]
        return ForceRoundOff(edges, stiffness, viscosity)
