"""Claims about the transversely isotropic law."""

import numpy as np
import pytest
from material_laws import (
    COMPOSITE,
    FRAME,
    LAMBDA,
    MU,
    TRANSVERSE,
    Law,
    deformation,
    energy_by_hand,
    transverse_stiffness,
)

from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.materials.transversely_isotropic import (
    TransverselyIsotropic,
    neo_hookean_share,
)


@pytest.mark.parametrize("law", TRANSVERSE)
def test_transversely_isotropic_law_is_isotropic_about_its_fibre(laws, rng, law):
    for _ in range(3):
        _, C = deformation(rng, 0.4)
        W = laws[law].energy(C)
        for angle in (0.3, 1.0, 2.5):
            Q = rotation_about(FRAME[:, 0], angle)
            assert laws[law].energy(Q.T @ C @ Q) == pytest.approx(W, rel=1e-12)


def test_length_of_the_fibre_vector_does_not_matter(comm, cells, laws, rng):
    law = Law(comm, cells, lambda a: TransverselyIsotropic(*COMPOSITE, -3.0 * a[0]))
    _, C = deformation(rng)
    assert law.energy(C) == pytest.approx(laws["composite"].energy(C), rel=1e-13)


def test_transversely_isotropic_law_with_isotropic_constants_is_neo_hookean(comm, cells, rng):
    E, nu = MU * (3 * LAMBDA + 2 * MU) / (LAMBDA + MU), LAMBDA / (2 * (LAMBDA + MU))
    law = Law(comm, cells, lambda a: TransverselyIsotropic(E, E, MU, nu, nu, a[0]))
    for _ in range(3):
        _, C = deformation(rng, 0.4)
        assert law.energy(C) == pytest.approx(energy_by_hand("neo_hooke", C), rel=1e-12)


def test_stiffness_of_the_transversely_isotropic_law_is_given():
    D = TransverselyIsotropic(*COMPOSITE, None).stiffness()
    assert np.allclose(D, transverse_stiffness(*COMPOSITE), rtol=1e-14, atol=0)


def test_neo_hookean_share_is_the_largest_that_leaves_a_convex_rest(rng):
    """For every stiffness that is positive definite; usual composites have the whole share."""
    for data in (COMPOSITE, (140.0, 10.0, 5.0, 0.3, 0.4), (12.0, 0.8, 0.7, 0.4, 0.45)):
        assert neo_hookean_share(transverse_stiffness(*data)) == 1.0
    shares = []
    while len(shares) < 200:
        data = (*np.exp(2 * rng.normal(size=3)), *rng.uniform(-0.99, 0.99, 2))
        try:
            D = transverse_stiffness(*data)
        except ValueError:
            continue
        mu, k, s = (D[1, 1] - D[1, 2]) / 2, (D[1, 1] + D[1, 2]) / 2, neo_hookean_share(D)
        K = np.array([[D[0, 0], D[0, 1]], [D[0, 1], k]])
        lowest = [np.linalg.eigvalsh(K - f * s * np.diag([2 * mu, mu]))[0] for f in (1, 1.001)]
        assert 0.0 < s <= 1.0 and lowest[0] >= -1e-12 * D[0, 0].clip(k)
        assert s == 1.0 or lowest[1] < 0.0
        shares.append(s)
    assert 20 < shares.count(1.0) < 180


@pytest.mark.parametrize("change", [(0, 0.0), (1, -1.0), (2, 0.0), (2, float("nan")), (0, np.inf)])
def test_transversely_isotropic_moduli_must_be_positive(change):
    data = list(COMPOSITE)
    data[change[0]] = change[1]
    with pytest.raises(ValueError, match="material is not positive definite"):
        TransverselyIsotropic(*data, None)


@pytest.mark.parametrize("ratios", [(0.3, 1.0), (0.3, -1.0), (1.74, 0.0), (0.9, 0.6)])
def test_transversely_isotropic_ratios_must_leave_a_positive_energy(ratios):
    with pytest.raises(ValueError, match="material is not positive definite"):
        TransverselyIsotropic(*COMPOSITE[:3], *ratios, None)
