"""Case files with bytes, words and numbers changed, and absurd settings, given to ``check``."""

import contextlib
import io
import re

from aero_files import write_aerodyn

from tests.attack._runs import ROOT
from tests.attack._tally import Tally

TRIES = 7000
DEMOS = [
    *sorted((ROOT / "demos" / "paper").glob("*.toml")),
    *sorted((ROOT / "demos" / "turbine").glob("*.toml")),
    ROOT / "demos" / "emergency_stop" / "emergency_stop.toml",
]
VALUES = (
    *("0", "-1", "1e308", "1e-308", "nan", "inf", "true", '""', "[]", "{}", "[1,2,3]", "1e999"),
    *('"-36000 kN m"', '"12 furlong"', '"\\u0000"', "[[[[1]]]]", "99999999999999999999", "0x7f"),
)
NUMBER = re.compile(r"\d+(?:\.\d+)?")


def attack(tries, random, folder):
    """Each ends with exit code 0 or 2 and sentences, never with a traceback."""
    from turbine_fenicsx.cli.main import main

    tally, path = Tally(), folder / "case.toml"
    write_aerodyn(folder, length=117.0)
    for k in range(tries):
        text, changes = mutated(random)
        path.write_bytes(text)
        arguments = ["check", str(path), "--set", "mesh.elements=[1,1,2]", "tower.elements=[4,1,2]"]
        said = io.StringIO()
        try:
            with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
                code = main([*arguments, *changes])
        except (Exception, SystemExit) as error:
            (folder / f"{k}.toml").write_bytes(text)
            tally.break_(f"{folder}/{k}.toml {changes}: {type(error).__name__}: {error}")
            continue
        if code == 0:
            tally.hold("valid")
        elif code == 2 and said.getvalue().startswith(("error: ", "warning: ")):
            tally.hold("refused in sentences")
        else:
            (folder / f"{k}.toml").write_bytes(text)
            tally.break_(f"{folder}/{k}.toml {changes}: exit code {code}")
    return tally


def mutated(random):
    """The bytes of a case and some settings for the command line."""
    text = DEMOS[int(random.integers(len(DEMOS)))].read_text(encoding="utf-8")
    text = text.replace("IEA-15-240-RWT.yaml", "rotor.dat")  # small, and read at once
    lines = text.splitlines()
    keys = re.findall(r"^(\w+) *=", text, re.MULTILINE)
    tables = re.findall(r"^\[([\w.]+)\]", text, re.MULTILINE)
    changes = []
    for _ in range(int(random.integers(1, 4))):
        kind, at = int(random.integers(6)), int(random.integers(len(lines)))
        value = VALUES[int(random.integers(len(VALUES)))]
        if kind == 0:
            del lines[at]
            lines = lines or [""]
        elif kind == 1:
            lines.insert(at, lines[int(random.integers(len(lines)))])
        elif kind == 2:
            lines[at] = NUMBER.sub(lambda _, v=value: v, lines[at], count=1)
        elif kind == 3:
            lines[at] = lines[at].split("=")[0] + f"= {value}"
        elif kind == 4:
            lines[at] = lines[at].replace("e", "é", 1).replace('"', "'", 1)
        elif keys and tables:
            table, key = (names[int(random.integers(len(names)))] for names in (tables, keys))
            changes.append(f"{table}.{key}={value}")
    data = bytearray("\n".join(lines).encode())
    if data and random.uniform() < 0.2:
        data[int(random.integers(len(data)))] = int(random.integers(256))
    return bytes(data), changes
