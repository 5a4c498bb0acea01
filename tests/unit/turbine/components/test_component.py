"""Components of a turbine that stand outside the package: parts, columns, pictures, mistakes."""

import csv
from dataclasses import dataclass

import numpy as np
import pytest

from turbine_fenicsx import (
    Case,
    Channel,
    Channels,
    Component,
    JointSpring,
    ModelError,
    Prismatic,
    Revolute,
    RigidBody,
    build_turbine,
    list_components,
    restart_case,
    run_case,
)
from turbine_fenicsx.bodies.rigid_surface import inertia_box
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.meshing import load
from turbine_fenicsx.turbine.run.run import make_stepper, turbine_channels
from turbine_fenicsx.turbine.tables.pitch import PitchCase
from turbine_fenicsx.turbine.tables.tower import TowerCase

pytestmark = pytest.mark.parallel

RIGID = {"turbine": {"model": "rigid"}, "loads": {"rotor_torque": 1e7}}
SHORT = {"time": {"end": 0.1}, "output": {"fields_every": 0.05}}
E3 = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Disc(Component):
    """A disc on a soft shaft behind the hub."""

    inertia: float = 5e6
    stiffness: float = 8e8

    def mistakes(self, case):
        if self.inertia <= 0.0:
            yield f"inertia of the disc = {self.inertia:g}: must be greater than 0"
        if case.tower.flexible:
            yield "a disc does not go with a flexible tower"

    def parts(self, assembly):
        hub = assembly.part("hub")
        half = 0.5 * self.inertia
        disc = RigidBody("disc", 1e3, (half, half, half), position=hub.position)
        shaft = Revolute("shaft", hub, disc, point=hub.position, axis=E3)
        return [disc, shaft, JointSpring("torsion", "shaft", self.stiffness)]

    def channels(self, turbine):
        k = turbine.system.joint_coordinate_names.index("shaft")
        torque = Channel(
            ("shaft_torque_[Nm]",), lambda s: [-self.stiffness * s.state.joint_coordinates[k]]
        )
        speed = Channel(("ShftTwist_[rad]",), lambda s: [s.state.joint_coordinates[k]])
        return Channels(history=[torque], openfast=[speed])

    def surfaces(self, turbine):
        return [inertia_box(turbine.part("disc"), turbine.numbers["disc"])]


@dataclass(frozen=True)
class Spring(Component):
    """A tower top that moves up and down on a spring, in place of a tower."""

    def parts(self, assembly):
        top = RigidBody("tower_top", 1e4, (1e4, 1e4, 1e4))
        guide = Prismatic("heave", None, top, point=(0, 0, 0), axis=(0, 1, 0))
        return [top, guide, JointSpring("pile", "heave", 1e8)]


@dataclass(frozen=True)
class Counter(Component):
    """Counts steps in an observer of its own, and shows their number in a column."""

    log: "CountingLog"

    def parts(self, assembly):
        return []

    def channels(self, turbine):
        return Channels(history=[Channel(("counted_[-]",), lambda s: [self.log.steps])])

    def observers(self, turbine, folder):
        assert turbine.part("hub") and folder.is_dir()
        return [self.log]


class CountingLog:
    """An observer that survives a restart."""

    name = "counting log"

    def __init__(self):
        self.steps = 0

    def start(self, snapshot, resumed):
        assert resumed == (self.steps > 0)

    def observe(self, snapshot):
        self.steps += 1

    def finish(self):
        pass

    def save(self):
        return RestartData({"steps": self.steps})

    def restore(self, data):
        self.steps = data.numbers["steps"]


def with_disc(case, **values):
    return [*list_components(case), Disc(**values)]


def test_parts_columns_and_pictures_of_a_new_component_are_there(comm):
    case = Case.parse(RIGID)
    turbine = build_turbine(case, comm, with_disc(case))
    assert turbine.system.joint_coordinate_names[-1] == "shaft"
    surfaces = turbine.surfaces()
    assert [s.body.name for s in surfaces][-1] == "disc"
    numbers = [s.part for s in surfaces]
    assert numbers[:5] == [0, 1, 2, 3, 4] and numbers[5] > 5
    assert turbine.part_names()[numbers[5]] == "disc"
    channels = turbine_channels(turbine, make_stepper(turbine.case, turbine.system), stress=False)
    history = [name for c in channels.history for name in c.columns]
    assert history.index("shaft_torque_[Nm]") == history.index("root_moment_3_z_[Nm]") + 1
    assert [name for c in channels.openfast for name in c.columns][-1] == "ShftTwist_[rad]"
    assert turbine.component_names == "Nacelle, Loads, RigidBlades, Pitch, Disc"


def test_what_is_called_tower_top_carries_the_nacelle(comm):
    case = Case.parse(RIGID)
    turbine = build_turbine(case, comm, [Spring(), *list_components(case)])
    assert turbine.part("yaw").first is turbine.part("tower_top")
    names = [body.name for body in turbine.system.rigid_bodies]
    assert (names[0], names[-1]) == ("nacelle", "tower_top")  # the paper's bodies keep their places


def test_all_mistakes_are_told_before_anything_is_built(comm, monkeypatch):
    case = Case.parse({"tower": {"flexible": True}})
    monkeypatch.setattr(load, "load_arrays", None)
    with pytest.raises(ModelError) as error:
        build_turbine(case, comm, with_disc(case, inertia=-1.0))
    assert str(error.value).splitlines() == [
        "inertia of the disc = -1: must be greater than 0",
        "a disc does not go with a flexible tower",
    ]


def test_rank_0_looks_for_mistakes_alone_and_all_ranks_raise_them(comm):
    """Files of a case may be there only for rank 0."""

    class Picky(Disc):
        def mistakes(self, case):
            return [f"told by rank {comm.rank}"]

    with pytest.raises(ModelError, match=r"^told by rank 0$"):
        build_turbine(Case.parse(RIGID), comm, [Picky()])


def test_cases_made_without_reading_are_checked_too(comm):
    """`Case.parse` finds contradictions; the constructors of the tables do not."""
    tower = TowerCase(flexible=True, wall=5.0, elements=(2, 1, 2))
    case = Case(tower=tower, pitch=PitchCase(bearings=True, drive="spring"))
    with pytest.raises(ModelError) as error:
        build_turbine(case, comm)
    starts = [line.split(":")[0] for line in str(error.value).splitlines()]
    assert starts == ['pitch.drive = "spring"', "tower.wall = 5", "tower.elements = [2, 1, 2]"]


@pytest.mark.parametrize("wrong", [Disc, "Disc", None])
def test_what_is_no_component_is_refused(comm, wrong):
    with pytest.raises(ModelError, match="needs the methods of Component, got"):
        build_turbine(Case.parse(RIGID), comm, [wrong])


def test_a_part_that_is_missing_is_a_sentence(comm):
    case = Case.parse(RIGID)
    with pytest.raises(ModelError, match="no part 'hub'; it has none yet"):
        build_turbine(case, comm, [Disc(), *list_components(case)])


def test_a_run_with_a_new_component_goes_on_only_with_the_same(comm, shared_tmp_path):
    whole, halves = shared_tmp_path / "whole", shared_tmp_path / "halves"
    case = Case.parse(RIGID | SHORT)
    result = run_case(case, whole, comm, "none", components=with_disc(case))
    assert result["components"] == "Nacelle, Loads, RigidBlades, Pitch, Disc"
    half = Case.parse(RIGID | SHORT | {"time": {"end": 0.04}})
    run_case(half, halves, comm, "none", components=with_disc(case))
    with pytest.raises(InputError, match=r"list of components has changed.* Pitch, Disc and is "):
        restart_case(halves, comm, ["time.end=0.1"], "none")
    restart_case(halves, comm, ["time.end=0.1"], "none", components=with_disc(case))
    comm.barrier()
    rows = []
    for folder in (whole, halves):
        with (folder / "history.csv").open(newline="") as file:
            names, *found = csv.reader(file)
        rows.append([row[:-1] for row in found])
    assert rows[0] == rows[1] and len(rows[0]) == 6
    torque, twist = (names.index(n) for n in ("shaft_torque_[Nm]", "angle_shaft_[rad]"))
    assert float(rows[0][-1][torque]) == -8e8 * float(rows[0][-1][twist]) != 0.0


def test_observers_of_a_component_see_a_step_before_it_is_written_and_survive_a_restart(
    comm, shared_tmp_path
):
    case, log = Case.parse(RIGID | {"time": {"end": 0.04}}), CountingLog()
    run_case(case, shared_tmp_path, comm, "none", components=[*list_components(case), Counter(log)])
    assert log.steps == 2
    again = [*list_components(case), Counter(CountingLog())]
    restart_case(shared_tmp_path, comm, ["time.end=0.1"], "none", components=again)
    comm.barrier()
    with (shared_tmp_path / "history.csv").open(newline="") as file:
        counts = [row["counted_[-]"] for row in csv.DictReader(file)]
    assert counts == ["0", "1", "2", "3", "4", "5"]
