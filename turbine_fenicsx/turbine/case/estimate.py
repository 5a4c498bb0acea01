"""Estimates of unknowns, time, memory and disk of a run, without building anything.

Times are fits to measured ones, see `COST`. They are within a factor of two there, for the
iterative solver of three; another machine is faster or slower by a factor of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, inf, log10

from turbine_fenicsx.meshing.size import MeshSize
from turbine_fenicsx.turbine.case.size import N_BLADES, PLANE_POINTS, size_of_tower
from turbine_fenicsx.turbine.case.tables import Tables

MACHINE = "cores of an AMD EPYC"

MEASURED_RANKS = 2
"""Times of more ranks than this are extrapolated."""

COST = {
    "frozen": (0.005, 4.0e-7, 1.22),
    "iterative": (0.01, 8.8e-7, 1.20),
    "lu": (0.06, 2.8e-7, 1.57),
    "monolithic": (0.06, 3.1e-7, 1.57),
}
"""Seconds per step are a + b N^c for N displacements and a tolerance of 1e-12: a, b, c.

Fitted to measurements on the machine above with 1053, 11025, 70713 and 220545 displacements: 0.006,
0.035, 0.33 and 1.3 s ("frozen"); -, 0.06, 0.59 and 2.2 s ("iterative"); 0.07, 0.6, 11 s and -
("lu"). Fields are written every fifth step.
"""

START = {"undeformed": 0.0, "equilibrium": 3.0, "turning": 9.0}
"""How long the start takes, in steps of the solver "lu", which factorises as often."""

RIGID_STEP = 0.0026
"""Seconds per step of the rigid turbine."""

RIGID_STEP_IN_WIND = 0.006, 1.8e-5
"""The same in wind, and for each station of a blade: 5 ms without a controller, 9 ms with one in
turbulence and 50 stations."""

WALLS = 2.9
"""Time of a step of hollow blades over that of other cells: longer rows, and twice as many
iterations. Measured with 19 287, 37 755 and 80 199 displacements of the IEA 15 MW turbine: 0.14,
0.22 and 0.54 s of the processor at rated speed with 4 iterations per step; 0.5 s with 37 755 and 9
while its blades pitch."""

ALONE = 0.09
"""Share of a step that several ranks do not share, from 1.83 times the speed on two ranks."""

VERTEX = 400.0
"""Memory of a vertex, or a cell, while a mesh is made [B]."""

BASES = 5.0
"""Vectors that are kept for each mode: of the iteration, and of the modes at two speeds."""

CHECKPOINT = 5.0
"""Numbers that a checkpoint keeps for each displacement."""

ROW, ROW_OF_WIND, ROW_OF_CONTROL = 700.0, 170.0, 240.0
"""Both time series together, and what wind and a controller add to them [B/step]."""

SURFACES = {"hybrid": (1584, 1488), "rigid": (3528, 3360)}
"""Points and faces of the pictures of the rigid parts in the field output."""


@dataclass(frozen=True)
class Estimate:
    """What a run will take.

    Args:
        unknowns: Number of unknowns by block, named as in ``summary.json``.
        exact: Whether these are counted.
        linear_solver: The linear solver that will be used.
        steps: Number of steps.
        step_seconds: Wall time per step [s].
        set_up_seconds: Wall time before the first step [s].
        memory: Memory of all ranks [B].
        disk: Size of the output folder [B].
        ranks: Number of ranks.
    """

    unknowns: dict[str, int]
    exact: bool
    linear_solver: str
    steps: float
    step_seconds: float
    set_up_seconds: float
    memory: float
    disk: float
    ranks: int = 1

    @property
    def seconds(self) -> float:
        """Wall time of the run [s]."""
        return self.set_up_seconds + self.steps * self.step_seconds

    def describe_shortage(self, available: float) -> str:
        """A sentence if the run needs more memory than there is, else nothing.

        Args:
            available: Memory of the machines [B].
        """
        if self.memory <= available:
            return ""
        direct = self.linear_solver != "iterative"
        way_out = '; solver.linear_solver = "iterative" needs less' if direct else ""
        return (
            f"the run needs about {in_bytes(self.memory)} of memory, this machine has "
            f"{in_bytes(available)}{way_out}"
        )

    def __str__(self) -> str:
        """A few lines for people."""
        about = "" if self.exact else "about "
        blocks = ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in self.unknowns.items())
        factor = "three" if self.linear_solver == "iterative" else "two"
        ranks = f"{self.ranks} rank{'s' * (self.ranks > 1)}"
        each = f", {in_bytes(self.memory / self.ranks)} on each rank" if self.ranks > 1 else ""
        sure = f"within a factor of {factor} on {MACHINE}"
        if self.ranks > MEASURED_RANKS:
            sure = f"extrapolated from measurements on {MEASURED_RANKS} ranks"
        return "\n".join(
            [
                f"unknowns: {about}{sum(self.unknowns.values())} ({blocks})",
                f"linear solver: {self.linear_solver}",
                f"run time: about {_format_time(self.seconds)} for {self.steps:.7g} steps of "
                f"{_format_time(self.step_seconds)} on {ranks}, {sure}",
                f"memory: about {in_bytes(self.memory)}{each}; disk: about {in_bytes(self.disk)}",
            ]
        )


def estimate(
    case: Tables, size: MeshSize | None, ranks: int = 1, available: float = inf
) -> Estimate:
    """Estimate what a case will take; what components of a user's own add is not counted.

    Args:
        case: The case.
        size: Size of the mesh of its blades; None for the rigid turbine.
        ranks: Number of ranks.
        available: Memory that they may use [B], by which "auto" chooses.
    """
    from turbine_fenicsx.linear_solvers import memory

    tower = size_of_tower(case.tower) if case.tower.flexible else None
    meshes = [mesh for mesh in (size, tower) if mesh]
    n_pitch = N_BLADES if case.pitch.bearings or size is None else 0
    n_bodies, n_joints = 2 + n_pitch + (1 if tower else 0), 2 + n_pitch
    n_drives = n_pitch if case.pitch.drive == "prescribed" else 0
    shared = size is not None and memory.shares_factor(size, ranks)
    displacements = sum(3 * mesh.nodes for mesh in meshes)
    name: str = case.solver.linear_solver
    if name == "auto":
        name = memory.choose_by_memory(meshes, ranks, shared, available)
    constant, factor, power = COST[name]
    digits = -log10(case.solver.tolerance)
    hollow = size is not None and bool(case.turbine.file or case.blade.wall)
    step = (constant + factor * displacements**power) * (0.7 + 0.3 * max(digits - 8.0, 0.0) / 4.0)
    step *= WALLS if hollow else 1.0
    set_up = 1.5 + 4.0 * (displacements / 7e4) ** 1.2
    a, b, c = COST["lu"]
    set_up += START[case.time.start] * (a + b * displacements**c)
    share = ALONE + (1.0 - ALONE) / ranks
    if not meshes:
        step, set_up, share = RIGID_STEP, 1.0, 1.0
        if case.wind.blows:
            a, b = RIGID_STEP_IN_WIND
            step = a + b * case.aero.stations
    at_once = case.time.start == "undeformed"  # else a factor is needed
    steps = float(ceil(case.time.end / case.time.step * (1.0 - 1e-9)))
    fields = _field_bytes(case, "hybrid" if size else "rigid", meshes, steps)
    row = ROW + ROW_OF_WIND * case.wind.blows + ROW_OF_CONTROL * (case.control.kind != "none")
    return Estimate(
        {
            "displacements": displacements,
            "coupling_multipliers": sum(3 * mesh.root_nodes for mesh in meshes),
            "rigid_coordinates": 12 * n_bodies,
            "joint_angles": n_joints,
            "rigid_and_joint_multipliers": 6 * n_bodies + (5 + 1) * n_joints + n_drives,
        },
        all(mesh.exact for mesh in meshes),
        name,
        steps,
        step * share,
        set_up * share,
        memory.estimate_memory(name if at_once else "lu", meshes, ranks, shared),
        fields + row * steps + checkpoint_bytes(displacements),
        ranks,
    )


def checkpoint_bytes(displacements: int) -> float:
    """Size of the two checkpoints that are kept [B]."""
    return 2.0 * (8.0 * CHECKPOINT * displacements + 12e3)


def mesh_memory(size: MeshSize) -> float:
    """Memory of the rank that makes a mesh [B]."""
    from turbine_fenicsx.linear_solvers.memory import PROGRAM

    return PROGRAM + VERTEX * max(size.vertices, size.cells)


def estimate_modes_memory(case: Tables, size: MeshSize | None, ranks: int, count: int) -> float:
    """Memory of all ranks that modes of a case need, with their direct solver [B].

    Args:
        case: The case.
        size: Size of the mesh of its blades; None for the rigid turbine.
        ranks: Number of ranks.
        count: Number of modes.
    """
    direct = case.model_copy(
        update={"solver": case.solver.model_copy(update={"linear_solver": "lu"})}
    )
    needed = estimate(direct, size, ranks)
    return needed.memory + 8.0 * needed.unknowns["displacements"] * BASES * (count + 20)


def _field_bytes(case: Tables, model: str, meshes: list[MeshSize], steps: float) -> float:
    """Size of the field output of a run [B]."""
    every = case.output.fields_every
    if every == 0.0:
        return 0.0
    points, faces = SURFACES[model]
    cells, topology = faces, 6 * 4 * faces
    for mesh in meshes:
        points, cells = points + mesh.vertices, cells + mesh.cells
        topology += 4 * mesh.cells * ((8 if mesh.cell == "hexahedron" else 4) + 2)
    outputs = 1.0 + ceil(min(case.time.end / every * (1.0 - 1e-9), steps))
    topology += 4 * points  # what is coupled to what
    # coordinates in double precision, displacement, velocity; two stresses, fibre
    one = points * (24 + 12 + 12) + cells * (4 + 4 + 12) + 1900
    if case.wind.blows:
        lines, squares = N_BLADES * (case.aero.stations - 1), (PLANE_POINTS - 1) ** 2
        topology += 4 * (4 * lines + 5 * squares + lines + squares)  # and the part of each cell
        # coordinates in double precision, loads and wind
        one += (N_BLADES * case.aero.stations + PLANE_POINTS**2) * (24 + 12 + 12) + 1300
    return float(outputs * one + topology)


def _format_time(seconds: float) -> str:
    """A time with a unit that suits it."""
    for limit, divisor, unit in (
        (1.0, 1e-3, "ms"),
        (120.0, 1.0, "s"),
        (7200.0, 60.0, "min"),
        (172800.0, 3600.0, "h"),
    ):
        if seconds < limit:
            return f"{_round(seconds / divisor)} {unit}"
    return f"{_round(seconds / 86400.0)} days"


def in_bytes(size: float) -> str:
    """A size with a unit that suits it."""
    for divisor, unit in ((1e12, "TB"), (1e9, "GB"), (1e6, "MB")):
        if size >= divisor:
            return f"{_round(size / divisor)} {unit}"
    return f"{_round(size / 1e3)} kB"


def _round(number: float) -> str:
    """Two digits, without an exponent where that can be read."""
    return f"{float(f'{number:.1e}'):.6g}"
