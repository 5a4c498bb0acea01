"""Kratos: the clamped blades with total Lagrangian elements, Newmark's trapezoidal rule."""

from __future__ import annotations

import os
import sys
import time

import KratosMultiphysics as Kratos
import measure
import numpy as np
from KratosMultiphysics import StructuralMechanicsApplication
from KratosMultiphysics.python_linear_solver_factory import ConstructSolver

# Its only direct solver in the PyPI wheel that suits; AMGCL with CG took ten times as long.
SOLVER = """{"solver_type": "LinearSolversApplication.sparse_lu"}"""


def model_part(model, problem):
    """Nodes, elements, material, supports and gravity."""
    data = np.load(problem.arrays)
    part = model.CreateModelPart("blades")
    part.ProcessInfo[Kratos.DOMAIN_SIZE] = 3
    for variable in (
        Kratos.DISPLACEMENT,
        Kratos.VELOCITY,
        Kratos.ACCELERATION,
        Kratos.VOLUME_ACCELERATION,
        Kratos.REACTION,
    ):
        part.AddNodalSolutionStepVariable(variable)
    part.SetBufferSize(2)
    for k, x in enumerate(data["points"], start=1):
        part.CreateNewNode(k, *map(float, x))
    lam, mu = problem.lame
    properties = part.CreateNewProperties(1)
    properties.SetValue(Kratos.DENSITY, problem.density)
    properties.SetValue(Kratos.YOUNG_MODULUS, mu * (3 * lam + 2 * mu) / (lam + mu))
    properties.SetValue(Kratos.POISSON_RATIO, lam / (2 * (lam + mu)))
    law = StructuralMechanicsApplication.LinearElastic3DLaw()
    properties.SetValue(Kratos.CONSTITUTIVE_LAW, law)
    for k, nodes in enumerate(data["hexahedra"], start=1):
        name = "TotalLagrangianElement3D8N"
        part.CreateNewElement(name, k, [int(n) + 1 for n in nodes], properties)
    for component in "XYZ":
        dof = getattr(Kratos, f"DISPLACEMENT_{component}")
        reaction = getattr(Kratos, f"REACTION_{component}")
        Kratos.VariableUtils().AddDof(dof, reaction, part)
    clamped = {int(n) + 1 for n in data["clamped"]}
    gravity = [0.0, -problem.gravity, 0.0]
    for node in part.Nodes:
        node.SetSolutionStepValue(Kratos.VOLUME_ACCELERATION, 0, gravity)
        node.SetSolutionStepValue(Kratos.VOLUME_ACCELERATION, 1, gravity)
        if node.Id in clamped:
            for component in "XYZ":
                node.Fix(getattr(Kratos, f"DISPLACEMENT_{component}"))
        else:  # gravity acts from the beginning
            node.SetSolutionStepValue(Kratos.ACCELERATION, 0, gravity)
    return part, data["tips"]


def strategy(part, problem):
    """Newton's method."""
    linear_solver = ConstructSolver(Kratos.Parameters(SOLVER))
    scheme = Kratos.ResidualBasedNewmarkDisplacementScheme()
    builder = Kratos.ResidualBasedBlockBuilderAndSolver(linear_solver)
    # Of the correction, as Kratos' residual cannot fall much below 1e-6 of its first value.
    criterion = Kratos.DisplacementCriteria(problem.tolerance, 1e-14)
    newton = Kratos.ResidualBasedNewtonRaphsonStrategy(
        part, scheme, criterion, builder, 20, False, False, True
    )
    newton.SetEchoLevel(0)
    newton.Check()
    newton.Initialize()
    return newton


def main():
    problem, args = measure.arguments(threads=1)
    Kratos.ParallelUtilities.SetNumThreads(args.threads)
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    model = Kratos.Model()
    part, tips = model_part(model, problem)
    newton = strategy(part, problem)
    set_up = measure.seconds_since_start()
    steps, iterations = [], []
    for k in range(1, problem.steps + 1):
        t0 = time.perf_counter()
        part.ProcessInfo[Kratos.STEP] = k
        part.ProcessInfo[Kratos.DELTA_TIME] = problem.dt
        part.CloneTimeStep(k * problem.dt)
        newton.InitializeSolutionStep()
        newton.Predict()
        if not newton.SolveSolutionStep():
            sys.exit(f"step {k} did not converge")
        newton.FinalizeSolutionStep()
        steps.append(time.perf_counter() - t0)
        iterations.append(part.ProcessInfo[Kratos.NL_ITERATION_NUMBER])
    nodes = [part.GetNode(int(n) + 1) for n in tips]
    measure.write(
        args.result,
        problem,
        set_up=set_up,
        steps=steps,
        iterations=iterations,
        tips=[n.GetSolutionStepValue(Kratos.DISPLACEMENT) for n in nodes],
        threads=args.threads,
        versions=measure.versions("KratosMultiphysics"),
    )


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)  # the order in which Kratos takes itself down is of no interest here
