"""Keys that name files of data: found beside the case, made absolute, hashed, read once.

`DataFile` marks such a key in its type, all else follows from the mark. `DataFolder` marks a folder
in which files are kept, which changes no result and is not hashed.
"""

from __future__ import annotations

import functools
import hashlib
import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import open_regular
from turbine_fenicsx.foundation.text_files import quote

Nested = Mapping[str, Any]
"""Nested tables as they are read, which may hold mistakes."""

Result = TypeVar("Result")


def find_beside(name: str, folder: str | os.PathLike[str]) -> str:
    """A file by its name relative to a folder."""
    return str(Path(folder) / name)


def keep_name(name: str, folder: str | os.PathLike[str]) -> str:
    """The name as it is, of a file that is found later."""
    return name


def list_no_parts(name: str) -> tuple[str, ...]:
    """The further files of a file that names none."""
    return ()


@dataclass(frozen=True)
class DataFile:
    """Marks a key whose value is the name of a file, or a list of names.

    Args:
        what: What the file is to the user, for example "wind file".
        find: Finds a file by its name and the folder of the case.
        parts: Further files that a file names, which count as parts of it.
    """

    what: str
    find: Callable[[str, str | os.PathLike[str]], str] = find_beside
    parts: Callable[[str], Iterable[str]] = list_no_parts

    def change(self, value: str, change: Callable[[str], str]) -> str:
        """The value of the key with another name of the file."""
        return change(value)


@dataclass(frozen=True)
class DataFolder(DataFile):
    """Marks a key whose value is the name of a folder."""


def change_files(
    data: Nested, model: type[BaseModel], change: Callable[[DataFile, str], str]
) -> dict[str, Any]:
    """A copy of nested tables in which each name of a file is changed.

    Args:
        change: Gives the new name for a mark and a name.
    """
    fields = model.model_fields
    return {
        key: _change(value, fields[key], change) if key in fields else value
        for key, value in data.items()
    }


def _change(value: Any, field: FieldInfo, change: Callable[[DataFile, str], str]) -> Any:
    """A value with other names of files."""
    kind = field.annotation
    if isinstance(value, Mapping):
        if get_origin(kind) is dict:  # tables with names of the user's own
            inner: type[BaseModel] = get_args(kind)[1]
            return {
                name: change_files(table, inner, change) if isinstance(table, Mapping) else table
                for name, table in value.items()
            }
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            return change_files(value, kind, change)
        return value
    mark = next((mark for mark in field.metadata if isinstance(mark, DataFile)), None)
    if mark is None:
        return value
    if isinstance(value, str):
        return mark.change(value, functools.partial(change, mark))
    if isinstance(value, list | tuple):
        return [change(mark, name) if isinstance(name, str) else name for name in value]
    return value


def list_files(data: Nested, model: type[BaseModel]) -> list[tuple[DataFile, str]]:
    """The files that nested tables name, in their order, without folders."""
    found: list[tuple[DataFile, str]] = []

    def note(mark: DataFile, name: str) -> str:
        if not isinstance(mark, DataFolder):
            found.append((mark, name))
        return name

    change_files(data, model, note)
    return found


def place_files(
    data: Nested, model: type[BaseModel], folder: str | os.PathLike[str]
) -> dict[str, Any]:
    """Nested tables with their files relative to a folder."""
    return change_files(data, model, lambda mark, name: mark.find(name, folder))


def make_absolute(data: Nested, model: type[BaseModel]) -> dict[str, Any]:
    """Nested tables that mean the same from any folder."""
    return change_files(data, model, lambda mark, name: os.path.abspath(mark.find(name, ".")))


def hash_files(data: Nested, model: type[BaseModel]) -> dict[str, str]:
    """Hash of the contents of the files of each kind, by what they are."""
    found: dict[str, str] = {}
    for mark, name in list_files(data, model):
        for part in (name, *mark.parts(name)):
            found[mark.what] = f"{found.get(mark.what, '')} {_hash(part)}".lstrip()
    return found


def _hash(name: str) -> str:
    try:
        with open_regular(name) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()[:16]
    except FileNotFoundError:  # a key without effect may name none
        return f"missing ({name})"


def _find_change(path: str, kind: str) -> tuple[int, int]:
    """When a file was changed last, and its size."""
    try:
        status = os.stat(path)
    except (OSError, ValueError) as error:
        words = " ".join(filter(None, ["cannot read", kind and f"the {kind}", quote(path)]))
        raise InputError(f"{words}: {getattr(error, 'strerror', error)}") from None
    return status.st_mtime_ns, status.st_size


def read_if_changed(
    kind: str = "", size: int = 4, parts: Callable[[str], Iterable[str]] = list_no_parts
) -> Callable[[Callable[..., Result]], Callable[..., Result]]:
    """Decorator of readers: files that did not change since are not read again.

    The first argument of the reader is a path, or a tuple of paths; all arguments are hashable. The
    reader raises InputError for files that are not there.

    Args:
        kind: What the file is to the user, for example "windIO file".
        size: Number of results that are kept.
    """

    def decorate(read: Callable[..., Result]) -> Callable[..., Result]:
        @functools.lru_cache(maxsize=size)
        def keep(changes: object, *arguments: Any) -> Result:
            return read(*arguments)

        @functools.wraps(read)
        def reader(paths: str | tuple[str, ...], *arguments: Any) -> Result:
            names = (paths,) if isinstance(paths, str) else paths
            changes = tuple(
                (part, _find_change(part, kind)) for name in names for part in (name, *parts(name))
            )
            return keep(changes, paths, *arguments)

        return reader

    return decorate
