"""Numbers of coordinates and constraints: from bodies, joints and relations to a rigid model.

A constraint Phi that is open at t = 0 would be closed by the first step, with an energy from
nothing. One whose gradient depends there on those of the others, G_r = c G, has no multiplier. It
is redundant if it holds wherever the others do; to second order, for all v with G v = 0,

    v . (Q_r - sum_k c_k Q_k) v = 0

with the second derivatives Q. Else it depends on the others in this one configuration only.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mpi4py import MPI

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.forces.force import BoundForce, Force, Layout
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.own_code import name_errors
from turbine_fenicsx.foundation.quadratic import Quadratic, QuadraticMap
from turbine_fenicsx.foundation.redundancy import find_redundant_rows
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.base import Joint
from turbine_fenicsx.joints.coordinates import JointCoordinate
from turbine_fenicsx.joints.functions import find_functions
from turbine_fenicsx.joints.relation import Relation
from turbine_fenicsx.joints.rheonomic import Rheonomic, function_of
from turbine_fenicsx.system.parts import Parts
from turbine_fenicsx.system.prescribed_rows import Paths, refuse_dependent_paths
from turbine_fenicsx.system.rigid_model import RigidModel

LARGEST_PART = 1e-9
"""Maximum gap of a constraint relative to the sum of its terms, which are lengths or cosines ..."""

ROUND_OFF = 1e-14
"""... and relative to the largest vector among the coordinates, where all its terms are zero."""

CURVATURE = 1e-6
"""Round-off of a curvature, relative to its terms."""

ZERO_FACTOR = 1e-9
"""Factor of a constraint, relative to the largest one, below which it is zero [-]."""


def check_closed(
    constraints: Sequence[Quadratic], owners: Sequence[str], values: Array, q: Array
) -> None:
    """Raise a ModelError for joints that are open.

    Args:
        values: What each of them must be at t = 0, shape (constraints,).
        q: Initial coordinates of all rigid bodies, shape (n_q,).
    """
    gaps = QuadraticMap(constraints, q.size).value(q) - values
    lengths = np.linalg.norm(q.reshape(-1, 3), axis=1)  # of centres and directors
    sizes = np.repeat(lengths, 3)  # a component may be zero up to round-off of the others
    allowed = LARGEST_PART * np.array([_sum_terms(c, sizes) for c in constraints])
    allowed += ROUND_OFF * np.max(lengths, initial=0.0)
    worst: dict[str, int] = {}
    for k in np.flatnonzero(np.abs(gaps) > allowed).tolist():
        best = worst.setdefault(owners[k], k)
        if abs(gaps[k]) > abs(gaps[best]):
            worst[owners[k]] = k
    told = [
        f"{name!r} by {abs(gaps[k]):.3g}{_unit(constraints[k])} (allowed: {allowed[k]:.1g})"
        for name, k in worst.items()
    ]
    if told:
        raise ModelError(
            f"{'these joints are' if len(told) > 1 else 'a joint is'} open in the initial "
            f"configuration, and the first step would snap {'them' if len(told) > 1 else 'it'} "
            f"shut: {', '.join(told)}; move the bodies to where the constraints hold"
        )


def find_singular_rows(
    constraints: Sequence[Quadratic], redundant: npt.NDArray[np.int64], q: Array
) -> list[int]:
    """Those of the redundant constraints that depend on the others in this configuration only.

    Args:
        redundant: Numbers of those that depend on the others.
        q: The configuration, shape (n_q,).
    """
    if not redundant.size:
        return []
    kept = [c for k, c in enumerate(constraints) if k not in redundant]
    functions, rest = (
        QuadraticMap(rows, q.size) for rows in (kept, [constraints[k] for k in redundant])
    )
    G, G_r = functions.jacobian(q), rest.jacobian(q)
    factors = np.linalg.lstsq(G.T, G_r.T, rcond=None)[0].T
    # round-off of zero must not be compared with itself below
    factors[np.abs(factors) < ZERO_FACTOR * np.abs(factors).max(axis=1, keepdims=True)] = 0.0
    free = np.linalg.svd(G)[2][len(G) :].T  # columns v, G v = 0
    found = []
    for row, k in enumerate(redundant.tolist()):
        Q_r = rest.hessian(np.eye(len(G_r))[row])
        curvature = free.T @ (Q_r - functions.hessian(factors[row])) @ free
        size = np.linalg.norm(Q_r) + np.linalg.norm(functions.hessian(np.abs(factors[row])))
        if np.linalg.norm(curvature) > CURVATURE * size:
            found.append(k)
    return found


def _sum_terms(function: Quadratic, q: Array) -> float:
    """Sum of the absolute values of all terms of a function, for q without negative values."""
    total = abs(function.constant) + sum(abs(b) * q[i] for i, b in function.linear)
    return float(total + sum(abs(a) * q[i] * q[j] for i, j, a in function.bilinear))


def _unit(function: Quadratic) -> str:
    """The unit of a function: that of the centres of mass in it, as directors have none."""
    pairs = [(i,) for i, _ in function.linear] + [(i, j) for i, j, _ in function.bilinear]
    power = max((sum(i % 12 < 3 for i in pair) for pair in pairs), default=0)
    return ("", " m", " m^2")[power]


log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Numbering:
    """The rigid part of a system, and which of its rows belong to what.

    Args:
        constraint_owners: Name of what each of `RigidModel.constraint_values` belongs to.
        joint_rows: Rows of `RigidModel.constraint_forces` that belong to each joint, by its name.
        redundant: Number of redundant constraints of each joint that has some, by its name.
    """

    model: RigidModel
    paths: Paths
    joint_coordinate_names: tuple[str, ...]
    constraint_owners: tuple[str, ...]
    joint_rows: Mapping[str, npt.NDArray[np.int64]]
    redundant: Mapping[str, int]
    warnings: tuple[str, ...]


def number_parts(comm: MPI.Intracomm, parts: Parts) -> Numbering:
    """Number joint coordinates, find redundant constraints, bind forces."""
    bodies = parts.rigid_bodies
    frames = {b: BodyFrame(b, 4 * k) for k, b in enumerate(bodies)}
    internal = [(c, b.name) for b, f in frames.items() for c in f.internal_constraints()]
    of_joints, coordinates, of_coordinates = _list_functions(parts.joints, frames)
    n_internal = len(internal)
    given = [c for c, _ in [*internal, *of_joints]]
    owners = [owner for _, owner in [*internal, *of_joints]]
    n_q = 12 * len(bodies)
    layout = Layout(
        {b: 12 * k for k, b in enumerate(bodies)},
        {name: n_q + k for k, name in enumerate(coordinates)},
    )
    q = np.concatenate([np.zeros(0), *(b.coordinates for b in bodies)])
    constraints = [function_of(c) for c in given]
    everything = Paths(comm, given, owners, 0)
    check_closed(constraints, owners, everything.values(0.0), q)
    redundant = find_redundant_rows(QuadraticMap(constraints, q.size).jacobian(q), n_internal)
    refuse_dependent_paths(given, redundant, owners)
    kept = [k for k in range(len(constraints)) if k not in redundant]
    S = _relation_rows(parts.relations, layout, n_q, len(coordinates))
    _check_relations(
        parts.relations, [constraints[k] for k in kept], list(coordinates.values()), S, q
    )
    model = RigidModel(
        np.concatenate([np.zeros(0), *(b.masses for b in bodies)]),
        constraints,
        list(coordinates.values()),
        S,
        [_bind(e, layout) for e in parts.motion_forces],
        redundant,
    )
    of_rows = [owners[k] for k in kept]
    paths = Paths(comm, [given[k] for k in kept], of_rows, len(coordinates))
    of_values = (*of_rows, *of_coordinates, *(owners[k] for k in sorted(redundant.tolist())))
    of_rows += 2 * of_coordinates
    rows = {j.name: np.flatnonzero([name == j.name for name in of_rows]) for j in parts.joints}
    counts = dict(Counter(owners[k] for k in redundant))
    singular = [owners[k] for k in find_singular_rows(constraints, redundant, q)]
    warnings = [
        *_describe_singular(singular),
        *_describe_redundant(counts, len(owners) - n_internal, singular),
        *_describe_velocities(bodies, constraints, everything.rates(0.0), owners, q),
    ]
    return Numbering(model, paths, tuple(coordinates), of_values, rows, counts, tuple(warnings))


def _list_functions(
    joints: Sequence[Joint], frames: Mapping[RigidBody, BodyFrame]
) -> tuple[list[tuple[Quadratic | Rheonomic, str]], dict[str, JointCoordinate], list[str]]:
    """Constraints of joints with the names of these, coordinates, and the joint of each of them."""
    constraints: list[tuple[Quadratic | Rheonomic, str]] = []
    coordinates: dict[str, JointCoordinate] = {}
    owners: list[str] = []
    for joint in joints:
        a, b = (BodyFrame(None) if body is None else frames[body] for body in joint.bodies)
        mine, its_coordinates = find_functions(joint, a, b)
        constraints += [(c, joint.name) for c in mine]
        for name, coordinate in its_coordinates.items():
            if name in coordinates:
                raise ModelError(f"two joint coordinates are called {name!r}")
            coordinates[name] = coordinate
            owners.append(joint.name)
    return constraints, coordinates, owners


def _bind(force: Force, layout: Layout) -> BoundForce:
    """A force with numbered coordinates."""
    with name_errors(f"bind() of {describe(force)}"):
        return force.bind(layout)


def _relation_rows(relations: Sequence[Relation], layout: Layout, n_q: int, n_T: int) -> Array:
    """S, shape (relations, n_T)."""
    S = np.zeros((len(relations), n_T))
    for row, relation in zip(S, relations, strict=True):
        for name, factor in relation.factors.items():
            row[layout.coordinate(name) - n_q] += factor
    return S


def _check_relations(
    relations: Sequence[Relation],
    constraints: list[Quadratic],
    coordinates: list[JointCoordinate],
    S: Array,
    q: Array,
) -> None:
    """Raise a ModelError for a relation that depends on constraints and the other relations."""
    moved = [c[-1] for c in coordinates]  # sine or displacement
    rows = []
    for factors in S:
        row = Quadratic(0.0)
        for factor, function in zip(factors.tolist(), moved, strict=True):
            row = row + factor * function
        rows.append(row)
    gradients = QuadraticMap([*constraints, *rows], q.size).jacobian(q)
    for k in find_redundant_rows(gradients, len(constraints)) - len(constraints):
        raise ModelError(
            f"{relations[k].name!r} depends on the joints and the other relations of joint "
            "coordinates"
        )


def _describe_singular(owners: Sequence[str]) -> list[str]:
    """Warn of constraints that depend on others in the initial configuration only."""
    return [
        f"{owners.count(name)} of the constraints of joint {name!r} locks nothing in the initial "
        "configuration that others do not lock, but does beside it (as a scalar product of two "
        "parallel directions, or a mechanism in a dead centre): steps do not keep it, and fail as "
        "soon as it opens; start a little aside, or say it by other constraints"
        for name in dict.fromkeys(owners)
    ]


def _describe_redundant(
    counts: Mapping[str, int], total: int, singular: Sequence[str] = ()
) -> list[str]:
    """Warn of redundant constraints, except for those that are reported as singular."""
    rest = {name: n - singular.count(name) for name, n in counts.items()}
    rest = {name: n for name, n in rest.items() if n}
    if not rest:
        return []
    return [
        f"{sum(rest.values())} of {total} joint constraints are redundant (in joints "
        f"{', '.join(rest)}): they hold without a multiplier, and the forces in these joints are "
        "one choice of many"
    ]


def _describe_velocities(
    bodies: Sequence[RigidBody],
    constraints: list[Quadratic],
    rates: Array,
    owners: list[str],
    q: Array,
) -> list[str]:
    """Warn of initial velocities that joints do not allow; they would make others alternate."""
    q_dot = np.concatenate([np.zeros(0), *(b.rates for b in bodies)])
    G = QuadraticMap(constraints, q.size).jacobian(q)
    terms = np.abs(G) @ np.abs(q_dot)
    allowed = 1e-9 * np.max(terms, initial=0.0) + 1e-6 * np.abs(rates)
    wrong = np.abs(G @ q_dot - rates) > allowed
    names = dict.fromkeys(owners[k] for k in np.flatnonzero(wrong))
    if not names:
        return []
    return [
        f"the initial velocities of the bodies do not agree with joints "
        f"{', '.join(map(repr, names))}; velocities will alternate from step to step"
    ]
