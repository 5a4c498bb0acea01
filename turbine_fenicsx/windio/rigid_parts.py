"""Hub, nacelle and yaw system of a windIO file: lengths, angles, masses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.windio.entry import Entry


@dataclass(frozen=True, eq=False)
class RigidPart:
    """A rigid body.

    Args:
        mass: Its mass [kg].
        inertia: Its tensor of inertia about its centre of mass, (3, 3) [kg m^2].
        location: Its centre of mass, (3,) [m].
    """

    mass: float
    inertia: Array
    location: Array


@dataclass(frozen=True, eq=False)
class Hub:
    """The hub.

    Args:
        radius: From the rotor centre to the roots of the blades; 0 where the file has none [m].
        cone_angle: From the plane of the rotor to the blades, away from the tower [deg].
        body: Hub, spinner, bearings and drives of the pitch; x downwind along the shaft, z upwards,
            origin at the rotor centre. None where the file has none.
    """

    radius: float
    cone_angle: float
    body: RigidPart | None


@dataclass(frozen=True, eq=False)
class Nacelle:
    """Parts on the tower, except hub and yaw system.

    Args:
        tilt: Angle of the shaft to the horizontal, upwards to the rotor [deg].
        overhang: Horizontal distance from the tower's axis to the rotor centre [m].
        height: Vertical distance from the tower's top to the rotor centre [m].
        gear_ratio: Speed of the generator over speed of the rotor [-].
        body: The whole drivetrain without the hub; x downwind, z upwards, origin at the tower's
            top. None where the file has none.
        generator: The generator, which is a part of `body`; x downwind along the shaft, z upwards,
            origin at the generator's centre. None where the file has none.
    """

    tilt: float
    overhang: float
    height: float
    gear_ratio: float
    body: RigidPart | None
    generator: RigidPart | None


def read_hub(entry: Entry) -> Hub:
    """The component `hub`."""
    cone = entry["cone_angle"].number(-45.0, 45.0) if "cone_angle" in entry else 0.0
    radius = 0.5 * entry["diameter"].positive() if "diameter" in entry else 0.0
    return Hub(radius, cone, read_rigid_part(entry))


def read_nacelle(entry: Entry) -> Nacelle:
    """The component `drivetrain`."""
    shape = entry["outer_shape"]
    generator = entry.get("generator")
    gearbox = entry.get("gearbox")
    return Nacelle(
        tilt=shape["uptilt"].number(-45.0, 45.0),
        overhang=shape["overhang"].number(0.0, 100.0),
        height=shape["distance_tt_hub"].number(0.0, 100.0),
        gear_ratio=gearbox["gear_ratio"].positive() if gearbox and "gear_ratio" in gearbox else 1.0,
        body=read_rigid_part(entry),
        generator=read_rigid_part(generator) if generator else None,
    )


def read_rigid_part(component: Entry) -> RigidPart | None:
    """The `elastic_properties` of a component; None if it has none."""
    entry = component.get("elastic_properties")
    if entry is None:
        return None
    values = entry["inertia"].numbers()
    if len(values) not in (3, 6):
        entry["inertia"].fail(f"must hold 3 or 6 numbers, got {len(values)}")
    xx, yy, zz, xy, xz, yz = np.append(values, np.zeros(6 - len(values))).tolist()
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    least = float(np.linalg.eigvalsh(inertia)[0])
    if least < -1e-9 * abs(inertia).max():
        entry["inertia"].fail(
            f"is no inertia of a body: its least principal moment is {least:g}, with the order "
            "xx, yy, zz, xy, xz, yz"
        )
    location = entry["location"].numbers()
    if len(location) not in (1, 3):
        entry["location"].fail(f"must hold 3 numbers, got {len(location)}")
    location = np.append(location, np.zeros(3 - len(location)))
    return RigidPart(entry["mass"].number(0.0), inertia, location)
