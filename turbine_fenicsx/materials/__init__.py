"""Hyperelastic materials as UFL strain energies, and damping, one file each."""

from turbine_fenicsx.materials.base import Material, Viscous
from turbine_fenicsx.materials.kelvin_voigt import KelvinVoigt
from turbine_fenicsx.materials.laminate import Laminate
from turbine_fenicsx.materials.mooney_rivlin import MooneyRivlin
from turbine_fenicsx.materials.neo_hooke import NeoHooke
from turbine_fenicsx.materials.orthotropic import OrthotropicSVK
from turbine_fenicsx.materials.st_venant_kirchhoff import StVenantKirchhoff
from turbine_fenicsx.materials.transversely_isotropic import TransverselyIsotropic

__all__ = [
    "KelvinVoigt",
    "Laminate",
    "Material",
    "MooneyRivlin",
    "NeoHooke",
    "OrthotropicSVK",
    "StVenantKirchhoff",
    "TransverselyIsotropic",
    "Viscous",
]
