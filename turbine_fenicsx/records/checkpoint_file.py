"""The file of a checkpoint: a head and named arrays, sealed by a checksum.

It is an ``.npz`` file that NumPy reads like any other. At its end, where zip files have room for a
comment, stands a checksum of everything before, so that one flipped bit is found before use.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from turbine_fenicsx.foundation.files import open_regular, replace_file
from turbine_fenicsx.foundation.types import Array

_FORMAT = b"turbine_fenicsx checkpoint 2, blake2b "
_DIGITS = 64
_NAME = re.compile(r"checkpoint_(\d+)\.npz")
_PIECE = 1 << 20


class UnusableError(Exception):
    """A checkpoint that cannot be used; the message says why, without its name."""


def list_checkpoints(folder: str | os.PathLike[str]) -> list[Path]:
    """The checkpoints in a folder, newest first: that of the largest step."""
    found = [(p, _NAME.fullmatch(p.name)) for p in Path(folder).glob("checkpoint_*.npz")]
    numbered = [(int(match[1]), path) for path, match in found if match]
    return [path for _, path in sorted(numbered, reverse=True)]


def step_of(path: Path) -> int:
    """Number of the step that a checkpoint belongs to."""
    return int(path.stem.rpartition("_")[2])


def write_checkpoint(path: Path, head: Mapping[str, Any], arrays: Mapping[str, Array]) -> None:
    """Write a file and wait until it is on the disk; an old one is replaced when it is."""
    content = io.BytesIO()
    np.savez(content, head=np.array(json.dumps(head)), **arrays)  # type: ignore[arg-type]
    with zipfile.ZipFile(content, "a") as archive:
        archive.comment = _FORMAT + _DIGITS * b"0"
    with content.getbuffer() as whole:
        digest = hashlib.blake2b(whole[:-_DIGITS], digest_size=_DIGITS // 2).hexdigest()
        whole[-_DIGITS:] = digest.encode()
        replace_file(path, whole)


def read_head(path: Path) -> dict[str, Any]:
    """The head of a file, once its checksum has shown that nothing in it has changed."""
    try:
        _check_seal(path)
        with np.load(path, allow_pickle=False) as file:
            head: dict[str, Any] = json.loads(str(file["head"]))
    except OSError as error:
        raise UnusableError(f"cannot be read: {error.strerror or error}") from None
    return head


def read_arrays(path: Path) -> dict[str, Array]:
    """The arrays of a file whose head was read."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file.files if name != "head"}


def _check_seal(path: Path) -> None:
    """Compare the checksum with the content."""
    seal = len(_FORMAT) + _DIGITS
    left = path.stat().st_size - _DIGITS
    hashed = hashlib.blake2b(digest_size=_DIGITS // 2)
    with open_regular(path) as file:
        while left > 0 and (piece := file.read(min(left, _PIECE))):
            hashed.update(piece)
            left -= len(piece)
        digest = file.read()
        file.seek(max(0, path.stat().st_size - seal))
        end = file.read(seal)
    if end.startswith(_FORMAT) and digest == hashed.hexdigest().encode():
        return
    if end[-22:].startswith(b"PK\x05\x06"):  # a zip file without a comment
        raise UnusableError("was written in an earlier format, without a checksum")
    raise UnusableError("is incomplete or damaged, its checksum does not fit")
