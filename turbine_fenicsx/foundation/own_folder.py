"""Folders whose content this program trusts, such as caches: nobody else may write to them."""

from __future__ import annotations

import os
import pwd
import stat
from pathlib import Path


def describe_stranger(path: Path) -> str | None:
    """Say who else could have written a folder, or a file in it.

    The system's administrator may, and so may the group, which the umask of many systems lets in.
    A link in a folder counts as what it leads to.

    Args:
        path: The folder or file; it need not exist.

    Returns:
        What is wrong, to follow the name of the path; None if nothing is.
    """
    try:
        status = os.stat(path)
    except OSError:
        return None
    if status.st_uid not in (os.geteuid(), 0):
        return f"belongs to {_name_user(status.st_uid)}, not to you"
    if status.st_mode & stat.S_IWOTH and not stat.S_ISCHR(status.st_mode):
        mode = stat.S_IMODE(status.st_mode)
        return f"may be written to by everybody (mode {mode:o}; `chmod o-w` forbids it)"
    return None


def _name_user(number: int) -> str:
    """Name of a user, or the number of one without a name."""
    try:
        return f"the user {pwd.getpwuid(number).pw_name!r}"
    except KeyError:
        return f"the user {number}"
