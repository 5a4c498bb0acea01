"""Three equal wings of section matrices on a hub, in the wind without a wake."""

from mpi4py import MPI

import numpy as np
from dolfinx.mesh import exterior_facet_indices

from turbine_fenicsx import (
    BeamLine,
    BeamSections,
    Coupling,
    MultibodySystem,
    Placement,
    PrescribedMotion,
    ReducedBody,
    Revolute,
    RigidBody,
    SectionLoads,
    StationLine,
    beam_basis,
    box_carrier,
)
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.wind.aero_blade import AeroBlade
from turbine_fenicsx.wind.aerodynamics import RotorAerodynamics
from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.polar import Polar
from turbine_fenicsx.wind.settable_wind import SettableWind

COMM = MPI.COMM_WORLD
SHAFT, ROOT, STATIONS = np.array([1.0, 0.0, 0.0]), 0.5, 20
ANGLES = np.radians(np.linspace(-180.0, 180.0, 361))


def plate(radius, length, chord, axis, twist):
    """A flat plate without drag."""
    flat, n = 0.0 * ANGLES, len(radius)
    polar = Polar("plate", ANGLES, np.pi * np.sin(2.0 * ANGLES), flat, flat)
    chords, twists = np.full(n, chord), np.full(n, twist)
    ends = ROOT, ROOT + length
    return AeroBlade(*ends, radius, chords, twists, (polar,) * n, reference=axis)


class Wings:
    """Wings along the directions from the shaft x; their first one along z, its chord along x or y.

    Args:
        stiffness: Of the section, about the point on the axis; x and y are those of the first wing.
        inertia: The same.
        length: Of a wing, which begins 0.5 m away from the shaft [m].
        chord: Of a wing [m].
        axis: Fraction of the chord that lies on the axis.
        twist: 90 degrees for chords along the wind.
        hinged: Whether wings flap about hinges on the shaft.
        speed: At which a motor turns the hub [rad/s].
        options: Of `RotorAerodynamics`.
    """

    def __init__(
        self,
        stiffness,
        inertia,
        length,
        chord,
        axis=0.25,
        twist=0.0,
        hinged=False,
        speed=0.0,
        **options,
    ):
        line = BeamLine.straight(length)
        box = box_carrier("wing", line, (chord, 0.1 * chord), 24, COMM)
        sections = BeamSections([0.0, length], np.array([stiffness] * 2), np.array([inertia] * 2))
        basis = beam_basis(box.carrier, line, sections, 8, 3, box.start, hold=1.0)
        turns = [rotation_about(SHAFT, 2.0 * np.pi * k / 3) for k in range(3)]
        spans = [R @ (0.0, 0.0, 1.0) for R in turns]
        body = ReducedBody(
            "wings",
            box.carrier,
            basis,
            [Placement(position=ROOT * z, rotation=R) for z, R in zip(spans, turns, strict=True)],
        )
        topology = box.carrier.mesh.topology
        topology.create_connectivity(2, 3)
        skin = np.setdiff1d(exterior_facet_indices(topology), [*box.start, *box.end])
        edges = ROOT + length * np.linspace(0.0, 1.0, STATIONS + 1)
        self.radius, self.parts = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
        blade = plate(self.radius, length, chord, axis, twist)
        ways = [np.cross(SHAFT, z) for z in spans]
        frames = [[z, y, np.cross(z, y)] for z, y in zip(spans, ways, strict=True)]
        self.wind = SettableWind(SteadyWind(1e-6, 0.1))
        air = RotorAerodynamics(
            blade, frames, SHAFT, np.zeros(3), self.wind, induction=False, **options
        )
        lines = [
            StationLine(
                skin.astype(np.int32), origin=np.zeros(3), axis=z, stations=self.radius, copy=k
            )
            for k, z in enumerate(spans)
        ]
        hub = RigidBody("hub", 1e4, (1e4, 1e4, 1e4))
        rotor = Revolute("rotor", None, hub, point=(0.0, 0.0, 0.0), axis=SHAFT, reference=spans[0])
        motor = PrescribedMotion("rotor", lambda t: speed * t)
        parts = [hub, body, rotor, motor, SectionLoads("air", body, lines, air)]
        for k, (z, y) in enumerate(zip(spans, ways, strict=True)):
            carrier = hub
            if hinged:
                carrier = RigidBody(f"ring {k}", 1e-3, (1e-4, 1e-4, 1e-4))
                hinge = Revolute(
                    f"flap {k}", hub, carrier, point=(0.0, 0.0, 0.0), axis=y, reference=z
                )
                parts += [carrier, hinge]
            parts.append(Coupling(f"root {k}", body, box.start, carrier, copy=k))
        self.system = MultibodySystem(COMM, parts)
