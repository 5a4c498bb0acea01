"""Claims about shaft tilt, precone, overhang, and centres of mass off the joint axes."""

import numpy as np
import pytest
from seen import Seen

from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.rotations import E2, rotation_about
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.axes import blade_axes
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run.run import make_stepper
from turbine_fenicsx.turbine.run.start import make_start
from turbine_fenicsx.turbine.run.summary import rotor_inertia

TILT, CONE, AHEAD, RISE = -6.0, -4.0, 12.0, 5.6
LEANING = {
    "tilt": f"{TILT} deg",
    "precone": f"{CONE} deg",
    "hub_distance": AHEAD,
    "hub_rise": RISE,
    "nacelle": {
        "mass": "600 t",
        "centre": [0.3, 4.5, -5.0],
        "inertia": [11e6, 10e6, 9e6, 0.2e6, -0.1e6, 2e6],
    },
    "hub": {"mass": "80 t", "centre": [0.0, 0.0, -0.6], "inertia": [7e5, 7e5, 1e6]},
}
SMALL = {"elements": [1, 1, 4]}
CENTRE = np.array([0.0, RISE, -AHEAD])
SHAFT = np.array([0.0, np.sin(np.radians(TILT)), np.cos(np.radians(TILT))])


def parse(turbine=(), **tables):
    """A case of the turbine that leans, with a small mesh."""
    return Case.parse({"mesh": SMALL, "turbine": {**LEANING, **dict(turbine)}, **tables})


def inertia_in_space(body):
    """The tensor of inertia of a body in e1, e2, e3."""
    R, E = np.asarray(body.directors), np.asarray(body.euler)
    return R @ np.diag(E.sum() - E) @ R.T


# --- geometry


def test_the_upright_blade_leans_back_and_the_lower_ones_forward():
    """By hand: a tilt of 6 degrees takes the top downwind, a cone of 4 all blades upwind."""
    plan = plan_rotor(parse())
    upright = plan.layout.frame(2)[0]
    assert np.allclose(upright, [0.0, np.cos(np.radians(2)), np.sin(np.radians(2))], atol=1e-15)
    turned = rotation_about(SHAFT, np.pi) @ upright
    assert np.allclose(turned, [0.0, -np.cos(np.radians(10)), -np.sin(np.radians(10))], atol=1e-15)
    tip = CENTRE + 56.25 * upright
    assert np.allclose(plan.tips[1], tip, rtol=0, atol=1e-12)
    for k in (1, 3):
        assert plan.layout.frame(k)[0] @ SHAFT == pytest.approx(np.sin(np.radians(CONE)))


def test_the_frame_of_a_blade_is_that_of_openfast(comm):
    """z to the tip, x downwind in the plane of shaft and span, y to the trailing edge."""
    layout = plan_rotor(parse()).layout
    for k in (1, 2, 3):
        x, y, z = axes = blade_axes(layout, k)
        assert np.allclose(axes @ axes.T, np.eye(3), atol=1e-15)
        assert x @ SHAFT == pytest.approx(np.cos(np.radians(CONE)), rel=1e-14)
        assert abs(y @ SHAFT) < 1e-15
        assert np.cross(SHAFT, z) @ y < 0.0  # the tip moves to -y when the rotor turns clockwise


@pytest.mark.parallel
@pytest.mark.parametrize("model", ["rigid", "hybrid"])
def test_bodies_and_joints_stand_where_the_case_says(comm, model):
    turbine = build_turbine(parse({"model": model}, pitch={"bearings": True}), comm)
    rotor, yaw = turbine.part("rotor"), turbine.part("yaw")
    assert np.allclose(rotor.axis, SHAFT, atol=1e-15)
    assert np.allclose(rotor.point, CENTRE)
    assert np.array_equal(yaw.point, np.zeros(3)) and np.array_equal(yaw.axis, -E2)
    nacelle, hub = turbine.part("nacelle"), turbine.part("hub")
    assert np.allclose(nacelle.position, [0.3, 4.5, -5.0])
    J = np.array([[11e6, 0.2e6, -0.1e6], [0.2e6, 10e6, 2e6], [-0.1e6, 2e6, 9e6]])
    assert np.allclose(inertia_in_space(nacelle), J, rtol=0, atol=1e-7)
    assert np.allclose(hub.position, CENTRE - 0.6 * SHAFT)
    about = 7e5 * np.eye(3) + 3e5 * np.outer(SHAFT, SHAFT)
    assert np.allclose(inertia_in_space(hub), about, rtol=0, atol=1e-7)
    for k in (1, 2, 3):
        span = turbine.rotor.layout.frame(k)[0]
        bearing = turbine.part(f"pitch_{k}")
        assert abs(np.asarray(bearing.axis) @ span) == pytest.approx(1.0, rel=1e-14)
        if model == "hybrid":
            assert np.allclose(turbine.part(f"ring_{k}").position, CENTRE + 2.25 * span)
    state = turbine.system.initial_state()
    assert turbine.system.constraint_error(state) <= 1e-13


def test_pictures_lean_with_the_rotor(comm):
    turbine = build_turbine(parse({"model": "rigid"}), comm)
    nacelle, hub, *blades = turbine.surfaces()
    ahead = (hub.points - CENTRE) @ SHAFT
    side = (hub.points - CENTRE) - np.outer(ahead, SHAFT)
    size = np.linalg.norm(side, axis=1).max()
    assert ahead.min() == pytest.approx(-1.4 * size, rel=1e-2)
    assert np.ptp(ahead.reshape(-1, 48), axis=1).max() < 1e-12 * size  # rings around the shaft
    along = (nacelle.points - CENTRE) @ SHAFT
    assert along.min() < ahead.max() and nacelle.points[:, 2].max() > 0.0
    for k, blade in enumerate(blades, start=1):
        span = turbine.rotor.layout.frame(k)[0]
        assert ((blade.points - CENTRE) @ span).max() == pytest.approx(56.25, rel=1e-12)


@pytest.mark.parallel
def test_inertia_about_the_shaft_is_that_of_the_parts(comm):
    turbine = build_turbine(parse({"model": "rigid"}), comm)
    expected = 0.0
    for name in ("hub", "blade_1", "blade_2", "blade_3"):
        body = turbine.part(name)
        arm = np.cross(SHAFT, np.asarray(body.position) - CENTRE)
        expected += SHAFT @ inertia_in_space(body) @ SHAFT + body.mass * arm @ arm
    assert rotor_inertia(turbine) == pytest.approx(expected, rel=1e-13)


# --- motion


def run(case, comm, end, state=None):
    """Run a case; the turbine, balances and energy errors, the last state."""
    turbine = build_turbine(case, comm)
    watch, stepper = Seen(lambda s: (s.balance, s.energy_error)), make_stepper(case, turbine.system)
    start = make_start(case, turbine.system)
    simulation = Simulation(turbine.system, case.time.step, end, [watch], stepper, start=start)
    last = simulation.run()
    stepper.destroy()
    balances, errors = zip(*watch.values, strict=True)
    return turbine, balances, errors, last


@pytest.mark.parametrize("model", ["rigid", "hybrid"])
def test_a_tilted_and_coned_rotor_conserves(comm, model):
    """Energy under weight; without it and on a free yaw, momentum about the vertical too."""
    speed = {"model": model, "rotor_speed": "12 rpm"}
    for gravity in (9.81, 0.0):
        case = parse(speed, time={"step": 0.02}, loads={"gravity": gravity})
        _, balances, errors, _ = run(case, comm, 1.0)
        scale = max(abs(b.kinetic) for b in balances)
        assert max(map(abs, errors)) < 1e-10 * scale
        spin = [b.angular @ E2 for b in balances]
        moved = max(np.abs(b.angular - balances[0].angular).max() for b in balances)
        assert np.ptp(spin) < 1e-9 * max(np.linalg.norm(b.angular) for b in balances)
        assert moved > 1e-4 * np.linalg.norm(balances[0].angular)  # of the other components


def test_weight_acts_downwards(comm):
    """A tilted rotor without cone has its weight on the shaft: standing, it stays in balance."""
    case = parse({"model": "rigid"}, pitch={"drive": "prescribed"})
    turbine = build_turbine(case, comm)
    state = turbine.system.initial_state()
    total, first = 0.0, turbine.system.first_coordinate
    height = {body.name: np.asarray(body.position) @ E2 for body in first}
    for body in first:
        total += body.mass * 9.81 * height[body.name]
    assert turbine.system.balance(state).potential == pytest.approx(total, rel=1e-12)


def test_it_turns_steadily_about_the_tilted_shaft(comm):
    """Started turning without weight, the blades keep their shape and each point its circle."""
    case = parse(
        {"rotor_speed": "12 rpm", "precone": "-4 deg"},
        time={"step": 0.02, "start": "turning"},
        loads={"gravity": 0.0},
        tower={"flexible": True, "elements": [4, 1, 2]},
    )
    turbine, _, _, last = run(case, comm, 1.0)
    start = make_start(case, turbine.system)
    frame = turning_frame(turbine.system, "rotor", 12.0 * np.pi / 30.0, start)
    assert frame.axis @ SHAFT > np.cos(np.radians(1.0))
    rotor = turbine.system.joint_coordinate_names.index("rotor")
    turned = last.state.joint_coordinates[rotor]
    assert turned == pytest.approx(12.0 * np.pi / 30.0, rel=1e-4)  # tan of half of each step
    frame.turn(last.state, -turned)
    assert start.u[0].norm() > 1e-3
    assert (last.state.u[0] - start.u[0]).norm() < 1e-7 * start.u[0].norm()


# --- mistakes


@pytest.mark.parametrize(
    ("turbine", "sentence"),
    [
        ({"tilt": "50 deg"}, "turbine.tilt"),
        ({"precone": -1.0}, "turbine.precone"),
        ({"hub": {"inertia": [1.0, 1.0, 3.0]}}, "turbine.hub.inertia = .* belongs to no mass"),
        ({"nacelle": {"inertia": [1.0, 1.0, 1.0, 2.0, 0, 0]}}, "turbine.nacelle.inertia"),
        ({"nacelle": {"inertia": [1.0, 1.0, 1.0, 0.0]}}, "got 4 numbers"),
        ({"nacelle": {"inertia": [1.0, 1.0]}}, "turbine.nacelle.inertia"),
        ({"nacelle": {"centre": [0.0, 1.0]}}, "turbine.nacelle.centre"),
    ],
)
def test_what_cannot_be_is_refused(turbine, sentence):
    with pytest.raises(InputError, match=sentence):
        Case.parse({"turbine": turbine})


def test_a_tensor_of_inertia_takes_the_place_of_euler_values():
    hub = {"inertia": [1.0, 1.0, 1.0], "euler": [2.0, 2.0, 2.0]}
    case = Case.parse({"turbine": {"hub": hub}})
    assert case.warnings == ["turbine.hub.euler has no effect beside turbine.hub.inertia"]
    assert Case.parse(case.model_dump(mode="json")) == case  # a run that goes on reads all keys


def test_roots_that_a_cone_brings_together_are_refused():
    tables = {"blade": {"hub_radius": 1.8, "chord": [6.0, 3.0, 0.6]}}
    Case.parse(tables)
    with pytest.raises(InputError, match="three blades that are 6 m wide at the root overlap"):
        Case.parse({**tables, "turbine": {"precone": "-20 deg"}})


def test_a_rotor_that_leans_towards_the_tower_is_doubted():
    warnings = Case.parse({"turbine": {"tilt": "6 deg", "precone": "4 deg"}}).warnings
    assert [w.split(" leans")[0] for w in warnings] == [
        "turbine.tilt = 6 degrees",
        "turbine.precone = 4 degrees",
    ]
    assert not any("leans" in w for w in parse().warnings)


def test_a_coned_and_raised_rotor_reaches_less_far_down():
    tower = {"flexible": True, "height": 50.0}
    depth = 56.25 * np.cos(np.radians(10.0)) - 55.6
    assert depth < 0.0
    assert not any("into the ground" in w for w in parse(tower=tower).warnings)
    low = Case.parse({"tower": tower}).warnings
    assert any("reach 6.25 m into the ground" in w for w in low)
