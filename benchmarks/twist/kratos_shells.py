"""Kratos: large displacements of the shells of a blade, clamped at the root.

The elements have four nodes, those at the corners of the elements of eight, and are corotational
(ShellThickElementCorotational3D4N of Kratos 10.2). Loads keep their direction. Thin skins buckle
near the free tip under a small part of the load, so that walls are stiffer there.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from section_motion import STIFF

TIP = 50.0
"""Times that walls are stiffer beyond the span fraction `STIFF`."""

SLICES = 24
"""Number of slices through a wall."""


@dataclass(frozen=True)
class Quadrilaterals:
    """Shells of four nodes, as `section_motion` wants them.

    Attributes:
        nodes: Shape (n, 3) [m].
        cells: Nodes of each, along the span first, shape (k, 4).
        plies: Materials and thicknesses of each cell, from outside inwards.
        along: Direction of the span in each cell, shape (k, 3).
        rows: Nodes of the skin in each row of nodes, with the lengths that they stand for [m].
        stations: Span fractions of these.
        axis: Points of the axis there [m].
    """

    nodes: np.ndarray
    cells: np.ndarray
    plies: list
    along: np.ndarray
    rows: list
    stations: np.ndarray
    axis: np.ndarray

    @classmethod
    def of(cls, shells):
        """The corners of shells of eight nodes."""
        used, cells = np.unique(shells.cells[:, :4], return_inverse=True)
        rows = []
        for numbers, _ in shells.rows:
            at = np.searchsorted(used, numbers[np.isin(numbers, used)])
            x = shells.nodes[used[at]]
            step = np.linalg.norm(np.roll(x, -1, axis=0) - x, axis=1)
            rows.append((at, 0.5 * (step + np.roll(step, 1))))
        cells = cells.reshape(-1, 4)
        nodes = shells.nodes[used]
        return cls(nodes, cells, shells.plies, shells.along, rows, shells.stations, shells.axis)


def solve(model, materials, forces, factors):
    """Displacements under multiples of forces that rise, shape (m, n, 3) [m].

    They end where no equilibrium is found.

    Args:
        model: The mesh; its first row of nodes is clamped.
        materials: Materials of windIO by name.
        forces: On the nodes, shape (n, 3) [N].
    """
    try:
        import KratosMultiphysics as kratos
        import KratosMultiphysics.ConstitutiveLawsApplication
        import KratosMultiphysics.LinearSolversApplication
        import KratosMultiphysics.StructuralMechanicsApplication as structures
    except ImportError as error:
        raise SystemExit(f"Kratos 10.2 is missing: {error}") from None
    kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)
    whole = kratos.Model()
    part = whole.CreateModelPart("blade", 2)
    pairs = ((kratos.DISPLACEMENT, kratos.REACTION), (kratos.ROTATION, kratos.REACTION_MOMENT))
    for variable in (*sum(pairs, ()), structures.POINT_LOAD, kratos.VOLUME_ACCELERATION):
        part.AddNodalSolutionStepVariable(variable)
    part.ProcessInfo[kratos.DOMAIN_SIZE] = 3
    for k, x in enumerate(model.nodes.tolist(), 1):
        part.CreateNewNode(k, *x)
    _add_cells(kratos, part, model, materials)
    for pair, axis in product(pairs, "XYZ"):
        way, reaction = (_variable(kratos, f"{x.Name()}_{axis}") for x in pair)
        kratos.VariableUtils().AddDof(way, reaction, part)
        for k in model.rows[0][0]:
            part.GetNode(int(k) + 1).Fix(way)
    loaded = np.flatnonzero(np.any(forces != 0.0, axis=1)).tolist()
    for number, k in enumerate(loaded, 1):
        part.CreateNewCondition("PointLoadCondition3D1N", number, [k + 1], part.GetProperties(1))
    strategy = _make_strategy(kratos, part)
    found = []
    for step, factor in enumerate(factors, 1):
        part.CloneTimeStep(float(step))
        part.ProcessInfo[kratos.STEP] = step
        for k in loaded:
            force = kratos.Array3((factor * forces[k]).tolist())
            part.GetNode(k + 1).SetSolutionStepValue(structures.POINT_LOAD, 0, force)
        strategy.Initialize()
        strategy.InitializeSolutionStep()
        strategy.Predict()
        if not strategy.SolveSolutionStep():
            print(f"Kratos finds no equilibrium at {factor:g} of the load", flush=True)
            break
        strategy.FinalizeSolutionStep()
        found.append([list(n.GetSolutionStepValue(kratos.DISPLACEMENT)) for n in part.Nodes])
        print(f"Kratos: {factor:g} of the load", flush=True)
    return np.array(found)


def _variable(kratos, name):
    return kratos.KratosGlobals.GetVariable(name)


def _add_cells(kratos, part, model, materials):
    """Elements with their layers and axes."""
    laws, structures = kratos.ConstitutiveLawsApplication, kratos.StructuralMechanicsApplication
    angles = _find_angles(model)
    tip = model.nodes[model.cells, 2].mean(axis=1) > STIFF * model.nodes[:, 2].max()
    for k, cell in enumerate((model.cells + 1).tolist()):
        properties = part.CreateNewProperties(k + 1)
        layers = kratos.Matrix(SLICES, 9)
        times = TIP if tip[k] else 1.0
        for row, values in enumerate(_slice(model.plies[k], materials, times)):
            for column, value in enumerate(values):
                layers[row, column] = value
        properties.SetValue(structures.SHELL_ORTHOTROPIC_LAYERS, layers)
        properties.SetValue(kratos.CONSTITUTIVE_LAW, laws.LinearElasticOrthotropic2DLaw())
        name = "ShellThickElementCorotational3D4N"
        element = part.CreateNewElement(name, k + 1, cell, properties)
        element.SetValue(_variable(kratos, "MATERIAL_ORIENTATION_ANGLE"), float(angles[k]))


def _make_strategy(kratos, part):
    """Newton's method with a direct solver."""
    from KratosMultiphysics.python_linear_solver_factory import ConstructSolver

    kind = kratos.Parameters('{"solver_type": "LinearSolversApplication.sparse_lu"}')
    strategy = kratos.ResidualBasedNewtonRaphsonStrategy(
        part,
        kratos.ResidualBasedIncrementalUpdateStaticScheme(),
        kratos.ResidualCriteria(1e-12, 1e-5),
        kratos.ResidualBasedBlockBuilderAndSolver(ConstructSolver(kind)),
        30,  # iterations
        False,
        False,
        True,
    )
    strategy.SetEchoLevel(0)
    return strategy


def _slice(stack, materials, times):
    """Slices of equal thickness through a wall, in place of layers.

    Each has the mean stiffness of what it cuts. The stretch of a stack whose layers differ in
    thickness is off by up to 40 % in these elements, and exact where they do not.

    Returns:
        Thickness, angle, density, E1, E2, nu12, G12, G13 and G23 of each.
    """
    ends = np.concatenate([[0.0], np.cumsum([thickness for _, thickness in stack])])
    cuts = np.linspace(0.0, ends[-1], SLICES + 1)
    stiffness = np.array([_stiffness(materials[name]) for name, _ in stack])
    sums = np.vstack([np.zeros(6), np.cumsum(stiffness * np.diff(ends)[:, None], axis=0)])
    whole = np.column_stack([np.interp(cuts, ends, column) for column in sums.T])
    thickness = ends[-1] / SLICES
    for q11, q22, q12, *shear in (times / thickness * np.diff(whole, axis=0)).tolist():
        nu = q12 / q22
        yield (thickness, 0.0, 1.0, q11 - q12 * nu, q22 - q12 * q12 / q11, nu, *shear)


def _stiffness(material):
    """Q11, Q22, Q12 of plane stress, G12, G13, G23."""
    E, G, nu = (np.atleast_1d(material[k]).astype(float) for k in ("E", "G", "nu"))
    E, G = (np.resize(v, 3) for v in (E, G))
    share = 1.0 - nu[0] ** 2 * E[1] / E[0]
    return [E[0] / share, E[1] / share, nu[0] * E[1] / share, *G]


def _find_angles(model):
    """Angles from the first edges of cells to the span, about their normals [rad]."""
    x = model.nodes[model.cells]
    normal = np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    flat = [
        v - np.sum(v * normal, axis=1)[:, None] * normal for v in (x[:, 1] - x[:, 0], model.along)
    ]
    first, along = (v / np.linalg.norm(v, axis=1)[:, None] for v in flat)
    return np.arcsin(np.sum(np.cross(first, along) * normal, axis=1))
