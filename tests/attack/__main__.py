"""Attack the program with damaged files and killed processes, outside the suite of tests.

``python -m tests.attack`` in the project's folder runs every attack at its full size, hours in all;
``make attack`` does the same. ``--share 0.02`` makes a fiftieth of it, names choose attacks. The
exit code is 1 if anything broke; its files then stay in ``out/attack/ATTACK`` for a look at them.

Each file here that has no leading underscore is an attack: the first line of its docstring says
what is tried, ``TRIES`` how often at full size, and ``attack(tries, random, folder)`` returns a
`Tally`.
"""

import argparse
import importlib
import os
import pkgutil
import shutil
import sys
from pathlib import Path

import numpy as np

import tests.attack
from tests.attack._tally import report

ROOT = Path(__file__).parents[2]


def main() -> int:
    """Run the attacks that were asked for and print what became of them."""
    modules = pkgutil.iter_modules(tests.attack.__path__)
    known = sorted(m.name for m in modules if not m.name.startswith("_"))
    parser = argparse.ArgumentParser(prog="python -m tests.attack", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="ATTACK", help=f"{', '.join(known)}; all")
    parser.add_argument("--share", type=float, default=1.0, help="of the full number of tries")
    parser.add_argument("--seed", type=int, default=1, help="another one tries other damages")
    options = parser.parse_args()
    unknown = sorted(set(options.names) - set(known))
    if unknown:
        parser.error(f"there is no attack {unknown[0]!r}, only {', '.join(known)}")
    broken = False
    for name in options.names or known:
        module = importlib.import_module(f"tests.attack.{name}")
        folder = ROOT / "out" / "attack" / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        random = np.random.default_rng([options.seed, *name.encode()])
        start = sum(os.times()[:4])
        tally = module.attack(max(1, round(options.share * module.TRIES)), random, folder)
        seconds = sum(os.times()[:4]) - start
        print(report(name, module.__doc__.splitlines()[0], tally, seconds), flush=True)
        if tally.broken:
            broken = True
        else:
            shutil.rmtree(folder)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
