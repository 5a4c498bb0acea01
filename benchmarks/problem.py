"""The problem that all codes solve: three blades, gravity switched on at t = 0.

It reaches the codes as a JSON file (numbers and paths); ``arrays`` names the mesh as NumPy arrays
for codes that do not read .msh files. This module needs nothing but NumPy until it makes a mesh.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

MATERIALS = {"stiff": (26.0e9, 17.0e9), "soft": (0.975e9, 0.24375e9)}
"""Lambda and mu of St. Venant-Kirchhoff blades [Pa]: glass fibre, and a quarter of eq. (67) of the
paper, so soft that gravity bends the blades by half their length."""

SIZES = {
    "tiny": (2, 2, 12),
    "10k": (4, 4, 48),
    "30k": (6, 6, 72),
    "70k": (8, 8, 96),
    "220k": (12, 12, 144),
    "300k": (14, 14, 148),
    "1.2M": (20, 20, 300),
}
"""Hexahedra of one blade along chord, thickness and span; even, so that a node is at the tip."""


@dataclass(frozen=True)
class Problem:
    """What to solve.

    Args:
        elements: Hexahedra of one blade along chord, thickness and span.
        material: Key of `MATERIALS`.
        steps: Time steps, warm-up included.
        warm_up: Steps that are not counted.
        dt: Time step [s].
        density: Density [kg/m^3].
        gravity: Acceleration along -e2 [m/s^2].
        tolerance: Relative residual to iterate to.
        msh: Mesh as a .msh file.
        degree: Polynomial degree of displacement and cells.
        nodes: Nodes of the mesh; those of trilinear hexahedra of three solid blades if 0.
        tips: Initial positions of the tips, three points [m]; those of the default blades if empty.
        arrays: The same mesh as .npz: ``points`` (n, 3), ``hexahedra`` (m, 8) in the order of
            gmsh and VTK, ``clamped`` nodes, ``tips`` (three nodes).
    """

    elements: tuple[int, int, int]
    material: str = "stiff"
    steps: int = 12
    warm_up: int = 2
    dt: float = 0.02
    density: float = 1500.0
    gravity: float = 9.81
    tolerance: float = 1e-8
    msh: str = ""
    arrays: str = ""
    degree: int = 1
    nodes: int = 0
    tips: tuple[tuple[float, float, float], ...] = ()

    @property
    def unknowns(self) -> int:
        """Displacements of all nodes of the three blades."""
        if self.nodes:
            return 3 * self.nodes
        a, b, c = self.elements
        return 9 * (a + 1) * (b + 1) * (c + 1)

    @property
    def lame(self) -> tuple[float, float]:
        """Lambda and mu [Pa]."""
        return MATERIALS[self.material]

    @property
    def tip_points(self) -> list[np.ndarray]:
        """Initial positions of the three tips [m]."""
        return [np.array(tip) for tip in self.tips] or tip_points()

    def write(self, path: Path) -> Path:
        """Write it for `load`; returns the path."""
        path.write_text(json.dumps(asdict(self), indent=2) + "\n", encoding="utf-8")
        return path

    @staticmethod
    def load(path: str) -> Problem:
        """Read what `prepare` wrote."""
        data = json.loads(Path(path).read_text(encoding="utf-8"))
        return Problem(**{**data, "elements": tuple(data["elements"])})


def parse_size(text: str) -> tuple[int, int, int]:
    """Elements from "8x8x96" or a key of `SIZES`."""
    if text in SIZES:
        return SIZES[text]
    a, b, c = (int(n) for n in text.split("x"))
    return a, b, c


def mesh_case(elements: tuple[int, int, int]) -> dict:
    """Tables of a turbine_fenicsx case with blades of this mesh."""
    return {"mesh": {"elements": list(elements)}}


def write_mesh(elements: tuple[int, int, int], folder: Path) -> tuple[str, str]:
    """Make the mesh of the rotor; returns the paths for ``msh`` and ``arrays``."""
    from turbine_fenicsx.meshing import build_rotor
    from turbine_fenicsx.meshing.read import read_msh
    from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
    from turbine_fenicsx.turbine.case.case import Case

    plan = plan_rotor(Case.parse(mesh_case(elements)))
    layout, name = plan.layout, "x".join(map(str, elements))
    msh = folder / f"{name}.msh"
    build_rotor(plan.blades.geometry, layout, plan.blades.options, msh)
    mesh = read_msh(msh, layout.volume_groups, ())
    roots = [mesh.surfaces[f"root_{k}"] for k in (1, 2, 3)]
    arrays = folder / f"{name}.npz"
    np.savez(
        arrays,
        points=mesh.points,
        hexahedra=mesh.cells,
        clamped=np.unique(mesh.facets[np.isin(mesh.facet_groups, roots)]),
        tips=[np.argmin(np.linalg.norm(mesh.points - x, axis=1)) for x in tip_points()],
    )
    return str(msh), str(arrays)


def prepare(folder: Path, elements: tuple[int, int, int], **more: Any) -> Path:
    """Write mesh and problem; returns the file of the problem.

    Args:
        folder: Where to.
        elements: Hexahedra of one blade.
        more: Other arguments of `Problem`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    msh, arrays = write_mesh(elements, folder)
    problem = Problem(elements, msh=msh, arrays=arrays, **more)
    return problem.write(folder / f"{'x'.join(map(str, elements))}_{problem.material}.json")


def tip_points() -> list[np.ndarray]:
    """Initial positions of the tips of the default blades [m]."""
    from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
    from turbine_fenicsx.turbine.case.case import Case

    return plan_rotor(Case.parse({})).tips


def main() -> None:
    """Prepare a problem by hand: ``problem.py SIZE FOLDER``."""
    parser = argparse.ArgumentParser(description="Write mesh and problem file; prints its path.")
    parser.add_argument("size", type=parse_size, help=f"like 8x8x96, or {', '.join(SIZES)}")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--steps", type=int, default=12)
    parser.add_argument("--material", choices=MATERIALS, default="stiff")
    args = parser.parse_args()
    print(prepare(args.folder, args.size, steps=args.steps, material=args.material))


if __name__ == "__main__":
    main()
