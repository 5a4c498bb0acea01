"""C code of this package's own, compiled with cffi into the cache of forms."""

from __future__ import annotations

import hashlib
import importlib.machinery
import importlib.util
import os
import platform
import shutil
import tempfile
from pathlib import Path
from typing import Any

from mpi4py import MPI

import cffi
import numpy as np

from turbine_fenicsx.foundation.form_cache import Claim, compile_on_all
from turbine_fenicsx.foundation.types import Array

VECTORS = Path(__file__).with_name("vectors.c")
"""Functions of vectors before the code of other files."""


def compile_c(
    comm: MPI.Intracomm, folder: Path, declaration: str, source: str, flags: list[str]
) -> Any:
    """A Python module with the functions of C code as members of `lib`. Collective.

    Args:
        source: The code, which must be the same on all ranks.
        flags: Flags for the compiler; ranks with other flags have separate code.
    """
    suffix = importlib.machinery.EXTENSION_SUFFIXES[0]
    key = "\n".join([declaration, source, *flags, cffi.__version__, suffix])
    name = f"turbine_fenicsx_{hashlib.sha1(key.encode()).hexdigest()}"

    def compile_here(place: Path, claim: Claim) -> tuple[None, Any]:
        library = place / f"{name}{suffix}"
        claim(name)
        if not library.exists():
            builder = cffi.FFI()
            builder.cdef(declaration)
            builder.set_source(name, source, extra_compile_args=flags)
            with tempfile.TemporaryDirectory() as work:
                made = builder.compile(tmpdir=work)
                unfinished = place / f"{name}.{platform.node()}_{os.getpid()}"
                shutil.copyfile(made, unfinished)
            os.replace(unfinished, library)
            (place / f"{name}.c.cached").touch()
        spec = importlib.util.spec_from_file_location(name, library)
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return None, module

    return compile_on_all(comm, folder, compile_here)[1]


class CompiledCode:
    """Functions of C code, for arrays.

    Args:
        module: Of `compile_c`.
    """

    def __init__(self, module: Any) -> None:
        self._ffi, self._lib = module.ffi, module.lib

    def _address(self, values: Array) -> Any:
        """Address of an array, of a copy of one that is not contiguous."""
        return self._ffi.from_buffer("double[]", np.ascontiguousarray(values, dtype=float))
