"""Damaged files that a case names (polars, turbulence, tables, windIO), given to check and run."""

import contextlib
import io
import warnings
from pathlib import Path

from aero_files import write_aerodyn, write_box, write_turbsim
from damage import damaged
from windio_files import small_turbine, write_turbine

from tests.attack._tally import Tally

TRIES = 3000
RIGID = """
turbine.model = "rigid"
turbine.rotor_speed = "11 rpm"
time.step = "0.02 s"
time.end = "0.04 s"
output.fields_every = 0
generator.keeps = "speed"
"""
WIND = """
[wind]
hub_height = "90 m"
{wind}
[aero]
file = "rotor.dat"
stations = 12
"""
TURBINE = """
turbine.file = "small.yaml"
mesh.span = 3
mesh.around = 8
time.step = "0.02 s"
time.end = "0.04 s"
output.fields_every = 0
"""
TABLE = b"time [s], rotor_torque [kN m], pitch_torque\n0, 0, 0\n1.5, 3600, 1\n3, 0, 1e3\n"
FRONT = b"time [s];speed [m/s];direction [deg]\n0;8;0\n30;8;0\n45;14;20\n600;14;20\n"
GUST = b"! time speed dir vert hshr exp vshr gust\n" + b"".join(
    b"%d %d 0 0 0 0.2 0 0\n" % (t, 8 + t % 5) for t in range(0, 60, 5)
)
SPEED = 'speed = "9 m/s"\nshear = 0.0'
BOX = """\
speed = "10 m/s"
box.files = ["u.bin", "v.bin", "w.bin"]
box.points = [128, 17, 17]
box.spacing = ["4 m", "12 m", "12 m"]
"""


def attack(tries, random, folder):
    """Each ends in sentences or with a result, never with a traceback."""
    tally, cases = Tally(), list(_cases(folder))
    for k in range(tries):
        case, name = cases[k % len(cases)]
        file = case.parent / name
        whole = file.read_bytes()
        file.write_bytes(damaged(whole, random))
        try:
            tally.hold(f"{file.suffix or name}: {try_case(case, folder / 'run')}")
        except (Exception, SystemExit) as error:
            (folder / f"{k}_{name}").write_bytes(file.read_bytes())
            tally.break_(f"{folder}/{k}_{name} in {case}: {type(error).__name__}: {error}")
        finally:
            file.write_bytes(whole)
    return tally


def try_case(case, out):
    """Say what check, and run if that finds nothing wrong, make of a case.

    Raises:
        AssertionError: if the answer is no sentence.
        Exception: what no user should see.
    """
    code, said = _call("check", str(case))
    if code == 0 and '"rigid"' in case.read_text():
        code, said = _call("run", str(case), "-o", str(out), "--overwrite", "--quiet")
        assert code != 2, f"run refuses what check finds valid: {said}"
        assert code in (0, 3, 4), f"exit code {code}: {said}"
        return "valid, and the run ends" if code == 0 else "valid, and the run says why it fails"
    assert code in (0, 2), f"exit code {code}: {said}"
    assert code == 0 or said.startswith(("error: ", "warning: ")), said
    return "refused in sentences" if code else "valid"


def _call(*arguments):
    """Exit code and words of a command of this process."""
    from turbine_fenicsx.cli.main import main

    said = io.StringIO()
    with (
        contextlib.redirect_stderr(said),
        contextlib.redirect_stdout(io.StringIO()),
        warnings.catch_warnings(action="error", category=RuntimeWarning),
    ):
        code = main(list(arguments))
    return code, said.getvalue()


def _cases(folder):
    """Case files and, beside them, a file each that they name."""
    winds = {
        "aerodyn": (SPEED, ["rotor.dat", "blade.dat", "plate.dat"]),
        "turbsim": ('file = "wind.bts"', ["wind.bts"]),
        "box": (BOX, ["u.bin"]),
        "front": ('file = "front.csv"\nshear = 0.0', ["front.csv"]),
        "gust": ('file = "gust.wnd"', ["gust.wnd"]),
    }
    for name, (wind, files) in winds.items():
        home = folder / name
        write_aerodyn(home)
        write_turbsim(home / "wind.bts", duration=90.0)
        write_box(home)
        (home / "front.csv").write_bytes(FRONT)
        (home / "gust.wnd").write_bytes(GUST)
        yield from ((_write(home, RIGID + WIND.format(wind=wind)), file) for file in files)
    home = folder / "table"
    home.mkdir()
    (home / "torque.csv").write_bytes(TABLE)
    tables = 'loads.file = "torque.csv"\n' + RIGID.replace('generator.keeps = "speed"', "")
    yield _write(home, tables), "torque.csv"
    home = folder / "windio"
    home.mkdir()
    write_turbine(small_turbine(), home)
    yield _write(home, TURBINE), "small.yaml"


def _write(home: Path, text):
    path = home / "case.toml"
    path.write_text(text)
    return path
