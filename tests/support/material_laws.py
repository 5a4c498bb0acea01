"""Materials as functions of numpy arrays, and their definitions by hand, for tests.

A mesh of volume one turns an integral of a constant into its value.
"""

from functools import cached_property

import numpy as np
import ufl
from dolfinx import fem
from scipy.optimize import brentq

from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.materials.base import second_piola_kirchhoff
from turbine_fenicsx.materials.kinematics import right_cauchy_green
from turbine_fenicsx.materials.orthotropic import stiffness_matrix
from turbine_fenicsx.time_stepping.discrete_gradients import general_stress

QUADRATIC = ("svk", "orthotropic")
TRANSVERSE = ("composite", "soft_fibre")
LAWS = (*QUADRATIC, "neo_hooke", "mooney_rivlin", *TRANSVERSE)
DIRECTED = ("orthotropic", *TRANSVERSE)
LAMBDA, MU = 3.0, 0.8
YOUNG, SHEAR, POISSON = (45.0, 15.0, 12.0), (5.4, 4.9, 6.1), (0.3, 0.25, 0.35)
FRAME = rotation_about((1.0, 2.0, 0.5), 1.1)  # columns a1, a2, a3
C10, C01, KAPPA = 0.3, 0.1, 4.0
COMPOSITE = (45.0, 15.0, 5.4, 0.3, 0.35)
SOFT_FIBRE = (10.0, 50.0, 4.0, 0.06, 0.1)
PAPER = {"young": (45.0, 15.0, 15.0), "shear": (5.4, 5.4, 5.4), "poisson": (0.3, 0.3, 0.3)}
ROUND_OFF = 2e-14
"""Moduli up to fifty times strains up to one, in sums of a dozen terms, relative to moduli."""


class Law:
    """W and S of a material as functions of numpy arrays; what is not asked for is not compiled."""

    def __init__(self, comm, cells, make):
        self.comm, self.cells = comm, cells
        self.frame = [self.constant(a) for a in FRAME.T]
        self.material = make(self.frame)
        self._C, self._F, self._D, self._A = (self.constant(np.eye(3)) for _ in range(4))

    def constant(self, value):
        return fem.Constant(self.cells, np.array(value, dtype=float, order="C"))

    def form(self, integrand):
        measure = ufl.dx(domain=self.cells, metadata={"quadrature_degree": 1})
        return fem.form(integrand * measure)

    def value(self, form):
        return float(self.comm.allreduce(fem.assemble_scalar(form)))

    def _W(self, C):
        return self.material.strain_energy(C, self.constant)

    @cached_property
    def _W_of_C(self):
        return self.form(self._W(self._C))

    @cached_property
    def _W_of_F(self):
        return self.form(self._W(right_cauchy_green(self._F)))

    @cached_property
    def _S(self):
        return self.form(ufl.inner(second_piola_kirchhoff(self._W, self._C), self._A))

    @cached_property
    def _defect(self):
        F, D = self._F, self._D
        work = 0.5 * ufl.inner(general_stress(self._W, F, D), F.T * D + D.T * F)
        W0, W1 = (self._W(right_cauchy_green(F + sign * D)) for sign in (-0.5, 0.5))
        return self.form(work - (W1 - W0))

    def energy(self, C):
        self._C.value = C
        return self.value(self._W_of_C)

    def energy_of_deformation(self, F):
        self._F.value = F
        return self.value(self._W_of_F)

    def stress(self, C):
        self._C.value = C
        S = np.zeros((3, 3))
        for i, j in np.ndindex(3, 3):
            self._A.value = np.outer(np.eye(3)[i], np.eye(3)[j])
            S[i, j] = fem.assemble_scalar(self._S)
        return self.comm.allreduce(S)

    def defect(self, F, D):
        """S_alg : dC/2 - (W_{n+1} - W_n) of the general algorithmic stress, F at the midpoint."""
        self._F.value, self._D.value = F, D
        return self.value(self._defect)


def deformation(rng, size=0.2):
    F = np.eye(3) + size * rng.uniform(-1, 1, (3, 3))
    return F, F.T @ F


def energy_by_hand(law, C):
    """W from the definitions, with numpy."""
    E = 0.5 * (C - np.eye(3))
    if law == "svk":
        return 0.5 * LAMBDA * np.trace(E) ** 2 + MU * np.sum(E * E)
    if law == "neo_hooke":
        ln_J = 0.5 * np.log(np.linalg.det(C))
        return 0.5 * MU * (np.trace(C) - 3) - MU * ln_J + 0.5 * LAMBDA * ln_J**2
    if law == "mooney_rivlin":
        I1, I2, J = np.trace(C), 0.5 * (np.trace(C) ** 2 - np.sum(C * C)), np.linalg.det(C) ** 0.5
        W = C10 * (I1 / J ** (2 / 3) - 3) + C01 * (I2 / J ** (4 / 3) - 3)
        return W + KAPPA / 4 * (J**2 - 1 - 2 * np.log(J))
    if law in TRANSVERSE:
        return transverse_energy(COMPOSITE if law == "composite" else SOFT_FIBRE, C)
    e = FRAME.T @ E @ FRAME
    voigt = np.array([e[0, 0], e[1, 1], e[2, 2], 2 * e[1, 2], 2 * e[0, 2], 2 * e[0, 1]])
    (E1, E2, E3), (G12, G13, G23), (n12, n13, n23) = YOUNG, SHEAR, POISSON
    S = np.diag([1 / E1, 1 / E2, 1 / E3, 1 / G23, 1 / G13, 1 / G12])
    S[0, 1] = S[1, 0] = -n12 / E1
    S[0, 2] = S[2, 0] = -n13 / E1
    S[1, 2] = S[2, 1] = -n23 / E2
    return 0.5 * voigt @ np.linalg.solve(S, voigt)


def transverse_stiffness(E1, E2, G, n12, n23):
    return stiffness_matrix((E1, E2, E2), (G, G, E2 / (2 * (1 + n23))), (n12, n12, n23))


def transverse_energy(data, C):
    """W from the parts of C in the frame of the fibre: C11, t = (C12, C13), and the area, which
    is what is left of C22, C23, C33 by elimination of C11."""
    D, c = transverse_stiffness(*data), FRAME.T @ C @ FRAME
    mu, k = (D[1, 1] - D[1, 2]) / 2, (D[1, 1] + D[1, 2]) / 2
    K = np.array([[D[0, 0], D[0, 1]], [D[0, 1], k]])
    s, neo_hooke = 1.0, np.diag([2 * mu, mu])
    if np.linalg.eigvalsh(K - neo_hooke)[0] < 0:
        s = brentq(lambda s: np.linalg.eigvalsh(K - s * neo_hooke)[0], 0, 1, xtol=1e-15)
    shear = c[0, 1:] @ c[0, 1:] / c[0, 0]
    area = c[1:, 1:] - np.outer(c[0, 1:], c[0, 1:]) / c[0, 0]
    y, z = 0.5 * np.log(c[0, 0]), 0.5 * np.log(np.linalg.det(area))
    W = s * mu * (0.5 * (c[0, 0] - 1) - y + np.exp(z) - 1 - z)
    W += mu * (0.5 * np.trace(area) - np.exp(z)) + 0.5 * data[2] * shear
    return W + 0.5 * np.array([y, z]) @ (K - s * neo_hooke) @ np.array([y, z])


STIFFNESS = {
    "svk": lambda: isotropic_stiffness(LAMBDA, MU),
    "neo_hooke": lambda: isotropic_stiffness(LAMBDA, MU),
    "mooney_rivlin": lambda: isotropic_stiffness(
        KAPPA - 4 / 3 * (C10 + C01),
        2 * (C10 + C01),  # Lambda = kappa - 2/3 of the shear modulus
    ),
    "orthotropic": lambda: stiffness_matrix(YOUNG, SHEAR, POISSON),
    "composite": lambda: transverse_stiffness(*COMPOSITE),
    "soft_fibre": lambda: transverse_stiffness(*SOFT_FIBRE),
}


def isotropic_stiffness(lam, mu):
    D = np.diag([2 * mu] * 3 + [mu] * 3)
    D[:3, :3] += lam
    return D
