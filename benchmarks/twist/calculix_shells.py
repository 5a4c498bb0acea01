"""CalculiX: shells of a blade, clamped at the root and rigid at the tip.

Composite S8R elements take shear strain as equal in all layers. Layers have no Poisson's ratios
through the wall, so that each has the stiffness of its plane stress.
"""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
from section_motion import STIFF


def solve(shells, materials, loads, folder, held=False):
    """Displacements under each load, shape (number of loads, n, 3) [m].

    Args:
        shells: The mesh; its first row of nodes is clamped.
        materials: Materials of windIO by name.
        loads: Forces on the nodes, shape (n, 3) each [N].
        folder: Where files go.
        held: Whether sections keep their shape in their plane.
    """
    if shutil.which("ccx") is None:
        raise SystemExit("CalculiX is missing (ccx): apt install calculix-ccx")
    folder = Path(folder)
    (folder / "blade.frd").unlink(missing_ok=True)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "blade.inp").write_text(write_input(shells, materials, loads, held))
    environment = dict(os.environ, OMP_NUM_THREADS=str(os.cpu_count()))
    with (folder / "ccx.log").open("w") as log:
        command = ["ccx", "-i", "blade"]
        subprocess.run(command, cwd=folder, stdout=log, stderr=log, env=environment, check=True)
    found = read_displacements(folder / "blade.frd", len(shells.nodes))
    if len(found) < len(loads):
        raise RuntimeError(f"CalculiX found {len(found)} of {len(loads)} solutions, see {log.name}")
    return found


def write_input(shells, materials, loads, held):
    """The input file."""
    text = ["*NODE,NSET=ALL"]
    n = len(shells.nodes)
    text += [f"{k},{x:.10e},{y:.10e},{z:.10e}" for k, (x, y, z) in enumerate(shells.nodes, 1)]
    span = np.linspace(0.0, 1.0, len(shells.whole))
    stiff = [i for i, s in enumerate(span) if s > STIFF]
    between = range(1, stiff[0]) if held else ()
    text += ["*NODE"]
    for i in [*between, stiff[0]]:
        x, y, z = shells.frames[i][0]
        text += [f"{n + 2 * i + k},{x:.10e},{y:.10e},{z:.10e}" for k in (0, 1)]
    used = sorted({material for stack in shells.plies for material, _ in stack})
    for k, cell in enumerate(shells.cells + 1, 1):
        text += [f"*ELEMENT,TYPE=S8R,ELSET=E{k}", f"{k},{','.join(map(str, cell))}"]
        a, b = ",".join(f"{v:.8e}" for v in shells.along[k - 1]), shells.across[k - 1]
        text += [f"*ORIENTATION,NAME=O{k}", a + "," + ",".join(f"{v:.8e}" for v in b)]
    for name in used:
        text += [f"*MATERIAL,NAME=M{used.index(name)}", *_elastic(materials[name])]
    for k, stack in enumerate(shells.plies, 1):
        text += [f"*SHELL SECTION,COMPOSITE,ELSET=E{k}"]
        text += [f"{t:.8e},,M{used.index(name)},O{k}" for name, t in reversed(stack)]
    for i in between:
        text += _hold(shells, i, shells.whole[i], n + 2 * i, warps=True)
    nodes = np.concatenate([shells.whole[i] for i in stiff])
    text += _hold(shells, stiff[0], nodes, n + 2 * stiff[0], warps=False)
    text += ["*BOUNDARY", *(f"{k + 1},1,6" for k in shells.whole[0])]
    for load in loads:
        text += ["*STEP", "*STATIC", "*CLOAD,OP=NEW"]
        for k in np.flatnonzero(np.any(load != 0.0, axis=1)):
            text += [f"{k + 1},{d + 1},{load[k, d]:.10e}" for d in range(3)]
        text += ["*NODE FILE,OUTPUT=2D", "U", "*END STEP"]
    return "\n".join(text) + "\n"


def _elastic(material):
    """Engineering constants; without Poisson's ratios through the wall, as plies are thin."""
    E, G, nu = (np.atleast_1d(material[k]).astype(float) for k in ("E", "G", "nu"))
    E, G = (np.resize(v, 3) for v in (E, G))
    return [
        "*ELASTIC,TYPE=ENGINEERING CONSTANTS",
        f"{E[0]:.6e},{E[1]:.6e},{E[2]:.6e},{nu[0]:.6e},0.,0.,{G[0]:.6e},{G[1]:.6e}",
        f"{G[2]:.6e}",
    ]


def _hold(shells, i, nodes, point, warps):
    """Equations by which nodes move with a row, as one whole or in its plane alone.

    Two further nodes have its translation U and rotation R. With z the normal of the section,
    u - U - R x r = lambda z, and lambda from the third component, or zero.
    """
    origin, axes = shells.frames[i]
    slopes = (axes[2, 0] / axes[2, 2], axes[2, 1] / axes[2, 2]) if warps else (0.0, 0.0, 0.0)
    text = []
    for k in nodes:
        r = shells.nodes[k] - origin
        cross = np.array([[0.0, r[2], -r[1]], [-r[2], 0.0, r[0]], [r[1], -r[0], 0.0]])  # R x r
        for d, slope in enumerate(slopes):
            turn = cross[d] - slope * cross[2]
            terms = [
                (k + 1, d + 1, 1.0),
                (k + 1, 3, -slope),
                (point, d + 1, -1.0),
                (point, 3, slope),
            ]
            terms += [(point + 1, c + 1, -turn[c]) for c in range(3)]
            terms = [t for t in terms if abs(t[2]) > 1e-12]
            text += ["*EQUATION", str(len(terms))]
            lines = [terms[m : m + 4] for m in range(0, len(terms), 4)]
            text += [",".join(f"{p},{c},{v:.10e}" for p, c, v in line) for line in lines]
    return text


def read_displacements(path, count):
    """Displacements of the first nodes in each step of a .frd file, shape (steps, count, 3)."""
    found, reading = [], False
    with Path(path).open() as file:
        for line in file:
            if line.startswith(" -4"):
                reading = line.split()[1] == "DISP"
                if reading:
                    found.append(np.zeros((count, 3)))
            elif line.startswith(" -3"):
                reading = False
            elif reading and line.startswith(" -1"):
                k = int(line[3:13])
                if k <= count:
                    found[-1][k - 1] = [float(line[13 + 12 * d : 25 + 12 * d]) for d in range(3)]
    return np.array(found)
