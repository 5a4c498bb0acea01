"""The file of beams of a case, read again when it has changed."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from turbine_fenicsx.case.files import read_if_changed
from turbine_fenicsx.foundation.errors import FileError, InputError
from turbine_fenicsx.turbine.tables.named_files import list_beam_parts

if TYPE_CHECKING:  # cases without such a file do not wait for what reads one
    from turbine_fenicsx.beam_files.beam_blade import BeamBlade


@read_if_changed("file of a beam", parts=list_beam_parts)
def load_beam(path: str) -> BeamBlade:
    """The blade of a primary file of BeamDyn, or of an htc file of HAWC2."""
    from turbine_fenicsx.beam_files.any_file import read_beam

    return read_beam(path)


def find_beam(blade: Mapping[str, Any]) -> BeamBlade | None:
    """The blade of ``blade.beam.file``; None if there is none, or something is wrong with it.

    Args:
        blade: The table of the blades.
    """
    beam = blade.get("beam")
    file = beam.get("file") if isinstance(beam, Mapping) else None
    if isinstance(file, str):
        with suppress(InputError, FileError):  # what is wrong with it is said by its own check
            return load_beam(file)
    return None


def find_beam_mu(blade: Mapping[str, Any], mu: tuple[float, ...]) -> tuple[float, ...]:
    """Damping of each strain by ``blade.beam.file``, or of the turbine's file.

    Args:
        blade: The table of the blades.
        mu: Those of the turbine's file.
    """
    found = find_beam(blade)
    return mu if found is None else tuple(float(x) for x in found.sections.viscosity)


def add_beam(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Nested tables of a case without ``turbine.file``, with what ``blade.beam.file`` has below.

    These are the length of the blades and their damping, as far as the case has none.
    """
    blade = data.get("blade") if isinstance(data, Mapping) else None
    if not isinstance(blade, Mapping) or blade.get("model") != "beam":
        return data
    found = find_beam(blade)
    if found is None:
        return data
    below: dict[str, Any] = {"length": found.line.length}
    mu = find_beam_mu(blade, ())
    if any(mu):
        below["damping"] = {"mu": list(mu)}
    return {**data, "blade": {**below, **blade}}
