"""A reduced body in one energy-momentum step.

Unknown: the increment dz = z_{n+1} - z_n of all vectors. With the strain coordinates c of
`GramStrain`, the mean vectors y_m and the times Z of viscous losses, v_{n+1} = 2 dz/dt - v_n and

    c_alg = (c_n + c_{n+1})/2 + (chi/2) (c_{n+1} - c_n) + Z (c_{n+1} - c_n)/dt,
    M (dz - dt v_n) + dt^2/2 L^T S(W c_alg) y_m = dt^2/2 (m g + f),

with the forces f of the middle of the step.

S y_m . dy = c_alg . (c_{n+1} - c_n), so that the step gains the strain energy
|c_{n+1}|^2/2 - |c_n|^2/2 and what dissipates, for any step; S is symmetric, so that no moment is
left. The derivative with respect to dz is

    A = M + dt^2/2 (J_m^T (1/2 + chi/2 + Z/dt) J_{n+1} + S(W c_alg)/2 (x) 1).

A first guess strains stiff walls by terms of second order, and their stress would spoil the last
term. There c is taken as it was expected: extrapolated from the last steps, then linear in the last
increment, c + J ddz. The residual stays as it is (mixed integration points: Magisano, Leonetti and
Garcea 2017). The tangent lasts for more than a step, see `KeptTangent`, and so do the slopes of
loads on sections, see `KeptSlopes`.
"""

from __future__ import annotations

from collections.abc import Sequence

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.parallel import from_rank0
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.gram_strain import add_to_components
from turbine_fenicsx.system.reduced_model import ReducedModel
from turbine_fenicsx.time_stepping.kept_slopes import KeptSlopes
from turbine_fenicsx.time_stepping.kept_tangent import ExpectedStrain, KeptTangent, find_frames

EQUAL_STEPS = 1e-6
"""Maximum difference of two steps of equal length, relative to it."""

WEIGHTS = ((1.0,), (0.0, 1.0), (1.0, 1.0, -1.0))
"""Weights of the values of the last steps, newest first, that extrapolate them to the next."""


class StrainHistory:
    """Strain coordinates at t_n, t_{n-1} and t_{n-2}; a repeated step leaves no trace."""

    def __init__(self) -> None:
        self._times: list[float] = []
        self._values: list[Array] = []
        self._dt = 0.0

    def start_step(self, times: StepTimes, c: Array) -> None:
        """A step begins at t_n with the strain coordinates c."""
        start, self._dt = times.end - times.dt, times.dt
        near = EQUAL_STEPS * times.dt
        known = [k for k, time in enumerate(self._times) if time < start - near]
        self._times = [start, *(self._times[k] for k in known)][:3]
        self._values = [c, *(self._values[k] for k in known)][:3]

    def expect(self) -> Array:
        """Strain coordinates to be expected at t_{n+1}."""
        gaps = [a - b for a, b in zip(self._times, self._times[1:], strict=False)]
        equal = 0
        while equal < len(gaps) and abs(gaps[equal] - self._dt) <= EQUAL_STEPS * self._dt:
            equal += 1
        weights = WEIGHTS[min(equal, 2)]
        found: Array = np.tensordot(weights, np.array(self._values[: len(weights)]), 1)
        return found

    def save(self) -> tuple[list[float], list[Array]]:
        """Times and values, newest first."""
        return list(self._times), [c.copy() for c in self._values]

    def restore(self, times: Sequence[float], values: Sequence[Array]) -> None:
        """Continue after these."""
        self._times, self._values = list(times), list(values)


DISSIPATION = "numerical dissipation"
"""Name of what numerical dissipation takes out, as of bodies on a mesh."""


class ReducedStep:
    """Residual and tangent of the step of a reduced body.

    Args:
        model: The body and the forces on it.
        numerical_dissipation: chi >= 0, as of `FlexibleStep`.

    Attributes:
        tangent: Dense matrix of the tangent on rank 0, filled by `assemble_tangent`.
    """

    def __init__(self, model: ReducedModel, numerical_dissipation: float = 0.0) -> None:
        self.model, self._chi = model, numerical_dissipation
        local, size = 3 * model.n_owned, 3 * model.size_global
        self.tangent = PETSc.Mat().createDense(((local, size), (local, size)), comm=model.comm)
        self.tangent.setUp()
        self.tangent.assemble()
        self.losses = (*model.losses, *([DISSIPATION] if numerical_dissipation else []))
        self._times = StepTimes.at_rest(0.0)
        self._round_off: float | None = None
        self._history = StrainHistory()
        signs = np.random.default_rng(0).choice([-1.0, 1.0], (2, len(model.mass) - 1, 3))
        self._factors = 1.0 + np.finfo(float).eps * signs
        self._expected: ExpectedStrain | None = None
        self._kept: KeptTangent | None = None
        self._slopes: KeptSlopes | None = None
        self._changed: tuple[Array, tuple[Array, Array, Array]] | None = None

    @property
    def midpoint(self) -> ReducedStep:
        """Works of forces, and what dissipates in this body."""
        return self

    def start_step(self, u: PETSc.Vec, v: PETSc.Vec, times: StepTimes, gravity: Array) -> None:
        """Set the state at t_n, the step, and gravity [m/s^2]."""
        model = self.model
        self._set_length(times)
        self._y, self._c = model.strain_at(u.array_r)
        self._history.start_step(times, self._c)
        self._changed = None
        self._dt_v = times.dt * model.split(v.array_r)
        self._impulse = times.half_dt2 * model.applied_forces(gravity, times.middle)
        M = np.abs(model.mass)
        masses = np.abs(model.nodal_mass).reshape(-1, len(M), 1)
        weight = times.half_dt2 * np.linalg.norm(gravity) * masses
        self._fixed_terms = M @ np.abs(self._dt_v) + weight
        self._u = u.array_r.copy()
        for loads in model.section_loads:
            loads.start_step_at(times, self._u)
        self._round_off = None
        self.start_iteration()

    def _set_length(self, times: StepTimes) -> None:
        """Set the times of a step, and D/(dt^2/2)."""
        self._times = times
        self._slope = 0.5 + 0.5 * self._chi + self.model.loss / times.dt

    def start_iteration(self) -> None:
        """A new iteration begins: forget the tangent of an earlier one."""
        self._expected = None

    def residual(self, du: PETSc.Vec, R: PETSc.Vec) -> None:
        """The residual [kg m] for the increment du, into R."""
        dz, strain = self.model.split(du.array_r), self.model.strain
        y, _, dc = self._change(dz)
        terms = self.model.mass @ (dz - self._dt_v) - self._impulse
        forces = strain.forces(strain.stress(self._algorithmic(dc)), y)
        R.array[:] = (terms + self._times.half_dt2 * forces).ravel()
        middle, factor = self._times.middle, -self._times.half_dt2
        self.model.add_forces(*self._move(du.array_r), middle, factor, R.array)

    def _move(self, du: Array) -> tuple[Array, Array]:
        """Displacements and velocities of the vectors in the middle of the step."""
        return self._u + 0.5 * du, du / self._times.dt

    def _middle(self, dz: Array) -> tuple[Array, Array]:
        """Mean vectors y_m in the step, and their increments."""
        dy = self.model.strain.vectors(dz)
        return self._y + 0.5 * dy, dy

    def _algorithmic(self, dc: Array) -> Array:
        """c_alg for changes of c, shape (copies, r)."""
        return self._c + self._slope * dc

    def _change(self, dz: Array) -> tuple[Array, Array, Array]:
        """As `_middle`, and the change of c; those of the last call for the same increments."""
        if self._changed is None or not np.array_equal(self._changed[0], dz):
            y, dy = self._middle(dz)
            self._changed = dz.copy(), (y, dy, self.model.strain.change(y, dy))
        return self._changed[1]

    def assemble_tangent(self, du: PETSc.Vec) -> None:
        """Assemble the derivative of the residual [kg] into `tangent`, with the expected strain."""
        dz = self.model.split(du.array_r)
        expected, one = self._expect(dz), np.broadcast_to(np.eye(3), (len(dz), 3, 3))
        z = self.model.vectors(self._u)
        self._kept = kept = self._linearise(np.array([z, z + dz]))
        self._expected = ExpectedStrain(dz.copy(), self._change(dz)[2], kept.J, one)
        A = self.differentiate(kept.J, kept.loaded, expected)
        if self.model.has_node_loads:
            A -= self._times.half_dt2 * self._find_slopes(du.array_r, kept.frames)
        self._write(A)

    def _find_slopes(self, du: Array, frames: Array) -> Array:
        """Slopes of loads on nodes, shape (copies, 3 n, 3 n) [N/m]. Collective."""
        kept, times = self._slopes, self._times
        if kept is None or not kept.serve(times.dt):
            found = self.model.find_slopes(*self._move(du), times)
            kept = KeptSlopes(times.dt, found, frames)
        self._slopes = kept._replace(age=kept.age + 1)
        return kept.turn(frames)

    def _linearise(self, ends: Array) -> KeptTangent:
        """Jacobians between vectors of the shape (2, copies, n, 3), see `KeptTangent`."""
        y = self.model.strain.vectors(ends)
        # one product for both: it reads a large matrix
        both = self.model.strain.jacobian(y.reshape(-1, *y.shape[2:]), single=True)
        J_m, J = np.split(both, 2)
        J_m += J  # J is linear in the vectors
        J_m *= (0.5 * self._times.half_dt2 * self._slope[:, None]).astype(J_m.dtype)
        return KeptTangent(self._times.dt, J, J_m, ends, find_frames(ends[1]))

    def _expect(self, dz: Array) -> Array:
        """Change of c expected at increments, shape (copies, r)."""
        if self._expected is None:
            return np.asarray(self._history.expect() - self._c)
        return self._expected.at(dz)

    @property
    def keeps_tangent(self) -> bool:
        """Whether there is a tangent of this length of the step."""
        return self._kept is not None and self._kept.dt == self._times.dt

    def turn_tangent(self, du: PETSc.Vec) -> tuple[Array | None, Array]:
        """Take the kept tangent to the increment du, see `KeptTangent`.

        Returns:
            Q, shape (copies, 3, 3), or None where that of an earlier iteration of the step stays;
            and what the residual lacks, (J_m0 - J_m)^T D (c - c_e), shape (3 n_owned,) [kg m].
        """
        assert self._kept is not None
        dz, strain, kept = self.model.split(du.array_r), self.model.strain, self._kept
        stays = self._expected
        Q = kept.find_turn(self.model.vectors(self._u) + dz) if stays is None else stays.Q
        y, _, dc = self._change(dz)
        lag = dc - self._expect(dz)
        self._expected = ExpectedStrain(dz.copy(), dc, kept.J, Q)
        forces = strain.forces(strain.stress(self._slope * lag, single=True), y)
        lacking = (kept.find_forces(Q, lag) - self._times.half_dt2 * forces).ravel()
        return Q if stays is None else None, lacking

    def forget_tangent(self) -> None:
        """The next tangent is new."""
        self._kept = self._slopes = None

    def assemble_at_rest(self) -> None:
        """Assemble the tangent for du = 0."""
        z, self._kept = self.model.vectors(self._u), None
        at_rest = self._linearise(np.array([z, z]))
        self._write(self.differentiate(at_rest.J, at_rest.loaded, 0.0 * self._c))

    def differentiate(self, J: Array, loaded: Array, dc: Array) -> Array:
        """The tangent A without loads on sections, shape (copies, 3 n, 3 n) [kg].

        Args:
            J: J_{n+1}, shape (copies, r, 3 n).
            loaded: D J_m, shape (copies, r, 3 n).
            dc: Change of c that makes the stress of the last term, shape (copies, r).
        """
        strain, half_dt2 = self.model.strain, self._times.half_dt2
        A = (loaded.swapaxes(1, 2) @ J).astype(float)
        S = strain.stress(self._algorithmic(dc), single=True)
        add_to_components(A, strain.geometric(S), 0.5 * half_dt2)
        add_to_components(A, self.model.mass[None], 1.0)
        return A

    def _write(self, A: Array) -> None:
        """Set the diagonal blocks of `tangent`. Collective."""
        for block, values in zip(self._blocks(), A, strict=True):
            block[:] = values
        self.tangent.assemble()

    def _read(self) -> Array:
        """The diagonal blocks of `tangent`, a copy."""
        return np.array(self._blocks())

    def _blocks(self) -> list[Array]:
        """Views of the diagonal blocks of `tangent` that this rank owns."""
        if not self.model.n_owned:
            return []
        dense, k = self.tangent.getDenseArray(), self.model.dense_block
        starts = range(0, len(dense), k)
        return [dense[start : start + k, start : start + k] for start in starts]

    def term_scale(self, du: PETSc.Vec) -> float:
        """Sum of the squares of the inertia and gravity terms of the residual."""
        terms = np.abs(self.model.mass) @ np.abs(self.model.split(du.array_r))
        return float(np.sum((terms + self._fixed_terms) ** 2))

    @property
    def round_off(self) -> float:
        """Sum of the squares of the round-off of the residual [(kg m)^2], by request."""
        if self._round_off is None:
            self._round_off = self._find_round_off()
        return self._round_off

    def _find_round_off(self) -> float:
        """Sum of the squares of what the forces change when the vectors change by their round-off.

        Forces are stiffnesses times small differences, so that it is measured.
        """
        pairs, strain = zip(self._middle(self._dt_v), self._factors, strict=True), self.model.strain
        y, dy = (np.concatenate([x, x * factor]) for x, factor in pairs)
        c = np.tile(self._c, (2, 1)) + self._slope * strain.change(y, dy)
        f = strain.forces(strain.stress(c), y)
        change = f[len(self._c) :] - f[: len(self._c)]
        return float(self._times.half_dt2**2 * np.sum(change * change))

    def works(self, du: PETSc.Vec) -> tuple[Array, Array]:
        """This rank's part of the work of each force, and of what each law dissipates [J]."""
        lost, dz = np.zeros(len(self.losses)), self.model.split(du.array_r)
        forces = self.model.forces_at(self._times.middle)
        u, v = self._move(du.array_r)
        works = [float(np.sum(force * du.array_r[dofs])) for dofs, force in forces]
        works += [x.work(u, v, self._times, du.array_r) for x in self.model.section_loads]
        dc = self._change(dz)[2]
        for k, Z in enumerate(self.model.losses.values()):
            lost[k] = np.sum(Z * dc * dc) / self._times.dt
        damper = self.model.mass_damper
        if damper is not None:
            place = list(self.model.losses).index("structural damping")
            lost[place] += self._times.dt * damper.power(u, v)
        if self._chi:
            lost[-1] = 0.5 * self._chi * np.sum(dc * dc)
        return np.array(works), lost

    def save(self) -> RestartData:
        """Strain coordinates at the starts of the last steps, and the tangent. Collective."""
        times, values = self._history.save()
        shape = (len(times), self.model.copies, self.model.strain.size)
        arrays = np.array(values).reshape(shape) if self.model.n_owned else np.zeros(shape)
        data = RestartData({"times": times}, {"strain": from_rank0(self.model.comm, arrays)})
        if self._kept is not None:
            copies, k = self.model.copies, self.model.dense_block
            A, ends = np.zeros((copies, k, k)), np.zeros((2, copies, k // 3, 3))
            if self.model.n_owned:
                A, ends = self._read(), self._kept.ends
            data.numbers["dt"] = self._kept.dt
            data.arrays["tangent"] = from_rank0(self.model.comm, A)
            data.arrays["ends"] = from_rank0(self.model.comm, ends)
        if self._slopes is not None:
            data.add("slopes", self._slopes.save(self.model.comm, self.model.copies))
        return data

    def restore(self, data: RestartData) -> None:
        """Restore it."""
        self._kept = self._slopes = None
        if not data:
            return
        mine = slice(self.model.copies if self.model.n_owned else 0)
        self._history.restore(data.numbers["times"], list(data.arrays["strain"][:, mine]))
        if "dt" in data.numbers:
            self._set_length(StepTimes.from_start(0.0, data.numbers["dt"]))
            self._kept = self._linearise(data.arrays["ends"][:, mine])
            self._write(data.arrays["tangent"][mine])
        slopes = data.part("slopes")
        self._slopes = KeptSlopes.restore(slopes, mine) if slopes else None
