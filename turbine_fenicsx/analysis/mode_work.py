"""Who feeds a mode: works of the air, of the structure and of the drive, seen from what turns.

With the motion z exp(s t) in multiblade coordinates, its rate seen from what turns,

    w = s z - Omega J z,    and the energy    2 E = w* . M w + z* . (K + M S^2) z,

every power P of the motion adds -P/(2 E) to the decay, -Re s: the changes F of the air's forces on
nodes, and viscous materials,

    air = -Re(w* . F)/(2 E),    structure = w* . D w/(2 E).

The rest comes through the bearing of a rotor on a support that moves, from what keeps its speed.
Along the blades the air does its work by the changes f and m of the loads on sections j,

    section_j = -Re(w_j* . f_j + omega_j* . m_j)/(2 E),

to which steady loads that turn with the sections add the rest of the whole, below 1 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.air_terms import MOVED, SPEED, AirTerms
from turbine_fenicsx.analysis.cyclic_shift import CyclicShift
from turbine_fenicsx.analysis.linear_system import LinearSystem, quadratic_form
from turbine_fenicsx.analysis.turning_frame import TurningFrame
from turbine_fenicsx.analysis.turning_vectors import TurningVectors
from turbine_fenicsx.foundation.parallel import largest_of_ranks, sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.bound_section_loads import BoundSectionLoads
from turbine_fenicsx.system.state import State


@dataclass(frozen=True, eq=False)
class ModeWork:
    """Parts of the decay of a mode [1/s]; negative for what feeds it.

    Args:
        air: Of all loads on sections.
        sections: For each of these loads of its n sections, shape (n,).
        structure: Of viscous materials.
        drive: Of what keeps the speed.
    """

    air: float
    sections: tuple[Array, ...]
    structure: float
    drive: float


def find_mode_work(
    frame: TurningFrame,
    linear: LinearSystem,
    shift: CyclicShift | None,
    terms: Sequence[AirTerms],
    s: complex,
    a: Array,
    X: Array,
) -> ModeWork:
    """The parts of the decay. Collective.

    Args:
        frame: What turns, about which axis and how fast.
        linear: The system about its steady state.
        shift: The cyclic shift of multiblade coordinates; None for those that turn.
        terms: Of all loads on sections, in the order of bodies and loads.
        s: The eigenvalue [rad/s].
        a: Its sum of motions, complex, shape (m,).
        X: The motions, this rank's rows.
    """
    vectors = TurningVectors(frame, shift)
    z = [X @ a.real, X @ a.imag]
    S_z = [vectors.spin(x) for x in z]
    # velocities in space, and those seen from what turns
    rates = [s.real * z[0] - s.imag * z[1], s.imag * z[0] + s.real * z[1]]
    v = [x + y for x, y in zip(rates, vectors.find_velocities(np.column_stack(z)).T, strict=True)]
    w = [x - y for x, y in zip(v, S_z, strict=True)]
    energy = _sum(linear.mass, linear, w) + _sum(linear.stiffness, linear, z)
    energy -= _sum(linear.mass, linear, S_z)  # z . M S^2 z
    bodies = [linear.vectors.split_rows(np.column_stack(x)) for x in (z, v, w)]
    air, sections, left = 0.0, [], iter(terms)
    for body, model in enumerate(frame.system.flexible_models):
        for loads in model.section_loads:
            t = next(left)
            matrix = s * np.eye(len(t.models)) - t.rates_by_states - t.whirl
            zeta = np.linalg.solve(matrix, (t.rates_by_motion + s * t.rates_by_rate) @ a)
            motion = bodies[0][body], bodies[1][body], bodies[2][body]
            states = np.stack([zeta.real, zeta.imag])
            whole, powers = _find_powers(frame, body, loads, linear.state, motion, states)
            air -= whole / energy
            sections.append(-powers / energy)
    structure = 0.0 if linear.damping is None else _sum(linear.damping, linear, w) / energy
    return ModeWork(air, tuple(sections), structure, -s.real - structure - air)


def _sum(matrix: PETSc.Mat, linear: LinearSystem, parts: Sequence[Array]) -> float:
    """x* . A x of a complex vector by its parts. Collective."""
    y, total = linear.vectors.new_vector(), 0.0
    for x in parts:
        y.array[:] = x
        total += quadratic_form(matrix, y)
    y.destroy()
    return total


def _find_powers(
    frame: TurningFrame,
    body: int,
    loads: BoundSectionLoads,
    state: State,
    motion: tuple[Array, Array, Array],
    zeta: Array,
) -> tuple[float, Array]:
    """Re(w* . F), and Re(w* . f + omega* . m) of each section, shape (n,). Collective.

    Args:
        motion: Displacements of the owned nodes, velocities in space, and those seen from what
            turns, real and imaginary parts in columns, shape (3 n, 2) each.
        zeta: Real and imaginary parts of the states, shape (2, n k).
    """
    u, v = state.u[body].array_r.copy(), state.v[body].array_r.copy()
    steady = loads.find_motion(u, v)
    states, time = loads.states.balance(steady, state.time), state.time
    largest = [
        largest_of_ranks(frame.system.comm, float(np.max(np.abs(x), initial=0.0)))
        for x in motion[:2]
    ]
    size = min(most / x for most, x in zip((MOVED, SPEED), largest, strict=True) if x)
    S = frame.spin if frame.flexible_turns[body] else np.zeros((3, 3))
    total: Array = np.zeros(len(steady.position))
    whole = 0.0
    for y, V, w, change in zip(*(x.T for x in motion), zeta, strict=True):
        change = change.reshape(states.shape)
        (F_1, _), (F_0, _) = (
            loads.respond(u + h * y, v + h * V, time, states + h * change) for h in (size, -size)
        )
        whole += float(w @ (F_1 - F_0)) / (2.0 * size)
        after, before = (loads.find_motion(u + h * y, v + h * V) for h in (size, -size))
        found = [
            loads.states.respond(moved, time, states + h * change)
            for moved, h in ((after, size), (before, -size))
        ]
        f, m = (
            (getattr(found[0], name) - getattr(found[1], name)) / (2.0 * size)
            for name in ("force", "moment")
        )
        moved, turning = (
            (getattr(after, name) - getattr(before, name)) / (2.0 * size)
            for name in ("velocity", "angular_velocity")
        )
        arm = (after.position - before.position) / (2.0 * size)
        turn = (after.axes - before.axes) / (2.0 * size) @ np.swapaxes(steady.axes, 1, 2)
        angle = np.stack([turn[:, 2, 1], turn[:, 0, 2], turn[:, 1, 0]], axis=1)
        total += np.sum((moved - arm @ S.T) * f + (turning - angle @ S.T) * m, axis=1)
    return float(sum_over_ranks(frame.system.comm, np.array([whole]))[0]), total
