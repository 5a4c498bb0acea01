"""Case files: one TOML file describes one run."""

from __future__ import annotations

import difflib
import os
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from turbine_fenicsx.errors import InputError
from turbine_fenicsx.turbine.parameters import PRINTED_ARMS, Inertia, TurbineParameters
from turbine_fenicsx.turbine.quantities import (
    Acceleration,
    Density,
    EulerMoment,
    Kilograms,
    Metres,
    Pascal,
    Seconds,
    Torque,
    to_si,
)

Positive = Field(gt=0.0, allow_inf_nan=False)
Finite = Field(allow_inf_nan=False)
_DEFAULTS = TurbineParameters()


class Section(BaseModel):
    """A table of a case file; unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class TimeCase(Section):
    """Time step and end of the run [s]."""

    step: Annotated[Seconds, Positive] = 0.02
    end: Annotated[Seconds, Field(ge=0.0, allow_inf_nan=False)] = 12.0


Moment = Annotated[EulerMoment, Positive]


class NacelleCase(Section):
    """Mass [kg] and Euler values [kg m^2] of the nacelle."""

    mass: Annotated[Kilograms, Positive] = _DEFAULTS.nacelle.mass
    euler: tuple[Moment, Moment, Moment] = _DEFAULTS.nacelle.euler


class HubCase(NacelleCase):
    """The same of the hub."""

    mass: Annotated[Kilograms, Positive] = _DEFAULTS.hub.mass
    euler: tuple[Moment, Moment, Moment] = _DEFAULTS.hub.euler


class RigidBladeCase(NacelleCase):
    """The same of a rigid blade."""

    mass: Annotated[Kilograms, Positive] = _DEFAULTS.blade.mass
    euler: tuple[Moment, Moment, Moment] = _DEFAULTS.blade.euler


def _arm(value: Any) -> Any:
    """Either "printed" or a positive length [m]."""
    if value == "printed":
        return value
    try:
        arm = float(to_si(value, "m"))
    except (TypeError, ValueError):
        arm = 0.0
    if not 0.0 < arm < float("inf"):
        raise ValueError('give "printed" or a length in m, greater than 0')
    return arm


class TurbineCase(Section):
    """Rigid parts; ``model`` decides whether the blades are rigid or flexible."""

    model: Literal["rigid", "hybrid"] = "hybrid"
    blade_arm: Annotated[Literal["printed"] | float, BeforeValidator(_arm)] = "printed"
    angle_form: Literal["regular", "paper"] = "regular"
    hub_distance: Annotated[Metres, Positive] = _DEFAULTS.hub_distance
    nacelle: NacelleCase = NacelleCase()
    hub: HubCase = HubCase()
    blade: RigidBladeCase = RigidBladeCase()

    def parameters(self) -> TurbineParameters:
        """The parameters for the builders."""
        arms = PRINTED_ARMS if self.blade_arm == "printed" else (float(self.blade_arm),) * 3
        parts = {
            name: Inertia(part.mass, part.euler)
            for name, part in (("nacelle", self.nacelle), ("hub", self.hub), ("blade", self.blade))
        }
        return TurbineParameters(hub_distance=self.hub_distance, blade_arms=arms, **parts)


class BladeCase(Section):
    """Shape of a blade, see `turbine_fenicsx.meshing.BladeGeometry`."""

    hub_radius: Annotated[Metres, Positive] = 2.25
    length: Annotated[Metres, Positive] = 54.0
    stations: tuple[float, ...] = (0.0, 0.2, 1.0)
    chord: tuple[Annotated[Metres, Positive], ...] = (1.8, 3.0, 0.6)
    thickness: tuple[Annotated[Metres, Positive], ...] = (1.8, 1.5, 0.2)


class MeshCase(Section):
    """Mesh of the blades; ``file`` takes a mesh of one's own instead."""

    cell: Literal["hexahedron", "tetrahedron"] = "hexahedron"
    elements: tuple[
        Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]
    ] = (2, 2, 12)
    size: Annotated[Metres, Positive] | None = None
    degree: Literal[1, 2] = 1
    geometry_degree: Literal[1, 2] = 1
    file: str | None = None


Stiffness = Annotated[Pascal, Finite]
Ratio = Annotated[float, Finite]


class MaterialCase(Section):
    """Material of the blades: law, its constants [Pa, -] and density [kg/m^3]."""

    law: Literal["transversely_isotropic", "st_venant_kirchhoff", "neo_hooke"] = (
        "transversely_isotropic"
    )
    density: Annotated[Density, Positive] = 1500.0
    young: tuple[Stiffness, Stiffness, Stiffness] = (45e9, 15e9, 15e9)
    shear: tuple[Stiffness, Stiffness, Stiffness] = (5.4e9, 5.4e9, 5.4e9)
    poisson: tuple[Ratio, Ratio, Ratio] = (0.3, 0.3, 0.3)
    first_lame: Stiffness = 3.9e9
    shear_modulus: Stiffness = 0.975e9

    @model_validator(mode="after")
    def _check(self) -> MaterialCase:
        """Reject materials that are not positive definite."""
        self.make(("a1", "a2", "a3"))
        return self

    def make(self, frame: tuple[Any, Any, Any]) -> Any:
        """The material with the given axes."""
        from turbine_fenicsx.materials import NeoHooke, OrthotropicSVK, StVenantKirchhoff

        if self.law == "transversely_isotropic":
            return OrthotropicSVK(self.young, self.shear, self.poisson, frame)
        law = StVenantKirchhoff if self.law == "st_venant_kirchhoff" else NeoHooke
        return law(self.first_lame, self.shear_modulus)


class LoadsCase(Section):
    """Gravity, and hat functions of torque on the rotor and the yaw bearing, eq. (60)."""

    gravity: Annotated[Acceleration, Field(ge=0.0, allow_inf_nan=False)] = 9.81
    rotor_torque: Annotated[Torque, Finite] = 0.0
    yaw_torque: Annotated[Torque, Finite] = 0.0
    duration: Annotated[Seconds, Positive] = 3.0


class SolverCase(Section):
    """Solver of the step."""

    preconditioner: Literal["auto", "frozen", "iterative", "lu", "monolithic"] = "auto"
    tolerance: Annotated[float, Field(gt=0.0, lt=1.0)] = 1e-12
    max_iterations: Annotated[int, Field(ge=1)] = 30


class OutputCase(Section):
    """Output; ``fields_every`` is the simulated time between two outputs of fields, 0 = never."""

    fields_every: Annotated[Seconds, Field(ge=0.0, allow_inf_nan=False)] = 0.1


class Case(Section):
    """One run."""

    title: str = ""
    time: TimeCase = TimeCase()
    turbine: TurbineCase = TurbineCase()
    blade: BladeCase = BladeCase()
    mesh: MeshCase = MeshCase()
    material: MaterialCase = MaterialCase()
    loads: LoadsCase = LoadsCase()
    solver: SolverCase = SolverCase()
    output: OutputCase = OutputCase()

    @staticmethod
    def load(path: str | os.PathLike[str], overrides: Iterable[str] = ()) -> Case:
        """Read a case file.

        Args:
            path: TOML file.
            overrides: Changes such as ``"time.end=1.0"``.

        Returns:
            The case; ``mesh.file`` is made relative to the case file.

        Raises:
            InputError: with one sentence for every mistake.
        """
        try:
            text = Path(path).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
            raise InputError(f"cannot read the case file {str(path)!r}: {reason}") from None
        try:
            data = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise InputError(f"{str(path)!r} is not valid TOML: {error}") from None
        for override in overrides:
            _override(data, override)
        mesh = data.get("mesh")
        if isinstance(mesh, dict) and isinstance(mesh.get("file"), str):
            mesh["file"] = str(Path(path).parent / mesh["file"])
        return Case.parse(data)

    @staticmethod
    def parse(data: Mapping[str, Any]) -> Case:
        """Make a case from nested tables.

        Args:
            data: The tables.

        Raises:
            InputError: with one sentence for every mistake.
        """
        try:
            return Case.model_validate(data)
        except ValidationError as error:
            raise InputError("\n".join(_sentences(error))) from None


_WORDS = (
    ("input should", "must"),
    ("field required", "needs more entries"),
    ("a valid tuple", "a list"),
    ("extra inputs are not permitted", "unknown key"),
)
"""Pydantic's words for mistakes and ours."""


def _override(data: dict[str, Any], override: str) -> None:
    """Apply one ``key=value`` to nested tables."""
    key, separator, text = override.partition("=")
    names = [name.strip() for name in key.split(".")]
    if not separator or not all(names):
        raise InputError(f"cannot read {override!r}: write --set section.key=value")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        value = text.strip()
    table = data
    for name in names[:-1]:
        table = table.setdefault(name, {})
        if not isinstance(table, dict):
            raise InputError(f"cannot set {key.strip()!r}: {name!r} is not a table")
    table[names[-1]] = value


def _sentences(error: ValidationError) -> list[str]:
    """One sentence per mistake: key, value, what is allowed."""
    sentences = {}
    for item in error.errors(include_url=False):
        names = [str(name) for name in item["loc"]]
        if item["type"] == "extra_forbidden":
            sentences[".".join(names)] = f"unknown key {'.'.join(names)!r}{_nearest(names)}"
            continue
        # A union adds the name of the member that failed to the location.
        if item["type"] == "missing" and names[-1].isdecimal():
            names.pop()  # a list that is too short
        key = ".".join(n for n in names if n.isidentifier() or n.isdecimal()) or "the case"
        message = item["msg"].removeprefix("Value error, ")
        message = message[0].lower() + message[1:]
        for theirs, ours in _WORDS:
            message = message.replace(theirs, ours)
        value = item["input"]
        shown = "" if isinstance(value, dict | BaseModel) else f" = {value!r}"
        sentences.setdefault(key, f"{key}{shown}: {message}")
    return list(sentences.values())


def _nearest(names: list[str]) -> str:
    """Hint at the valid key that is nearest to an unknown one."""
    fields: Any = Case.model_fields
    for name in names[:-1]:
        model = fields[name].annotation if name in fields else None
        fields = getattr(model, "model_fields", {})
    known = [".".join([*names[:-1], name]) for name in fields]
    match = difflib.get_close_matches(".".join(names), known, n=1, cutoff=0.6)
    if match:
        return f"; did you mean {match[0]!r}?"
    where = f"[{'.'.join(names[:-1])}]" if names[:-1] else "a case file"
    return f"; {where} takes {', '.join(sorted(fields))}"
