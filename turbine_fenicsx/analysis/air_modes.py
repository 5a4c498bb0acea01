"""Modes of a turning system in the air: eigenvalues with the states of wake, stall and lift.

Motions are sums z = X a of the m slowest modes of the structure, of unit modal mass, and of its
rotation about the axis. With the matrices of `turning_modes` and the terms of `air_terms`,

    | a   |'   |       0             1         0          | | a    |
    | a'  |  = | X^T F_z - K    X^T F_v - D    X^T F_zeta | | a'   |,
    | zeta|    |     g_z X         g_v X    g_zeta + WJ   | | zeta |    W = Omega,

whose eigenvalues are all found. There are hundreds, most of them of the air. Those of the structure
have a large share of a and a', the sum of the products of left and right eigenvectors: 1 without
states, 0 for states alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.analysis.air_terms import AirTerms, find_air_terms
from turbine_fenicsx.analysis.bordered_solver import FlatVectors
from turbine_fenicsx.analysis.complex_modes import make_mode
from turbine_fenicsx.analysis.cyclic_shift import CyclicShift, cyclic_shift
from turbine_fenicsx.analysis.feedback import Feedback, keep_free
from turbine_fenicsx.analysis.first_order import assemble, solve_first_order
from turbine_fenicsx.analysis.isotropy import check_isotropic
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.modal_filter import ModalFilter, find_left_vector
from turbine_fenicsx.analysis.mode import Mode, Modes
from turbine_fenicsx.analysis.mode_work import ModeWork, find_mode_work
from turbine_fenicsx.analysis.slepc import Pair
from turbine_fenicsx.analysis.slow_motions import (
    find_rotation,
    find_slow_motions,
    multiply,
    project,
)
from turbine_fenicsx.analysis.turning_frame import TurningFrame, turning_frame
from turbine_fenicsx.analysis.turning_modes import turning_problem
from turbine_fenicsx.analysis.turning_vectors import TurningVectors
from turbine_fenicsx.analysis.whirl import WhirlMeter
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import on_rank0, sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.start import check_start
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

MOTIONS = 100
"""Number of modes of the structure whose sums motions are."""

BALANCED, LEAST_STIFFNESS = 1e-2, 1e-6
"""Part that forces may lack of each other, and stiffness of the rotation below which nothing is
compared [1/s^2]."""

VIBRATES = 0.3
"""Least part of an eigenvalue that is frequency; motions of more damping creep back."""

SLOW = 1e-3
"""Growth below which nothing grows, relative to the speed: the angle of the rotor has none."""


@dataclass(frozen=True)
class AirModel:
    """How the air follows motions.

    Args:
        frozen: Models of the air whose states stay as they are, such as ``"wake"``.
        instant: Models whose states are in balance at each moment.
    """

    frozen: tuple[str, ...] = ()
    instant: tuple[str, ...] = ()


def air_modes(
    system: MultibodySystem,
    joint: str,
    speed: float,
    state: State,
    count: int = 12,
    blades: int | None = 3,
    air: AirModel = AirModel(),
) -> Modes:
    """Modes of a system that turns steadily in the air.

    Args:
        system: The system; its loads on sections must come from sources that act on bodies that
            turn, and should know their states (`StateLoad`).
        joint: As in `turning_modes`.
        speed: As in `turning_modes`.
        state: The state of steady rotation, see `turning_equilibrium`. Not changed.
        count: Number of modes.
        blades: As in `turning_modes`.
        air: How the air follows.

    Returns:
        The modes, as of `AirProblem.find`.

    Raises:
        TypeError, ModelError: as `AirProblem` does.

    Note:
        Collective.
    """
    problem = AirProblem(system, joint, speed, state, blades)
    try:
        return problem.find(count, air)
    finally:
        problem.destroy()


class AirProblem:
    """Motions and air about a state of steady rotation.

    Args:
        system: As in `air_modes`.
        joint: As in `air_modes`.
        speed: As in `air_modes`.
        state: As in `air_modes`.
        blades: As in `air_modes`.
        motions: Number of modes of the structure whose sums motions are.
        feedback: A controller that closes a loop around the rotor; None leaves its torque and the
            pitch constant.

    Attributes:
        stiffness: X^T K X, shape (m, m) [1/s^2]. With feedback the pitch is the last motion.
        damping: X^T D X, shape (m, m) [1/s].
        terms: Of the air, for each of the loads on sections.
        generator: The angle of the generator for each of the motions, shape (m,); zero without
            feedback.
        turned: The rotation of what turns as a sum of the motions, of unit modal mass; zero if a
            motor drives it.

    Raises:
        TypeError, ModelError: if the state is not one of this system, or no equilibrium, bodies
            are not reduced, nothing has loads on sections, or multiblade coordinates do not suit
            the rotor.

    Note:
        Collective, as are all methods.
    """

    def __init__(
        self,
        system: MultibodySystem,
        joint: str,
        speed: float,
        state: State,
        blades: int | None = 3,
        motions: int = MOTIONS,
        feedback: Feedback | None = None,
    ) -> None:
        check_start(system, state)
        _check_loads(system)
        self._frame, self._blades = turning_frame(system, joint, speed, state), blades
        self._linear, self._feedback = LinearSystem(system, state), feedback
        self._shift = self._meter = self._problem = None
        try:
            if blades is not None:
                self._shift = cyclic_shift(self._frame, state, blades)
                check_isotropic(self._frame, self._linear, self._shift)
                self._meter = WhirlMeter(self._linear, self._shift, speed)
            problem = self._problem = turning_problem(self._frame, self._linear, self._shift)
            pitch = None if feedback is None else feedback.pitch
            X = self._X = find_slow_motions(self._frame, problem, motions, pitch)
            vectors = self._linear.vectors
            self.terms = _find_terms(self._frame, vectors, state, X, self._shift)
            self.damping = np.zeros((X.shape[1],) * 2)
            if problem.damping is not None:
                self.damping = project(problem.damping, vectors, X)
            self.stiffness = project(problem.stiffness, vectors, X)
            rotation = find_rotation(self._frame, self._linear)[:, None]
            along = X.T @ multiply(self._linear.mass, vectors, rotation)
            along = sum_over_ranks(system.comm, along)[:, 0]
            along[len(along) - (feedback is not None) :] = 0.0  # round-off: the pitch is normal
            is_free = not self._frame.is_driven
            self.turned: Array = along / np.linalg.norm(along) if is_free else 0.0 * along
            self.generator = self._find_generator({} if feedback is None else feedback.generator)
            self._check_balance()
        except BaseException:
            self.destroy()
            raise

    def find(self, count: int, air: AirModel = AirModel()) -> Modes:
        """The vibrations of the structure with the smallest eigenvalues, by rising frequency.

        Motions that grow without vibration come first. Those that decay without any are left out,
        and so is the rotation of a free rotor, which changes its speed slowly. With a controller it
        comes as one more mode after the others, whether it vibrates or not.

        Args:
            count: How many.
            air: How the air follows.

        Raises:
            ModelError: for models that the air does not have.
        """
        unknown = sorted({*air.frozen, *air.instant} - self.models)
        if unknown:
            raise ModelError(
                f"the air has no model {unknown[0]!r}; there are {sorted(self.models)}"
            )
        terms = [terms.freeze(air.frozen).follow(air.instant) for terms in self.terms]
        return self._find(count, assemble(self.damping, self.stiffness, terms), self._feedback)

    def make_filter(self, mode: Mode) -> ModalFilter:
        """A meter of one of the modes in runs.

        Args:
            mode: As `find` gave it, without feedback and with the air as in runs.
        """
        A, m = assemble(self.damping, self.stiffness, self.terms), self._X.shape[1]
        left = on_rank0(self._frame.system.comm, lambda: find_left_vector(A, mode.eigenvalue))
        MX = multiply(self._linear.mass, self._linear.vectors, self._X)
        ends = 2 * m + np.cumsum([len(t.models) for t in self.terms])
        of_states = np.split(left[2 * m :], ends[:-1] - 2 * m)
        return ModalFilter(
            self._frame,
            self._shift,
            MX @ left[:m],
            MX @ left[m : 2 * m],
            [(t.whirl, part) for t, part in zip(self.terms, of_states, strict=True)],
        )

    def find_work(self, mode: Mode) -> ModeWork:
        """Who feeds one of the modes.

        Args:
            mode: As `find` gave it, without feedback and with the air as in runs.
        """
        linear, a = self._linear, np.zeros(self._X.shape[1], dtype=complex)
        for motion, factor in ((mode.real, 1.0), (mode.imaginary, 1j)):
            if motion is not None:
                x = linear.vectors.vector(motion)
                found = self._X.T @ multiply(linear.mass, linear.vectors, x.array_r[:, None])
                a += factor * sum_over_ranks(linear.system.comm, found)[:, 0]
                x.destroy()
        s = mode.eigenvalue
        return find_mode_work(self._frame, linear, self._shift, self.terms, s, a, self._X)

    @property
    def models(self) -> set[str]:
        """The models of the air that have states."""
        return {name for terms in self.terms for name in terms.models}

    def find_still(self, count: int) -> Modes:
        """The same modes where loads of the air stay as they are, and pitch and torque too."""
        return self._find(count, assemble(self.damping, self.stiffness, []), None)

    def _check_balance(self) -> None:
        """Refuse a state out of equilibrium.

        Turned as a whole, it has forces that differ from the turned ones by those it lacks.
        """
        structure = float(self.turned @ self.stiffness @ self.turned)
        air = sum(float(self.turned @ t.by_motion @ self.turned) for t in self.terms)
        lacks = abs(structure - air) / max(abs(structure), abs(air), LEAST_STIFFNESS)
        if not lacks <= BALANCED:
            raise ModelError(
                f"the rotor on {self._frame.joint!r} is not in equilibrium with the air, or its "
                f"wind differs around it: forces lack {100.0 * lacks:.2g} % of each other as it "
                "turns"
            )

    def _find(self, count: int, A: Array, feedback: Feedback | None) -> Modes:
        """The modes of a matrix of first order; the last one of the speed if there is feedback."""
        frame, m, turned = self._frame, self._X.shape[1], self.turned
        if feedback is not None:
            A = feedback.close(A, self.generator)
        elif self._feedback is not None:
            A = A[np.ix_(*(keep_free(len(A), m),) * 2)]
        if self._feedback is not None:
            turned = turned[:-1]

        def solve() -> tuple[Array, Array]:
            values, vectors = solve_first_order(A, turned, feedback is not None)
            a = vectors[: len(turned)]
            if feedback is not None:
                a = np.vstack([a, feedback.find_pitch(vectors[-len(feedback.A) :])])
            return values, np.pad(a, [(0, m - len(a)), (0, 0)])

        values, motions = on_rank0(frame.system.comm, solve)
        pairs = list(zip(values, motions.T, strict=True))
        last = [self._make_mode(*pairs.pop())] if feedback is not None else []
        modes = list[Mode]()
        for s, a in pairs:
            if len(modes) == count:
                break
            mode = self._make_mode(s, a)
            if self._lasts(mode):
                modes.append(mode)
            else:
                mode.destroy()
        modes.sort(key=lambda mode: (mode.eigenvalue.imag, abs(mode.eigenvalue)))
        found = (*modes, *last)
        return Modes(self._linear.state, found, frame.joint, frame.speed, self._blades)

    def _make_mode(self, s: complex, a: Array) -> Mode:
        """The mode of an eigenvalue and the sum of motions."""
        vectors = self._linear.vectors
        assert self._problem is not None
        parts = vectors.new_vector(), vectors.new_vector()
        for part, values in zip(parts, (a.real, a.imag), strict=True):
            part.array[:] = self._X @ values
        pair = Pair(complex(s), parts)
        mode = make_mode(self._problem, pair, False, self._meter)
        pair.destroy()
        return mode

    def _find_generator(self, factors: Mapping[str, float]) -> Array:
        """n, a sum of joint coordinates for each of the motions."""
        system, along = self._frame.system, np.zeros(self._X.shape[1])
        if system.comm.rank == 0:
            angles = self._X[len(self._X) - len(system.joint_coordinate_names) :]
            for name, factor in factors.items():
                along += factor * angles[system.joint_coordinate_names.index(name)]
        return sum_over_ranks(system.comm, along)

    def _lasts(self, mode: Mode) -> bool:
        """Whether a mode vibrates, seen from what turns, or grows."""
        s, speed, whirl = mode.eigenvalue, abs(self._frame.speed), mode.whirl
        if s.real > SLOW * speed:
            return True
        ways = {} if whirl is None else {"forward": -speed, "backward": speed}
        frequency = s.imag + ways.get(whirl.name if whirl else "", 0.0)
        return bool(abs(frequency) > VIBRATES * np.hypot(frequency, s.real))

    def destroy(self) -> None:
        """Free the matrices."""
        for thing in (self._problem, self._meter, self._shift, self._linear):
            if thing is not None:
                thing.destroy()


def _check_loads(system: MultibodySystem) -> None:
    """Refuse a system without loads on sections of flexible bodies, or with large ones."""
    if system.rigid_section_loads or not any(m.section_loads for m in system.flexible_models):
        raise ModelError(
            "modes in the air need loads on sections of flexible bodies, and none of rigid ones"
        )
    if system.has_large_bodies:
        raise ModelError("modes in the air need bodies that move by few functions: reduced ones")


def _find_terms(
    frame: TurningFrame,
    vectors: FlatVectors,
    state: State,
    X: Array,
    shift: CyclicShift | None,
) -> list[AirTerms]:
    """Terms of all loads on sections."""
    rows = vectors.split_rows(X)
    turned = vectors.split_rows(TurningVectors(frame, shift).find_velocities(X))
    return [
        find_air_terms(frame, body, loads, state, rows[body], turned[body], shift)
        for body, model in enumerate(frame.system.flexible_models)
        for loads in model.section_loads
    ]
