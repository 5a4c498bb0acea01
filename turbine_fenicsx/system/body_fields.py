"""Displacement, strain and stress of a flexible body as DOLFINx functions.

With F = I + grad u and the strain energy W(C) of the material, C = F^T F,

    E = (C - I)/2,    sigma = F S F^T / det F,    S = 2 dW/dC.
"""

from __future__ import annotations

from dolfinx import fem

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.argument_checks import check_among_parts
from turbine_fenicsx.materials.base import cauchy_stress
from turbine_fenicsx.materials.kinematics import (
    deformation_gradient,
    green_lagrange,
    right_cauchy_green,
)
from turbine_fenicsx.system.make_model import on_mesh
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


class BodyFields:
    """Displacement, strain and stress of a flexible body, for custom post-processing.

    Strain and stress are discontinuous from cell to cell. With the degree 0 they are the values at
    the cell centres, with a higher one those at the nodes of each cell. The stress is the elastic
    one, without viscosity.

    Args:
        system: The system.
        body: A flexible body of the system.
        degree: Degree of strain and stress, 0 or more.

    Attributes:
        displacement: u [m], in the space of the body.
        strain: Green-Lagrange strain E, values of shape (3, 3).
        stress: Cauchy stress sigma [Pa], values of shape (3, 3).

    Raises:
        ModelError: for a body that is not part of the system.

    Note:
        Making it and `update` are collective.
    """

    def __init__(self, system: MultibodySystem, body: FlexibleBody, degree: int = 0) -> None:
        check_among_parts("flexible body", body, system.flexible_bodies)
        self._index = system.flexible_bodies.index(body)
        self._model = on_mesh(system.flexible_models[self._index], "fields")
        space = _compat.cellwise_space(body.mesh, (3, 3), degree)
        self.displacement = fem.Function(self._model.space, name="displacement")
        self.strain, self.stress = (fem.Function(space, name=n) for n in ("strain", "stress"))
        F = deformation_gradient(self.displacement)
        self._strain = _compat.expression(green_lagrange(right_cauchy_green(F)), space)
        self._stress = _compat.expression(cauchy_stress(self._model.energy, F), space)

    def update(self, state: State) -> None:
        """Set the functions to a state. Collective.

        Args:
            state: A state of the system.
        """
        u = self._model.nodal_values(state.u[self._index])
        self.displacement.x.array[:] = u.ravel()
        self.strain.interpolate(self._strain)
        self.stress.interpolate(self._stress)
