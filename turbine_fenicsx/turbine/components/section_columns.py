"""Forces and moments in sections of beam blades, with the names of their columns."""

from __future__ import annotations

from collections.abc import Sequence

from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import BLADES
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.section_loads import BeamLoads
from turbine_fenicsx.turbine.components.component import Turbine


def name_sections(places: Sequence[float]) -> list[str]:
    """Columns of the loads of `BeamLoads` at some places, blade by blade."""
    return [
        family(blade=k, place=f"{place:g}", axis=axis)
        for k in range(1, len(BLADES) + 1)
        for place in places
        for family in (names.SECTION_FORCE, names.SECTION_MOMENT)
        for axis in "xyz"
    ]


def make_section_channel(turbine: Turbine, body: str) -> Channel | None:
    """Columns of the sections at ``output.sections``; None without any. Collective.

    Args:
        body: Name of the body of all blades.
    """
    places = turbine.case.output.sections
    if not places or not turbine.case.has_beam_blades:
        return None
    loads = BeamLoads(turbine.system, turbine.part(body), places)
    return Channel(tuple(name_sections(places)), lambda s: loads.at(s.state).ravel().tolist())
