"""Processes that compile the same forms at once, some of them killed; a last one must succeed."""

import os
import shutil
import signal
import subprocess
import sys
import time

from tests.attack._runs import ROOT
from tests.attack._tally import Tally

TRIES = 100
FORMS = """
from mpi4py import MPI
from petsc4py import PETSc
import ufl
from dolfinx import fem, mesh
from turbine_fenicsx import _compat
cube = mesh.create_unit_cube(MPI.COMM_WORLD, 2, 2, 2, mesh.CellType.hexahedron)
u = fem.Function(_compat.vector_space(cube, 1))
_compat.compile_form(ufl.dot(u, u) * ufl.dx)
_compat.expression(2.0 * u, _compat.cellwise_space(cube, (3,)))
print("done")
"""


def attack(tries, random, folder):
    """One to three processes die, each some time after the first has begun to compile."""
    tally = Tally()
    for k in range(tries):
        cache = folder / str(k)
        processes = [_start(cache) for _ in range(random.integers(1, 4))]
        while not any(cache.rglob("*.c")) and any(p.poll() is None for p in processes):
            time.sleep(0.01)
        for process in processes:
            time.sleep(random.uniform(0.0, 1.0))
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
        torn = [c for c in cache.rglob("*.c") if not c.with_name(f"{c.name}.cached").exists()]
        last = _start(cache)
        try:
            out, err = last.communicate(timeout=600)
        except subprocess.TimeoutExpired:
            os.killpg(last.pid, signal.SIGKILL)
            out, err = last.communicate()
        if out == "done\n":
            tally.hold("compiled where one had died while compiling" if torn else "compiled")
            shutil.rmtree(cache)
        else:
            tally.break_(f"{cache}: {err[-300:]}")
    return tally


def _start(cache):
    """A process that compiles, with its compilers in a group of its own."""
    return subprocess.Popen(
        [sys.executable, "-c", FORMS],
        env={**os.environ, "XDG_CACHE_HOME": str(cache)},
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        process_group=0,
    )
