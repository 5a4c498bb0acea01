"""Defaults in PETSc's database of options, for as long as an object reads them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from petsc4py import PETSc


@contextmanager
def default_options(prefix: str | None, defaults: Mapping[str, str]) -> Iterator[None]:
    """Set options that the user has not set, and leave no trace of them.

    Args:
        prefix: Prefix of the object that reads them.
    """
    options = PETSc.Options(prefix)
    mine = [key for key in defaults if not options.hasName(key)]
    for key in mine:
        options[key] = defaults[key]
    try:
        yield
    finally:
        for key in mine:
            options.delValue(key)
