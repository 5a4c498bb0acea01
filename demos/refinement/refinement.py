"""How fine must the mesh of a blade be? Hexahedra and tetrahedra, linear and quadratic.

For the paper's blade, clamped at its root, this computes the deflection of its tip under its own
weight across the blade and the first natural frequencies of bending, on finer and finer meshes,
and compares them with the limit of the quadratic hexahedra. A mesh of level n has n x n x 6n
hexahedra, or tetrahedra about as wide as those; the paper's mesh, 2 x 2 x 12, is level 2.

Two errors add up on a coarse mesh, and partly cancel:

- the *shape*: flat faces make a polygon of each elliptic section, so that volume and stiffness are
  missing and the blade bends too far. Quadratic elements on the same flat mesh show this alone;
- *locking*: linear elements cannot bend without shearing, so that the blade is too stiff. Linear
  against quadratic elements on the same flat mesh show this alone.

Linear elements take flat meshes, quadratic ones curved meshes, as the displacement must be able to
do what the shape does. The whole takes some minutes and 5 GB:

    python demos/refinement/refinement.py -o out/refinement
"""

import argparse
import csv
import time
from dataclasses import astuple, dataclass, fields
from pathlib import Path

from mpi4py import MPI

from clamped_blade import ClampedBlade
from refinement_report import markdown, plot

from turbine_fenicsx import BladeGeometry
from turbine_fenicsx.meshing import MeshOptions

LEVELS = {"hexahedron": (2, 3, 4, 6, 8, 12), "tetrahedron": (2, 3, 4, 6)}


@dataclass(frozen=True)
class Row:
    """Results on one mesh.

    Attributes:
        cell: "hexahedron" or "tetrahedron".
        degree: Of the displacement.
        geometry_degree: 1 for flat faces, 2 for curved ones.
        level: n.
        unknowns: Number of free displacements.
        volume: Of the mesh, relative to the blade's [-].
        tip: Deflection of the tip [m].
        flap: First natural frequency in the thickness direction [Hz].
        edge: First natural frequency in the chord direction [Hz].
        seconds: Wall time of static solution and modes [s].
    """

    cell: str
    degree: int
    geometry_degree: int
    level: int
    unknowns: int
    volume: float
    tip: float
    flap: float
    edge: float
    seconds: float


def solve(comm, cell, degree, geometry_degree, level):
    """Results on one mesh, see `Row`."""
    options = MeshOptions(cell, geometry_degree, (level, level, 6 * level))
    blade = ClampedBlade(comm, options, degree)
    start = time.perf_counter()
    tip, modes = blade.deflection(), blade.frequencies()
    seconds = time.perf_counter() - start
    volume = blade.volume / BladeGeometry().volume
    numbers = blade.unknowns, volume, tip, modes.flap, modes.edge, seconds
    return Row(cell, degree, geometry_degree, level, *numbers)


def solve_all(comm, levels=LEVELS):
    """Rows of all meshes: linear, quadratic on the same flat mesh, quadratic and curved.

    The finest hexahedra are not taken flat and quadratic, which saves a fourth of the time.
    """
    for cell, numbers in levels.items():
        for degree, geometry_degree in ((1, 1), (2, 1), (2, 2)):
            costly = cell == "hexahedron" and (degree, geometry_degree) == (2, 1)
            for level in numbers[:-1] if costly else numbers:
                yield solve(comm, cell, degree, geometry_degree, level)


def write(rows, path):
    """Write rows as CSV."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([field.name for field in fields(Row)])
        writer.writerows(astuple(row) for row in rows)


def read(path):
    """Rows of a CSV file."""
    with path.open(newline="", encoding="utf-8") as file:
        _, *lines = csv.reader(file)
    kinds = {"str": str, "int": int, "float": float}
    types = [kinds[getattr(field.type, "__name__", field.type)] for field in fields(Row)]
    return [Row(*(kind(x) for kind, x in zip(types, line, strict=True))) for line in lines]


def main(arguments=None):
    """Compute, or read what was computed before, and write CSV, table and picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--out", type=Path, default=Path("out/refinement"), help="folder")
    parser.add_argument("--redraw", action="store_true", help="compute nothing, read the CSV file")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    results = options.out / "refinement.csv"
    if options.redraw:
        rows = read(results)
    else:
        rows = []
        for row in solve_all(MPI.COMM_WORLD):
            rows.append(row)
            print(row, flush=True)
        write(rows, results)
    text = markdown(rows)
    (options.out / "refinement.md").write_text(text, encoding="utf-8")
    plot(rows, options.out / "refinement.png")
    print(text)


if __name__ == "__main__":
    main()
