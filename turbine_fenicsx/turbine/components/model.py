"""From a case to a turbine: its components, its parts, its system."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from mpi4py import MPI

from turbine_fenicsx.case.contradictions import find_contradictions, list_checks
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records.conventions import NACELLE, PART_NUMBERS
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.inflow import make_inflow
from turbine_fenicsx.turbine.components.component import Assembly, Component, Turbine
from turbine_fenicsx.turbine.components.control import Control
from turbine_fenicsx.turbine.components.drivetrain import Drivetrain
from turbine_fenicsx.turbine.components.flexible_blades import FlexibleBlades
from turbine_fenicsx.turbine.components.generator import Generator
from turbine_fenicsx.turbine.components.loads import Loads
from turbine_fenicsx.turbine.components.nacelle import Nacelle, Yaw
from turbine_fenicsx.turbine.components.pitch import Pitch
from turbine_fenicsx.turbine.components.rigid_blades import RigidBlades
from turbine_fenicsx.turbine.components.structural_damping import StructuralDamping
from turbine_fenicsx.turbine.components.tower import Tower
from turbine_fenicsx.turbine.components.wind import Wind
from turbine_fenicsx.wind.inflow import PlacedInflow


def list_components(case: Case) -> list[Component]:
    """Components of a case from the ground up."""
    tower = [Tower()] if case.tower.flexible else []
    rigid = case.turbine.model == "rigid"
    rotor = [RigidBlades(), Pitch()] if rigid else [Pitch(), FlexibleBlades()]
    wind = [Wind()] if case.wind.blows else []
    d = case.drivetrain
    drivetrain = [Drivetrain()] if d.model != "none" or d.friction > 0.0 else []
    yaw = [Yaw()] if case.yaw.drive != "free" else []
    control = [Control()] if case.control.kind != "none" or case.event else []
    generator = [Generator()] if case.generator.keeps != "nothing" else []
    damped = (not rigid and case.blade.damping.acts) or (
        case.tower.flexible and case.tower.damping.acts
    )
    damping = [StructuralDamping()] if damped else []
    behind = [*damping, *generator, *drivetrain, *yaw, *control]
    return [*tower, Nacelle(), Loads(), *rotor, *wind, *behind]


def assemble(
    case: Case,
    components: Iterable[Component],
    comm: MPI.Intracomm,
    inflow: PlacedInflow | None = None,
) -> Assembly:
    """Build the parts of components, each on those before it. Collective.

    Args:
        case: The case.
        components: From the ground up.
        comm: Communicator.
        inflow: The wind; that of the case if None.

    Raises:
        ModelError: with one sentence for every mistake that a component finds.
        InputError: if a file cannot be read or written.
    """
    components = list(components)
    for c in components:
        if isinstance(c, type) or not isinstance(c, Component):
            raise ModelError(f"a component of a turbine needs the methods of Component, got {c!r}")
    mistakes = on_rank0(comm, lambda: [*_find_mistakes(case, components)])
    if mistakes:
        raise ModelError("\n".join(mistakes))
    inflow = make_inflow(case, comm) if inflow is None else inflow
    assembly = Assembly(case, comm, plan_rotor(case, comm), inflow=inflow)
    for component in components:
        assembly.parts.extend(component.parts(assembly))
    return assembly


def _find_mistakes(case: Case, components: Iterable[Component]) -> Iterator[str]:
    """Mistakes in a case, which may have changed since it was read, and in components."""
    for mistake in find_contradictions(case, list_checks(case), set()):
        yield mistake.sentence
    for component in components:
        yield from component.mistakes(case)


def build_turbine(
    case: Case,
    comm: MPI.Intracomm,
    components: Iterable[Component] | None = None,
    inflow: PlacedInflow | None = None,
) -> Turbine:
    """Build the turbine of a case. Collective.

    Args:
        case: The case.
        comm: Communicator.
        components: What it is made of from the ground up; `list_components` if None.
        inflow: The wind; that of the case if None.

    Raises:
        ModelError: for parts, or a mesh, that do not fit together.
        InputError: if a file cannot be read or written.
    """
    components = list_components(case) if components is None else list(components)
    assembly = assemble(case, components, comm, inflow)
    # the paper counts bodies from the nacelle on; what carries it comes last, also in the columns
    parts = _rotate(assembly.part(NACELLE), assembly.parts)
    nacelle = next((c for c in components if isinstance(c, Nacelle)), components[0])
    system = MultibodySystem(comm, parts)
    bodies = [*(b.name for b in system.rigid_bodies), *(b.name for b in system.flexible_bodies)]
    volumes = [name for mesh in assembly.meshes.values() for name in mesh.cell_names]
    names = dict.fromkeys([*PART_NUMBERS, *bodies, *volumes])
    return Turbine(
        **vars(assembly),
        components=tuple(_rotate(nacelle, components)),
        system=system,
        numbers={name: number for number, name in enumerate(names)},
    )


def _rotate(first: Any, items: list[Any]) -> list[Any]:
    """The items from one of them on, then those before it."""
    place = next(k for k, item in enumerate(items) if item is first)
    return [*items[place:], *items[:place]]
