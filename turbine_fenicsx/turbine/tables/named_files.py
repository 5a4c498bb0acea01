"""Files that the files of a turbine name: they count as parts of these."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from turbine_fenicsx.foundation.errors import FileError, InputError


def is_windio(name: str) -> bool:
    """Whether a file is one of windIO by its name."""
    return Path(name).suffix.lower() in (".yaml", ".yml")


def list_included(name: str) -> Iterable[str]:
    """Files that a windIO file includes."""
    from turbine_fenicsx.windio.yaml_file import list_included  # not needed without a file

    return list_included(name)


def list_beam_parts(name: str) -> Iterable[str]:
    """Files that a file of a beam names; none of one that cannot be read."""
    from turbine_fenicsx.beam_files.any_file import list_parts  # not needed without such a file

    try:
        return list_parts(name)
    except (FileError, InputError):
        return ()


def list_parts(name: str) -> Iterable[str]:
    """Files that a windIO file includes, or blades and polars that a file of AeroDyn names.

    Files that are neither have none: whoever reads them says what is wrong.
    """
    if is_windio(name):
        return list_included(name)
    from turbine_fenicsx.wind.aerodyn_files import AeroDynNames

    try:
        return AeroDynNames.read(name).list_paths()
    except (FileError, InputError):
        return ()
