"""Claims about materials at large strains."""

import numpy as np
import pytest
from material_laws import (
    COMPOSITE,
    FRAME,
    LAWS,
    QUADRATIC,
    SOFT_FIBRE,
    STIFFNESS,
    TRANSVERSE,
    Law,
    transverse_stiffness,
)
from scipy.optimize import brentq

from turbine_fenicsx.materials.orthotropic import OrthotropicSVK


def stretched(stretches):
    """C of stretches along the axes of the frame."""
    return (FRAME * np.square(stretches)) @ FRAME.T


def force(law, stretches, axis=0):
    """Force per area at rest along an axis of the frame."""
    a = FRAME[:, axis]
    return stretches[axis] * a @ law.stress(stretched(stretches)) @ a


STRETCHES = np.geomspace(1.0, 0.05, 25)


@pytest.mark.parametrize("law", [law for law in LAWS if law not in QUADRATIC])
@pytest.mark.parametrize("axis", range(3))
def test_resistance_to_compression_grows_without_end(laws, law, axis):
    """Down to 5 % of the length, sides held; a linear force would end at -0.95 of the stiffness."""
    forces = [force(laws[law], np.where(np.arange(3) == axis, s, 1.0), axis) for s in STRETCHES]
    assert np.all(np.diff(forces) < 0)
    assert forces[-1] < -5.0 * STIFFNESS[law]()[axis, axis]


def test_st_venant_kirchhoff_gives_way_in_compression(comm, cells):
    """The same constants as the law above: the force is largest at 1/sqrt(3) of the length."""
    E1, E2, G, n12, n23 = COMPOSITE
    data = {
        "young": (E1, E2, E2),
        "shear": (G, G, E2 / (2 * (1 + n23))),
        "poisson": (n12, n12, n23),
    }
    law = Law(comm, cells, lambda a: OrthotropicSVK(**data, frame=tuple(a)))
    forces = [force(law, (s, 1.0, 1.0)) for s in STRETCHES]
    assert STRETCHES[np.argmin(forces)] == pytest.approx(3**-0.5, rel=0.07)
    assert forces[-1] > 0.15 * min(forces)
    assert law.energy(stretched((1e-8, 1.0, 1.0))) < 0.13 * transverse_stiffness(*COMPOSITE)[0, 0]


@pytest.mark.parametrize("law", TRANSVERSE)
def test_resistance_to_compression_along_the_fibre_grows_with_free_sides_too(laws, law):
    a2, side, forces = FRAME[:, 1], 1.0, []

    def stress_at_side(side, stretch):
        return a2 @ laws[law].stress(stretched((stretch, side, side))) @ a2

    for stretch in STRETCHES:
        side = brentq(stress_at_side, 0.9 * side, 3.0 * side, args=(stretch,), xtol=1e-12)
        forces.append(force(laws[law], (stretch, side, side)))
    assert np.all(np.diff(forces) < 0)
    assert forces[-1] < -8.0 * (COMPOSITE if law == "composite" else SOFT_FIBRE)[0]


@pytest.mark.parametrize("law", ["mooney_rivlin", *TRANSVERSE])
def test_energy_is_positive_for_large_strains_and_grows_without_bound(laws, rng, law):
    modulus = np.min(np.diag(STIFFNESS[law]()))
    for size in (0.5, 1.0, 2.0):
        for _ in range(20):
            Q, stretches = (
                np.linalg.qr(rng.normal(size=(3, 3)))[0],
                np.exp(size * rng.normal(size=3)),
            )
            assert laws[law].energy((Q * stretches**2) @ Q.T) > 1e-3 * modulus
    for axis in (*FRAME.T, np.ones(3) / 3**0.5):
        for sign in (1, -1):
            energies = [
                laws[law].energy(np.eye(3) + (np.exp(2 * sign * x) - 1) * np.outer(axis, axis))
                for x in (2.0, 4.0, 8.0)
            ]
            assert energies[0] > modulus and np.all(np.diff(energies) > energies[:2])
    for stretches in ((0.02,) * 3, (50.0,) * 3, (0.02, 50.0, 0.02), (50.0, 0.02, 50.0)):
        assert laws[law].energy(stretched(stretches)) > 10 * modulus
