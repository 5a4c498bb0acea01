"""What the kernels of the residual cost, against what the processor can do: a roofline in numbers.

``roofline.py [KIND ...]`` of "linear", "quadratic" (hexahedra of solid blades) and "hollow" (blades
of laminates from a windIO file). Operations are counted by running the C code of FFCx with numbers
that count; its time is that of the processor for cells one after the other, with the flags of the
package and with ``-march=native``. Needs g++.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from mpi4py import MPI

import numpy as np
from competitors import HERE

from turbine_fenicsx import _compat
from turbine_fenicsx.forces import StepTimes
from turbine_fenicsx.foundation import form_cache
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.model import build_turbine

KINDS = {
    "linear": {"mesh": {"elements": [6, 6, 72]}},
    "quadratic": {"mesh": {"elements": [3, 3, 36], "degree": 2}},
    "hollow": {
        "turbine": {"file": "IEA-15-240-RWT.yaml"},
        "mesh": {"span": 20, "around": 24},
    },
}
SIGNATURE = re.compile(r"^void tabulate_tensor_integral_\w+\(.*?^}$", re.DOTALL | re.MULTILINE)
WAYS = {"": (2, []), " -march=native": (8, ["-march=native"])}
"""Numbers in a register, and flags."""


def residual_of(kind):
    """The C code of the residual, nodes of a cell, number of cells, seconds of a residual."""
    made, compile_on_all = [], form_cache.compile_on_all

    def note(comm, folder, compile_here):
        result = compile_on_all(comm, folder, compile_here)
        made.append(folder / f"{result[1].__name__}.c")
        return result

    form_cache.compile_on_all = note
    system = build_turbine(Case.parse(KINDS[kind]), MPI.COMM_SELF).system
    block, state = system.flexible_models[0], system.initial_state()
    body = FlexibleStep(block)
    form_cache.compile_on_all = compile_on_all
    texts = [path.read_text(encoding="utf-8") for path in made]
    code = [t for t in texts if re.search(r"\.rank = 1,", t) and SIGNATURE.search(t)][-1]
    du, R = block.new_vector(), block.new_vector()
    body.begin(state.u[0], state.v[0], StepTimes.from_start(0.0, 0.01), np.zeros(3))
    seconds = []
    for _ in range(15):
        start = time.process_time()
        body.residual(du, R)
        seconds.append(time.process_time() - start)
    mesh = block.body.mesh
    nodes = mesh.geometry.dofmap
    first = nodes.links(0) if hasattr(nodes, "links") else nodes[0]  # DOLFINx up to 0.6
    cells = mesh.topology.index_map(3).size_local
    return code, mesh.geometry.x[first], cells, min(seconds)


def run_kernel(code, X, folder, lanes, flags):
    """What `roofline.cpp` prints for the code: counts and speeds."""
    kernel = re.sub(r"tabulate_tensor_integral_\w+", "tabulate", SIGNATURE.search(code).group())
    text = (
        (HERE / "roofline.cpp").read_text(encoding="utf-8").replace("\nKERNEL\n", f"\n{kernel}\n")
    )
    source, program, points = folder / "kernel.cpp", folder / "kernel", folder / "X"
    source.write_text(text, encoding="utf-8")
    np.savetxt(points, X)
    width = 1 + max(int(n) for n in re.findall(r"\bw\[\(?(\d+)", kernel)) + 3 * 27
    numbers = []
    for more in (["-DCOUNT", "-O1"], [*_compat._COMPILER_FLAGS, *flags]):
        command = ["g++", *more, f"-DWIDTH_W={width}", f"-DLANES={lanes}", str(source)]
        subprocess.run([*command, "-o", str(program)], check=True)
        done = subprocess.run([program, points], check=True, capture_output=True, text=True)
        numbers += [float(word) for word in done.stdout.split()]
    return numbers


def main():
    head = ("residual", "operations of a cell", "bytes", "operations / byte")
    head += ("kernel [us]", "Gop/s", "of the peak", "whole residual [us]")
    last = {}
    print(f"| {' | '.join(head)} |\n| --- |{' ---: |' * (len(head) - 1)}")
    for kind in sys.argv[1:] or KINDS:
        code, X, cells, seconds = residual_of(kind)
        for words, (lanes, flags) in WAYS.items():
            with tempfile.TemporaryDirectory() as folder:
                numbers = run_kernel(code, X, Path(folder), lanes, flags)
            operations, of_w, of_X, of_A, each, peak, triad = numbers
            moved = of_w + of_X + 2.0 * of_A
            cell = f"{1e6 * seconds / cells:.2f}" if not flags else ""
            row = (f"{kind}{words}", f"{operations:.0f}", f"{moved:.0f}")
            row += (f"{operations / moved:.1f}", f"{1e6 * each:.2f}")
            row += (f"{1e-9 * operations / each:.1f}", f"{operations / each / peak:.2f}", cell)
            print(f"| {' | '.join(row)} |", flush=True)
            last[words] = f"{1e-9 * peak:.0f} Gop/s{words}, triad {1e-9 * triad:.0f} GB/s"
    print(f"\npeak: {'; '.join(last.values())}")


if __name__ == "__main__":
    main()
