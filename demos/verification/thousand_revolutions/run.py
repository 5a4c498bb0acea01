"""A thousand revolutions of the flexible turbine.

The paper's hybrid turbine with stiff blades, 144 trilinear hexahedra on a rigid hub, with gravity.
A torque spins the rotor up within 14 seconds to 12 rpm; from there on nothing drives it. In the
step of 0.05 s, 99 of them for a revolution, a hundred thousand steps follow one another.

Then energy is constant; so is the angular momentum about the vertical, the axis of the free yaw
bearing, which is zero. The rotor angle is a coordinate of the system, with one equation that ties
it to the directors, which know it up to full turns only. It must continue without a jump, and at
all times be the sum of the turns that the directors make from step to step.

All these errors are sums of the round-off of single steps; the table shows how large they grew.
"""

from published import compare_long_run


def main():
    """Rows of the table; nothing is run."""
    return compare_long_run("thousand_revolutions")
