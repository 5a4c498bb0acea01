"""What DOLFINx compiles goes through the cache of forms, also beside killed processes."""

import os
import signal
import subprocess
import sys
import textwrap
import time

import pytest
import ufl
from dolfinx import fem, mesh

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation import form_cache
from turbine_fenicsx.foundation.errors import CompilationError
from turbine_fenicsx.foundation.form_cache import compile_on_all


def of_dolfinx(comm):
    """Make one of everything that DOLFINx compiles."""
    cube = mesh.create_unit_cube(comm, 2, 2, 2, mesh.CellType.hexahedron)
    space, cellwise = _compat.vector_space(cube, 1), _compat.cellwise_space(cube, (3,))
    u = fem.Function(space)
    _compat.expression(2.0 * u, cellwise)
    _compat.compile_form(ufl.dot(u, u) * ufl.dx)


def test_all_that_dolfinx_compiles_goes_into_the_folder(comm, monkeypatch):
    folders = set()

    def spy(comm, folder, compile_here):
        folders.add(folder)
        return compile_on_all(comm, folder, compile_here)

    monkeypatch.setattr(form_cache, "compile_on_all", spy)
    before = _compat.dolfinx.jit.ffcx_jit
    of_dolfinx(comm)
    assert {folder.parts[-3:] for folder in folders} == {("fenics", "turbine_fenicsx", "forms")}
    assert _compat.dolfinx.jit.ffcx_jit is before  # what others compile is theirs


def test_forms_for_this_processor_are_kept_apart(comm, monkeypatch):
    names = []

    def spy(comm, folder, compile_here):
        made = compile_on_all(comm, folder, compile_here)
        names.append(made[1].__name__)
        return made

    cube = mesh.create_unit_cube(comm, 2, 2, 2, mesh.CellType.hexahedron)
    u = fem.Function(_compat.vector_space(cube, 1))
    monkeypatch.setattr(form_cache, "compile_on_all", spy)
    for flags in ("", "-march=native", "-march=native"):
        monkeypatch.setenv("TURBINE_FENICSX_CFLAGS", flags)
        _compat.compile_form(ufl.dot(u, u) * ufl.dx)
    assert names[0] != names[1] == names[2]


def test_another_processor_has_other_flags(monkeypatch):
    monkeypatch.setenv("TURBINE_FENICSX_CFLAGS", "-march=native -O2")
    here = form_cache.read_extra_flags()
    assert here[:2] == ["-march=native", "-O2"] and here == form_cache.read_extra_flags()
    other = "model name : another\nflags : fpu sse2\n"
    monkeypatch.setattr(form_cache, "describe_processors", lambda: other)
    there = form_cache.read_extra_flags()
    assert there[:2] == here[:2] and there[2] != here[2]
    monkeypatch.setenv("TURBINE_FENICSX_CFLAGS", "-march=x86-64-v3")
    assert form_cache.read_extra_flags() == ["-march=x86-64-v3"]


KILLED = textwrap.dedent(
    """
    from mpi4py import MPI
    import ufl
    from dolfinx import fem, mesh
    from turbine_fenicsx import _compat
    cube = mesh.create_unit_cube(MPI.COMM_WORLD, 2, 2, 2, mesh.CellType.hexahedron)
    u = fem.Function(_compat.vector_space(cube, 1))
    _compat.compile_form(ufl.dot(u, u) * ufl.dx)
    print("done")
    """
)


def test_a_process_killed_while_it_compiles_does_no_harm(comm, tmp_path):
    """With the real compiler: the first process hangs in it and is killed, two others go on."""
    if comm.size > 1:
        pytest.skip("starts processes")
    compiler = tmp_path / "cc"
    compiler.write_text("#!/bin/sh\ntouch $XDG_CACHE_HOME/called\nsleep 60\n")
    compiler.chmod(0o755)
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}
    command = [sys.executable, "-c", KILLED]
    first = subprocess.Popen(command, env=environment | {"CC": str(compiler)}, process_group=0)
    while not (tmp_path / "called").exists():
        assert first.poll() is None
        time.sleep(0.05)
    os.killpg(first.pid, signal.SIGKILL)
    first.wait()
    (folder,) = tmp_path.glob("fenics/turbine_fenicsx/forms")
    assert any(
        not (folder / f"{name}.cached").exists() for name in os.listdir(folder) if name[-1] == "c"
    )
    later = [subprocess.Popen(command, env=environment, stdout=subprocess.PIPE) for _ in range(2)]
    assert [process.communicate(timeout=100)[0] for process in later] == [b"done\n"] * 2


def test_flags_with_an_open_quotation_are_a_sentence(monkeypatch):
    monkeypatch.setenv(form_cache.EXTRA_FLAGS, "-O3 '-g")
    with pytest.raises(CompilationError, match=r"TURBINE_FENICSX_CFLAGS = .*: no closing quot"):
        form_cache.read_extra_flags()
