"""A user's program with types: every public name of the package, checked by mypy, and it runs.

`assert_type` says what type checkers and editors know about each; it does nothing when it runs.
"""

from __future__ import annotations

import math
import sys
from contextlib import suppress
from pathlib import Path
from typing import assert_type

from mpi4py import MPI

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import fem, mesh

import turbine_fenicsx as tfx

Array = npt.NDArray[np.float64]
Material = (
    tfx.KelvinVoigt
    | tfx.MooneyRivlin
    | tfx.NeoHooke
    | tfx.OrthotropicSVK
    | tfx.StVenantKirchhoff
    | tfx.TransverselyIsotropic
)


def materials() -> list[Material]:
    """One of each."""
    lam, mu = 1.0e6, 1.0e6
    axes = (ufl.as_vector([1, 0, 0]), ufl.as_vector([0, 1, 0]), ufl.as_vector([0, 0, 1]))
    soft = assert_type(tfx.StVenantKirchhoff(lam, mu), tfx.StVenantKirchhoff)
    return [
        assert_type(tfx.KelvinVoigt(soft, shear_viscosity=10.0), tfx.KelvinVoigt),
        assert_type(tfx.MooneyRivlin(c10=mu, c01=0.0, bulk_modulus=lam), tfx.MooneyRivlin),
        assert_type(tfx.NeoHooke(lam, mu), tfx.NeoHooke),
        assert_type(
            tfx.OrthotropicSVK(young=(mu,) * 3, shear=(mu,) * 3, poisson=(0.2,) * 3, frame=axes),
            tfx.OrthotropicSVK,
        ),
        assert_type(
            tfx.TransverselyIsotropic(2 * mu, mu, mu, 0.2, 0.2, axes[0]), tfx.TransverselyIsotropic
        ),
    ]


def beam(comm: MPI.Intracomm) -> tuple[tfx.FlexibleBody, npt.NDArray[np.int32]]:
    """A block of soft rubber, and the facets at its lower end."""
    ends: list[npt.ArrayLike] = [np.zeros(3), np.array([0.1, 0.1, 1.0])]
    box = mesh.create_box(comm, ends, [1, 1, 3], mesh.CellType.hexahedron)

    def density_at(points: Array) -> Array:
        return 1000.0 + 10.0 * points[:, 2]

    density: fem.Function = tfx.cell_field(box, density_at)
    if Path("part.msh").exists():
        print(tfx.load_msh(comm, "part.msh", surfaces=["foot"]).facets("foot"))
    law = materials()[0]
    assert assert_type(tfx.check_material(law, box), list[str]) == []
    body = tfx.FlexibleBody("beam", box, law, density)
    assert len(tfx.squared_stretches(ufl.Identity(3))) == 3
    foot = mesh.locate_entities_boundary(box, 2, lambda x: np.isclose(x[2], 0.0))
    return assert_type(body, tfx.FlexibleBody), np.asarray(foot, dtype=np.int32)


def joints(a: tfx.RigidBody, b: tfx.RigidBody) -> list[str]:
    """The others, by their names."""
    at, axis = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    cylindrical = assert_type(tfx.Cylindrical("c", a, b, point=at, axis=axis), tfx.Cylindrical)
    planar = assert_type(tfx.Planar("p", a, b, point=at, normal=axis), tfx.Planar)
    prismatic = assert_type(tfx.Prismatic("s", a, b, point=at, axis=axis), tfx.Prismatic)
    rigid = assert_type(tfx.Rigid("r", a, b, at), tfx.Rigid)
    spherical = assert_type(tfx.Spherical("b", a, None, at), tfx.Spherical)
    universal = assert_type(
        tfx.Universal("u", a, b, point=at, first_axis=axis, second_axis=(1.0, 0.0, 0.0)),
        tfx.Universal,
    )
    return [j.name for j in (cylindrical, planar, prismatic, rigid, spherical, universal)]


def functions_of_time() -> list[float]:
    """Their values at 1 s."""
    table = assert_type(tfx.Table((0.0, 2.0), (0.0, 4.0)), tfx.Table)
    functions = (
        assert_type(tfx.Constant(1.0), tfx.Constant),
        assert_type(tfx.Hat(2.0), tfx.Hat),
        assert_type(tfx.Ramp(3.0, 1.0), tfx.Ramp),
        assert_type(tfx.Sine(1.0, 0.25), tfx.Sine),
        table,
    )
    return assert_type([function(1.0) for function in functions], list[float])


class Largest:
    """An observer that survives a restart."""

    name = "largest"

    def __init__(self) -> None:
        self.energy = 0.0

    def start(self, snapshot: tfx.Snapshot, resumed: bool) -> None:
        self.observe(snapshot)

    def observe(self, snapshot: tfx.Snapshot) -> None:
        self.energy = max(self.energy, assert_type(snapshot.balance, tfx.Balance).kinetic)

    def finish(self) -> None:
        """There is no file to close."""

    def save(self) -> tfx.RestartData:
        return tfx.RestartData({"energy": self.energy})

    def restore(self, data: tfx.RestartData) -> None:
        self.energy = float(data.numbers["energy"])


def forces(a: tfx.RigidBody, b: tfx.RigidBody, body: tfx.FlexibleBody) -> list[object]:
    """One of each; forces on surfaces get no facets of this rank here."""
    facets, at, up = np.zeros(0, np.int32), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    return [
        assert_type(tfx.BodyForce("body", body, field=np.sin), tfx.BodyForce),
        assert_type(tfx.FollowerForce("follower", a, point=at, force=up), tfx.FollowerForce),
        assert_type(tfx.Gravity((0.0, -9.81, 0.0)), tfx.Gravity),
        assert_type(tfx.JointDamper("damper", "hinge", 0.1), tfx.JointDamper),
        assert_type(tfx.JointSpring("spring", "hinge", 1.0), tfx.JointSpring),
        assert_type(tfx.JointTorque("torque on hinge", "hinge", 1.0), tfx.JointTorque),
        assert_type(tfx.NodeForce("node", body, point=at, force=up), tfx.NodeForce),
        assert_type(
            tfx.PointDamper("dashpot", a, b, first_point=at, second_point=up, damping=0.1),
            tfx.PointDamper,
        ),
        assert_type(
            tfx.PointForce("wind", b, point=at, force=up, function=math.sin), tfx.PointForce
        ),
        assert_type(
            tfx.PointSpring("cable", a, b, first_point=at, second_point=up, stiffness=1.0),
            tfx.PointSpring,
        ),
        assert_type(tfx.Pressure("pressure", body, facets, 1.0), tfx.Pressure),
        assert_type(
            tfx.RayleighDamping(
                "damping", body, stiffness=1e-3, mass=0.1, held=[tfx.HeldPart(facets)]
            ),
            tfx.RayleighDamping,
        ),
        assert_type(tfx.SurfaceTraction("traction", body, facets, up), tfx.SurfaceTraction),
        assert_type(tfx.Torque("torque", a, up), tfx.Torque),
    ]


class Drag:
    """A force on a surface, against its velocity."""

    function = tfx.Constant(1.0)

    def __init__(self, name: str, flexible: tfx.FlexibleBody, facets: npt.NDArray[np.int32]):
        self.name, self.flexible, self.facets = name, flexible, facets

    def traction(self, at: tfx.SurfacePoint) -> object:
        return -at.parameter(0.1) * at.v


class Wind:
    """Loads on sections, against their velocity."""

    def start_step(self, times: tfx.StepTimes) -> None:
        """There is nothing to prepare."""

    def loads(
        self, motion: tfx.SectionMotion, time: float
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        return -motion.velocity, -motion.angular_velocity

    def accept(self, motion: tfx.SectionMotion, times: tfx.StepTimes) -> None:
        """There is no wake."""

    def save(self) -> tfx.RestartData:
        return tfx.RestartData()

    def restore(self, data: tfx.RestartData) -> None:
        """There is nothing to go on with."""


def section_loads(body: tfx.FlexibleBody) -> tfx.SectionLoads:
    """Loads on three stations; this rank has no facets here."""
    source: tfx.LineLoad = Wind()
    facets, stations = np.zeros(0, np.int32), [0.0, 1.0, 2.0]
    line = assert_type(
        tfx.StationLine(facets, origin=(0, 0, 0), axis=(1, 0, 0), stations=stations),
        tfx.StationLine,
    )
    return tfx.SectionLoads("wind", body, [line], source)


def rigid_section_loads(body: tfx.RigidBody, source: tfx.LineLoad) -> tfx.RigidSectionLoads:
    stations = assert_type(tfx.RigidStations(body, [(0, 0, 1), (0, 0, 2)]), tfx.RigidStations)
    return tfx.RigidSectionLoads("wind", [stations], source)


def relations() -> list[tfx.JointRelation]:
    """Gears and screws."""
    return [
        assert_type(tfx.JointRelation("sum", {"a": 1.0, "b": 2.0}), tfx.JointRelation),
        assert_type(tfx.gear_pair("gears", "a", "b", -2.0), tfx.JointRelation),
        assert_type(tfx.screw("screw", "a", "b", 0.01), tfx.JointRelation),
    ]


def led(x: tfx.Quadratic) -> tfx.Rheonomic:
    """A constraint of a joint of one's own that follows time."""
    return assert_type(tfx.Rheonomic(x, math.sin), tfx.Rheonomic)


def duration(times: tfx.StepTimes) -> float:
    """What a force of one's own sees of a step."""
    return assert_type(times.half_dt2, float)


def functions_of_coordinates() -> tfx.Quadratic:
    """What a joint of one's own is made of."""
    first = assert_type(tfx.AffineVector.slot(0), tfx.AffineVector)
    second = tfx.AffineVector.fixed((1.0, 0.0, 0.0))
    return assert_type(tfx.dot(first, second) - 1.0, tfx.Quadratic)


def strain(system: tfx.MultibodySystem, body: tfx.FlexibleBody) -> tfx.Channel:
    """A gauge on the side of the beam."""
    gauge = tfx.Gauge("side", body, point=(0.05, 0.05, 0.4), outward=(1, 0, 0), along=(0, 0, 1))
    gauges = assert_type(tfx.Gauges(system, [assert_type(gauge, tfx.Gauge)]), tfx.Gauges)
    return assert_type(tfx.gauge_channel(gauges), tfx.Channel)


def reduced(comm: MPI.Intracomm, file: Path) -> tfx.State:
    """Two equal reduced beams on the ground, bent by their weight."""
    body, foot = beam(comm)
    held = tfx.MultibodySystem(comm, [body, tfx.Coupling("clamp", body, foot, None)])
    loads = assert_type(tfx.smooth_loads(held, body, size=0.01), list[tfx.LoadPath])[:1]
    made = assert_type(
        tfx.reduce_body(held, body, modes=2, functions=9, loads=loads), tfx.ReducedBasis
    )
    said = assert_type(tfx.judge(held, body, made, loads, count=1), tfx.Verdict)
    assert_type(said.warnings, list[str])
    tfx.write_basis(file, made)
    basis = assert_type(tfx.read_basis(file, body), tfx.ReducedBasis)
    places = [assert_type(tfx.Placement(position=(x, 0.0, 0.0)), tfx.Placement) for x in (0.0, 1.0)]
    beams = assert_type(tfx.ReducedBody("beams", body, basis, places), tfx.ReducedBody)
    clamps = [tfx.Coupling(f"clamp {k}", beams, foot, None, copy=k) for k in range(2)]
    return tfx.equilibrium(tfx.MultibodySystem(comm, [beams, *clamps, tfx.Gravity()]))


def sections(comm: MPI.Intracomm) -> tfx.State:
    """A beam of the matrices of its section, bent by its weight."""
    size = mesh.create_rectangle(MPI.COMM_SELF, [(-0.25, -0.1), (0.25, 0.1)], [4, 4])
    section = tfx.analyse_section(size, tfx.StVenantKirchhoff(0.0, 5e8), 1000.0)
    print(assert_type(section, tfx.Section).shear_centre)
    line = assert_type(tfx.BeamLine.straight(length=10.0, twist=0.2), tfx.BeamLine)
    both = [np.array([matrix, matrix]) for matrix in (section.stiffness, section.inertia)]
    of_beam = tfx.BeamSections(np.array([0.0, line.length]), both[0], both[1])
    box = tfx.box_carrier("beam", line, (0.5, 0.2), cells=12, comm=comm)
    carrier = assert_type(box.carrier, tfx.Carrier)
    basis = assert_type(
        tfx.beam_basis(carrier, line, of_beam, elements=4, degree=3, start=box.start),
        tfx.BeamBasis,
    )
    body = tfx.ReducedBody("beam", carrier, basis)
    clamp = tfx.Coupling("clamp", body, box.start, None)
    return tfx.equilibrium(tfx.MultibodySystem(comm, [body, clamp, tfx.Gravity()]))


def find_in_air(rotor: tfx.MultibodySystem, turning: tfx.Modes) -> None:
    """Ask for modes in the air, which does not blow here."""
    still_wake = assert_type(tfx.AirModel(frozen=("wake",)), tfx.AirModel)
    with suppress(tfx.ModelError):  # no air blows
        state = turning.state
        assert_type(tfx.air_modes(rotor, "axle", 2.0, state, 1, air=still_wake), tfx.Modes)


def pendulum(comm: MPI.Intracomm, folder: Path) -> tfx.Snapshot:
    """A soft beam on a swinging arm."""
    body, foot = beam(comm)
    arm = tfx.RigidBody("arm", 1.0, (0.1, 0.1, 0.1), position=(0.0, 0.5, 0.0))
    hinge = tfx.Revolute("hinge", None, arm, point=(0.0, 1.0, 0.0), axis=(0.0, 0.0, 1.0))
    assert_type((arm, hinge), tuple[tfx.RigidBody, tfx.Revolute])
    second = tfx.RigidBody("second", 1.0, (0.1, 0.1, 0.1), position=(5.0, 0.0, 0.0))
    drive = tfx.Revolute("drive", None, second, point=(5.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
    motion = assert_type(tfx.PrescribedMotion("drive", tfx.Ramp(1.0, 2.0)), tfx.PrescribedMotion)
    coupling = assert_type(tfx.Coupling("clamp", body, foot, arm), tfx.Coupling)
    frame = tfx.SurfaceFrame("tip", (body, foot), point=(0.0, 0.0, 0.0))
    print(assert_type(frame.couplings, tuple[tfx.Coupling, ...]))
    parts = [arm, hinge, second, drive, motion, body, coupling, tfx.Gravity()]
    system = assert_type(tfx.MultibodySystem(comm, parts), tfx.MultibodySystem)

    at_rest = assert_type(tfx.equilibrium(system, held=["drive"]), tfx.State)
    found = assert_type(tfx.modes(system, at_rest, count=4), tfx.Modes)
    lowest: tfx.Mode = found.modes[0]
    print(lowest.frequency, assert_type(lowest.real, tfx.Motion).q)
    assert_type(tfx.damped_modes(system, at_rest, count=4), tfx.Modes)
    wheel = tfx.RigidBody("wheel", 1.0, (0.1, 0.1, 0.1))
    axle = tfx.Revolute("axle", None, wheel, point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
    rotor = tfx.MultibodySystem(comm, [wheel, axle])
    turning = assert_type(tfx.turning_modes(rotor, "axle", 2.0, 1, blades=3), tfx.Modes)
    whirl = assert_type(turning.modes[0].whirl, tfx.Whirl | None)
    find_in_air(rotor, turning)
    diagram = assert_type(tfx.campbell(rotor, "axle", [0.0, 2.0], 1), tfx.Campbell)
    print(whirl, diagram.frequencies[0], diagram.names)
    assert_type(tfx.turning_equilibrium(system, "hinge", 2.0, periodic=True), tfx.State)
    swinging = assert_type(tfx.initial_motion(system, {"hinge": 0.1}), tfx.State)
    options = assert_type(tfx.SolverOptions(tolerance=1e-11), tfx.SolverOptions)
    solver = assert_type(tfx.EnergyMomentum(system, options=options), tfx.EnergyMomentum)
    assert_type(tfx.EnergyMomentumStep(system).frames, tuple[float, float])
    report = assert_type(solver.advance(at_rest, 0.01, at_rest.copy()), tfx.StepReport)
    damped: tfx.Stepper = assert_type(tfx.GeneralisedAlpha(system, 0.8), tfx.GeneralisedAlpha)
    print(report.work, damped.advance(at_rest, 0.01, at_rest.copy()).residual)

    reaction = assert_type(tfx.JointReaction(hinge), tfx.JointReaction)
    reactions = assert_type(tfx.JointReactions(system, [reaction]), tfx.JointReactions)
    point = assert_type(tfx.Point("tip", arm, (0.0, 0.0, 0.0)), tfx.Point)
    points = assert_type(tfx.Points(system, [point]), tfx.Points)
    channels = [tfx.joint_channel(reactions), tfx.point_channel(points), strain(system, body)]
    channels.append(tfx.Channel(("angle_[rad]",), lambda s: [float(s.state.joint_coordinates[0])]))
    assert_type(channels, list[tfx.Channel])
    largest = Largest()
    restartable: tfx.RestartableObserver = largest
    observers: list[tfx.Observer] = [
        assert_type(tfx.History(comm, folder / "history.csv", channels), tfx.History),
        assert_type(tfx.Fields(system, folder / "fields.xdmf", 0.01, 0.02), tfx.Fields),
        restartable,
    ]
    checkpoints = assert_type(tfx.Checkpoints(system, folder / "checkpoints"), tfx.Checkpoints)
    fields = assert_type(tfx.BodyFields(system, body, degree=1), tfx.BodyFields)
    fields.update(at_rest)
    print(fields.stress.name)
    run = tfx.Simulation(
        system, 0.01, 0.02, observers, solver, checkpoints=checkpoints, start=swinging
    )
    return assert_type(assert_type(run, tfx.Simulation).run(), tfx.Snapshot)


class Generator(tfx.Component):
    """A disc on the hub and its speed."""

    def parts(self, assembly: tfx.Assembly) -> list[tfx.RigidBody | tfx.Revolute]:
        hub = assembly.part("hub")
        disc = tfx.RigidBody("disc", 1e3, (1e6, 1e6, 1e6), position=hub.position)
        return [disc, tfx.Revolute("shaft", hub, disc, point=hub.position, axis=(0.0, 0.0, 1.0))]

    def channels(self, turbine: tfx.Turbine) -> tfx.Channels:
        speed = tfx.Channel(("speed_[rad/s]",), lambda s: [float(s.state.joint_rates[-1])])
        return assert_type(tfx.Channels(history=[speed]), tfx.Channels)


def turbine(comm: MPI.Intracomm, folder: Path) -> None:
    """A turbine with a component of one's own, and the same run as one that goes on."""
    output = {"format": "vtkhdf"}
    table = {"turbine": {"model": "rigid"}, "time": {"end": 0.04}, "output": output}
    case = tfx.Case.parse(table)
    components = assert_type(tfx.list_components(case), list[tfx.Component])
    components.append(Generator())
    assert_type(tfx.build_turbine(case, comm, components), tfx.Turbine)
    print(len(tfx.run_case(case, folder / "out", comm, "none", components=components)))
    more = tfx.restart_case(folder / "out", comm, ["time.end=0.08"], "none", components=components)
    assert_type(more[0], tfx.Case)
    with tfx.VtkHdfFile(folder / "out" / "fields.vtkhdf") as file:
        print(file.read(0).points.shape)


def main(folder: Path) -> None:
    """Run all of it."""
    comm: MPI.Intracomm = MPI.COMM_WORLD
    print(assert_type(tfx.__version__, str), functions_of_time(), functions_of_coordinates())
    a, b = (tfx.RigidBody(name, 1.0, (0.1, 0.1, 0.1)) for name in "ab")
    body, foot = beam(comm)
    print(joints(a, b), len(forces(a, b, body)), [r.factors for r in relations()])
    print(Drag("drag", body, foot).name, duration(tfx.StepTimes.from_start(0.0, 0.1)))
    case = assert_type(tfx.Case.parse({"time": {"end": 1.0}}), tfx.Case)
    print(assert_type(case.time.end, float), assert_type(tfx.BladeGeometry(), tfx.BladeGeometry))
    print(reduced(comm, folder / "beam.npz").time, sections(comm).time)
    turbine(comm, folder)
    print(tfx.read_run(folder / "out").shape)
    print(assert_type(tfx.system_matrices(tfx.MultibodySystem(comm, [a])), tfx.SystemMatrices))
    try:
        tfx.JointSpring("spring", "hinge", -1.0)
    except (tfx.ModelError, tfx.ModelWarning) as error:
        print(assert_type(error, tfx.ModelError | tfx.ModelWarning))
    try:
        print(pendulum(comm, folder).energy_error)
    except tfx.StepFailure as failure:
        print(assert_type(failure, tfx.StepFailure))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
