"""The table of the basis of reduced blades."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.files import DataFile, DataFolder
from turbine_fenicsx.case.quantities import Whole
from turbine_fenicsx.case.rules import Beside
from turbine_fenicsx.case.section import Section

FOLDER = "bases"
"""Folder beside the case file in which bases are kept, unless the case names one."""

LARGEST = 300
"""Functions of a basis; the time of a step grows with their third power."""

Number = Annotated[Whole, Field(ge=0, le=LARGEST)]


class ReductionCase(Section):
    """Basis of the reduced blades, see howto/reduced_turbine.

    Blades of ``turbine.file`` learn it from operating points of the turbine, others from smooth
    loads along the span.
    """

    modes: Number = 6
    """Number of vibration modes of the blade in its basis, which are exact then."""
    functions: Annotated[Whole, Field(ge=1, le=LARGEST)] = 66
    """Number of all functions of the basis, three for each mode; more are better and slower."""
    strains: Number = 25
    """Number of strain coordinates besides those that small motions need."""
    file: Annotated[str | None, DataFile("basis of the blades")] = None
    """Basis that the command ``reduce`` has written for such blades; without it a run takes one
    from ``folder``, or makes it and keeps it there."""
    folder: Annotated[str | None, DataFolder("folder of bases"), Beside("file")] = None
    """Folder in which bases are kept, relative to the case file; none: ``bases`` beside it, or in a
    study beside the case file of the study."""

    @check("functions", "modes")
    def _check_functions(self, case: Any) -> str:
        """Each mode takes three functions."""
        return find_few_functions("blade", self.functions, self.modes)


class TowerReductionCase(Section):
    """Basis of the reduced tower, which learns it from smooth loads along its height."""

    modes: Number = 4
    """Number of vibration modes of the tower between foot and head in its basis."""
    functions: Annotated[Whole, Field(ge=1, le=LARGEST)] = 24
    """Number of all functions of the basis, three for each mode."""
    strains: Number = 15
    """Number of strain coordinates besides those that small motions need."""
    file: Annotated[str | None, DataFile("basis of the tower")] = None
    """Basis of such a tower; without it a run takes one from ``folder``, or makes it and keeps it
    there."""
    folder: Annotated[str | None, DataFolder("folder of bases"), Beside("file")] = None
    """Folder in which bases are kept, relative to the case file; none: ``bases`` beside it, or in a
    study beside the case file of the study."""

    @check("functions", "modes")
    def _check_functions(self, case: Any) -> str:
        """Each mode takes three functions."""
        return find_few_functions("tower", self.functions, self.modes)


def find_few_functions(table: str, functions: int, modes: int) -> str:
    """A sentence if there are too few functions for the modes.

    Args:
        table: Of the body, for example "blade".
        functions: Number of functions.
        modes: Number of modes.
    """
    if functions >= 3 * modes:
        return ""
    return (
        f"{table}.reduction.functions = {functions}: expected at least {3 * modes}, three for "
        f"each of {table}.reduction.modes = {modes}"
    )
