"""Forces and moments in sections of blades and the tower, whatever these are made of.

Beams know them from their strains. In solids they are sums of all that acts beyond a section.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.foundation.rotations import E2
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import BLADES, TOWER
from turbine_fenicsx.simulation.observers.cuts import Cut
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.outboard_loads import OutboardLoads
from turbine_fenicsx.simulation.observers.section_loads import BeamLoads, BeamStepLoads
from turbine_fenicsx.simulation.observers.section_turns import Section
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS
from turbine_fenicsx.turbine.components.axes import TOWER_AXES, blade_axes
from turbine_fenicsx.turbine.components.component import Channels, Turbine
from turbine_fenicsx.turbine.components.openfast_channel import in_openfast

HALF_WIDTH = 0.02
"""Half of the part of the length that a section is made of."""

STEPS = "energy_momentum"
"""Scheme whose forces act in the middle of a step, as the sums need."""

_NUMBERS = range(1, len(BLADES) + 1)


SlenderLoads: TypeAlias = BeamStepLoads | OutboardLoads
"""Force and moment of what lies beyond sections on what lies before them."""


def find_blade_sections(turbine: Turbine, places: Sequence[float]) -> SlenderLoads:
    """Loads in sections of flexible blades, blade by blade. Collective.

    Args:
        places: Fractions of the length of the reference axis, about which moments are.
    """
    body, layout = turbine.part(ROOTS[0]).flexible, turbine.rotor.layout
    if turbine.case.has_beam_blades:
        return BeamStepLoads(BeamLoads(turbine.system, body, places, blade_axes(layout, 1)))
    points = turbine.rotor.blades.axis_at(np.array([0.0, 1.0, *places]))
    start, end, *distances = points[:, 0]
    cuts = []
    for k in _NUMBERS:
        axes, copy = blade_axes(layout, k), turbine.part(ROOTS[k - 1]).copy
        for s, point, distance in zip(places, layout.place(points[2:], k), distances, strict=True):
            section = Section(
                f"blade {k} at {s:g}",
                body,
                origin=layout.centre,
                axis=axes[2],
                distance=distance,
                half_width=HALF_WIDTH * (end - start),
                copy=copy,
            )
            cuts.append(Cut(section, start, end, point, axes))
    return OutboardLoads(turbine.system, cuts)


def find_tower_sections(turbine: Turbine, places: Sequence[float], head: Coupling) -> SlenderLoads:
    """Loads in sections of a flexible tower. Collective.

    Args:
        places: Fractions of its height.
        head: What holds its top.
    """
    body, height = turbine.part(TOWER), turbine.case.tower.height
    if turbine.case.has_beam_tower:
        return BeamStepLoads(BeamLoads(turbine.system, body, places, TOWER_AXES))
    foot, cuts = -height * E2, []
    for s in places:
        section = Section(
            f"tower at {s:g}",
            body,
            origin=foot,
            axis=E2,
            distance=s * height,
            half_width=HALF_WIDTH * height,
        )
        cuts.append(Cut(section, 0.0, height, foot + s * height * E2, TOWER_AXES, [head]))
    return OutboardLoads(turbine.system, cuts)


def name_sections(places: Sequence[float]) -> list[str]:
    """Columns of the loads in sections of blades, blade by blade."""
    return [
        family(blade=k, place=f"{place:g}", axis=axis)
        for k in _NUMBERS
        for place in places
        for family in (names.SECTION_FORCE, names.SECTION_MOMENT)
        for axis in "xyz"
    ]


def blade_section_channels(turbine: Turbine) -> Channels:
    """Loads in the sections at ``output.sections``. Collective."""
    places = turbine.case.output.sections
    if not places or turbine.case.time.scheme != STEPS:
        return Channels()
    openfast = [
        f"Spn{n}{kind}L{axis}b{k}"
        for k in _NUMBERS
        for n in range(1, len(places) + 1)
        for kind in "FM"
        for axis in "xyz"
    ]
    return _make_channels(find_blade_sections(turbine, places), name_sections(places), openfast)


def tower_section_channels(turbine: Turbine, head: Coupling) -> Channels:
    """Loads in the sections at ``output.tower_sections``; see `find_tower_sections`."""
    places = turbine.case.output.tower_sections
    if not places or turbine.case.time.scheme != STEPS:
        return Channels()
    columns = [
        family(place=f"{place:g}", axis=axis)
        for place in places
        for family in (names.TOWER_SECTION_FORCE, names.TOWER_SECTION_MOMENT)
        for axis in "xyz"
    ]
    openfast = [
        f"TwHt{n}{kind}L{axis}t"
        for n in range(1, len(places) + 1)
        for kind in "FM"
        for axis in "xyz"
    ]
    return _make_channels(find_tower_sections(turbine, places, head), columns, openfast)


def _make_channels(
    loads: SlenderLoads, history: Sequence[str], openfast: Sequence[str]
) -> Channels:
    """Columns of both histories."""

    def find(s: Snapshot) -> list[float]:
        found: list[float] = loads.mean_at(s).ravel().tolist()
        return found

    return Channels(
        history=[Channel(tuple(history), find, loads)],
        openfast=[in_openfast(openfast, loads.mean_at, loads)],
    )
