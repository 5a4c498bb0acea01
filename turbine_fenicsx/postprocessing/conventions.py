"""Signs in which users see the angles of a turbine; the paper counts some the other way."""

OPENFAST_SIGNS = {"yaw": -1.0, "rotor": 1.0, "pitch_1": -1.0, "pitch_2": 1.0, "pitch_3": -1.0}
"""Joint coordinate to the factor that makes it an angle of OpenFAST: the rotor's is positive about
the shaft, downwind; yaw about the upward vertical; pitch, of all blades alike, about the span from
tip to root, to feather."""
