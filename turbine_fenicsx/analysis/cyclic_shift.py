"""The cyclic shift of a rotor of N equal blades, and what generates its whirl.

Turned by R, the Nth part of a revolution, the rotor comes to lie on itself, each blade on the next.
A motion y of it is shifted by

    (C y)(x) = R y(R^-1 x),

which permutes nodes and rigid bodies and turns their displacements. The matrix D of the directors
of a body goes to R D Q^T on the body that takes its place; the rotation Q makes the directors at
rest fit. C^N = 1. The eigenvectors of C, with the eigenvalues exp(2 pi i m/N), are the patterns of
cyclic index m. In m = 0 all blades move alike, m = +-1 are those that whirl, and no others reach
the support of the rotor. The real polynomial

    J = 2/N sum_j sin(2 pi j/N) C^j = (C - C^T)/sqrt(3) for N = 3

has the eigenvalues +-i on the patterns m = +-1 and 0 on all others. It is skew, and commutes with
whatever commutes with C. On the motions of a rigid hub it is the rotation by 90 degrees of all that
is normal to the axis, and exp(psi J) is their rotation by psi. For N = 3 this is the multiblade
coordinate transformation, see G. Bir, NREL/CP-500-42553 (2008).
"""

from __future__ import annotations

from dataclasses import dataclass

from petsc4py import PETSc

import numpy as np
from scipy.spatial import cKDTree

from turbine_fenicsx.analysis.turning_frame import TurningFrame, turning_frame
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.rigid_model import RigidModel
from turbine_fenicsx.system.state import State

SAME_PLACE = 1e-5
"""Maximum distance of two nodes or bodies in the same place, relative to their distance from the
axis."""


@dataclass(frozen=True, eq=False)
class CyclicShift:
    """C and J of all that turns, zero on what does not turn.

    Args:
        bodies: C of each flexible body; None for those that do not turn.
        body_generators: J of each flexible body; None for those that do not turn.
        rigid: C of the coordinates of the rigid bodies, shape (n_q, n_q).
        rigid_generator: Their J, shape (n_q, n_q).
    """

    blades: int
    bodies: tuple[PETSc.Mat | None, ...]
    body_generators: tuple[PETSc.Mat | None, ...]
    rigid: Array
    rigid_generator: Array

    def destroy(self) -> None:
        """Free the matrices. Collective."""
        for matrix in (*self.bodies, *self.body_generators):
            if matrix is not None:
                matrix.destroy()


def cyclic_shift(frame: TurningFrame, state: State, blades: int) -> CyclicShift:
    """The cyclic shift of what turns about a joint. Collective.

    Args:
        frame: What turns about which axis.
        state: Where everything is.
        blades: N, at least three.

    Raises:
        ModelError: for fewer than three blades, or if a body has no equal where the shift takes it.
    """
    if isinstance(blades, bool) or not isinstance(blades, int) or blades < 3:
        raise ModelError(
            f"multiblade coordinates need a rotor of three or more equal blades, got {blades!r}: "
            "with two the equations of the whole turbine change with the azimuth"
        )
    R = _turn_by_one(frame, blades)
    models = frame.system.flexible_models
    shifts = tuple(
        _shift_body(model, _find_sources(frame, k, u, blades), R, blades) if turns else None
        for k, (model, u, turns) in enumerate(
            zip(models, state.u, frame.flexible_turns, strict=True)
        )
    )
    C = _shift_rigid(frame, state.q, R, blades)
    J = np.zeros_like(C)
    power = np.eye(len(C))
    for j in range(1, blades):
        power = power @ C
        J += find_weight(j, blades) * power
    generators = tuple(None if s is None else _generator(s, blades) for s in shifts)
    return CyclicShift(blades, shifts, generators, C, J)


def joint_rates(model: RigidModel, state: State) -> Array:
    """The rates of the joint coordinates as a linear function of q', shape (n_T, n_q)."""
    G = model.constraint_jacobian(state.q, state.joint_coordinates)
    rows = G[model.n_constraints : model.n_constraints + model.n_T]
    slopes = np.diag(rows[:, model.n_q :])
    return np.asarray(-rows[:, : model.n_q] / slopes[:, None])


def find_weight(j: int, blades: int) -> float:
    """Factor of C^j in J."""
    return float(2.0 / blades * np.sin(2.0 * np.pi * j / blades))


def _find_sources(frame: TurningFrame, k: int, u: PETSc.Vec, blades: int) -> IntArray:
    """Numbers of the nodes that come to lie on those that this rank owns, -1 for none.

    Args:
        k: Number of the flexible body.
        u: Its displacement.
    """
    model = frame.system.flexible_models[k]
    if model.is_small:
        return _find_copies(frame, model, blades)
    arms, R = frame.body_arms(k, u), _turn_by_one(frame, blades)
    everywhere = np.concatenate(model.comm.allgather(arms))
    reach = np.max(np.linalg.norm(everywhere, axis=1))
    far, sources = cKDTree(everywhere).query(arms @ R)
    found: IntArray = np.where(far > SAME_PLACE * reach, -1, sources)
    return found


def _turn_by_one(frame: TurningFrame, blades: int) -> Array:
    """R, which takes each blade to the next."""
    return rotation_about(frame.axis, 2.0 * np.pi / blades)


def _find_copies(frame: TurningFrame, model: BodyModel, blades: int) -> IntArray:
    """As `_find_sources`: the vectors of one copy come to lie on those of another.

    Copies stand where they are placed, about the axis of the joint before it moves.
    """
    frame = turning_frame(frame.system, frame.joint, frame.speed)
    size, R = model.dense_block // 3, _turn_by_one(frame, blades)
    ends = [  # the origin of each copy, and points one metre along its axes, from the axis
        t - frame.point + np.vstack([np.zeros(3), A.T])
        for A, t in (placement.frame() for placement in model.body.placements)
    ]
    near, found = SAME_PLACE * float(np.max(np.abs(ends))), []
    for place in ends:
        gaps = [float(np.max(np.abs(other @ R.T - place))) for other in ends]
        source = int(np.argmin(gaps)) if min(gaps) <= near else -1
        found.append(source * size + np.arange(size) if source >= 0 else np.full(size, -1))
    sources: IntArray = np.concatenate(found)[: model.n_owned]
    return sources


def _shift_body(model: BodyModel, sources: IntArray, R: Array, blades: int) -> PETSc.Mat:
    """C of a flexible body.

    Args:
        sources: Numbers of the nodes that come to lie on its owned ones, -1 for none.
    """
    comm, total = model.comm, model.size_global
    counts = np.zeros(total, dtype=np.int64)
    np.add.at(counts, sources[sources >= 0], 1)
    if not np.all(comm.allreduce(counts) == 1):
        raise ModelError(
            f"the mesh of {model.body.name!r} does not come to lie on itself when it is turned by "
            f"1/{blades} of a revolution, which multiblade coordinates need: one flexible body "
            f"with {blades} equal blades"
        )
    rows, columns = np.nonzero(R)
    entries = np.bincount(rows, minlength=3)
    indptr = np.concatenate([[0], np.cumsum(np.tile(entries, len(sources)))])
    indices = (3 * sources[:, None] + columns).ravel()
    values = np.tile(R[rows, columns], len(sources))
    size = (3 * len(sources), 3 * total)
    csr = (indptr.astype(PETSc.IntType), indices.astype(PETSc.IntType), values)
    return PETSc.Mat().createAIJ((size, size), csr=csr, comm=comm)


def _shift_rigid(frame: TurningFrame, q: Array, R: Array, blades: int) -> Array:
    """C of the rigid bodies, shape (n_q, n_q)."""
    bodies, arms = frame.system.rigid_bodies, frame.rigid_arms(q)
    turning = [k for k, turns in enumerate(frame.rigid_turns) if turns]
    reach = max((float(np.linalg.norm(arms[k, 0])) for k in turning), default=0.0)
    C, free = np.zeros((q.size, q.size)), list(turning)
    for k in turning:
        place = R @ arms[k, 0]
        near = [
            m
            for m in free
            if np.linalg.norm(arms[m, 0] - place) <= SAME_PLACE * reach
            and np.isclose(bodies[m].mass, bodies[k].mass, rtol=SAME_PLACE)
        ]
        if not near:
            raise ModelError(
                f"rigid body {bodies[k].name!r} has no equal 1/{blades} of a revolution further, "
                "which multiblade coordinates need"
            )
        m = k if k in near else near[0]
        free.remove(m)
        Q = arms[m, 1:] @ R @ arms[k, 1:].T  # rows of arms[:, 1:] are the directors
        C[12 * m : 12 * m + 3, 12 * k : 12 * k + 3] = R
        C[12 * m + 3 : 12 * m + 12, 12 * k + 3 : 12 * k + 12] = np.kron(Q, R)
    return C


def _generator(C: PETSc.Mat, blades: int) -> PETSc.Mat:
    """J of a flexible body, the sum over pairs C^j - (C^j)^T."""
    J, power = None, C.copy()
    for j in range(1, (blades - 1) // 2 + 1):
        back = power.transpose(PETSc.Mat())
        term = power.copy()
        term.axpy(-1.0, back, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        term.scale(find_weight(j, blades))
        if J is None:
            J = term
        else:
            J.axpy(1.0, term, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
            term.destroy()
        following = power.matMult(C)
        for matrix in (back, power):
            matrix.destroy()
        power = following
    power.destroy()
    assert J is not None  # blades >= 3
    return J
