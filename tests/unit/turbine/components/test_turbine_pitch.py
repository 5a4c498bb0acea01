"""Claims about pitch bearings: rings, joints, drives and their signs."""

import numpy as np
import pytest

from turbine_fenicsx import JointDamper, JointSpring, PrescribedMotion
from turbine_fenicsx.foundation.rotations import E2, E3
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import assemble, build_turbine
from turbine_fenicsx.turbine.components.nacelle import Nacelle
from turbine_fenicsx.turbine.components.pitch import Pitch, make_pitch_drive, make_pitch_torques
from turbine_fenicsx.turbine.components.rigid_blades import RigidBlades
from turbine_fenicsx.turbine.run.summary import list_masses, rotor_inertia
from turbine_fenicsx.turbine.tables.pitch import PitchCase

HYBRID = Case.parse({"pitch": {"bearings": True, "ring_mass": 7.0, "ring_euler": [3.0, 1.0, 2.0]}})
SIGNS = (-1.0, 1.0, -1.0)
"""What a pitch to feather is in the coordinates of the bearings."""


def hybrid(comm):
    """Hub with rings."""
    return assemble(HYBRID, [Nacelle(), Pitch()], comm)


def rings_of(assembly):
    return [assembly.part(f"ring_{k}") for k in (1, 2, 3)]


def test_rings_are_centred_on_the_roots_with_their_second_axis_along_the_span(comm):
    turbine = hybrid(comm)
    body, layout = turbine.part("hub"), turbine.rotor.layout
    for k, ring in enumerate(rings_of(turbine), start=1):
        span, chord, _ = layout.frame(k)
        assert (ring.name, ring.mass, tuple(ring.euler)) == (f"ring_{k}", 7.0, (3.0, 1.0, 2.0))
        assert np.allclose(ring.position, body.position + 2.25 * span, atol=1e-14)
        directors = np.asarray(ring.directors).T
        assert np.allclose(directors[1:], [span, E3], atol=1e-15)
        assert abs(directors[0] @ chord) == pytest.approx(1.0)


def test_bearings_have_names_axes_and_signs_of_the_rigid_turbine(comm):
    rigid = Case.parse({"turbine": {"model": "rigid"}})
    bearings, printed = (
        [part for part in turbine.parts if part.name.startswith("pitch_")]
        for turbine in (
            hybrid(comm),
            assemble(rigid, [Nacelle(), RigidBlades(), Pitch()], comm),
        )
    )
    assert (
        [b.name for b in bearings] == [j.name for j in printed] == ["pitch_1", "pitch_2", "pitch_3"]
    )
    for bearing, joint in zip(bearings, printed, strict=True):
        assert np.allclose(bearing.axis, joint.axis, atol=1e-15)
        assert np.array_equal(bearing.reference, joint.reference)
        assert np.array_equal(bearing.point, bearing.second.position)


def test_a_free_bearing_has_no_drive():
    assert make_pitch_drive(PitchCase(stiffness=1.0, damping=1.0, angle=1.0)) == []


@pytest.mark.parametrize(("stiffness", "damping"), [(2.0, 0.0), (0.0, 3.0), (2.0, 3.0)])
def test_springs_and_dampers_are_on_all_bearings(stiffness, damping):
    parts = make_pitch_drive(PitchCase(drive="spring", stiffness=stiffness, damping=damping))
    springs = [p for p in parts if isinstance(p, JointSpring)]
    dampers = [p for p in parts if isinstance(p, JointDamper)]
    assert len(springs) + len(dampers) == len(parts) == len({p.name for p in parts})
    names = ["pitch_1", "pitch_2", "pitch_3"]
    assert [(s.coordinate, s.stiffness) for s in springs] == [(n, 2.0) for n in names if stiffness]
    assert [(d.coordinate, d.damping) for d in dampers] == [(n, 3.0) for n in names if damping]


def test_prescribed_motion_begins_and_ends_in_time_and_is_positive_to_feather():
    parts = make_pitch_drive(PitchCase(drive="prescribed", angle=0.4, start=1.0, duration=2.0))
    assert [p.coordinate for p in parts] == ["pitch_1", "pitch_2", "pitch_3"]
    for part, sign in zip(parts, SIGNS, strict=True):
        assert isinstance(part, PrescribedMotion)
        values = [part.motion(t) for t in (0.0, 1.0, 2.0, 3.0, 9.0)]
        assert np.allclose(values, sign * np.array([0.0, 0.0, 0.2, 0.4, 0.4]), atol=1e-15)


def test_pitch_torque_is_positive_to_feather():
    torques = make_pitch_torques(Case.parse({"loads": {"pitch_torque": 5.0, "duration": 2.0}}))
    assert [(t.coordinate, t.torque * t.function(1.0)) for t in torques] == [
        (f"pitch_{k}", 5.0 * sign) for k, sign in enumerate(SIGNS, start=1)
    ]


@pytest.mark.parallel
def test_rings_carry_the_blades_and_belong_to_the_rotor(comm):
    mesh = {"mesh": {"elements": [1, 1, 2]}}
    without = build_turbine(Case.parse(mesh), comm)
    pitch = {"bearings": True, "ring_mass": 500.0, "ring_euler": [300.0, 10.0, 200.0]}
    turbine = build_turbine(Case.parse(mesh | {"pitch": pitch}), comm)
    rings = [f"ring_{k}" for k in (1, 2, 3)]
    assert [turbine.part(f"root_{k}").rigid.name for k in (1, 2, 3)] == rings
    assert [list_masses(turbine)[name] for name in rings] == [500.0] * 3
    assert [without.part(f"root_{k}").rigid.name for k in (1, 2, 3)] == ["hub"] * 3
    # about the shaft: the Euler values along chord and span, and the mass at the hub's radius
    more = 3 * (300.0 + 10.0 + 500.0 * 2.25**2)
    assert rotor_inertia(turbine) - rotor_inertia(without) == pytest.approx(more, rel=1e-6)


def test_ring_axis_of_the_upright_blade_is_vertical(comm):
    assert np.allclose(np.asarray(rings_of(hybrid(comm))[1].directors)[:, 1], E2, atol=1e-15)
