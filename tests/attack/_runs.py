"""Small runs to be attacked, and what their results must be."""

from pathlib import Path

from histories import read_lines

from tests.cli.conftest import run_command

ROOT = Path(__file__).parents[2]
RIGID = ROOT / "demos" / "paper" / "rigid.toml"
SOFT = ROOT / "demos" / "paper" / "hybrid_soft.toml"
SIZE = ("mesh.elements=[1,1,6]", "output.fields_every=0.02", "output.checkpoint_every=0.02")
"""Changes that make the hybrid turbine small, and its files grow in every step."""


def command(*arguments, ranks=None, timeout=600.0):
    """Run the command line in a process of its own; on two ranks if asked to."""
    return run_command(*arguments, ranks=ranks, timeout=timeout)


def differences(folder, whole):
    """Names of the series of a folder that are not those of another run bit for bit."""
    from outputs import read_fields

    found = []
    if read_lines(folder) != read_lines(whole):
        found.append("history.csv")
    if (folder / "history.out").read_bytes() != (whole / "history.out").read_bytes():
        found.append("history.out")
    mine, theirs = (read_fields(f / "fields.xdmf") for f in (folder, whole))
    same = mine.keys() == theirs.keys() and all(
        mine[t].keys() == theirs[t].keys()
        and all((mine[t][name] == theirs[t][name]).all() for name in theirs[t])
        for t in theirs
    )
    return found if same else [*found, "fields"]
