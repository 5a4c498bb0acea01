"""A case file of a turbine of rigid blades with a controller, which runs in seconds."""

from aero_files import write_aerodyn

CASE = """
[time]
step = "0.1 s"
[turbine]
model = "rigid"
[wind]
speed = "9 m/s"
shear = 0
hub_height = "90 m"
turbulence = {points = 4, time_step = "1 s"}
[aero]
file = "rotor.dat"
stations = 8
[pitch]
drive = "actuator"
[drivetrain]
model = "stiff"
ratio = 97
generator_inertia = 500
[control]
kind = "pi"
"""


def write_controlled_case(folder):
    """Write it with the files of its air; the path of the case."""
    write_aerodyn(folder)
    path = folder / "case.toml"
    path.write_text(CASE)
    return path
