"""One process compiles each form; what keeps a form from being compiled is one sentence."""

import fcntl
import os
import signal
import subprocess
import sys
from contextlib import closing
from importlib.machinery import EXTENSION_SUFFIXES

import pytest
from cffi import VerificationError
from fake_forms import FORM, compiled, files, no_locks, sealed

from turbine_fenicsx.foundation import form_cache
from turbine_fenicsx.foundation.errors import CompilationError
from turbine_fenicsx.foundation.form_cache import compile_on_all
from turbine_fenicsx.foundation.interrupts import catch_signals

pytestmark = pytest.mark.parallel

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


@pytest.fixture
def holder(comm, folder):
    """Another process that compiles a form; ends when it is told so."""
    process = None
    if comm.rank == 0:
        folder.mkdir()
        command = [sys.executable, "-c", HOLDER, str(folder / f".{FORM}.lock")]
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
    assert compile_on_all(comm, folder, compiled)[0] == "code"
    assert f".{FORM}.lock" not in files(folder)


def test_what_was_not_finished_goes_before_the_form_is_compiled(comm, folder):
    """Other forms stay."""
    if comm.rank == 0:
        folder.mkdir()
        compiled(folder, name="libffcx_forms_whole")
        for suffix in (".c", ".o", ".c.~123"):
            (folder / f"{FORM}{suffix}").touch()
    comm.barrier()

    def compile_here(place, claim):
        claim(FORM)
        assert not any(FORM in name for name in files(folder) if comm.rank == 0 and name[0] != ".")
        assert sum("whole" in name for name in files(folder)) == 4
        return compiled(place)

    compile_on_all(comm, folder, compile_here)


def test_nobody_else_compiles_the_form_meanwhile(comm, folder):
    """Other forms can be."""

    def compile_here(place, claim):
        claim(FORM)
        if comm.rank == 0:
            lock = os.open(folder / f".{FORM}.lock", os.O_RDWR)
            with pytest.raises(BlockingIOError):
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            os.close(lock)
            with closing(form_cache.Claim(folder)) as other:
                other("libffcx_forms_2")
                assert other.take()
        return compiled(place)

    compile_on_all(comm, folder, compile_here)


@pytest.mark.parametrize("worth_saying", [0.1, 1000.0])
def test_another_process_is_waited_for_and_that_is_said_once(
    comm, folder, holder, caplog, monkeypatch, worth_saying
):
    """Not if it is a short time, as others take to load what is compiled."""
    monkeypatch.setattr(form_cache, "WORTH_SAYING", worth_saying)
    order = []

    def end():
        order.append("ended")
        holder.kill()

    if comm.rank == 0:
        clock = signal.signal(signal.SIGALRM, lambda *_: end())
        signal.setitimer(signal.ITIMER_REAL, 1.5)
    for name in (FORM, "libffcx_forms_2"):

        def compile_here(place, claim, name=name):
            made = compiled(place, claim, name)
            order.append(name)
            return made

        compile_on_all(comm, folder, compile_here)
    if comm.rank == 0:
        signal.signal(signal.SIGALRM, clock)
        assert order == ["ended", FORM, "libffcx_forms_2"]
        said = [f"waiting for another process to compile into {str(folder)!r}"]
        assert caplog.messages == (said if worth_saying < 1.0 else [])


def test_what_is_compiled_waits_for_nobody(comm, folder, holder, monkeypatch):
    monkeypatch.setattr(form_cache, "WORTH_SAYING", 0.0)
    if comm.rank == 0:
        sealed(folder)
    comm.barrier()
    assert compile_on_all(comm, folder, compiled)[0] == "code"


def test_a_folder_without_locks_is_a_sentence_unless_all_is_there(comm, folder, monkeypatch):
    monkeypatch.setattr(form_cache.fcntl, "flock", no_locks)
    with pytest.raises(CompilationError, match=r"has no locks \(Operation not supported\); XDG_CA"):
        compile_on_all(comm, folder, compiled)
    if comm.rank == 0:
        sealed(folder)
    comm.barrier()
    assert compile_on_all(comm, folder, compiled)[0] == "code"


def test_a_folder_that_everybody_may_write_to_is_refused(comm, folder):
    if comm.rank == 0:
        folder.mkdir()
        folder.chmod(0o777)
    comm.barrier()
    with pytest.raises(CompilationError, match=r"may be written to by everybody \(mode 777.*own$"):
        compile_on_all(comm, folder, compiled)
    comm.barrier()
    if comm.rank == 0:
        folder.chmod(0o775)  # as the umask of many systems makes it
    comm.barrier()
    compile_on_all(comm, folder, compiled)


@pytest.mark.parametrize("what", ["the folder", "the code"])
def test_code_of_another_user_is_refused(comm, folder, what):
    if os.geteuid() != 0:
        pytest.skip("gives files away")
    if comm.rank == 0:
        folder.mkdir()
        library = f"{FORM}{EXTENSION_SUFFIXES[0]}"
        compiled(folder)
        (folder / library).touch()
        os.chown(folder if what == "the folder" else folder / library, 65534, -1)
    comm.barrier()
    with pytest.raises(CompilationError, match=r"belongs to the user .*, not to you; or set XDG_"):
        compile_on_all(comm, folder, compiled)


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

    def compile_here(place, claim):
        if comm.rank == rank % comm.size:
            raise error
        return compiled(place, claim)

    with pytest.raises(CompilationError, match=sentence) as caught:
        compile_on_all(comm, folder, compile_here)
    assert "\n" not in str(caught.value)
    assert not isinstance(caught.value, OSError)  # which is told as trouble with the output


def test_code_cut_short_by_a_power_cut_is_compiled_anew(comm, folder):
    if comm.rank == 0:
        folder.mkdir()
        compiled(folder)
        (folder / f"{FORM}.so").write_text("cut short")
    comm.barrier()

    def compile_here(place, claim):
        code = place / f"{FORM}.so"
        claim(FORM)
        if code.exists() and code.read_text():
            raise ImportError("file too short", path=str(code))
        return compiled(place)

    compile_on_all(comm, folder, compile_here)


def test_a_mistake_in_a_form_stays_what_it_is(comm, folder):
    def compile_here(place, claim):
        raise ValueError("cannot derive")

    with pytest.raises(ValueError, match="cannot derive"):
        compile_on_all(comm, folder, compile_here)


def test_a_missing_compiler_is_named(comm, folder, monkeypatch):
    def compile_here(place, claim):
        raise VerificationError("CompileError: command 'x' failed")

    monkeypatch.setenv("CC", "no-such-compiler -O2")
    with pytest.raises(CompilationError, match="needs a C compiler and there is no 'no-such-comp"):
        compile_on_all(comm, folder, compile_here)


def test_a_folder_that_cannot_be_made_is_a_sentence(comm, shared_tmp_path):
    def compile_here(place, claim):
        (shared_tmp_path / "file" / "forms").mkdir()

    if comm.rank == 0:
        (shared_tmp_path / "file").touch()
    comm.barrier()
    with pytest.raises(CompilationError, match="Not a directory"):
        compile_on_all(comm, shared_tmp_path / "file" / "forms", compile_here)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_compilation_at_once_on_all_ranks(comm, folder, number):
    """Where it would only be noted otherwise."""

    def compile_here(place, claim):
        if comm.rank == 0:
            os.kill(os.getpid(), number)
        return compiled(place, claim)

    with catch_signals(), pytest.raises(KeyboardInterrupt):
        compile_on_all(comm, folder, compile_here)


def test_ranks_with_another_folder_compile_too(comm, shared_tmp_path):
    """As where every computer of a cluster has its own."""
    mine = shared_tmp_path / str(comm.rank)
    mine.mkdir()
    (mine / f"{FORM}.c").touch()  # where somebody was killed

    def compile_here(place, claim):
        claim(FORM)
        assert not (mine / f"{FORM}.c").exists()
        return compiled(place)

    compile_on_all(comm, mine, compile_here)
    assert (mine / f"{FORM}.c.cached").exists()
