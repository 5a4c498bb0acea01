"""CalculiX: the clamped blades with C3D8 or C3D20R elements, direct implicit dynamics.

Hexahedra of 8 nodes are integrated in full, those of 20 in eight points.

The input file asks for *DYNAMIC, DIRECT with ALPHA = 0 (trapezoidal rule, no numerical damping) and
NLGEOM, which makes *ELASTIC a St. Venant-Kirchhoff material; numbers may have 20 characters. The
times per step are the times at which the program appends a line to its .sta file.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import measure
import numpy as np


def rows(values, per_line=15):
    """Numbers as the lines of a set."""
    text = [str(v) for v in values]
    return ",\n".join(",".join(text[k : k + per_line]) for k in range(0, len(text), per_line))


def input_file(problem, tolerance):
    """The text of the .inp file."""
    mesh = np.load(problem.arrays)
    nodes = "\n".join(
        f"{k},{x:.12e},{y:.12e},{z:.12e}" for k, (x, y, z) in enumerate(mesh["points"], start=1)
    )
    hexahedra = mesh["hexahedra"]
    element = {8: "C3D8", 20: "C3D20R"}[hexahedra.shape[1]]
    cells = "\n".join(rows([k, *nodes + 1]) for k, nodes in enumerate(hexahedra, start=1))
    lam, mu = problem.lame
    young, poisson = mu * (3 * lam + 2 * mu) / (lam + mu), lam / (2 * (lam + mu))
    return f"""*NODE, NSET=ALL
{nodes}
*ELEMENT, TYPE={element}, ELSET=BLADES
{cells}
*NSET, NSET=CLAMPED
{rows(mesh["clamped"] + 1)}
*NSET, NSET=TIPS
{rows(mesh["tips"] + 1)}
*BOUNDARY
CLAMPED,1,3
*MATERIAL, NAME=SVK
*ELASTIC
{young:.12e},{poisson:.12e}
*DENSITY
{problem.density}
*SOLID SECTION, ELSET=BLADES, MATERIAL=SVK
*STEP, NLGEOM, INC={10 * problem.steps}
*DYNAMIC, DIRECT, ALPHA=0., SOLVER=SPOOLES
{problem.dt},{problem.dt * problem.steps:.12e}
*CONTROLS, PARAMETERS=FIELD
{tolerance},1.,,,,,1e-12
*DLOAD
BLADES,GRAV,{problem.gravity},0.,-1.,0.
*NODE PRINT, NSET=TIPS, FREQUENCY={problem.steps}
U
*END STEP
"""


def wall_time(_process):
    """Seconds of the clock."""
    return time.perf_counter()


def processor_time(process):
    """Seconds that a process, which nobody has waited for yet, has had of the processor."""
    words = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def watch(command, folder, environment, clock):
    """Run the program; returns the moments at which lines of the .sta file appeared."""
    status, moments, lines = folder / "blades.sta", [], 0
    with open(folder / "log", "w", encoding="utf-8") as log:
        child = subprocess.Popen(command, cwd=folder, stdout=log, stderr=log, env=environment)
        moments.append(clock(child.pid))
        ended = None
        while ended is None:
            time.sleep(0.001)
            ended = os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)
            found = status.read_text().count("\n") if status.exists() else 0
            moments += [clock(child.pid)] * (found - lines)
            lines = found
        child.wait()
    if child.returncode:
        raise RuntimeError((folder / "log").read_text()[-2000:])
    return moments


def main():
    problem, args = measure.arguments(threads=1, clock=["wall", "processor"])
    threads = str(args.threads)
    environment = {**os.environ, "OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": "1"}
    program = shutil.which("ccx")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        text = input_file(problem, problem.tolerance)
        (folder / "blades.inp").write_text(text, encoding="utf-8")
        clock = processor_time if args.clock == "processor" else wall_time
        moments = watch([program, "blades"], folder, environment, clock)
        memory = measure.peak_memory_of_child()
        table = (folder / "blades.sta").read_text().splitlines()
        increments = [line.split() for line in table if line.strip()[:1].isdigit()]
        header = len(table) - len(increments)
        tips = [
            [float(x) for x in line.split()[1:4]]
            for line in (folder / "blades.dat").read_text().splitlines()
            if len(line.split()) == 4
        ][-3:]
    nodes = np.load(problem.arrays)["tips"]
    tips = [tips[k] for k in np.argsort(np.argsort(nodes))]  # printed by node number
    set_up, moments = moments[header] - moments[0], moments[header:]
    libraries = subprocess.run(["ldd", program], capture_output=True, text=True).stdout
    about = subprocess.run([program, "-v"], capture_output=True, text=True).stdout
    measure.write(
        args.result,
        problem,
        set_up=set_up,
        steps=list(np.diff(moments)),
        iterations=[int(row[3]) for row in increments],
        tips=tips,
        threads=args.threads,
        memory=memory,
        blas=measure.loaded_blas(libraries),
        versions={"calculix": about.strip().split()[-1]},
    )


if __name__ == "__main__":
    main()
