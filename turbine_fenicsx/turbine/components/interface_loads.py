"""Loads at the yaw bearing and of the rotor on its shaft, and the motion of the nacelle.

A free body passes on the sum over the joints that hold it. The hub passes on the load of its
bearing, without the part that its joint with the generator gives back. Weight, inertia and
air of the rotor are in it. Its torque is the one that drives the generator.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import HUB, NACELLE, OPENFAST_SIGNS
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.joint_reactions import JointReaction, JointReactions
from turbine_fenicsx.simulation.observers.step_rates import StepRates
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.components.axes import TOWER_AXES, hub_axes, shaft_axes
from turbine_fenicsx.turbine.components.component import Channels, Turbine
from turbine_fenicsx.turbine.components.drivetrain import SHAFT, fast_shaft
from turbine_fenicsx.turbine.components.nacelle import ROTOR, SUPPORT, YAW
from turbine_fenicsx.turbine.components.openfast_channel import in_openfast


class InterfaceLoads:
    """Loads of the nacelle on the yaw bearing, and of the rotor on the shaft.

    Args:
        turning: Whether axes turn with nacelle and hub (n, a), or stay with what carries these
            (p, s).

    Attributes:
        loads: What the joints pass on, with the memory of means.
    """

    def __init__(self, turbine: Turbine, turning: bool) -> None:
        hub, nacelle, layout = turbine.part(HUB), turbine.part(NACELLE), turbine.rotor.layout
        yaw, rotor, shaft = turbine.part(YAW), turbine.part(ROTOR), turbine.find(SHAFT)
        of_bearing = TOWER_AXES, nacelle if turning else turbine.find(SUPPORT)
        of_shaft = (hub_axes(layout), hub) if turning else (shaft_axes(layout), nacelle)
        reactions = [
            JointReaction(yaw, (0.0, 0.0, 0.0), *of_bearing),
            JointReaction(rotor, layout.centre, *of_shaft),
        ]
        self._given_back = shaft is not None
        if shaft is not None:
            reactions.append(JointReaction(shaft, layout.centre, *of_shaft))
        self.loads = JointReactions(turbine.system, reactions)

    def mean_at(self, snapshot: Snapshot) -> Array:
        """Means of two steps; see `pass_on`."""
        return self.pass_on(self.loads.mean_at(snapshot))

    def at_rest(self, state: State) -> Array:
        """Loads in an equilibrium; see `pass_on`."""
        return self.pass_on(self.loads.at_rest(state))

    def pass_on(self, loads: Array) -> Array:
        """Force and moment on the yaw bearing and the shaft, shape (2, 2, 3)."""
        found = -loads[:2]  # a joint has what it exerts on nacelle and hub
        if self._given_back:
            found[1] += loads[2]
        return found


def interface_channels(turbine: Turbine) -> Channels:
    """Loads at yaw bearing and shaft, speeds and accelerations of rotor and nacelle. Collective."""
    interfaces, gauge = InterfaceLoads(turbine, turning=False), turbine.case.output.shaft_gauge
    columns = [
        family(axis=axis)
        for family in (
            *(names.YAW_BEARING_FORCE, names.YAW_BEARING_MOMENT),
            *(names.SHAFT_FORCE, names.SHAFT_MOMENT),
        )
        for axis in "xyz"
    ]

    def both(s: Snapshot) -> list[float]:
        found: list[float] = interfaces.mean_at(s).ravel().tolist()
        return found

    return Channels(
        history=[Channel(tuple(columns), both, interfaces.loads)],
        openfast=[
            *_load_channels(interfaces, "ps", gauge),
            *_load_channels(InterfaceLoads(turbine, turning=True), "na", gauge),
            *_drivetrain_channels(turbine, interfaces),
            *_motion_channels(turbine),
        ],
    )


def _load_channels(interfaces: InterfaceLoads, frames: str, gauge: float) -> list[Channel]:
    """Loads at yaw bearing and shaft.

    Args:
        frames: Letters of the axes of bearing and shaft.
        gauge: Distance of the gauge of the shaft behind the rotor centre [m].
    """
    top, shaft = frames[0], frames[1]

    def make(columns: Sequence[str], find: Callable[[Array], Array]) -> Channel:
        return in_openfast(columns, lambda s: find(interfaces.mean_at(s)), interfaces.loads)

    def at_gauge(loads: Array) -> Array:
        # M_g = M - L e x F for the gauge at L e behind the rotor centre
        F, M = loads[1]
        return np.array([M[1] + gauge * F[2], M[2] - gauge * F[1]])

    across = [f"{name}{axis}{shaft}" for name in ("LSShftF", "LSSTipM") for axis in "yz"]
    along = () if shaft == "a" else ("RotThrust", "RotTorq")
    return [
        make([f"YawBr{kind}{axis}{top}" for kind in "FM" for axis in "xyz"], lambda x: x[0]),
        *([make(along, lambda x: x[1, :, 0])] if along else []),
        make(across, lambda x: x[1, :, 1:]),
        make([f"LSSGagM{axis}{shaft}" for axis in "yz"], at_gauge),
    ]


def _drivetrain_channels(turbine: Turbine, interfaces: InterfaceLoads) -> list[Channel]:
    """Speed of the generator, torque and power of both shafts."""
    coordinates, ratio = turbine.system.joint_coordinate_names, turbine.case.drivetrain.ratio
    factors, rotor = fast_shaft(turbine.system, ratio), coordinates.index(ROTOR)
    terms = [(coordinates.index(name), factor) for name, factor in factors.items()]

    def find_speed(s: Snapshot) -> float:
        return sum(factor * float(s.state.joint_rates[k]) for k, factor in terms)

    def powers(s: Snapshot) -> list[float]:
        torque = float(interfaces.mean_at(s)[1, 1, 0])
        slow, fast = float(s.state.joint_rates[rotor]), find_speed(s)
        return [torque * slow, torque / ratio, torque / ratio * fast]

    return [
        in_openfast(("GenSpeed",), lambda s: [find_speed(s)]),
        in_openfast(("RotPwr", "HSShftTq", "HSShftPwr"), powers, interfaces.loads),
    ]


def _motion_channels(turbine: Turbine) -> list[Channel]:
    """Speed of the yaw, and accelerations of rotor, yaw bearing and nacelle."""
    nacelle, support = turbine.part(NACELLE), turbine.find(SUPPORT)
    coordinates, first = turbine.system.joint_coordinate_names, turbine.system.first_coordinate
    rotor, yaw = coordinates.index(ROTOR), coordinates.index(YAW)

    def place(state: State, body: RigidBody) -> Array:
        return state.q[first[body] : first[body] + 12].reshape(4, 3)

    # constant coordinates in the frame of the nacelle: 1 for its origin, then its directors
    bearing = np.array([1.0, *nacelle.body_coordinates(np.zeros(3))])
    axes = shaft_axes(turbine.rotor.layout) @ np.asarray(nacelle.directors)
    spin = StepRates(lambda state: state.joint_coordinates[rotor : rotor + 1])
    way = StepRates(lambda state: bearing @ place(state, nacelle))
    turn = StepRates(lambda state: place(state, nacelle)[1:].T, _find_turn)

    def in_nacelle(s: Snapshot, vector: Array) -> Array:
        return np.asarray(axes @ place(s.state, nacelle)[1:] @ vector)

    def of_bearing(s: Snapshot) -> Array:
        return in_nacelle(s, way.follow(s.state)[1])

    def on_top(s: Snapshot) -> Array:
        _, a = way.follow(s.state)
        if support is None:
            return np.asarray(TOWER_AXES @ a)
        directors = np.asarray(support.directors) @ place(s.state, support)[1:]
        return np.asarray(TOWER_AXES @ directors @ a)

    return [
        in_openfast(("YawVzn",), lambda s: [OPENFAST_SIGNS[YAW] * s.state.joint_rates[yaw]]),
        in_openfast(("RotAccel",), lambda s: spin.follow(s.state)[1], spin),
        in_openfast([f"YawBrTA{axis}p" for axis in "xyz"], on_top, way),
        in_openfast([f"NcIMUTA{axis}s" for axis in "xyz"], of_bearing, way),
        in_openfast(
            [f"NcIMU{kind}{axis}s" for kind in ("RV", "RA") for axis in "xyz"],
            lambda s: np.array([in_nacelle(s, vector) for vector in turn.follow(s.state)]),
            turn,
        ),
    ]


def _find_turn(new: Array, old: Array) -> Array:
    """Vector of the rotation from old to new directors, which are columns, shape (3,)."""
    return np.asarray(Rotation.from_matrix(new @ old.T).as_rotvec())
