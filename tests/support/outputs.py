"""Files as a run writes them, without a run: time series, and fields of a turbine of boxes."""

import csv
import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.rotations import E2, E3, rotation_about
from turbine_fenicsx.records.field_files import open_series
from turbine_fenicsx.records.parts import Part, Parts

ANGLES = ("yaw", "rotor")
HUB_CENTRE = np.array([0.0, 0.0, -5.0])
SPIN = 0.4
"""Of the turbine of boxes about e3 [rad/s]."""
PARTS = Parts(
    (
        Part(0, "nacelle", "nacelle", 0),
        Part(1, "hub", "hub", 0),
        *(Part(1 + k, f"blade_{k}", "blades") for k in (1, 2, 3)),
    ),
    {1: 0, 2: 0, 3: 0},
)
"""Of the turbine of boxes."""


def history(n_tips: int = 3, angles: tuple[str, ...] = ANGLES, n: int = 61) -> dict:
    """Columns of a run: torque up to 3 s, then free rotation with vibrating blades."""
    t = np.linspace(0.0, 12.0, n)
    speed = -1.12 * np.minimum(t / 3.0, 1.0) ** 2
    work = 15e6 * speed**2
    strain = 4e5 * np.sin(6.0 * t) ** 2
    error = 1e-4 * np.sin(40.0 * t)
    momentum = np.outer([0.0, 1e-6, 5e7], speed)
    return {
        "time_[s]": t,
        "kinetic_energy_[J]": work - strain,
        "strain_energy_[J]": strain,
        "potential_energy_[J]": np.full(n, -56e3),
        "total_energy_[J]": work - 56e3 + error,
        "external_work_[J]": work,
        "energy_error_[J]": error,
        **{f"linear_momentum_{i + 1}_[kgm/s]": momentum[i] for i in range(3)},
        **{f"angular_momentum_{i + 1}_[Nms]": momentum[i] for i in range(3)},
        **{f"angle_{name}_[rad]": (i + 1) * speed * t for i, name in enumerate(angles)},
        **{f"tip_deflection_{i + 1}_[m]": np.abs(np.sin(6.0 * t + i)) for i in range(n_tips)},
        **{
            f"tip_{way}_{i + 1}_[m]": a * np.sin(6.0 * t + i)
            for i in range(n_tips)
            for way, a in (("flap", 0.8), ("edge", -0.6))
        },
        **{
            f"root_moment_{i + 1}_{axis}_[Nm]": a * np.sin(6.0 * t + i)
            for i in range(n_tips)
            for axis, a in (("x", 2e5), ("y", 3e6), ("z", 1e3))
        },
        "constraint_error_[-]": np.full(n, 1e-15),
        "newton_iterations": np.full(n, 3),
        "krylov_iterations": np.zeros(n),
        "wall_time_[s]": t,
    }


def write(path: Path, columns: dict, end: str = "") -> Path:
    """Write ``history.csv``, and ``end`` after its last row."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
        file.write(end)
    return path


def turbine(
    path: Path, times: tuple[float, ...] = (0.0, 1.0), bend: float = 2.0, pitch: float = 0.0
) -> Path:
    """Boxes for nacelle and hub and three needles for blades, on a hub that turns.

    The tips bend by ``bend`` times the time [m] along e3, the blades pitch by ``pitch`` times the
    time [rad], stress grows in proportion. The roots are couplings 1 to 3.
    """
    cube = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=float)
    faces = np.array([(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6)])
    hexahedron = np.array([[0, 1, 3, 2, 4, 5, 7, 6]])
    blade = cube * (1.0, 27.0, 0.5) + (0.0, 29.25, 0.0)
    azimuths = [rotation_about(E3, 2.0 * np.pi / 3.0 * k) for k in range(3)]
    points = [2.0 * cube, 2.0 * cube + HUB_CENTRE, *(blade @ R.T + HUB_CENTRE for R in azimuths)]
    cells = [
        ("quadrilateral", np.concatenate([faces, faces + 8])),
        ("hexahedron", np.concatenate([hexahedron + 8 * i for i in (2, 3, 4)])),
    ]
    X = np.concatenate(points)
    distance = np.linalg.norm(X - HUB_CENTRE, axis=1)
    blade_of = np.repeat([0, 0, 1, 2, 3], 8)
    coupling = np.where(distance < 10.0, blade_of, 0)
    part = np.array([0] * 4 + [1] * 4 + [2, 3, 4])
    series = open_series(
        MPI.COMM_SELF,
        path,
        cells=cells,
        n_points=len(X),
        point_data={"coupling": coupling},
        cell_data={"part": part},
        information={"parts": PARTS.to_text()},
    )
    for t in times:
        x = X.copy()
        for k, R in enumerate(azimuths):
            mine = blade_of == k + 1
            turn = rotation_about(R @ E2, pitch * t)
            x[mine] = (X[mine] - HUB_CENTRE) @ turn.T + HUB_CENTRE
            x[mine & (distance > 50.0)] += bend * t * E3
        x[8:] = (x[8:] - HUB_CENTRE) @ turned(t).T + HUB_CENTRE
        stress = 1e7 * t * np.where(part >= 2, part, 0.0)
        fields = {"cauchy_stress_norm": stress, "von_mises_stress": 0.5 * stress}
        series.write(t, x, {"displacement": x - X}, fields)
    return path


def turned(t: float) -> np.ndarray:
    """Rotation of the hub of the turbine of boxes, shape (3, 3)."""
    return rotation_about(E3, SPIN * t)


def read_fields(path: Path) -> dict[float, dict[str, np.ndarray]]:
    """Everything in ``fields.xdmf``: time to arrays by name, without any library."""
    found = {}
    for grid in ElementTree.parse(path).getroot().iter("Grid"):
        if grid.get("Name") != "mesh":
            continue
        arrays = {}
        for part in grid:
            item = part.find("DataItem")
            if item is None:
                continue
            shape = tuple(int(n) for n in item.get("Dimensions").split())
            kind = {"Float": "f", "Int": "i"}[item.get("NumberType")] + item.get("Precision")
            name = "".join(item.itertext()).strip()
            numbers = np.fromfile(
                path.parent / name, kind, math.prod(shape), offset=int(item.get("Seek"))
            )
            arrays[part.get("Name") or part.tag] = numbers.reshape(shape)
        found[float(grid.find("Time").get("Value"))] = arrays
    return found
