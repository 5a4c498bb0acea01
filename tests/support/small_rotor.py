"""Rotors of rigid blades on hinges, for tests of what turns: small, fast, with closed forms."""

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx import (
    JointDamper,
    JointSpring,
    MultibodySystem,
    PrescribedMotion,
    Revolute,
    RigidBody,
)
from turbine_fenicsx.foundation.rotations import E1, E2, E3, rotation_about

HUB = np.array([0.0, 0.0, -2.0])  # centre of the hub; it turns about e3
OFFSET, ARM = 0.7, 1.6  # of the hinges from the axis, of the blades' centres from the hinges [m]
MASS, EULER = 3.0, (0.2, 0.05, 2.5)  # of a blade, along chord, axis and span [kg, kg m^2]


@dataclass(frozen=True)
class Rotor:
    """Blades on a hub, each with a lag hinge, a ring and a flap hinge, on a nacelle that yaws.

    Args:
        blades: Their number.
        speed: Speed at which the hub is driven; None leaves it free [rad/s].
        yaw: Stiffness of the nacelle's bearing; None holds the nacelle [N m/rad].
        flap: Stiffness of the flap hinges [N m/rad].
        lag: Stiffness of the lag hinges [N m/rad].
        damping: Damping of the flap hinges [N m s/rad].
        heavier: Factor of the mass of the first blade.
        stiffer: Factor of the stiffness of the first blade's flap hinge.
    """

    blades: int = 3
    speed: float | None = None
    yaw: float | None = None
    flap: float = 500.0
    lag: float = 900.0
    damping: float = 0.0
    heavier: float = 1.0
    stiffer: float = 1.0

    def system(self, comm, *more):
        """The system with other parts."""
        return MultibodySystem(comm, [*self.parts(), *more])

    def parts(self):
        """All parts."""
        nacelle = RigidBody("nacelle", 5.0, (2.0, 3.0, 2.5))
        hub = RigidBody("hub", 4.0, (0.6, 0.6, 0.4), position=HUB)
        yield from (nacelle, hub)
        yield Revolute("yaw", None, nacelle, point=np.zeros(3), axis=E2)
        yield Revolute("rotor", nacelle, hub, point=HUB, axis=E3)
        if self.yaw is None:
            yield PrescribedMotion("yaw", lambda t: 0.0)
        else:
            yield JointSpring("yaw spring", "yaw", self.yaw)
        if self.speed is not None:
            yield PrescribedMotion("rotor", lambda t: self.speed * t)
        for k in range(self.blades):
            yield from self.blade(k, hub)

    def blade(self, k, hub):
        """A blade with what holds it."""
        turn = rotation_about(E3, 2.0 * np.pi * k / self.blades)
        span, chord = turn @ E1, turn @ E2
        hinge = HUB + OFFSET * span
        ring = RigidBody(f"ring_{k}", 0.5, (0.01, 0.01, 0.01), position=hinge, directors=turn)
        factor = 1.0 if k else self.heavier
        axes = np.column_stack([chord, E3, span])
        euler = tuple(factor * e for e in EULER)
        blade = RigidBody(
            f"blade_{k}", factor * MASS, euler, position=hinge + ARM * span, directors=axes
        )
        yield from (ring, blade)
        yield Revolute(f"lag_{k}", hub, ring, point=hinge, axis=E3)
        yield Revolute(f"flap_{k}", ring, blade, point=hinge, axis=-chord)
        yield JointSpring(f"lag spring {k}", f"lag_{k}", self.lag)
        yield JointSpring(f"flap spring {k}", f"flap_{k}", self.flap * (1.0 if k else self.stiffer))
        if self.damping:
            yield JointDamper(f"flap damper {k}", f"flap_{k}", self.damping)

    def frequencies(self, speed):
        """Frequencies of flap and lag of blades on a driven hub, in its frame [rad/s].

        From the potential -1/2 Omega^2 int (x^2 + y^2) dm of the centrifugal force; for the thin
        ring, which lags with the blade, its mass is at the hinge.
        """
        chord, axis, span = EULER
        pull, inertia = OFFSET * MASS * ARM, span + MASS * ARM**2
        flap = (self.flap + speed**2 * (pull + inertia - axis)) / (inertia + axis)
        lag = (self.lag + speed**2 * pull) / (inertia + chord + 0.02)
        return np.sqrt(flap), np.sqrt(lag)
