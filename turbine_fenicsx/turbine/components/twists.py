"""Twist of flexible blades at places along the span: that of the walls, seen from the root."""

from __future__ import annotations

from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import BLADES
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.section_turns import Section, SectionTurns
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS
from turbine_fenicsx.turbine.components.component import Turbine

HALF_WIDTH = 0.02
"""Half of the part of the span that a section is made of."""


def make_twist_channel(turbine: Turbine) -> Channel | None:
    """Columns with the twist of each blade at ``output.twists``; None without any. Collective.

    Twist is positive towards feather, as that of the shape of a blade.
    """
    places, layout, blades = turbine.case.output.twists, turbine.rotor.layout, turbine.rotor.blades
    if not places:
        return None
    sections, columns = [], []
    for k, root in enumerate(ROOTS[: len(BLADES)], start=1):
        coupling = turbine.part(root)
        for place in places:
            columns.append(names.TWIST(blade=k, place=f"{place:g}"))
            sections.append(
                Section(
                    columns[-1],
                    coupling.flexible,
                    origin=layout.centre,
                    axis=-layout.frame(k)[0],
                    distance=-(blades.hub_radius + place * blades.length),
                    half_width=HALF_WIDTH * blades.length,
                    carrier=coupling.rigid,
                    copy=coupling.copy,
                )
            )
    turns = SectionTurns(turbine.system, sections)
    return Channel(tuple(columns), lambda s: turns.at(s).tolist())
