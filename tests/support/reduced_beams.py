"""A slender beam on a coarse mesh, its bases, and systems with it, full or reduced."""

from functools import cache

from mpi4py import MPI

import numpy as np
from dolfinx import mesh

from turbine_fenicsx import (
    BodyForce,
    Coupling,
    FlexibleBody,
    KelvinVoigt,
    MultibodySystem,
    NodeForce,
    Placement,
    ReducedBody,
    Revolute,
    RigidBody,
    StVenantKirchhoff,
    reduce_body,
)
from turbine_fenicsx.foundation.rotations import rotation_about

COMM = MPI.COMM_WORLD
SIZE, DENSITY, LAME = np.array([0.2, 0.3, 4.0]), 1000.0, (1.2e7, 8.0e6)
TAU = 0.003
"""Time that the viscous law takes to creep [s]."""


@cache
def beam(law="svk", cells=(1, 2, 8), degree=1, alone=False):
    """A beam along e3 from the origin; first bending at 0.4 and 0.5 Hz if clamped."""
    ends = [[-0.5 * SIZE[0], -0.5 * SIZE[1], 0.0], [0.5 * SIZE[0], 0.5 * SIZE[1], SIZE[2]]]
    box = mesh.create_box(
        MPI.COMM_SELF if alone else COMM, ends, list(cells), mesh.CellType.hexahedron
    )
    material = StVenantKirchhoff(*LAME)
    if law == "viscous":
        material = KelvinVoigt(material, TAU * LAME[1], TAU * (LAME[0] + 2.0 / 3.0 * LAME[1]))
    return FlexibleBody("beam", box, material, DENSITY, degree)


def facets_at(body, z):
    """Facets of a beam at a height."""
    return mesh.locate_entities_boundary(body.mesh, 2, lambda X: np.isclose(X[2], z))


def clamped(body, *more):
    """The beam on the ground."""
    return MultibodySystem(
        COMM, [body, Coupling("root", body, facets_at(_full(body), 0.0), None), *more]
    )


@cache
def clamped_basis(functions=18, modes=4, **kind):
    """A basis with the root as interface."""
    return reduce_body(clamped(beam(**kind)), beam(**kind), modes, functions, loads=())


@cache
def free_basis(functions=18, modes=4):
    """A basis without interfaces."""
    return reduce_body(MultibodySystem(COMM, [beam()]), beam(), modes, functions, loads=())


def expand(system, state, what="u"):
    """Displacements or velocities of the nodes of the first body, (copies, N, 3), on all ranks."""
    return system.flexible_models[0].expand(getattr(state, what)[0])


def _full(body):
    return body if isinstance(body, FlexibleBody) else body.full


def on_hub(
    blades, *more, speed=1.0, velocity=(0.0, 0.0, 0.0), axis=(1.0, 0.0, 0.0), at=(0.0, 0.0, 0.0)
):
    """Bodies of one or more copies each on a hub.

    Args:
        blades: Reduced bodies.
        more: Further parts, or functions of the hub that make some.
        speed: Of the hub about the axis [rad/s].
        velocity: Of the hub [m/s].
        axis: Of its revolute joint on the ground; None for a hub in free flight.
        at: Where the hub is [m].
    """
    spin = speed * np.array([1.0, 0.2, -0.1] if axis is None else axis)
    hub = RigidBody(
        "hub", 200.0, (50.0,) * 3, position=at, velocity=velocity, angular_velocity=spin
    )
    parts = [hub] if axis is None else [hub, Revolute("main", None, hub, at, axis=axis)]
    for blade in blades:
        parts.append(blade)
        for copy in range(len(blade.placements)):
            facets = facets_at(blade.full, 0.0)
            parts.append(Coupling(f"root of {blade.name} {copy}", blade, facets, hub, copy))
    return MultibodySystem(blades[0].full.mesh.comm, [*parts, *more])


def placements(count=3, radius=0.5, at=(0.0, 0.0, 0.0)):
    """Where the blades of a rotor about e1 stand."""
    turns = [rotation_about((1.0, 0.0, 0.0), 2.0 * np.pi * k / count) for k in range(count)]
    return [Placement(position=at + R @ (0.0, 0.0, radius), rotation=R) for R in turns]


def tip_of(placement):
    """A node at the tip of a blade in the initial configuration."""
    return np.asarray(placement.position) + np.asarray(placement.rotation) @ (
        0.5 * SIZE[0],
        0.0,
        SIZE[2],
    )


def gusts(body, first=0):
    """A force on the tip of each copy that changes in time."""
    return [
        NodeForce(
            f"gust {first + k}",
            body,
            point=tip_of(place),
            force=(30.0, 10.0, 5.0),
            function=lambda t: np.sin(3.0 * t),
        )
        for k, place in enumerate(body.placements)
    ]


def pull(body):
    """A force on the mass of all copies that changes in time."""
    return BodyForce("pull", body, field=lambda X: 0.3 * X[:, [1, 2, 0]], function=np.cos)


def rotor(functions=18, at=(0.0, 0.0, 0.0), **kind):
    """Three copies of the beam."""
    basis = clamped_basis(functions, **kind)
    return ReducedBody("blades", beam(**kind), basis, placements(at=at))


def march(stepper, state, dt, steps):
    """State after some steps, the sum of works less losses, and the reports. Collective."""
    now, out, reports = state, stepper.system.initial_state(), []
    for _ in range(steps):
        reports.append(stepper.advance(now, dt, out))
        now, out = out, now
    done = sum(sum(r.works) - sum(r.dissipated) for r in reports)
    return now, done, reports
