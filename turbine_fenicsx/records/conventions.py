"""Names and numbers of a turbine's parts in its output, and the signs of its angles."""

NACELLE, HUB, TOWER = "nacelle", "hub", "tower"
BLADES = ("blade_1", "blade_2", "blade_3")
PART_NUMBERS = {name: k for k, name in enumerate((NACELLE, HUB, *BLADES, TOWER))}
"""Numbers of the parts of every turbine in the field output; other parts follow."""

OPENFAST_SIGNS = {"yaw": -1.0, "rotor": 1.0, "pitch_1": -1.0, "pitch_2": 1.0, "pitch_3": -1.0}
"""Joint coordinate to the factor that makes it an angle of OpenFAST. The rotor's angle is positive
about the shaft, downwind; yaw about the upward vertical; pitch of all blades about the span from
tip to root, to feather. The paper counts some the other way."""

OPENFAST_HEAD = 8
"""Lines of ``history.out`` before the first row: free text, the fifth the title; names, units."""

MOTION = "motion.bin"
"""File of the motion of reduced bodies in an output folder."""
