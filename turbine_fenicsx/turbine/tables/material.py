"""The table of the material of the blades."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.quantities import Density, Number, Pascal, Viscosity
from turbine_fenicsx.case.rules import NotBeside, Only, Unless
from turbine_fenicsx.case.section import Finite, NotNegative, Positive, Section
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.plausible import Plausible

_OF_FILE = NotBeside("turbine.file", "which has the layup of the blades")
_OWN = (_OF_FILE, Unless("blade.model", "beam"))
_FIBRES = (*_OWN, Only("law", "transversely_isotropic", "transversely_isotropic_finite"))
_ISOTROPIC = (*_OWN, Only("law", "st_venant_kirchhoff", "neo_hooke"))

_MODULUS = Plausible(1e6, 2e12)

Stiffness = Annotated[Pascal, Finite]
Moduli = tuple[Stiffness, Stiffness, Stiffness]
Ratio = Annotated[Number, Finite]


class MaterialCase(Section):
    """Material of the blades: law, its constants [Pa, -], density [kg/m^3] and viscosity [Pa s].

    ``"transversely_isotropic_finite"`` has the stiffness of ``"transversely_isotropic"`` at rest
    and resists being crushed; it takes the shear modulus 23 from the others. Viscosities damp the
    blades, see `turbine_fenicsx.KelvinVoigt`.
    """

    law: Literal[
        "transversely_isotropic",
        "transversely_isotropic_finite",
        "st_venant_kirchhoff",
        "neo_hooke",
        "windio",
    ] = "transversely_isotropic"
    """Strain energy; ``"windio"`` is the layup of ``turbine.file``."""
    density: Annotated[Density, Positive, *_OWN, Plausible(20.0, 2e4)] = 1500.0
    """Density in the initial configuration."""
    young: Annotated[Moduli, *_FIBRES, _MODULUS] = (
        45e9,
        15e9,
        15e9,
    )
    """Young's moduli E₁, E₂, E₃ of the two transversely isotropic laws; 1 is the span."""
    shear: Annotated[Moduli, *_FIBRES, _MODULUS] = (
        5.4e9,
        5.4e9,
        5.4e9,
    )
    """Shear moduli G₁₂, G₁₃, G₂₃ of these two laws."""
    poisson: Annotated[tuple[Ratio, Ratio, Ratio], *_FIBRES] = (0.3, 0.3, 0.3)
    """Poisson's ratios 12, 13 and 23 of these two laws."""
    first_lame: Annotated[Stiffness, *_ISOTROPIC, _MODULUS] = 3.9e9
    """First Lame constant of the two isotropic laws."""
    shear_modulus: Annotated[Stiffness, *_ISOTROPIC, _MODULUS] = 0.975e9
    """Shear modulus of the two isotropic laws."""
    shear_viscosity: Annotated[Viscosity, NotNegative] = 0.0
    """Viscosity of the deviator of the strain rate."""
    bulk_viscosity: Annotated[Viscosity, NotNegative] = 0.0
    """Viscosity of the trace of the strain rate."""

    def make(self, frame: tuple[Any, Any, Any]) -> Any:
        """The material with the given axes."""
        return self.add_viscosity(self._elastic(frame))

    def add_viscosity(self, elastic: Any) -> Any:
        """A material with the viscosities of this table."""
        from turbine_fenicsx.materials.kelvin_voigt import KelvinVoigt

        if self.shear_viscosity == self.bulk_viscosity == 0.0:
            return elastic
        return KelvinVoigt(elastic, self.shear_viscosity, self.bulk_viscosity)

    def _elastic(self, frame: tuple[Any, Any, Any]) -> Any:
        """The material without viscosity."""
        from turbine_fenicsx.materials.neo_hooke import NeoHooke
        from turbine_fenicsx.materials.orthotropic import OrthotropicSVK
        from turbine_fenicsx.materials.st_venant_kirchhoff import StVenantKirchhoff
        from turbine_fenicsx.materials.transversely_isotropic import TransverselyIsotropic

        if self.law == "transversely_isotropic":
            return OrthotropicSVK(
                young=self.young, shear=self.shear, poisson=self.poisson, frame=frame
            )
        if self.law == "transversely_isotropic_finite":
            for name, i, j in (("young", 1, 2), ("shear", 0, 1), ("poisson", 0, 1)):
                values = getattr(self, name)
                if values[i] != values[j]:
                    raise ModelError(
                        f"material.{name} = {list(values)}: expected entries {i + 1} and {j + 1} "
                        f'to be equal with material.law = "{self.law}"'
                    )
            (E1, E2, _), (n12, _, n23) = self.young, self.poisson
            return TransverselyIsotropic(E1, E2, self.shear[0], n12, n23, frame[0])
        law = StVenantKirchhoff if self.law == "st_venant_kirchhoff" else NeoHooke
        return law(self.first_lame, self.shear_modulus)

    @check("law", "turbine.file")
    def _check_law(self, case: Any) -> str:
        """The law of layups belongs to a file, and the other way round."""
        law, file = self.law, case.turbine.file
        if case.turbine.model == "rigid" or (law == "windio") == (file is not None):
            return ""
        if file is None:
            return 'material.law = "windio": expected turbine.file, the windIO file with the layup'
        return f'material.law = "{law}": expected "windio" or none beside turbine.file'

    @check("law", "young", "shear", "poisson", "first_lame", "shear_modulus")
    def _check_stiffness(self, case: Any) -> str:
        """The material is positive definite."""
        if case.turbine.model == "rigid" or self.law == "windio":
            return ""
        try:
            with np.errstate(all="raise"):
                self.make(("a1", "a2", "a3"))
        except ModelError as error:
            return str(error)
        except (ArithmeticError, np.linalg.LinAlgError):  # numbers are absurdly large or small
            fibres = self.law.startswith("transversely")
            names = "young, shear, poisson" if fibres else "first_lame, shear_modulus"
            return f"material is not positive definite: {names} are out of range"
        return ""
