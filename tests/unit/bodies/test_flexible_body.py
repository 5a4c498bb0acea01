"""Claims about the data of a flexible body."""

import pytest

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.materials.st_venant_kirchhoff import StVenantKirchhoff

SVK = StVenantKirchhoff(1.0, 1.0)


@pytest.mark.parametrize("density", [0.0, -1500.0, float("nan")])
def test_density_must_be_positive(density):
    words = f"density of .* 'blade' must be positive, got {density:g}"
    with pytest.raises(ValueError, match=words):
        FlexibleBody("blade", None, SVK, density)


@pytest.mark.parametrize("degree", [0, 3, 1.5])
def test_degree_must_be_one_or_two(degree):
    with pytest.raises(ValueError, match=f"degree of 'blade' must be 1 or 2, got {degree}"):
        FlexibleBody("blade", None, SVK, 1500.0, degree)


@pytest.mark.parametrize("material", [None, "steel", 2e9])
def test_material_must_have_a_strain_energy(material):
    with pytest.raises(TypeError, match="material of 'blade' needs strain_energy"):
        FlexibleBody("blade", None, material, 1500.0)
