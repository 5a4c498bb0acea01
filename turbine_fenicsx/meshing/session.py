"""A gmsh session for one task, closed without a trace."""

import signal
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from turbine_fenicsx.meshing.errors import MeshError

# Silent, and the same mesh on every call: one thread.
_OPTIONS = {"General.Terminal": 0.0, "General.NumThreads": 1.0}
_MODEL = "turbine_fenicsx"


@contextmanager
def gmsh_session(options: Mapping[str, float] | None = None) -> Iterator[Any]:
    """Give access to gmsh with an empty model, on the calling rank only.

    On leaving, gmsh is as it was before: closed if it was closed, else with the previous model
    and options. Configuration files of the user are not read.
    """
    with keep_interrupts():
        gmsh = _import_gmsh()
        was_open = is_open(gmsh)
        previous = gmsh.model.getCurrent() if was_open else ""
        if not was_open:
            gmsh.initialize(readConfigFiles=False)
        wanted = {**_OPTIONS, **(options or {})}
        saved = {name: gmsh.option.getNumber(name) for name in wanted}
        try:
            for name, value in wanted.items():
                gmsh.option.setNumber(name, value)
            gmsh.model.add(_MODEL)
            yield gmsh
        except Exception as error:
            if type(error) is Exception:  # gmsh raises nothing more specific
                raise MeshError(f"gmsh reports: {str(error).strip() or 'unknown error'}") from error
            raise
        finally:
            if was_open:
                gmsh.model.setCurrent(_MODEL)
                gmsh.model.remove()
                gmsh.model.setCurrent(previous)
                for name, value in saved.items():
                    gmsh.option.setNumber(name, value)
            else:
                gmsh.finalize()


def _import_gmsh() -> Any:
    """Return the module gmsh or raise MeshError that says how to install it."""
    try:
        import gmsh
    except (ImportError, OSError) as error:  # OSError: the module without its shared library
        raise MeshError(how_to_install(error)) from error
    return gmsh


def how_to_install(error: object) -> str:
    """Return the sentence for those without gmsh."""
    return (
        f"gmsh cannot be loaded ({error}); install it with 'apt install python3-gmsh' or "
        "'pip install gmsh'"
    )


def is_open(gmsh: Any) -> bool:
    """Return whether gmsh is initialised in this process already."""
    if hasattr(gmsh, "isInitialized"):
        return bool(gmsh.isInitialized())
    try:
        return bool(gmsh.model.list())  # an initialised gmsh always has a model
    except Exception:  # the older versions without isInitialized complain only after a finalize
        return False


@contextmanager
def keep_interrupts() -> Iterator[None]:
    """Restore the handler of Ctrl-C, which gmsh replaces when it is imported or initialised."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handler = signal.getsignal(signal.SIGINT)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
