"""Claims about loads in sections: they balance what lies beyond, on meshes and reduced bodies."""

import numpy as np
import pytest
from dolfinx import mesh
from reduced_beams import (
    COMM,
    DENSITY,
    SIZE,
    beam,
    clamped,
    clamped_basis,
    facets_at,
    on_hub,
    placements,
    tip_of,
)
from seen import Seen

from turbine_fenicsx import (
    Coupling,
    GeneralisedAlpha,
    Gravity,
    ModelError,
    MultibodySystem,
    NodeForce,
    Placement,
    ReducedBody,
    RestartData,
    SectionLoads,
    Simulation,
    StationLine,
    reduce_body,
)
from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.simulation.observers.cuts import Cut
from turbine_fenicsx.simulation.observers.outboard_loads import OutboardLoads
from turbine_fenicsx.simulation.observers.reactions import Reaction, Reactions
from turbine_fenicsx.simulation.observers.section_turns import Section

pytestmark = pytest.mark.parallel

CELLS, LENGTH = (3, 3, 8), SIZE[2]
LINE_MASS, G = DENSITY * SIZE[0] * SIZE[1], np.array([2.0, -9.81, 1.0])
STATIONS, WIDTH = np.linspace(0.25, 3.75, 8), 0.5
HERE = Placement()
POINT = np.array([0.1, -0.05, 0.0])
AXES = rotation_about((1.0, 2.0, -1.0), 0.8)


class Push:
    """A load per length that turns with the sections, and a moment per length."""

    force, moment = np.array([70.0, -30.0, 10.0]), np.array([5.0, 8.0, -4.0])

    def start_step(self, times):
        pass

    def loads(self, motion, time):
        return WIDTH * motion.axes @ self.force, WIDTH * motion.axes @ self.moment

    def accept(self, motion, times):
        pass

    def save(self):
        return RestartData()

    def restore(self, data):
        pass


def push(body, places):
    """The load on all copies of a beam."""
    skin = mesh.locate_entities_boundary(
        body.full.mesh, 2, lambda x: ~np.isclose(x[2], 0.0) & ~np.isclose(x[2], LENGTH)
    )
    lines = [
        StationLine(skin, origin=t, axis=R[:, 2], stations=STATIONS, copy=k)
        for k, (R, t) in enumerate(map(Placement.frame, places))
    ]
    return SectionLoads("push", body, lines, Push())


def cut(body, s, copy=0, place=HERE, beyond=()):
    """A section at a distance s along the beam."""
    R, t = place.frame()
    section = Section(
        f"at {s:g}", body, origin=t, axis=2.0 * R[:, 2], distance=s, half_width=0.1, copy=copy
    )
    point, axes = t + R @ (POINT + np.array([0.0, 0.0, s])), AXES @ R.T
    return Cut(section, 0.0, LENGTH, point, axes, beyond)


def make(kind):
    """The beam on its mesh, or reduced where it stands."""
    full = beam(cells=CELLS)
    return full if kind == "full" else ReducedBody("beam", full, clamped_basis(cells=CELLS))


def run(system, *loads):
    """What the loads say of the steps of a run."""
    seen = Seen(lambda s: [np.copy(x.at(s)) for x in loads])
    simulation = Simulation(system, 0.02, 0.08, [seen])
    simulation.run()
    simulation.stepper.destroy()
    return [column[1:] for column in seen.columns]


def agree(found, expected):
    assert np.abs(expected).max() > 100.0
    assert np.allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())


def test_at_the_roots_of_turning_copies_they_are_the_loads_of_the_roots():
    places = placements(2)
    body = ReducedBody("blades", beam(cells=CELLS), clamped_basis(cells=CELLS), places)
    system = on_hub([body], push(body, places), Gravity(tuple(G)), speed=2.0)
    roots = [c for c in system.couplings]
    cuts = [cut(body, 0.0, k, place) for k, place in enumerate(places)]
    at_roots = [Reaction(r, c.point, c.axes) for r, c in zip(roots, cuts, strict=True)]
    agree(*run(system, OutboardLoads(system, cuts), Reactions(system, at_roots)))


@pytest.mark.parametrize("kind", ["full", "reduced"])
def test_what_holds_the_part_beyond_counts(kind):
    """A beam between two grounds that starts to move, and is pulled by its weight."""
    full = beam(cells=CELLS)
    ends = [facets_at(full, 0.0), facets_at(full, LENGTH)]
    held = MultibodySystem(
        COMM, [full, *(Coupling(f"{k}", full, f, None) for k, f in enumerate(ends))]
    )
    body = full
    if kind == "reduced":
        body = ReducedBody("beam", full, reduce_body(held, full, 4, 12, loads=()))
    first, last = (Coupling(n, body, f, None) for n, f in zip(("foot", "head"), ends, strict=True))
    system = MultibodySystem(COMM, [body, first, last, push(body, [HERE]), Gravity(tuple(G))])
    there = cut(body, 0.0, beyond=[last])
    reaction = Reaction(first, there.point, there.axes)
    agree(*run(system, OutboardLoads(system, [there]), Reactions(system, [reaction])))


@pytest.mark.parametrize("kind", ["full", "reduced"])
def test_sections_carry_weight_and_line_loads_of_what_lies_beyond(kind):
    """Wherever they cut cells and stations; moments to the square of the length of a cell."""
    body = make(kind)
    system = clamped(body, push(body, [HERE]), Gravity(tuple(G)))
    places = np.array([0.0, 0.3, 1.5, 2.37, 3.7])
    found = OutboardLoads(system, [cut(body, s) for s in places]).at_rest(system.initial_state())
    for s, (F, M) in zip(places, found @ AXES, strict=True):
        beyond = LENGTH - s
        of_line = LINE_MASS * G + Push.force
        assert beyond * of_line == pytest.approx(F, rel=1e-9)
        arm = np.array([0.0, 0.0, 0.5 * beyond]) - POINT
        expected = np.cross(arm, beyond * of_line) + beyond * Push.moment
        assert pytest.approx(M, abs=0.02 * np.linalg.norm(LINE_MASS * G)) == expected


def test_sections_of_what_turns_carry_its_inertia():
    place = placements(1, radius=0.5)[0]
    body = ReducedBody("blades", beam(cells=CELLS), clamped_basis(cells=CELLS), [place])
    system = on_hub([body], speed=2.0)
    frame = turning_frame(system, "main", 2.0)
    state = system.initial_state()
    frame.set_velocities(state)
    s = np.array([0.0, 1.5, 3.0])
    cuts = [cut(body, x, 0, place) for x in s]
    F = OutboardLoads(system, cuts).at_rest(state, frame)[:, 0] @ AXES
    expected = 2.0**2 * LINE_MASS * ((LENGTH + 0.5) ** 2 - (s + 0.5) ** 2) / 2.0
    assert F[:, 2] == pytest.approx(expected, abs=0.01 * expected[0])
    assert np.allclose(F[:, :2], 0.0, atol=1e-9 * expected[0])


def test_forces_that_do_not_count_and_other_bodies_and_steps_are_refused():
    body = make("full")
    pulled = clamped(body, NodeForce("pull", body, point=tip_of(HERE), force=(1, 0, 0)))
    with pytest.raises(
        ModelError, match="count weight and loads on stations, not the force 'pull'"
    ):
        OutboardLoads(pulled, [cut(body, 1.0)])
    with pytest.raises(ModelError, match="body 'beam' of section 'at 1' is not"):
        OutboardLoads(clamped(beam()), [cut(body, 1.0)])
    system = clamped(body)
    loads = OutboardLoads(system, [cut(body, 1.0)])
    stepper = GeneralisedAlpha(system)
    simulation = Simulation(system, 0.02, 0.04, [Seen(loads.at)], stepper)
    with pytest.raises(ModelError, match="need steps with their forces in the middle"):
        simulation.run()
    stepper.destroy()
