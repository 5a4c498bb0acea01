"""A whole turbine from a windIO file."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.materials.ply import PlyMaterial
from turbine_fenicsx.windio.blade import WindIOBlade, read_blade
from turbine_fenicsx.windio.control import ControllerData, read_control
from turbine_fenicsx.windio.curves import Curve, read_curve
from turbine_fenicsx.windio.entry import Entry
from turbine_fenicsx.windio.implausible_entries import list_implausible
from turbine_fenicsx.windio.materials import WindIOMaterial, read_materials
from turbine_fenicsx.windio.polars import PolarSource
from turbine_fenicsx.windio.references import References, read_references
from turbine_fenicsx.windio.rigid_parts import (
    Hub,
    Nacelle,
    RigidPart,
    read_hub,
    read_nacelle,
    read_rigid_part,
)
from turbine_fenicsx.windio.section_properties import (
    SectionProperties,
    read_damping,
    read_section_properties,
)
from turbine_fenicsx.windio.yaml_file import read_yaml
from turbine_fenicsx.windio.yaml_text import YamlError

HIGHEST = 1000.0
"""A tower is no higher [m]."""


@dataclass(frozen=True, eq=False)
class Tower:
    """An upright tube.

    Args:
        base: Height of its base above ground or mean sea level [m].
        top: Height of its top [m].
        diameter: Outer diameter over the fraction of its height [m].
        wall: Thickness of the wall over the fraction of its height [m].
        outfitting: Its mass over that of the tube alone [-].
    """

    base: float
    top: float
    diameter: Curve
    wall: Curve
    material: PlyMaterial
    outfitting: float

    @property
    def mass(self) -> float:
        """Mass of tube and outfitting [kg]."""
        s = np.linspace(0.0, 1.0, 401)
        area = np.pi * self.wall(s) * (self.diameter(s) - self.wall(s))
        density = self.material.density * self.outfitting
        return density * (self.top - self.base) * Curve(s, area).integral


def read_tower(entry: Entry, materials: Mapping[str, PlyMaterial]) -> Tower:
    """The component `tower`."""
    x, y, z = (
        read_curve(entry["reference_axis"][key], -HIGHEST, HIGHEST, whole=True) for key in "xyz"
    )
    if max(np.ptp(x.values), np.ptp(y.values)) > 1e-3:
        entry["reference_axis"].fail("must be upright: x and y must not change")
    if (np.diff(z.values) <= 0.0).any():
        entry["reference_axis"]["z"].fail("must rise from the base to the top")
    diameter = read_curve(entry["outer_shape"]["outer_diameter"], 0.01, 100.0, whole=True)
    structure = entry["structure"]
    layers = [(e["material"].text(), e) for e in structure["layers"].entries()]
    names = {name for name, _ in layers}
    if len(names) != 1:
        structure["layers"].fail(f"must be of one material, got {len(names)}")
    name = names.pop()
    if name not in materials:
        structure["layers"].fail(f"are of {name!r}, which is not among the materials of the file")
    walls = [read_curve(layer["thickness"], 0.0, 5.0, whole=True) for _, layer in layers]
    grid = np.unique(np.concatenate([wall.grid for wall in walls]))
    wall = Curve(grid, np.asarray(sum(wall(grid) for wall in walls)))
    wrong = grid[(wall.values <= 0.0) | (2.0 * wall.values >= diameter(grid))]
    if len(wrong):
        structure["layers"].fail(
            f"must be thicker than 0 and thinner than the radius, got {wall(wrong[0]):g} m at "
            f"station {wrong[0]:g}"
        )
    outfitting = structure.get("outfitting_factor")
    return Tower(
        base=float(z.values[0]),
        top=float(z.values[-1]),
        diameter=diameter,
        wall=wall,
        material=materials[name],
        outfitting=outfitting.number(1.0, 10.0) if outfitting else 1.0,
    )


T = TypeVar("T")

FOUNDATIONS = ("monopile", "jacket", "floating_platform", "mooring")
"""Components below the tower."""

_OLD_KEYS = ("outer_shape_bem", "internal_structure_2d_fem", "elastic_properties_mb")
"""Keys of a blade in windIO 1."""


@dataclass(frozen=True, eq=False)
class WindIOTurbine:
    """Contents of a windIO file that this package reads.

    Args:
        name: Name of the turbine.
        blade_count: Number of blades.
        upwind: Whether the rotor stands before the tower.
        hub_height: Of the rotor centre above ground or mean sea level; None where not given [m].
        rated_power: None where not given [W].
        rated_speed: Rated speed of the rotor; None where not given [rad/s].
        control: The controller; None where the file has none.
        blade: The blade, which all have in common.
        polars: The polars of its airfoils.
        hub: The hub.
        nacelle: Drivetrain; None where the file has none.
        yaw: Yaw system, axes and origin as for the nacelle; None where the file has none.
        tower: The tower; None where the file has none.
        materials: All materials by their names.
        blade_sections: The blade's section matrices; None where the file has none.
        references: Numbers that follow from others as well.
        blade_damping: Factors ``mu`` of the stiffness in the damping matrix of the blade, see
            `read_damping`; zero where the file has none [s].
        tower_damping: Those of the tower.
        foundations: Names of the components below the tower, which are not read.
        warnings: Numbers whose unit is probably another one, a sentence each.
    """

    name: str
    blade_count: int
    upwind: bool
    hub_height: float | None
    rated_power: float | None
    rated_speed: float | None
    control: ControllerData | None
    blade: WindIOBlade
    polars: PolarSource
    hub: Hub
    nacelle: Nacelle | None
    yaw: RigidPart | None
    tower: Tower | None
    materials: dict[str, WindIOMaterial]
    blade_sections: SectionProperties | None
    references: References
    blade_damping: tuple[float, ...] = (0.0,) * 6
    tower_damping: tuple[float, ...] = (0.0,) * 6
    foundations: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


def read_turbine(path: str | os.PathLike[str]) -> WindIOTurbine:
    """Read a file of windIO 2.

    Args:
        path: The file; `find_turbine_file` finds those of an installed windIO.

    Raises:
        InputError: with one sentence if it cannot be read or is of windIO 1, else with one for each
            component in which anything that is needed is missing or wrong.
    """
    root = _read_root(path)
    components, problems = root["components"], Problems()
    materials = problems.attempt(lambda: _read_materials(root))
    plies = {key: material.ply for key, material in (materials or {}).items()}
    hub = problems.attempt(lambda: read_hub(components["hub"]))
    radius = hub.radius if hub else 0.0
    entry, airfoils = components["blade"], root["airfoils"]
    blade = problems.attempt(
        lambda: None if materials is None else read_blade(entry, airfoils, plies, radius)
    )
    of_nacelle, of_yaw, of_tower = (components.get(x) for x in ("drivetrain", "yaw", "tower"))
    nacelle = problems.attempt(lambda: read_nacelle(of_nacelle) if of_nacelle else None)
    yaw = problems.attempt(lambda: read_rigid_part(of_yaw) if of_yaw else None)
    tower = problems.attempt(
        lambda: read_tower(of_tower, plies) if of_tower and materials is not None else None
    )
    section = root.get("control")
    control = problems.attempt(lambda: read_control(section) if section else None)
    problems.raise_all()
    assert hub and blade
    structure = components["blade"]["structure"]
    sections = structure.get("elastic_properties") or components["blade"].get("elastic_properties")
    tower_sections = of_tower["structure"].get("elastic_properties") if of_tower else None
    assembly = root["assembly"]
    orientation = assembly.get("rotor_orientation")
    height, power = (assembly.get(key) for key in ("hub_height", "rated_power"))
    return WindIOTurbine(
        name=root["name"].text(),
        blade_count=_read_blade_count(assembly),
        upwind=orientation is None or orientation.text().lower() != "downwind",
        hub_height=height.number(0.0) if height else None,
        rated_power=power.number(0.0) if power else None,
        rated_speed=control.rated_speed if control else None,
        control=control,
        blade=blade,
        polars=PolarSource(root["airfoils"], components["blade"]["outer_shape"]["airfoils"]),
        hub=hub,
        nacelle=nacelle,
        yaw=yaw,
        tower=tower,
        materials=materials or {},
        blade_sections=read_section_properties(sections) if sections else None,
        blade_damping=read_damping(sections),
        tower_damping=read_damping(tower_sections),
        foundations=tuple(key for key in FOUNDATIONS if key in components),
        references=read_references(root),
        warnings=tuple(list_implausible(root)),
    )


def _read_materials(root: Entry) -> dict[str, WindIOMaterial]:
    """The materials; none is needed where neither blade nor tower has layers."""
    parts = (root["components"].get(name) for name in ("blade", "tower"))
    structures = (part.get("structure") for part in parts if part)
    layered = any(structure is not None and "layers" in structure for structure in structures)
    return read_materials(root["materials"]) if layered or "materials" in root else {}


def _read_root(path: str | os.PathLike[str]) -> Entry:
    """The contents of a file of windIO 2."""
    name = Path(path).name
    try:
        root = Entry(read_yaml(path), name)
    except YamlError as error:
        Entry(None, name).fail(str(error))
    _check_version(root)
    return root


class Problems:
    """Sentences about parts of a file, each of which is read although others are wrong."""

    def __init__(self) -> None:
        self._sentences: list[str] = []

    def attempt(self, read: Callable[[], T]) -> T | None:
        """The result of a function that reads; None if something is wrong there."""
        try:
            return read()
        except ModelError as error:
            self._sentences += str(error).splitlines()
        return None

    def raise_all(self) -> None:
        """Raise a ModelError if something was wrong."""
        if self._sentences:
            raise ModelError("\n".join(dict.fromkeys(self._sentences)))


def _check_version(root: Entry) -> None:
    blade = root["components"]["blade"]
    version = root["windIO_version"].text() if "windIO_version" in root else None
    old = any(key in blade for key in _OLD_KEYS)
    if old or (version or "").startswith(("1", "0")):
        root.fail(
            "is of windIO 1, which is not read: convert it with windIO's own "
            "windIO.converters.windIO2windIO (`python -m windIO.converters.windIO2windIO -i "
            "OLD.yaml -o ./NEW.yaml`), or take the turbine's file of windIO 2"
        )
    if version is None:
        root.fail("has no 'windIO_version'")
    if version.split(".")[0] != "2":
        root.fail(f"is of windIO {version}, expected version 2")


def _read_blade_count(assembly: Entry) -> int:
    count = assembly["number_of_blades"].number(1.0, 10.0)
    if not count.is_integer():
        assembly["number_of_blades"].fail(f"must be a whole number, got {count:g}")
    return int(count)
