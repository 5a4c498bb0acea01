"""Run benchmarks and write their table to ``docs/verification.md``.

``python demos/verification`` runs all of them but those that take minutes each (``SLOW = True`` in
their script), ``python demos/verification NAME ...`` runs those named; the page keeps what it has
of the others. The exit status is 1 if an error is larger than allowed.

A benchmark is a folder here with two files, and is found without being listed anywhere:

- ``run.py``: its docstring is what the page says; ``main()`` returns the rows of the table;
- ``reference.toml``: ``source``, in Markdown, and the values to compare with, see `Reference`.

An independent solution, if there is one, stands in ``exact.py``; tests compare it with the values.
"""

import argparse
import sys

from mpi4py import MPI

from page import markdown, table
from published import HERE, load, names

PAGE = HERE.parents[1] / "docs" / "verification.md"


def main(chosen):
    """Run the benchmarks and return the exit status."""
    first = MPI.COMM_WORLD.rank == 0
    results = {}
    for name in chosen or names():
        benchmark = load(name)
        if not chosen and getattr(benchmark, "SLOW", False):
            continue
        results[name] = benchmark.main()
        if first:
            print(f"{name}\n{table(results[name])}\n", flush=True)
    if first:
        before = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
        PAGE.write_text(markdown(results, before), encoding="utf-8")
    failed = [
        f"{name}: {row.quantity}" for name, rows in results.items() for row in rows if not row.holds
    ]
    if first and failed:
        print("errors or orders out of bounds:", *failed, sep="\n  ", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("name", nargs="*", help=f"{', '.join(names())}; default: all but slow ones")
    wanted = parser.parse_args().name
    if unknown := set(wanted) - set(names()):
        parser.error(f"there is no benchmark {min(unknown)!r}; there are {', '.join(names())}")
    sys.exit(main(wanted))
