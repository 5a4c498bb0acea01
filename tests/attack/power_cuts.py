"""Series cut, filled with zeros or with garbage behind the last checkpoints, then gone on with."""

import shutil

from tests.attack._runs import RIGID, command, differences
from tests.attack._tally import Tally

TRIES = 300
SERIES = ("history.csv", "history.out", "fields.bin", "fields.xdmf")
CHANGES = ("output.checkpoint_every=0.04", "output.fields_every=0.02")


def attack(tries, random, folder):
    """Damage, go on, compare with the run that was not damaged."""
    tally, half, whole = Tally(), folder / "half", folder / "whole"
    for out, end in ((half, 0.3), (whole, 0.4)):
        settings = ("--quiet", "--set", f"time.end={end}", *CHANGES)
        result = command("run", RIGID, "-o", out, *settings)
        assert result.returncode == 0, result.stderr
    for k in range(tries):
        out = folder / str(k)
        shutil.copytree(half, out)
        what = damage(out, random)
        result = command("restart", out, "--quiet", "--set", "time.end=0.4")
        said = [line for line in result.stderr.splitlines() if line.startswith("warning: ")]
        lost = any("lost" in line for line in said)
        if result.returncode or "Traceback" in result.stderr:
            tally.break_(f"{out}: {what}: {result.returncode}: {result.stderr[-300:]}")
        elif not lost and (found := differences(out, whole)):
            tally.break_(f"{out}: {what}: {', '.join(found)} differs, and nothing was said")
        else:
            tally.hold(
                "what cannot be restored was said"
                if lost
                else "went on from an earlier checkpoint, bit for bit"
                if said
                else "went on from the newest checkpoint, bit for bit"
            )
            shutil.rmtree(out)
    return tally


def damage(folder, random):
    """Damage one or two series as a power cut may; returns what was done."""
    done = []
    for name in random.choice(SERIES, int(random.integers(1, 3)), replace=False):
        path = folder / name
        data, kind = path.read_bytes(), random.choice(["cut", "zeros", "garbage", "missing"])
        end = len(data) - int(random.integers(1, 1 + len(data) // int(random.integers(1, 9))))
        rest = len(data) - end
        if kind == "garbage" and name == "fields.bin":
            kind = "cut"  # fields carry no checksum: whatever stands there is numbers
        if kind == "zeros" and name == "fields.bin":
            kind = "cut"
        if kind == "missing":
            path.unlink()
        else:
            tail = {"cut": b"", "zeros": bytes(rest), "garbage": random.bytes(rest)}[kind]
            path.write_bytes(data[:end] + tail)
        done.append(f"{name} {kind} from byte {end} of {len(data)}")
    return ", ".join(done)
