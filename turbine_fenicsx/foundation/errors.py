"""Exceptions for what a user can correct."""

from __future__ import annotations


class InputError(ValueError):
    """Wrong input; the message is one clear sentence per mistake. Exit code 2."""


class ModelError(InputError):
    """A wrong model, found by a check of ours: a joint, a force, a body, a material, a mesh, ..."""


class ForeignError(ModelError):
    """Code of a user that fails, such as a controller or a force; it is raised on all ranks.

    The message is one sentence with its name, its file and what went wrong. Exit code 2.
    """


class ModelWarning(UserWarning):
    """Suspicious setting of a model, or balance of a run, that may be intended."""


class StepFailure(RuntimeError):
    """A step, or an equilibrium, that was not found; the message holds the reason in words."""


class NoEquilibrium(StepFailure):
    """An equilibrium that was not found.

    Args:
        advice: What may help, for who calls from Python.
    """

    def __init__(self, reason: str, advice: str) -> None:
        super().__init__(reason, advice)
        self.reason, self.advice = reason, advice

    def __str__(self) -> str:
        """Both as one sentence."""
        return f"{self.reason}; {self.advice}"


class CompilationError(RuntimeError):
    """A form cannot be compiled on this computer; the message is one sentence. Exit code 2."""


class FileError(OSError):
    """A file that cannot be read or written; the message is a sentence that names it. Exit code 2.

    The cause may be the disk, the permissions, or somebody who has moved the folder.
    """
