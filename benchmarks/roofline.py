"""What the kernels of the residual cost, against what the processor can do: a roofline in numbers.

``roofline.py [KIND ...]`` of "linear", "quadratic" (hexahedra of solid blades) and "hollow" (blades
of laminates from a windIO file). Operations are counted by running the C code of FFCx with numbers
that count. Its time is that of the processor for cells one after the other; that of whole residuals
is for as many cells at once as registers have lanes, all widths that the processor has. Needs g++.
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

from turbine_fenicsx import StepTimes, _compat
from turbine_fenicsx.foundation import vectorise
from turbine_fenicsx.foundation.form_cache import describe_processors
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import build_turbine

KINDS = {
    "linear": {"mesh": {"elements": [6, 6, 72]}},
    "quadratic": {"mesh": {"elements": [3, 3, 36], "degree": 2}},
    "hollow": {
        "turbine": {"file": "IEA-15-240-RWT.yaml"},
        "mesh": {"span": 20, "around": 24},
        "blade": {"damping": 0},
    },
}
WIDTHS = vectorise.REGISTERS[vectorise.find_registers(describe_processors()) :]
"""Registers of this processor."""
HEAD = """static void tabulate(double* restrict A, const double* restrict w,
    const double* restrict c, const double* restrict coordinate_dofs,
    const int* restrict entity_local_index, const uint8_t* restrict quadrature_permutation)
"""


def residual_of(kind):
    """The C code of the residual, nodes of a cell, and seconds of a cell for `WIDTHS`."""
    system = build_turbine(Case.parse(KINDS[kind]), MPI.COMM_SELF).system
    block, state = system.flexible_models[0], system.initial_state()
    paths, compile_it = [], _compat.compile_form_with_source

    def note(form):
        compiled, path = compile_it(form)
        paths.append(path)
        return compiled, path

    _compat.compile_form_with_source = note
    bodies = [body_with(block, width) for width in WIDTHS]
    _compat.compile_form_with_source = compile_it
    du, R = block.new_vector(), block.new_vector()
    seconds = np.full((15, len(bodies)), np.inf)
    for body in bodies:
        body.start_step(state.u[0], state.v[0], StepTimes.from_start(0.0, 0.01), np.zeros(3))
    for turn, k in np.ndindex(seconds.shape):
        start = time.process_time()
        for _ in range(3):
            bodies[k].residual(du, R)
        seconds[turn, k] = (time.process_time() - start) / 3.0
    mesh = block.body.mesh
    X = mesh.geometry.x[_compat.nodes_of_cells(mesh)[0]]
    cells = mesh.topology.index_map(3).size_local
    return paths[0].read_text(encoding="utf-8"), X, seconds.min(axis=0) / cells


def body_with(block, width):
    """The step of a body with registers of one width."""
    find, number = vectorise.find_registers, vectorise.REGISTERS.index(width)
    vectorise.find_registers = lambda _: number
    body = FlexibleStep(block)
    vectorise.find_registers = find
    return body


def run_kernel(code, X, folder, width=vectorise.REGISTERS[-1]):
    """What `roofline.cpp` prints for the code: counts and speeds.

    Args:
        code: C code of FFCx.
        X: Nodes of a cell.
        folder: Where to compile.
        width: Registers that the peak is measured with; the kernel takes the flags of the package.
    """
    kernel = HEAD + next(vectorise.find_kernels(code))
    text = (
        (HERE / "roofline.cpp").read_text(encoding="utf-8").replace("\nKERNEL\n", f"\n{kernel}\n")
    )
    source, program, points = folder / "kernel.cpp", folder / "kernel", folder / "X"
    source.write_text(text, encoding="utf-8")
    np.savetxt(points, X)
    more_w = 1 + max(int(n) for n in re.findall(r"\bw\[\(?(\d+)", kernel)) + 3 * 27
    target = [f"-m{word}" for word in width.target.split(",") if word]
    numbers = []
    for more in (["-DCOUNT", "-O1"], [*_compat._COMPILER_FLAGS, *target]):
        command = ["g++", *more, f"-DWIDTH_W={more_w}", f"-DLANES={width.lanes}", str(source)]
        subprocess.run([*command, "-o", str(program)], check=True)
        done = subprocess.run([program, points], check=True, capture_output=True, text=True)
        numbers += [float(word) for word in done.stdout.split()]
    return numbers


def main():
    head = ("residual", "operations of a cell", "bytes", "operations / byte", "kernel [us]")
    head += ("lanes", "whole residual [us]", "Gop/s", "of the peak")
    print(f"| {' | '.join(head)} |\n| --- |{' ---: |' * (len(head) - 1)}")
    peaks = {}
    for kind in sys.argv[1:] or KINDS:
        code, X, seconds = residual_of(kind)
        alone = ""
        for width, cell in zip(reversed(WIDTHS), reversed(seconds), strict=True):
            with tempfile.TemporaryDirectory() as folder:
                numbers = run_kernel(code, X, Path(folder), width)
            operations, of_w, of_X, of_A, each, peak, triad = numbers
            alone = alone or f"{1e6 * each:.2f}"  # by the instructions that all processors have
            moved = of_w + of_X + 2.0 * of_A
            row = (kind, f"{operations:.0f}", f"{moved:.0f}", f"{operations / moved:.1f}", alone)
            row += (f"{width.lanes}", f"{1e6 * cell:.2f}", f"{1e-9 * operations / cell:.1f}")
            print(f"| {' | '.join(row)} | {operations / cell / peak:.2f} |", flush=True)
            peaks[width.lanes] = f"{1e-9 * peak:.0f} Gop/s with {width.lanes} lanes"
    print(f"\npeak: {', '.join(peaks.values())}; triad {1e-9 * triad:.0f} GB/s")


if __name__ == "__main__":
    main()
