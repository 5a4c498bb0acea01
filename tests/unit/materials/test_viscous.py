"""Claims about viscous stress."""

import numpy as np
import pytest
import ufl
from dolfinx import fem
from material_laws import LAMBDA, MU

from turbine_fenicsx import KelvinVoigt, NeoHooke
from turbine_fenicsx.materials.base import Material, Viscous


@pytest.fixture(scope="module")
def viscous_stress(comm, cells):
    """S_v of a Kelvin-Voigt material as a function of a rate of strain."""
    rate, A = (fem.Constant(cells, np.zeros((3, 3))) for _ in range(2))
    material = KelvinVoigt(NeoHooke(LAMBDA, MU), 0.7, 0.4)
    S = material.viscous_stress(rate, lambda c: fem.Constant(cells, np.array(c, dtype=float)))
    form = fem.form(ufl.inner(S, A) * ufl.dx(domain=cells))

    def evaluate(E_dot):
        rate.value, S = E_dot, np.zeros((3, 3))
        for index in np.ndindex(3, 3):
            A.value = np.zeros((3, 3))
            A.value[index] = 1.0
            S[index] = comm.allreduce(fem.assemble_scalar(form))
        return S

    return evaluate


def test_viscous_stress_is_that_of_its_two_viscosities(viscous_stress, rng):
    for _ in range(3):
        E_dot = rng.normal(size=(3, 3))
        E_dot += E_dot.T
        trace = np.trace(E_dot)
        S = viscous_stress(E_dot)
        expected = 2 * 0.7 * (E_dot - trace / 3 * np.eye(3)) + 0.4 * trace * np.eye(3)
        assert np.allclose(S, expected, rtol=0, atol=1e-14)
        assert np.array_equal(S, S.T) and np.sum(S * E_dot) > 0.0


def test_viscous_material_keeps_its_elastic_energy():
    class Elastic:
        quadratic = True

        def strain_energy(self, C, parameter):
            return "W", C, parameter

    material = KelvinVoigt(Elastic(), 1.0)
    assert isinstance(material, Material) and isinstance(material, Viscous)
    assert material.strain_energy("C", "parameter") == ("W", "C", "parameter")
    assert material.quadratic and not KelvinVoigt(NeoHooke(1.0, 1.0), 1.0).quadratic
    assert material.bulk_viscosity == 0.0


@pytest.mark.parametrize("name", ["shear", "bulk"])
@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_viscosities_that_are_negative_or_no_numbers_are_refused(name, value):
    data = {"shear_viscosity": 1.0, "bulk_viscosity": 1.0} | {f"{name}_viscosity": value}
    with pytest.raises(
        ValueError, match=f"{name} viscosity must not be negative, got {value:g} Pa s"
    ):
        KelvinVoigt(NeoHooke(1.0, 1.0), **data)
    assert KelvinVoigt(NeoHooke(1.0, 1.0), 0.0).shear_viscosity == 0.0


def test_elastic_part_must_be_a_material_and_not_viscous_itself():
    with pytest.raises(TypeError, match="must be a material, got int 3"):
        KelvinVoigt(3, 1.0)
    with pytest.raises(TypeError, match=r"must not be viscous itself, got .*KelvinVoigt"):
        KelvinVoigt(KelvinVoigt(NeoHooke(1.0, 1.0), 1.0), 1.0)
