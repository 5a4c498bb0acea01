"""Line loads and pitching moments along a body, for bodies whose loads nobody knows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.forces.body_force import BodyForce
from turbine_fenicsx.forces.time_functions import Ramp
from turbine_fenicsx.foundation.argument_checks import check_positive
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.reduction.load_path import LoadPath
from turbine_fenicsx.reduction.long_axis import LongAxis
from turbine_fenicsx.reduction.static_body import StaticBody, check_held
from turbine_fenicsx.system.nodal_forces import find_nodal_values
from turbine_fenicsx.system.system import MultibodySystem

Profile = Callable[[Array], Array]
"""A load per length as a function of the place along the body from 0 to 1."""

PROFILES: dict[str, Profile] = {
    "uniform": np.ones_like,
    "growing": lambda s: 0.1 + s,
    "bowed": lambda s: np.sin(np.pi * s),
    "waved": lambda s: 1.0 + 0.6 * np.cos(2.5 * np.pi * s),
}
"""Profiles by name."""

SEEN, UNSEEN = ("uniform", "growing", "bowed"), "waved"
"""Profiles of loads for training, and of those that judge."""

TWIST = 0.5
"""Twist by pitching moments in radians over the deflection by line loads in lengths."""

SMOOTHING = 0.05
"""Part of the length over which the mass per length is averaged."""


def smooth_loads(
    system: MultibodySystem, body: FlexibleBody, size: float = 0.1, unseen: bool = False
) -> list[LoadPath]:
    """Load paths across a slender body: line loads in eight directions with pitching moments.

    A line load bends the body in its softer direction by a part of its length, and moments of both
    signs twist it by half as many radians, if it was linear. In the stiffer direction the load is
    the same.

    Args:
        system: A system with the body and all couplings that will hold it.
        body: The body.
        size: Deflection at the end of each path over the length of the body [-].
        unseen: Whether the loads shall be others than by default, in direction and profile: those
            of training must not judge.

    Returns:
        16 paths with 3 equilibria each, or 4 with 2 each.

    Raises:
        ModelError: for a size that is not positive, and a body that no coupling holds.

    Note:
        Collective.
    """
    check_positive("size of smooth loads", size)
    check_held(system, body)
    still = StaticBody(system, body, body)
    try:
        lines, paths = LineLoads(still), []
        amplitudes = {name: lines.find_amplitudes(p) for name, p in PROFILES.items()}
    finally:
        still.destroy()
    for k in range(4 if unseen else 16):
        angle = 22.5 + 90.0 * k if unseen else 45.0 * (k % 8)
        sign = (-1.0) ** (k if unseen else k // 8)
        profile = UNSEEN if unseen else SEEN[k % len(SEEN)]
        push, moment = amplitudes[profile]
        across = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0.0])
        field = lines.field(
            PROFILES[profile],
            size * push * lines.axis.axes @ across,
            sign * TWIST * size * moment,
        )
        name = f"{profile} load at {angle:g} degrees, moment {'+' if sign > 0.0 else '-'}"
        force = BodyForce(name, body, field=field, function=Ramp(1.0, 1.0))
        paths.append(LoadPath(name, [force], (0.5, 1.0) if unseen else (0.2, 0.6, 1.0)))
    return paths


class LineLoads:
    """Loads per length of a body as fields of forces per mass. Collective.

    Args:
        still: The body at rest.

    Attributes:
        axis: Its long axis.
    """

    def __init__(self, still: StaticBody) -> None:
        self._still = still
        model = still.model
        X = still.gather(model.positions)
        masses = np.concatenate(model.comm.allgather(model.weights))
        self.axis = LongAxis(X, masses, still.find_ground())
        arms, s = self.axis.arms(X), self.axis.span(X)
        squares = np.sum(arms * arms, axis=1)
        self._places = np.linspace(0.0, 1.0, 101)
        near = np.exp(-0.5 * ((self._places[:, None] - s) / SMOOTHING) ** 2)
        grid = np.linspace(0.0, 1.0, 1001)
        width = np.exp(-0.5 * ((self._places[:, None] - grid) / SMOOTHING) ** 2).mean(axis=1)
        length = width * self.axis.length
        self._mass, self._inertia = near @ masses / length, near @ (masses * squares) / length
        tip = s > 0.85
        self._tip, self._arms = tip, arms[tip] * masses[tip, None]
        self._tip_inertia = float(masses[tip] @ squares[tip])

    def field(self, profile: Profile, push: Array, moment: float) -> Callable[[Array], Array]:
        """Forces per mass of a force per length and a moment per length about the long axis.

        Args:
            profile: Both over the length.
            push: The force, shape (3,) [N/m].
            moment: The moment [N].

        Returns:
            A function of positions, shape (n, 3) -> (n, 3) [N/kg].
        """
        axis, places = self.axis, self._places

        def evaluate(X: Array) -> Array:
            s = np.clip(axis.span(X), 0.0, 1.0)
            q = profile(s)[:, None]
            mass, inertia = (np.interp(s, places, x)[:, None] for x in (self._mass, self._inertia))
            turned = np.cross(axis.axes[:, 2], axis.arms(X))
            forces: Array = q * (push / mass + moment * turned / inertia)
            return forces

        return evaluate

    def find_amplitudes(self, profile: Profile) -> tuple[float, float]:
        """Force per length for a deflection of the length, and moment for a twist of 1 rad.

        By the linear response of the body; the deflection is in its softer direction.
        """
        body = self._still.system.flexible_bodies[0]
        axes = self.axis.axes
        fields = [self.field(profile, axes[:, k], 0.0) for k in range(2)]
        fields.append(self.field(profile, np.zeros(3), 1.0))
        forces = [BodyForce("load", body, field=field) for field in fields]
        loads = [find_nodal_values(self._still.model, force).ravel() for force in forces]
        *bent, twisted = (self._still.gather(u) for u in self._still.respond(loads))
        deflection = max(float(np.max(np.linalg.norm(u, axis=1))) for u in bent)
        turned = np.cross(self._arms, twisted[self._tip]) @ axes[:, 2]
        return self.axis.length / deflection, float(self._tip_inertia / np.sum(turned))
