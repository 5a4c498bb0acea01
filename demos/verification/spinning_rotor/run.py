"""The rotor of the IEA 22 MW turbine spins freely, with hollow blades of laminates.

The rotor of the windIO file on its tilted shaft, with three shear webs and all layers in each
blade, on a nacelle that may yaw freely on a rigid tower. There is no weight. It starts turning at
8 rpm, stretched by that, and a push of its torque, one second long, makes its blades swing by
centimetres. Afterwards nothing drives it and nothing takes energy out.

Then energy is constant, and so is the angular momentum about the vertical, the axis of the yaw
bearing. Walls of a few millimetres which are carried about by 12 m in each step of 0.1 s make the
round-off of the elastic forces large. Steps come down to it, so that the sum of their errors is a
random walk and not a drift.
"""

from published import compare_long_run


def main():
    """Rows of the table; nothing is run."""
    return compare_long_run("spinning_rotor")
