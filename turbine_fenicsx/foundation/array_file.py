"""Arrays in one file, ``.npz``, of which nothing is pickled or compressed."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import name_file_in_errors, open_regular, replace_file
from turbine_fenicsx.foundation.types import Array


def write_arrays(path: str | os.PathLike[str], arrays: Mapping[str, npt.ArrayLike]) -> None:
    """Write arrays to a file, whole or not at all; an old one is replaced."""
    content = io.BytesIO()
    np.savez(content, **{name: np.asarray(values) for name, values in arrays.items()})
    with content.getbuffer() as whole:
        replace_file(path, whole)


def read_arrays(path: str | os.PathLike[str], what: str) -> dict[str, Array]:
    """Arrays of a file of `write_arrays`."""
    name = os.fspath(path)
    with name_file_in_errors("read", name), open_regular(name) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                if any(member.compress_type for member in archive.infolist()):
                    raise zipfile.BadZipFile  # what is compressed may be of any size
            with np.load(file, allow_pickle=False) as members:
                return {member: members[member] for member in members.files}
        except (ValueError, KeyError, TypeError, EOFError, MemoryError, zipfile.BadZipFile):
            raise InputError(f"{name!r} is not {what}, or damaged") from None
