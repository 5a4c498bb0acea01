"""Works and losses of a flexible body in a step, by the midpoint rule."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from petsc4py import PETSc

import numpy as np
import ufl
from dolfinx import fem

from turbine_fenicsx import _compat
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.kinematics import deformation_gradient, strain_rate
from turbine_fenicsx.system.flexible_model import FlexibleModel


class MidpointWorks:
    """Force in the middle of the step times increment; exact where the scheme does the same.

    Args:
        model: The body and the forces on it, which must be set to the middle of the step.
        u_n: Displacement at its start, a function on the mesh.
        dt: Step [s], a constant on the mesh.
        more: Further stresses that dissipate, by name, beside those of the model.
    """

    def __init__(
        self, model: FlexibleModel, u_n: Any, du: Any, dt: Any, more: Mapping[str, Any]
    ) -> None:
        self._model, self._u_n, self._du = model, u_n, du
        self._times = StepTimes.at_rest(0.0)
        u_mid = u_n + 0.5 * du
        dE = strain_rate(deformation_gradient(u_mid), ufl.grad(du))
        self.stresses: dict[str, Any] = {**model.viscous_stresses(dE / dt), **more}
        works = model.surface.integrals(u_mid, du / dt, du, (u_n, u_n + du))
        self._works = [
            _compat.compile_form(work)
            for work, stored in zip(works, model.surface.has_energy, strict=True)
            if not stored
        ]
        losses = [ufl.inner(S, dE) * model.dx_stress for S in self.stresses.values()]
        self._losses = [_compat.compile_form(loss) for loss in losses]

    @property
    def losses(self) -> tuple[str, ...]:
        """Names of what dissipates."""
        return tuple(self.stresses)

    def start_step(self, times: StepTimes) -> None:
        """A step begins from u_n."""
        self._times = times
        for loads in self._model.section_loads:
            loads.start_step_at(times, self._u_n.x.array[: 3 * self._model.n_owned])

    def add_forces(self, du: PETSc.Vec, factor: float, out: PETSc.Vec) -> None:
        """Add loads on sections and damping of masses in the middle of the step. Collective."""
        if self._model.has_node_loads:
            self._model.add_forces(*self._middle(du), self._times.middle, factor, out.array)

    def _middle(self, du: PETSc.Vec) -> tuple[Array, Array]:
        """Displacements and velocities of the owned nodes in the middle of the step."""
        u_n, increment = self._u_n.x.array[: 3 * self._model.n_owned], du.array_r
        return u_n + 0.5 * increment, increment / self._times.dt

    def works(self, du: PETSc.Vec) -> tuple[Array, Array]:
        """This rank's part of the work of each force, and of what each stress dissipates [J]."""
        if self._works or self._losses:
            self._model.copy_to(self._du, du)
        works = [float(fem.assemble_scalar(work)) for work in self._works]
        for dofs, force in self._model.nodal_forces:
            works.append(float(np.sum(force * du.array_r[dofs])))
        if self._model.section_loads:
            u, v = self._middle(du)
            for loads in self._model.section_loads:
                works.append(loads.work(u, v, self._times, du.array_r))
        losses = np.array([float(fem.assemble_scalar(x)) for x in self._losses])
        if self._model.mass_damper is not None:
            place = list(self.stresses).index("structural damping")
            losses[place] += self._times.dt * self._model.mass_damper.power(*self._middle(du))
        return np.array(works), losses
