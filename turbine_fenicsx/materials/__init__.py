"""Hyperelastic materials as UFL strain energies, one file each."""

from turbine_fenicsx.materials.base import Material
from turbine_fenicsx.materials.neo_hooke import NeoHooke
from turbine_fenicsx.materials.orthotropic import OrthotropicSVK
from turbine_fenicsx.materials.st_venant_kirchhoff import StVenantKirchhoff

__all__ = ["Material", "NeoHooke", "OrthotropicSVK", "StVenantKirchhoff"]
