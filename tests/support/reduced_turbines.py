"""A small turbine of a windIO file with reduced blades, in wind, and its runs."""

from mpi4py import MPI

from histories import read_columns
from windio_files import small_turbine, write_turbine
from windio_polars import add_polars

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.run.run import run_case

COMM = MPI.COMM_WORLD
CONTROL = {
    "min_rotor_speed": 10.0,
    "rated_rotor_speed": 30.0,
    "rated_power": 2e5,
    "optimal_tsr": 7.0,
    "fine_pitch": 0.0,
}
CASE = """
[time]
step = "0.05 s"
end = "0.5 s"
start = "turning"
[wind]
speed = "9 m/s"
shear = 0.1
[aero]
stations = 8
[turbine]
file = "small.yaml"
rotor_speed = "25 rpm"
numerical_dissipation = 0.1
[mesh]
span = 6
around = 8
tip = "open"
[blade]
model = "reduced"
[blade.reduction]
modes = 4
functions = 30
[tower]
elements = [4, 1, 4]
[pitch]
bearings = true
drive = "prescribed"
angle = "10 deg"
duration = "0.3 s"
[solver]
tolerance = 1e-9
[output]
twists = [0.7, 0.9]
[output.gauges.root]
blade = 3
station = 0.2
"""


STRENGTH = 1e8
STRENGTHS = [
    f"life.material.biax.tension=[{STRENGTH}, {STRENGTH}]",
    f"life.material.biax.compression=[{STRENGTH}, {STRENGTH}]",
    f"life.material.biax.shear={STRENGTH}",
]
"""Strengths that the file of the turbine does not have, for the command life [Pa]."""


def write_case(folder):
    """Write the case and its turbine into a folder; the path of the case. Collective."""

    def write():
        write_turbine(add_polars(small_turbine()) | {"control": CONTROL}, folder)
        path = folder / "case.toml"
        path.write_text(CASE)
        return path

    return on_rank0(COMM, write)


def run(path, name, *changes):
    """Run the case with changes; its output folder. Collective."""
    out = path.parent / name
    run_case(Case.load(path, [*changes, "output.fields_every=0"]), out, COMM, "none")
    return out


def read(out):
    """Columns of a run, on all ranks."""
    return on_rank0(COMM, lambda: read_columns(out))
