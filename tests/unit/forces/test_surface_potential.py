"""Claims about forces on surfaces that have an energy: contact with a floor."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import ufl
from dolfinx import mesh
from seen import Seen

from turbine_fenicsx import Gravity, NeoHooke, Pressure
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.forces.time_functions import ALWAYS
from turbine_fenicsx.foundation.errors import ModelError, StepFailure
from turbine_fenicsx.simulation.checkpoint import Checkpoints
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum

DT, END = 0.004, 0.472
LARGEST = 11.945525846285
"""Energy of the floor [J] at its largest, of 29.8 J, from a run on one rank."""


def depth(x):
    return ufl.min_value(x[2], 0.0)


@dataclass(frozen=True, eq=False)
class Contact:
    """The floor z = 0, with the energy k/2 depth^2 per initial area."""

    name: str
    flexible: FlexibleBody
    facets: Any
    stiffness: float = 5e6
    kind: str = "conservative"
    function: Callable = ALWAYS

    def energy(self, at):
        return at.parameter(0.5 * self.stiffness) * depth(at.x) ** 2

    def traction(self, at):
        d0, d1, way = depth(at.x0), depth(at.x1), at.x1[2] - at.x0[2]
        slope = ufl.conditional(ufl.lt(at.x[2], 0.0), 1.0, 0.0)
        part = ufl.conditional(ufl.lt(abs(way), 1e-12), slope, (d1 - d0) / way)
        return ufl.as_vector([0, 0, -at.parameter(0.5 * self.stiffness) * (d0 + d1) * part])


@dataclass(frozen=True, eq=False)
class Rough(Contact):
    """The same with the force in the middle of the step alone, which is no discrete gradient."""

    def traction(self, at):
        return ufl.as_vector([0, 0, -at.parameter(self.stiffness) * depth(at.x)])


class Interrupted(EnergyMomentum):
    """Long steps fail now and then, so that they are halved."""

    def advance(self, state, dt, out):
        if dt > 0.6 * DT and round(state.time / DT) % 5 in (1, 2):
            raise StepFailure("halved on purpose")
        return super().advance(state, dt, out)


def system(comm, make=Contact, **options):
    corners = [[0, 0, 0.1], [0.4, 0.2, 0.3]]
    cells = mesh.create_box(comm, corners, [2, 1, 1], mesh.CellType.hexahedron)
    brick = FlexibleBody("brick", cells, NeoHooke(4e5, 3e5), density=1000.0)
    skin = mesh.locate_entities_boundary(cells, 2, lambda x: np.full(x.shape[1], True))
    floor = make("floor", brick, skin, **options)
    return MultibodySystem(comm, [brick, floor, Gravity((0.5, 0.0, -9.81))])


def run(model, stepper=None, end=END):
    """The simulation, spring energies and energy errors of its steps, and the end."""
    seen = Seen(lambda s: (s.balance.spring, abs(s.energy_error)))
    simulation = Simulation(model, DT, end, [seen], stepper=stepper)
    last = simulation.run()
    return simulation, *seen.columns, last


@pytest.mark.parametrize("make", [EnergyMomentum, Interrupted])
def test_energy_is_kept_through_bounces_also_when_steps_are_halved(comm, make):
    model = system(comm)
    simulation, spring, error, last = run(model, make(model))
    touching = spring > 0.0
    assert np.count_nonzero(np.diff(touching.astype(int)) == 1) >= 2  # bounces
    assert max(spring) > 0.1 * last.balance.total
    assert max(error) < 1e-9 * last.balance.total
    assert (simulation.halvings > 10) == (make is Interrupted)
    assert model.work_names == ("gravity",) and last.external_work == 0.0
    if make is EnergyMomentum:  # on any number of ranks
        assert max(spring) == pytest.approx(LARGEST, rel=1e-8)


def test_a_force_that_is_no_discrete_gradient_shows_in_the_balance(comm):
    _, _, error, last = run(system(comm, Rough), end=45 * DT)
    assert max(error) > 1e-4 * last.balance.total


def test_a_run_in_contact_goes_on_bit_for_bit(comm, shared_tmp_path):
    whole = run(system(comm), end=44 * DT)[-1]
    steps = []
    for stop in (lambda: steps.append(0) or len(steps) == 38, None):
        model = system(comm)
        checkpoints = Checkpoints(model, shared_tmp_path)
        seen = Seen(lambda snapshot: snapshot.balance.spring)
        simulation = Simulation(model, DT, 44 * DT, [seen], checkpoints=checkpoints, stop=stop)
        last = simulation.run() if stop else simulation.resume()
        assert seen.values[-1 if stop else 0] > 0.0  # it stands in the floor
    assert last.energy_error == whole.energy_error
    assert np.array_equal(last.state.u[0].array_r, whole.state.u[0].array_r)
    assert last.balance.total == whole.balance.total


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"kind": "springy"}, "kind of 'floor' must be 'external' or 'conservative' .* 'springy'"),
        ({"kind": "dissipative"}, "must be 'external' or 'conservative'"),
    ],
)
def test_other_kinds_are_refused(comm, options, told):
    with pytest.raises(ModelError, match=told):
        system(comm, **options)


def test_a_conservative_force_needs_an_energy(comm):
    class Springy(Pressure):
        kind = "conservative"

    def make(name, brick, skin):
        return Springy(name, brick, skin, 1.0)

    with pytest.raises(ModelError, match=r"'floor' is conservative and needs the method energy"):
        system(comm, make)
