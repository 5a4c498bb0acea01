"""Claims about algorithmic stresses: what makes the step conserve energy for any material.

F (at the midpoint) and D = F_{n+1} - F_n are constants on a mesh of volume one, so that integrals
are values.
"""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh

from turbine_fenicsx import NeoHooke, OrthotropicSVK, StVenantKirchhoff
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.materials.base import second_piola_kirchhoff
from turbine_fenicsx.time_stepping.discrete_gradients import (
    ROUND_OFF,
    SMALL_INCREMENT,
    discrete_gradient_stress,
    general_stress,
    mean_stress,
)

LAWS = ("svk", "orthotropic", "neo_hooke")
FRAME = rotation_about((1.0, 2.0, 0.5), 1.1)
EPS = np.finfo(float).eps
MODULUS = 20.0
"""About the largest stiffness D of the three laws."""


def stress_at_mean_deformation(energy, F, D):
    """S(F_mid^T F_mid): second order, symmetric, but no discrete gradient of any energy."""
    return second_piola_kirchhoff(energy, F.T * F)


class TensionOnly:
    """St. Venant-Kirchhoff and fibres that bear tension only: the stress has a kink at C = I."""

    quadratic = False

    def strain_energy(self, C, parameter):
        E = 0.5 * (C - ufl.Identity(3))
        stretch = [E[0, 0], 0.36 * E[0, 0] + 0.96 * E[0, 1] + 0.64 * E[1, 1]]
        tension = [ufl.conditional(ufl.gt(e, 0.0), e, 0.0) for e in stretch]
        return 2.0 * ufl.inner(E, E) + parameter(7.0) * (tension[0] ** 2 + tension[1] ** 2)


def uncorrected_stress(energy, F, D):
    """The mean of the stresses at two Gauss points between C_n and C_{n+1}, and no more."""
    C, dC = F.T * F + 0.25 * D.T * D, F.T * D + D.T * F
    ends = (C + sign * 12.0**-0.5 * dC for sign in (-1, 1))
    return 0.5 * sum(second_piola_kirchhoff(energy, end) for end in ends)


class Step:
    """An algorithmic stress of a material as function of numpy arrays F_mid and D."""

    def __init__(self, comm, cells, law, stress=None):
        def constant(value):
            return fem.Constant(cells, np.array(value, dtype=float, order="C"))

        material = {
            "svk": lambda: StVenantKirchhoff(10.0, 5.0),
            "neo_hooke": lambda: NeoHooke(10.0, 5.0),
            "tension_only": TensionOnly,
            "orthotropic": lambda: OrthotropicSVK(
                young=(20.0, 8.0, 7.0),
                shear=(4.0, 3.0, 2.5),
                poisson=(0.3, 0.25, 0.3),
                frame=[constant(a) for a in FRAME.T],
            ),
        }[law]()
        if stress is None:
            stress = discrete_gradient_stress(material.quadratic)

        def energy(C):
            return material.strain_energy(C, constant)

        def form(integrand):
            compiled = fem.form(integrand * ufl.dx(domain=cells))
            return lambda: float(comm.allreduce(fem.assemble_scalar(compiled)))

        self._F, self._D, self._A = (constant(np.zeros((3, 3))) for _ in range(3))
        self._energy = form(energy(self._F.T * self._F))
        S = stress(energy, self._F, self._D)
        self._S = form(ufl.inner(S, self._A))

    def stress(self, F, D):
        self._F.value, self._D.value = F, D
        S = np.zeros((3, 3))
        for i in range(3):
            for j in range(3):
                self._A.value = np.outer(np.eye(3)[i], np.eye(3)[j])
                S[i, j] = self._S()
        return S

    def energy(self, F):
        self._F.value = F
        return self._energy()

    def defect(self, F, D):
        """S_alg : dC/2 - (W_{n+1} - W_n)."""
        dC = F.T @ D + D.T @ F
        return 0.5 * np.sum(self.stress(F, D) * dC) - (
            self.energy(F + 0.5 * D) - self.energy(F - 0.5 * D)
        )


@pytest.fixture(scope="module")
def cells(comm):
    return mesh.create_box(
        comm, [[0, 0, 0], [1, 1, 1]], [2, 1, 1], cell_type=mesh.CellType.hexahedron
    )


@pytest.fixture(scope="module")
def steps(comm, cells):
    return {law: Step(comm, cells, law) for law in LAWS}


@pytest.fixture(scope="module")
def kinked(comm, cells):
    return Step(comm, cells, "tension_only")


@pytest.fixture
def rng():
    return np.random.default_rng(30)


def pair(rng, size, strain=0.2):
    """A deformation at the midpoint and an increment of it whose |dC| is ``size``."""
    F = rotation_about(rng.normal(size=3), 1.0) @ (np.eye(3) + strain * rng.uniform(-1, 1, (3, 3)))
    D = rng.normal(size=(3, 3))
    return F, D * size / np.linalg.norm(F.T @ D + D.T @ F)


def tolerance(F, D, law="neo_hooke"):
    """Round-off of W_{n+1} - W_n and of S:dC.

    C is rounded by a few EPS; that is multiplied by the stress, at most modulus times strain, and
    once more for the rounding of the energies themselves. Thirty operations, none unlucky. The
    neo-Hookean energy is a difference of two terms as large as the modulus even at rest.
    """
    strain = np.linalg.norm(F.T @ F - np.eye(3)) + np.linalg.norm(D)
    rest = 0.2 if law == "neo_hooke" else 0.0
    return 30 * EPS * MODULUS * (strain * (1.0 + strain) + rest)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("size", [0.5, 0.1, 1e-2, 1e-3, 1e-5, 1e-8])
def test_algorithmic_stress_is_a_discrete_gradient_of_the_energy(steps, rng, law, size):
    for _ in range(4):
        F, D = pair(rng, size)
        assert abs(steps[law].defect(F, D)) <= tolerance(F, D, law)


@pytest.mark.parametrize("factor", [0.3, 0.9, 0.999, 1.001, 1.1, 3.0])
@pytest.mark.parametrize("strain", [0.0, 0.1, 0.3])
def test_general_stress_is_a_discrete_gradient_on_both_sides_of_its_threshold(
    steps, rng, factor, strain
):
    for _ in range(4):
        F, D = pair(rng, factor * SMALL_INCREMENT, strain)
        assert abs(steps["neo_hooke"].defect(F, D)) <= tolerance(F, D)


def kept(F, D):
    """What `TensionOnly` may lose of its energy: round-off, and brackets as small as that."""
    return tolerance(F, D, "tension_only") + ROUND_OFF * 2 * MODULUS


@pytest.mark.parametrize("size", [1e-2, 1.9e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9])
@pytest.mark.parametrize("strain", [0.0, 0.3])
def test_general_stress_is_a_discrete_gradient_where_the_stress_has_a_kink(
    kinked, rng, size, strain
):
    """With strain, two of the switches are open or closed all the way."""
    for _ in range(4):
        F, D = pair(rng, size, strain)
        assert abs(kinked.defect(F, D)) <= kept(F, D)


@pytest.mark.parametrize("size", [1.9e-3, 1e-4, 1e-5])
def test_a_kink_is_lost_without_a_correction(comm, cells, rng, size):
    """The assertion above rejects a correction that is left out for small increments."""
    step = Step(comm, cells, "tension_only", uncorrected_stress)
    F, D = pair(rng, size, 0.0)
    assert abs(step.defect(F, D)) > 1e-3 * size**2 * MODULUS
    assert abs(step.defect(F, D)) > 10 * kept(F, D)


@pytest.mark.parametrize("size", [1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("strain", [0.0, 0.1])
def test_no_round_off_is_added_to_a_smooth_stress(comm, cells, steps, rng, size, strain):
    """Divided by |dC| it would be ten thousand times that of the stress itself."""
    plain = Step(comm, cells, "neo_hooke", uncorrected_stress)
    for _ in range(4):
        F, D = pair(rng, size, strain)
        difference = steps["neo_hooke"].stress(F, D) - plain.stress(F, D)
        assert np.max(np.abs(difference)) <= tolerance(F, D)


def test_general_stress_does_not_jump_at_its_threshold(steps, rng):
    """What the correction changes there is the round-off of W over |dC|."""
    for _ in range(4):
        F, D = pair(rng, SMALL_INCREMENT, strain=0.3)
        below, above = (steps["neo_hooke"].stress(F, f * D) for f in (1 - 1e-9, 1 + 1e-9))
        # 1e-9 of the threshold moves the stress itself by 1e-9 * 1e-6; round-off/|dC| is 1e-11
        assert np.max(np.abs(above - below)) <= 10 * tolerance(F, D) / SMALL_INCREMENT


def test_midpoint_stress_conserves_quadratic_energies_only(comm, cells, rng):
    """The assertion above rejects a stress that is merely second order."""
    step = Step(comm, cells, "neo_hooke", mean_stress)
    for size in (0.5, 0.1, 1e-2):
        F, D = pair(rng, size)
        assert abs(step.defect(F, D)) > 100 * tolerance(F, D)


@pytest.mark.parametrize("law", ["svk", "neo_hooke"])
def test_stress_at_the_mean_deformation_conserves_no_energy(comm, cells, rng, law):
    step = Step(comm, cells, law, stress_at_mean_deformation)
    for size in (0.5, 0.1, 1e-2):
        F, D = pair(rng, size)
        assert abs(step.defect(F, D)) > 100 * tolerance(F, D, law)


@pytest.mark.parametrize("law", ["svk", "orthotropic"])
def test_general_stress_is_a_discrete_gradient_of_quadratic_energies_too(comm, cells, rng, law):
    """It need not know that W is quadratic: then both stresses are the same."""
    general, mean = Step(comm, cells, law, general_stress), Step(comm, cells, law, mean_stress)
    for size in (0.5, 1e-3):
        F, D = pair(rng, size)
        assert abs(general.defect(F, D)) <= 2 * tolerance(F, D, law)
        difference = np.max(np.abs(general.stress(F, D) - mean.stress(F, D)))
        assert difference <= 4 * tolerance(F, D, law) / size  # round-off of W over |dC|


@pytest.mark.parametrize("law", ["svk", "orthotropic"])
def test_mean_stress_is_the_mean_of_the_stresses_at_the_ends(steps, rng, law):
    F, D = pair(rng, 0.5)
    ends = [steps[law].stress(F + s * 0.5 * D, np.zeros((3, 3))) for s in (1, -1)]
    assert np.allclose(
        steps[law].stress(F, D), 0.5 * (ends[0] + ends[1]), rtol=0, atol=tolerance(F, D, law)
    )


@pytest.mark.parametrize("law", LAWS)
def test_algorithmic_stress_without_increment_is_the_stress(comm, cells, steps, rng, law):
    """No 0/0, exactly at rest and for tiny increments."""
    plain = Step(comm, cells, law, stress_at_mean_deformation)
    F, D = pair(rng, 1.0)
    S = plain.stress(F, 0 * D)
    assert np.allclose(steps[law].stress(F, 0 * D), S, rtol=0, atol=tolerance(F, 0 * D, law))
    # Squares that underflow among them; and where round-off of W over |dC| would be noise.
    for size in (1e-300, 1e-160, 1e-20, 1e-9, 1e-7, 1e-6):
        assert np.allclose(
            steps[law].stress(F, size * D),
            S,
            rtol=0,
            atol=tolerance(F, 0 * D, law) + MODULUS * size**2,
        )


@pytest.mark.parametrize("law", LAWS)
def test_algorithmic_stress_approaches_the_midpoint_stress_with_second_order(
    comm, cells, steps, rng, law
):
    plain = Step(comm, cells, law, stress_at_mean_deformation)
    F, D = pair(rng, 0.2)
    gaps = [
        np.linalg.norm(steps[law].stress(F, h * D) - plain.stress(F, 0 * D)) for h in (1.0, 0.1)
    ]
    # a factor of 100, up to the next term h^4, some per cent at h = 1
    assert gaps[0] / gaps[1] == pytest.approx(100, rel=0.1)


@pytest.mark.parametrize("law", LAWS)
def test_algorithmic_stress_is_symmetric_and_knows_no_rotation(steps, rng, law):
    F, D = pair(rng, 0.3)
    S = steps[law].stress(F, D)
    assert np.allclose(S, S.T, rtol=0, atol=tolerance(F, D, law))
    Q = rotation_about((1.0, 0.2, -0.5), 2.1)
    assert np.allclose(steps[law].stress(Q @ F, Q @ D), S, rtol=0, atol=2 * tolerance(F, D, law))


@pytest.mark.parametrize("law", LAWS)
def test_a_finite_rigid_rotation_within_a_step_makes_no_stress(steps, law):
    R0, R1 = rotation_about((1, 0, 0), 0.3), rotation_about((1, 2, 0.5), 1.5)
    S = steps[law].stress(0.5 * (R0 + R1), R1 - R0)
    assert np.max(np.abs(S)) <= 30 * EPS * MODULUS


def test_the_stress_is_chosen_by_the_kind_of_energy():
    assert discrete_gradient_stress(quadratic=True) is mean_stress
    assert discrete_gradient_stress(quadratic=False) is general_stress
