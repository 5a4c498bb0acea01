"""NGSolve: the clamped blades, implicit midpoint rule, Newton with its sparse Cholesky.

The form is compiled to C++, which makes its assembly twice as fast; set-up time counts that.
"""

from __future__ import annotations

import os
import sys
import time

import measure
import netgen.meshing as nm
import ngsolve
import numpy as np
from ngsolve import (
    BilinearForm,
    CoefficientFunction,
    Grad,
    GridFunction,
    Id,
    InnerProduct,
    LinearForm,
    Mesh,
    TaskManager,
    Trace,
    VectorH1,
    dx,
)

FACES = np.array(
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
)


def netgen_mesh(problem):
    """The mesh, with the clamped faces as the boundary "root"."""
    data = np.load(problem.arrays)
    mesh = nm.Mesh(dim=3)
    points = [mesh.Add(nm.MeshPoint(nm.Pnt(*x))) for x in data["points"]]
    mesh.Add(nm.FaceDescriptor(bc=1, domin=1, surfnr=1))
    mesh.SetBCName(0, "root")
    is_clamped = np.zeros(len(points), dtype=bool)
    is_clamped[data["clamped"]] = True
    for nodes in data["hexahedra"]:
        mesh.Add(nm.Element3D(1, [points[k] for k in nodes]))
        for face in nodes[FACES]:
            if is_clamped[face].all():
                mesh.Add(nm.Element2D(1, [points[k] for k in face]))
    return Mesh(mesh), data["tips"]


def main():
    problem, args = measure.arguments(threads=1)
    os.environ["PATH"] = f"{os.path.dirname(sys.executable)}:{os.environ['PATH']}"  # its compiler
    ngsolve.SetNumThreads(args.threads)
    mesh, tips = netgen_mesh(problem)
    V = VectorH1(mesh, order=1, dirichlet="root")
    delta, w = V.TnT()
    u, du, dt_v = GridFunction(V), GridFunction(V), GridFunction(V)
    h = 0.5 * problem.dt**2
    rho, (lam, mu) = problem.density, problem.lame
    g = CoefficientFunction((0.0, -problem.gravity, 0.0))

    F = Id(3) + Grad(u) + 0.5 * Grad(delta)
    E = 0.5 * (F.trans * F - Id(3))
    S = lam * Trace(E) * Id(3) + 2.0 * mu * E
    form = BilinearForm(V, symmetric=True)
    form += (
        rho * InnerProduct(delta - dt_v - h * g, w) + h * InnerProduct(F * S, Grad(w))
    ).Compile(True, wait=True) * dx
    terms = LinearForm(rho * InnerProduct(CoefficientFunction((1.0, 1.0, 1.0)), w) * dx)

    free = np.array(list(V.FreeDofs()), dtype=bool)
    steps, iterations = [], []
    with TaskManager(pajetrace=0):
        mass = np.array(terms.Assemble().vec)
        residual, correction = u.vec.CreateVector(), u.vec.CreateVector()
        inverse = None
        set_up = measure.seconds_since_start()
        for _ in range(problem.steps):
            t0 = time.perf_counter()
            du.vec.data = dt_v.vec
            for count in range(20):  # noqa: B007
                form.Apply(du.vec, residual)
                scale = mass * (np.abs(du.vec) + np.abs(dt_v.vec) + h * problem.gravity)
                error = np.linalg.norm(residual.FV().NumPy()[free])
                if error <= problem.tolerance * np.linalg.norm(scale):
                    break
                form.AssembleLinearization(du.vec)
                if inverse is None:
                    inverse = form.mat.Inverse(V.FreeDofs(), inverse="sparsecholesky")
                else:
                    inverse.Update()
                correction.data = inverse * residual
                du.vec.data -= correction
            u.vec.data += du.vec
            dt_v.vec.data *= -1.0  # in two lines: NGSolve evaluates sums in place
            dt_v.vec.data += 2.0 * du.vec
            steps.append(time.perf_counter() - t0)
            iterations.append(count)
    values = np.array(u.vec).reshape(3, -1).T  # component by component
    measure.write(
        args.result,
        problem,
        set_up=set_up,
        steps=steps,
        iterations=iterations,
        tips=values[tips],
        threads=args.threads,
        versions=measure.versions("ngsolve"),
    )


if __name__ == "__main__":
    main()
