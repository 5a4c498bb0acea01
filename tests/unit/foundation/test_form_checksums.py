"""Compiled forms have checksums: those that were cut off or damaged since are compiled again."""

import os
import subprocess
import sys

import pytest
from fake_forms import FORM, compiled, sealed

from turbine_fenicsx.foundation.errors import CompilationError
from turbine_fenicsx.foundation.form_cache import compile_on_all
from turbine_fenicsx.foundation.mpi_environment import environment_without_mpi

pytestmark = pytest.mark.parallel


@pytest.fixture
def folder(shared_tmp_path):
    return shared_tmp_path / "forms"


@pytest.mark.parametrize("has_seal", [True, False])
def test_code_that_everybody_may_write_to_is_refused(comm, folder, has_seal):
    if comm.rank == 0:
        folder.mkdir()
        sealed(folder) if has_seal else compiled(folder)
        (folder / f"{FORM}.so").chmod(0o666)
    comm.barrier()
    with pytest.raises(CompilationError, match=r"may be written to by everybody \(mode 666.*own$"):
        compile_on_all(comm, folder, compiled)


def test_code_that_was_damaged_since_is_compiled_again(comm, folder):
    """Also where nothing says what it was, as an earlier version has left it."""
    compile_on_all(comm, folder, compiled)
    code, seal = folder / f"{FORM}.so", folder / f"{FORM}.seal"
    for damage in (lambda: code.write_bytes(b"cut"), seal.unlink, lambda: seal.write_bytes(b"0")):
        if comm.rank == 0:
            damage()
        comm.barrier()
        seen = []

        def compile_here(place, claim, seen=seen):
            claim(FORM)
            seen.append(code.exists())
            return compiled(place)

        compile_on_all(comm, folder, compile_here)
        assert seen == [comm.rank > 0]
        assert code.read_bytes() == b""


LOOK = """
import sys
from pathlib import Path
from mpi4py import MPI
from turbine_fenicsx.foundation.c_code import compile_c
source = "double table[40000] = {1.0}; double f(int k) { return k + table[k]; }"
lib = compile_c(MPI.COMM_SELF, Path(sys.argv[1]), "double f(int k);", source, ["-O0"]).lib
print(lib.f(39999))
"""


def test_code_that_was_cut_off_does_not_end_the_process(tmp_path, comm):
    """Half of a library can be loaded; what is beyond its end is a bus error."""
    if comm.rank:
        return
    folder = tmp_path / "forms"
    command, alone = [sys.executable, "-c", LOOK, str(folder)], environment_without_mpi()
    for _ in range(2):
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=alone)
        assert done.stdout == "39999.0\n"
        (library,) = folder.glob("*.so")
        os.truncate(library, library.stat().st_size // 2)
