"""A slider-crank with a flexible coupler, as a solid and as a chain of rigid pieces.

A crank of 0.2 m, which starts smoothly from rest and reaches 10 rad/s within half a second, drives
a slider by a coupler of 1 m. The coupler is a slender rod, rigid for 5 cm at both ends where it
hangs on revolute joints, and flexible between them; its first natural frequency is four times that
of the crank. Its own inertia bends it by up to 9 mm.

Once the flexible part is a solid of quadratic hexahedra that is coupled to both ends; once it is a
chain of rigid pieces on hinges with springs of the stiffness `EI/l`, `l` the length of a piece.
Neither knows of the other. Compared is the deflection of the middle from the line between the pins,
over 7.5 rad of the crank with the same time step. The chain with 8, 16 and 32 pieces follows the
law of the order 2 and is extrapolated. The solid comes from 1.4e-4 m with 8 by 1 by 1 elements to
1e-5 m with 16 by 1 by 1; it shears, which the chain does not.

The multipliers of the couplings are the forces on the ends. Newton's laws say what they must be: at
every step, their sum is the change of the solid's momentum, and the same holds for their moments
about the shaft.
"""

from mpi4py import MPI

import numpy as np
from published import Row, extrapolate, load, references

from turbine_fenicsx import Simulation
from turbine_fenicsx.simulation.observers.reactions import Reaction, Reactions
from turbine_fenicsx.study.convergence import observed_order

STEP, STEPS = 2e-3, 500  # [s]; 7.5 rad of the crank
ELEMENTS = (16, 2, 2)  # along the coupler and across
PIECES = (8, 16, 32)

SLOW = True

parts = load("flexible_coupler", "mechanism")


class Deflection:
    """Observer of the distance of the middle of the coupler from the line between the pins [m].

    Args:
        system: The system.
        middle: Function of the state that returns the place of the middle.
    """

    def __init__(self, system, middle):
        """Nothing seen yet."""
        bodies = {body.name: k for body, k in system.first_coordinate.items()}
        self._first, self._slider = bodies["first"], bodies["slider"]
        self._middle, self.values = middle, []

    def start(self, snapshot, resumed):
        """Keep the first state."""
        self.observe(snapshot)

    def observe(self, snapshot):
        """Measure."""
        q = snapshot.state.q
        phi, d1 = q[self._first : self._first + 6].reshape(2, 3)
        pin, bolt = phi - 0.5 * parts.END * d1, q[self._slider : self._slider + 3]
        line = (bolt - pin) / np.linalg.norm(bolt - pin)
        away = self._middle(snapshot.state) - pin
        self.values.append(line[0] * away[1] - line[1] * away[0])

    def finish(self):
        """There is no file to close."""


class Balance:
    """Observer of how far reactions are from Newton's laws, relative to their largest.

    Args:
        system: The system.
        couplings: All couplings of its flexible body.
    """

    def __init__(self, system, couplings):
        """Nothing seen yet."""
        self._system, self._couplings = system, couplings
        points = [coupling.rigid.position for coupling in couplings]
        pairs = zip(couplings, points, strict=True)
        self._reactions = Reactions(system, [Reaction(c, point) for c, point in pairs])
        self._before = None
        self.errors, self.sizes = [], []

    def start(self, snapshot, resumed):
        """Keep the first state."""
        self.observe(snapshot)

    def observe(self, snapshot):
        """Compare the loads of a step with the change of momenta in it."""
        loads = self._reactions.at(snapshot)
        now = self._momenta(snapshot.state)
        if self._before is not None:
            dt = now[0] - self._before[0]
            F, M = loads[:, 0], loads[:, 1]
            mean = 0.5 * (now[3] + self._before[3])
            force = F.sum(axis=0) + (now[1] - self._before[1]) / dt
            moment = (M + np.cross(mean, F)).sum(axis=0) + (now[2] - self._before[2]) / dt
            self.errors.append([np.linalg.norm(force), np.linalg.norm(moment)])
            self.sizes.append([np.max(np.abs(F)), np.max(np.abs(M + np.cross(mean, F)))])
        self._before = now

    def _momenta(self, state):
        """Time, momenta of the solid, and places of the carriers."""
        block = self._system.flexible_models[0]
        p = block.new_vector()
        block.momentum(state.v[0], p)
        momentum = p.array_r.reshape(-1, 3)
        x = block.positions + state.u[0].array_r.reshape(-1, 3)
        sums = np.array([momentum.sum(axis=0), np.cross(x, momentum).sum(axis=0)])
        P, L = self._system.comm.allreduce(sums)
        p.destroy()
        q = self._system.coordinates_of(state.q)
        return state.time, P, L, np.array([q[c.rigid][:3] for c in self._couplings])

    def finish(self):
        """There is no file to close."""


def solid(elements, steps=STEPS, comm=MPI.COMM_WORLD):
    """Deflections at all steps [m], and errors of the reactions, see `Balance`."""
    system, couplings = parts.with_solid(comm, elements)
    block = system.flexible_models[0]
    at_middle = np.linalg.norm(block.positions - parts.MIDDLE, axis=1) < 1e-9

    def middle(state):
        u = state.u[0].array_r.reshape(-1, 3)[at_middle]
        return parts.MIDDLE + comm.allreduce(u.sum(axis=0))

    seen, balance = Deflection(system, middle), Balance(system, couplings)
    run(system, steps, [seen, balance])
    return np.array(seen.values), np.max(balance.errors, axis=0) / np.max(balance.sizes, axis=0)


def chain(pieces, steps=STEPS, comm=MPI.COMM_WORLD):
    """Deflections at all steps [m]."""
    system, link = parts.with_chain(comm, pieces)

    def middle(state):
        q, xi = system.coordinates_of(state.q)[link], link.body_coordinates(parts.MIDDLE)
        return q[:3] + xi @ q[3:].reshape(3, 3)

    seen = Deflection(system, middle)
    run(system, steps, [seen])
    return np.array(seen.values)


def run(system, steps, observers):
    """Run a system; all steps have the same length."""
    simulation = Simulation(system, STEP, steps * STEP, observers)
    simulation.run()
    simulation.stepper.destroy()
    assert simulation.halvings == 0


def main(elements=ELEMENTS, pieces=PIECES):
    """Rows of the table."""
    chains = np.array([chain(n) for n in pieces])
    limit = np.array([extrapolate(1.0 / np.array(pieces), values) for values in chains.T])
    gaps = np.max(np.abs(chains - limit), axis=1)
    ours, (force, moment) = solid(elements)
    found = {
        "largest": (float(np.max(np.abs(limit))), float(np.max(np.abs(ours)))),
        "solid": (0.0, float(np.max(np.abs(ours - limit)))),
        "chain": (0.0, float(gaps[-1])),
        "force": (0.0, float(force)),
        "moment": (0.0, float(moment)),
    }
    steps = {"chain": f"{pieces[-1]} pieces", "force": "", "moment": ""}
    order = {"chain": observed_order(1.0 / np.array(pieces), gaps)}
    return [
        Row(
            r.quantity,
            r.unit,
            *found[name],
            r.tolerance,
            steps.get(name, " by ".join(map(str, elements)) + " elements"),
            order.get(name),
            round_off=name in ("force", "moment"),
        )
        for name, r in references("flexible_coupler").items()
    ]
