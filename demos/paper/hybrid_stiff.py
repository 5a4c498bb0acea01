"""The paper's hybrid turbine with stiff blades, built from the library's own classes."""

from mpi4py import MPI

import numpy as np

from turbine_fenicsx import (
    BladeGeometry,
    Coupling,
    FlexibleBody,
    Gravity,
    Hat,
    History,
    JointTorque,
    MultibodySystem,
    OrthotropicSVK,
    Revolute,
    RigidBody,
    Simulation,
)
from turbine_fenicsx.bodies.frame_fields import frame_fields
from turbine_fenicsx.meshing import MeshOptions, RotorLayout, load_arrays, mesh_rotor
from turbine_fenicsx.simulation.observers import history

E2, E3 = np.eye(3)[1:]


def main(path="history.csv", end=12.0, comm=MPI.COMM_WORLD):
    """Run to the end time [s] and return the last snapshot."""
    hub_centre = -5.0 * E3
    layout = RotorLayout(centre=tuple(hub_centre))
    mesh = load_arrays(comm, lambda: mesh_rotor(BladeGeometry(), layout, MeshOptions()), "rotor")

    # Rigid parts (1)-(8) of Table 1; yaw and rotor bearings (12) with joint angles (15)-(18)
    nacelle = RigidBody("nacelle", mass=2.0e5, euler=(6.0e5, 6.0e5, 6.0e5))
    hub = RigidBody("hub", mass=6.1e4, euler=(102940, 102940, 81330), position=hub_centre)
    yaw = Revolute("yaw", None, nacelle, point=(0, 0, 0), axis=-E2, reference=E3)
    rotor = Revolute("rotor", nacelle, hub, point=hub_centre, axis=E3, reference=E2)

    # Flexible blades (62)-(66), fibre along the span; their roots move with the hub (53)-(54)
    frames = {mesh.cell_names[f"blade_{k}"]: layout.frame(k) for k in (1, 2, 3)}
    axes = frame_fields(mesh.mesh, mesh.cell_tags, frames)
    law = OrthotropicSVK(
        young=(45e9, 15e9, 15e9), shear=(5.4e9,) * 3, poisson=(0.3,) * 3, frame=axes
    )
    blades = FlexibleBody("blades", mesh.mesh, law, density=1500.0)
    roots = [
        Coupling(name, blades, mesh.facets(name), hub) for name in ("root_1", "root_2", "root_3")
    ]

    torque = JointTorque("torque on rotor", "rotor", -3.6e7, Hat(1.0, duration=3.0))
    loads = [Gravity((0.0, -9.81, 0.0)), torque]
    system = MultibodySystem(comm, [nacelle, hub, yaw, rotor, blades, *roots, *loads])
    columns = [history.energy_channel(), history.angle_channel(system), history.numerics_channel()]
    return Simulation(system, 0.02, end, [History(comm, path, columns)]).run()


if __name__ == "__main__":
    print(main())
