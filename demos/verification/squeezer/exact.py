"""The squeezing mechanism as what it is: one degree of freedom, solved by quadrature.

With the crank angle `beta` as the only coordinate, `T = M(beta) beta'^2 / 2` is the kinetic energy
and `W(beta)` the work of torque and spring since the start at rest, so that

    t(beta) = int sqrt(M / (2 W)) d beta        from beta(0) on.

The loops close by intersections of circles; derivatives with respect to `beta` are complex steps.
The integrand has an inverse square root at the start, which beta = beta(0) + s^2 takes away.
"""

import numpy as np

STEP = 1e-30  # of the complex step: no difference is taken, so that it may be this small
NODES = 16  # of Gauss's rule in each panel
NEAR = 0.1  # what is near the start [rad]


def perpendicular(v):
    """Vectors turned by 90 degrees, shape (2, ...)."""
    return np.array([-v[1], v[0]])


def meeting(P, p, Q, q, side):
    """Where the circles about P and Q with radii p and q meet, to the left or right of PQ."""
    v = Q - P
    square = v[0] ** 2 + v[1] ** 2
    a = (square + p**2 - q**2) / (2.0 * square)
    return P + a * v + side * np.sqrt(p**2 / square - a**2) * perpendicular(v)


def side_of(P, Q, X):
    """+1 if X is to the left of PQ, -1 to the right."""
    return np.sign((Q - P)[0] * (X - P)[1] - (Q - P)[1] * (X - P)[0]).real


class Mechanism:
    """Its geometry as a function of the crank angle.

    Args:
        run: The benchmark, for its data.
    """

    def __init__(self, run):
        """Find out on which sides the loops close at the start."""
        self.run = run
        self.fixed = [np.array(point)[:, None] for point in (run.ORIGIN, run.A, run.B, run.C)]
        a = run.START
        origin, A, B, _ = self.fixed
        F = origin + run.along(a["beta"], run.RR)[:2, None]
        E = F - run.along(a["beta"] + a["Theta"], run.D_)[:2, None]
        G = A + run.along(a["delta"], run.ZT)[:2, None]
        H = A + run.along(a["epsilon"], 0.0, -run.U_)[:2, None]
        self.sides = side_of(F, B, E), side_of(E, A, G), side_of(E, A, H)

    def points(self, beta):
        """F, E, D, G, H at crank angles, each of shape (2, n)."""
        r, (origin, A, B, _) = self.run, self.fixed
        F = origin + r.RR * np.array([np.cos(beta), np.sin(beta)])
        E = meeting(F, r.D_, B, r.SS, self.sides[0])
        u = perpendicular(E - B) / r.SS  # the direction of gamma: E is SS across it
        D = B + r.SD * u + r.SC * (E - B) / r.SS
        G = meeting(E, r.E_, A, r.ZT, self.sides[1])
        H = meeting(E, r.ZF, A, r.U_, self.sides[2])
        return F, E, D, G, H

    def bars(self, beta):
        """Of each body two points P, Q and the centre of mass as P + a PQ + b PQ turned."""
        r, (origin, A, B, _) = self.run, self.fixed
        F, E, _, G, H = self.points(beta)
        return (
            (origin, F, r.RA / r.RR, 0.0),
            (F, E, r.DA / r.D_, 0.0),
            (B, E, r.SA / r.SS, r.SB / r.SS),
            (G, E, (r.E_ - r.EA) / r.E_, 0.0),
            (A, G, r.TB / r.ZT, r.TA / r.ZT),
            (H, E, (r.ZF - r.FA) / r.ZF, 0.0),
            (A, H, r.UA / r.U_, r.UB / r.U_),
        )

    def inertia(self, beta):
        """M(beta), twice the kinetic energy at unit rate."""
        M = 0.0
        bars = self.bars(beta + 1j * STEP)
        for m, J, (P, Q, a, b) in zip(self.run.MASSES, self.run.INERTIAS, bars, strict=True):
            v = Q - P
            centre = (P + a * v + b * perpendicular(v)).imag / STEP
            w = v.imag / STEP
            turn = (v.real[0] * w[1] - v.real[1] * w[0]) / np.sum(v.real**2, axis=0)
            M = M + m * np.sum(centre**2, axis=0) + J * turn**2
        return M

    def spring_energy(self, beta):
        """Energy of the spring."""
        D = self.points(beta)[2]
        length = np.sqrt(np.sum((D - self.fixed[3]) ** 2, axis=0))
        return 0.5 * self.run.STIFFNESS * (length - self.run.REST) ** 2

    def work(self, beta):
        """W(beta) of torque and spring, shape (n,).

        Near the start it is the integral of dW/d beta, as the difference of two energies of the
        spring would be round-off.
        """
        start = np.array([self.run.START["beta"]])
        turned = beta - start
        far = self.run.TORQUE * turned - self.spring_energy(beta) + self.spring_energy(start)
        x, w = np.polynomial.legendre.leggauss(NODES)
        between = (start + 0.5 * (1.0 + x) * np.minimum(turned, NEAR)[:, None]).ravel()
        slope = self.spring_energy(between + 1j * STEP).imag / STEP
        near = turned * (self.run.TORQUE - slope.reshape(-1, NODES) @ w / 2.0)
        return np.where(turned < NEAR, near, far)

    def angles(self, beta):
        """All angles of the test set along an array of crank angles that begins at the start."""
        directions = {n: np.unwrap(np.arctan2(*(Q - P)[::-1])) for n, P, Q in self._arms(beta)}
        turned = {name: angle - angle[0] for name, angle in directions.items()}
        a = self.run.START
        relative = {
            "beta": turned["K1"],
            "Theta": turned["K2"] - turned["K1"],
            "gamma": turned["K3"],
            "Phi": turned["K4"] - turned["K5"],
            "delta": turned["K5"],
            "Omega": turned["K6"] - turned["K7"],
            "epsilon": turned["K7"],
        }
        return {name: a[name] + angle for name, angle in relative.items()}

    def _arms(self, beta):
        """Names of the bodies with two points of each."""
        n = np.ones_like(beta)
        for k, (P, Q, _, _) in enumerate(self.bars(beta), start=1):
            yield f"K{k}", P * n, Q * n


def angles(run, panels=32):
    """All angles at the end [rad], with the data of ``run``.

    Args:
        run: The benchmark.
        panels: Panels of the quadrature.
    """
    mechanism = Mechanism(run)
    x, w = np.polynomial.legendre.leggauss(NODES)
    start = run.START["beta"]

    def path(beta):
        """Substituted nodes and weights up to a crank angle."""
        h = np.sqrt(beta - start) / panels
        s = h * (np.arange(panels)[:, None] + 0.5 * (1.0 + x)).ravel()
        return s, np.tile(0.5 * h * w, panels)

    def rate(beta):
        return np.sqrt(2.0 * mechanism.work(beta) / mechanism.inertia(beta))

    def time(beta):
        s, weights = path(beta)
        return float(weights @ (2.0 * s / rate(start + s**2)))

    beta = start + np.pi  # any angle on the way
    for _ in range(50):
        change = (run.END - time(beta)) * float(rate(np.array([beta]))[0])
        beta += change
        if abs(change) < 1e-13:
            break
    s, _ = path(beta)
    way = np.concatenate([[start], start + s**2, [beta]])
    return {name: float(angle[-1]) for name, angle in mechanism.angles(way).items()}
