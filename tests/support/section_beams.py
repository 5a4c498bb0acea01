"""Beams of section matrices on boxes that carry them."""

from functools import cache

from mpi4py import MPI

import numpy as np

from turbine_fenicsx import (
    BeamLine,
    BeamSections,
    Coupling,
    MultibodySystem,
    NodeForce,
    ReducedBody,
    beam_basis,
    box_carrier,
)

COMM = MPI.COMM_WORLD
LENGTH = 10.0


def sections(length=LENGTH, stiffness=None, density=300.0, taper=1.0, viscosity=(0.0,) * 6):
    """A section whose stiffness falls to a part of it at the end, with a centre of mass aside."""
    C = np.diag([3.0e7, 2.0e7, 6.0e7, 4.0e5, 9.0e5, 2.5e5]) if stiffness is None else stiffness
    M = np.zeros((6, 6))
    M[range(6), range(6)] = density * np.array([1.0, 1.0, 1.0, 0.01, 0.04, 0.05])
    M[2, 4] = M[4, 2] = -density * 0.03
    M[2, 3] = M[3, 2] = density * 0.02
    M[3, 4] = M[4, 3] = -density * 0.004
    parts = np.array([1.0, taper])[:, None, None]
    return BeamSections([0.0, length], parts * C, parts * M, viscosity)


def bent_line(count=41):
    """An axis with prebend and sweep, twisted."""
    s = np.linspace(0.0, 1.0, count)
    points = np.column_stack([0.4 * s**2, -0.3 * s**3, LENGTH * s])
    angle = 0.3 * (1.0 - s)
    c, n, z = np.cos(angle), np.sin(angle), 0.0 * s
    return BeamLine(s, points, np.stack([np.stack([c, n, z], 1), np.stack([-n, c, z], 1)], 1))


@cache
def carried(line="straight", elements=4, degree=3, ends=1, hold=0.01, alone=False, **kind):
    """A beam's carrier and its basis, held at no end, at the start or at both."""
    line = bent_line() if line == "bent" else BeamLine.straight(LENGTH)
    comm = MPI.COMM_SELF if alone else COMM
    box = box_carrier("beam", line, (0.4, 0.2), 2 * elements * degree, comm)
    held = (box.start, box.end)[:ends]
    basis = beam_basis(
        box.carrier, line, sections(line.length, **kind), elements, degree, *held, hold=hold
    )
    return box, basis


def clamped_beam(*more, **kind):
    """The beam on the ground at its start, and parts that are made for it."""
    box, basis = carried(**kind)
    body = ReducedBody("beam", box.carrier, basis)
    parts = [part for make in more for part in make(body)]
    held = [Coupling("start", body, box.start, None)]
    if len(basis.origins) == 2:
        held.append(Coupling("end", body, box.end, None))
    return MultibodySystem(box.carrier.mesh.comm, [body, *held, *parts])


def pull_end(force):
    """Quarters of a force at the corners of the last section."""

    def make(body):
        X = body.basis.points
        tip = X[np.argsort(-X[:, 2])[:4]]
        quarter = tuple(np.asarray(force) / 4.0)
        return [
            NodeForce(f"pull {k}", body, point=p, force=quarter, function=lambda t: t)
            for k, p in enumerate(tip)
        ]

    return make


def move_axis(state, basis, place=-1):
    """Displacement of the axis at the last section [m]."""
    X = basis.points
    rows = basis.functions[np.argsort(-X[:, 2])[:4]].mean(axis=0)
    return rows @ state.u[0].array.reshape(-1, 3)
