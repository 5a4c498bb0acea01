"""One process compiles at a time; what keeps a form from being compiled is one sentence."""

import fcntl
import os
import signal
import subprocess
import sys
import textwrap
import time
from types import SimpleNamespace

import pytest
import ufl
from cffi import VerificationError
from dolfinx import fem, mesh

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation import form_cache
from turbine_fenicsx.foundation.errors import CompilationError
from turbine_fenicsx.foundation.form_cache import compile_on_all
from turbine_fenicsx.foundation.interrupts import catch_signals

HOLDER = """
import fcntl, os, sys
lock = os.open(sys.argv[1], os.O_RDWR | os.O_CREAT, 0o666)
fcntl.flock(lock, fcntl.LOCK_EX)
print("mine", flush=True)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def fresh():
    """What is said once is said once in each test."""
    form_cache._say_once.cache_clear()


@pytest.fixture
def folder(shared_tmp_path):
    return shared_tmp_path / "forms"


def compiled(folder, name="libffcx_forms_1"):
    """What FFCx does: it writes the files of a form and returns the code with its module."""
    for suffix in (".c", ".o", ".so", ".c.cached"):
        (folder / f"{name}{suffix}").touch()
    return "code", SimpleNamespace(__file__=str(folder / f"{name}.abi3.so")), ()


def files(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def holder(comm, folder):
    """Another process that compiles; ends when it is told so."""
    process = None
    if comm.rank == 0:
        folder.mkdir()
        command = [sys.executable, "-c", HOLDER, str(folder / ".lock")]
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert process.stdout.readline() == "mine\n"
    comm.barrier()
    yield process
    if process is not None:
        process.kill()
        process.communicate()


def test_every_rank_gets_the_code(comm, folder):
    assert compile_on_all(comm, folder, lambda: compiled(folder))[0] == "code"


def test_what_was_not_finished_goes_before_anything_is_compiled(comm, folder):
    """Whole forms stay."""
    if comm.rank == 0:
        folder.mkdir()
        compiled(folder, "libffcx_forms_whole")
        for suffix in (".c", ".o", ".c.~123"):
            (folder / f"libffcx_forms_torn{suffix}").touch()
    comm.barrier()

    def compile_here():
        left = files(folder)
        assert not any("torn" in name for name in left)
        assert sum("whole" in name for name in left) == 4
        return compiled(folder)

    compile_on_all(comm, folder, compile_here)


def test_nobody_else_compiles_meanwhile(comm, folder):
    def compile_here():
        if comm.rank == 0:
            lock = os.open(folder / ".lock", os.O_RDWR)
            with pytest.raises(BlockingIOError):
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            os.close(lock)
        return compiled(folder)

    compile_on_all(comm, folder, compile_here)


@pytest.mark.parametrize("seconds", [0.3, 2.0])
def test_another_process_is_waited_for_and_that_is_said_once(comm, folder, holder, caplog, seconds):
    """Not if it is a short time, as others take to load what is compiled."""
    order = []

    def end():
        order.append("ended")
        holder.kill()

    if comm.rank == 0:
        clock = signal.signal(signal.SIGALRM, lambda *_: end())
        signal.setitimer(signal.ITIMER_REAL, seconds)
    for name in ("libffcx_forms_1", "libffcx_forms_2"):
        compile_on_all(comm, folder, lambda name=name: order.append(name) or compiled(folder, name))
    if comm.rank == 0:
        signal.signal(signal.SIGALRM, clock)
        assert order == ["ended", "libffcx_forms_1", "libffcx_forms_2"]
        said = [f"waiting for another process to compile into {str(folder)!r}"]
        assert caplog.messages == (said if seconds > 1.0 else [])


def test_patience_has_an_end_on_all_ranks(comm, folder, holder, monkeypatch):
    monkeypatch.setattr(form_cache, "PATIENCE", 0.2)
    with pytest.raises(CompilationError, match="another process has not finished compiling"):
        compile_on_all(comm, folder, lambda: compiled(folder))


def test_without_locks_only_old_leavings_go(comm, folder, monkeypatch, caplog):
    """They may belong to a process that is at work."""

    def no_lock(file, operation):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(form_cache.fcntl, "flock", no_lock)
    if comm.rank == 0:
        folder.mkdir()
        for name, age in (("libffcx_old.c", form_cache.PATIENCE), ("libffcx_new.c", 60)):
            (folder / name).touch()
            os.utime(folder / name, 2 * (time.time() - age,))
    comm.barrier()
    for _ in range(2):
        compile_on_all(comm, folder, lambda: compiled(folder))
    assert "libffcx_new.c" in files(folder)
    assert "libffcx_old.c" not in files(folder)
    if comm.rank == 0:
        assert len(caplog.messages) == 1
        assert "has no locks (Operation not supported)" in caplog.messages[0]


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (TimeoutError("JIT compilation timed out"), "another process has not finished"),
        (PermissionError(13, "Permission denied"), "Permission denied; XDG_CACHE_HOME names"),
        (OSError(28, "No space left on device"), "No space left on device; XDG_CACHE_HOME"),
        (VerificationError("CompileError: command 'cc' failed"), "cannot compile a form: "),
    ],
)
@pytest.mark.parametrize("rank", [0, -1])
def test_whatever_goes_wrong_is_one_sentence_on_all_ranks(comm, folder, error, sentence, rank):
    """Also where the last rank alone sees it."""

    def compile_here():
        if comm.rank == rank % comm.size:
            raise error
        return compiled(folder)

    with pytest.raises(CompilationError, match=sentence) as caught:
        compile_on_all(comm, folder, compile_here)
    assert "\n" not in str(caught.value)
    assert not isinstance(caught.value, OSError)  # which is told as trouble with the output


def test_code_cut_short_by_a_power_cut_is_compiled_anew(comm, folder):
    if comm.rank == 0:
        folder.mkdir()
        compiled(folder)
        (folder / "libffcx_forms_1.so").write_text("cut short")
    comm.barrier()

    def compile_here():
        code = folder / "libffcx_forms_1.so"
        if code.exists() and code.read_text():
            raise ImportError("file too short", path=str(code))
        return compiled(folder)

    compile_on_all(comm, folder, compile_here)


def test_a_mistake_in_a_form_stays_what_it_is(comm, folder):
    def compile_here():
        raise ValueError("cannot derive")

    with pytest.raises(ValueError, match="cannot derive"):
        compile_on_all(comm, folder, compile_here)


def test_a_missing_compiler_is_named(comm, folder, monkeypatch):
    def compile_here():
        raise VerificationError("CompileError: command 'x' failed")

    monkeypatch.setenv("CC", "no-such-compiler -O2")
    with pytest.raises(CompilationError, match="needs a C compiler and there is no 'no-such-comp"):
        compile_on_all(comm, folder, compile_here)


def test_a_folder_that_cannot_be_made_is_a_sentence(comm, shared_tmp_path):
    def compile_here():
        (shared_tmp_path / "file" / "forms").mkdir()

    if comm.rank == 0:
        (shared_tmp_path / "file").touch()
    comm.barrier()
    with pytest.raises(CompilationError, match="Not a directory"):
        compile_on_all(comm, shared_tmp_path / "file" / "forms", compile_here)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_compilation_at_once_on_all_ranks(comm, folder, number):
    """Where it would only be noted otherwise."""

    def compile_here():
        if comm.rank == 0:
            os.kill(os.getpid(), number)
        return compiled(folder)

    with catch_signals(), pytest.raises(KeyboardInterrupt):
        compile_on_all(comm, folder, compile_here)


def test_ranks_with_another_folder_compile_too(comm, shared_tmp_path):
    """As where every computer of a cluster has its own."""
    mine = shared_tmp_path / str(comm.rank)
    mine.mkdir()
    (mine / "libffcx_forms_1.c").touch()  # where somebody was killed

    def compile_here():
        assert not (mine / "libffcx_forms_1.c").exists()
        return compiled(mine)

    compile_on_all(comm, mine, compile_here)
    assert (mine / "libffcx_forms_1.c.cached").exists()


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
    assert {folder.parts[-2:] for folder in folders} == {("fenics", "turbine_fenicsx")}
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
    (folder,) = tmp_path.glob("fenics/turbine_fenicsx")
    assert any(
        not (folder / f"{name}.cached").exists() for name in files(folder) if name[-1] == "c"
    )
    later = [subprocess.Popen(command, env=environment, stdout=subprocess.PIPE) for _ in range(2)]
    assert [process.communicate(timeout=100)[0] for process in later] == [b"done\n"] * 2


def test_flags_with_an_open_quotation_are_a_sentence(monkeypatch):
    monkeypatch.setenv(form_cache.EXTRA_FLAGS, "-O3 '-g")
    with pytest.raises(CompilationError, match=r"TURBINE_FENICSX_CFLAGS = .*: no closing quot"):
        form_cache.read_extra_flags()
