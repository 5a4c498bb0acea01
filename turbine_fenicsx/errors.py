"""The exception for what a user can mend."""

from __future__ import annotations


class InputError(ValueError):
    """Wrong input; the message is one clear sentence per mistake. Exit code 2."""
