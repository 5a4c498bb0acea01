"""Pictures of a load set: channels over the wind speed beside those of others, and return periods.

``python demos/load_set/draw.py OUT [FILE ...]`` writes ``OUT/winds.png``, with tables such as
``iea22_openfast.csv`` beside, and ``OUT/returns.png``.
"""

import sys
from pathlib import Path

from turbine_fenicsx.load_sets.set_panels import draw_exceedance, draw_winds
from turbine_fenicsx.load_sets.stored_set import StoredSet, read_winds


def main():
    out, *files = map(Path, sys.argv[1:])
    found = StoredSet.read(out)
    others = {path.stem: read_winds(path)[""] for path in files}
    draw_winds(found.winds["1.2"], others, out / "winds.png")
    draw_exceedance(found.returns, out / "returns.png")


if __name__ == "__main__":
    main()
