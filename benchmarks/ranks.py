"""What each rank sends in a step, on 1, 2, 4, ... ranks of any machine, however few its cores.

Counts, no times: a counter between the program and MPI (`count_messages.c`, made with mpicc) sees
every send and every collective operation, also those of PETSc and MUMPS. Writes ``ranks.json`` and
prints tables. Exit code 1 means that tips or iterations depend on the number of ranks. A step may
take one iteration more or less: solves are inexact, and at 1e-12 round-off decides when to end.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from competitors import HERE, environment, mpirun
from problem import parse_size, prepare

SAME = 1e-9
"""Tips on several ranks are those on one to this relative difference."""

WARM_UP = 2


def compile_counter(folder: Path) -> Path:
    """The counter as a library that can be preloaded."""
    library, source = folder / "count_messages.so", HERE / "count_messages.c"
    command = ["mpicc", "-shared", "-fPIC", "-O2", "-o", str(library), str(source), "-ldl"]
    subprocess.run(command, check=True)
    return library


def count(problem: Path, library: Path, ranks: int, solver: str, limit: float) -> dict:
    """Run the problem on some ranks; returns what `count_messages.py` writes."""
    result = library.with_name("counts.json")
    command = [*mpirun(ranks), sys.executable, str(HERE / "count_messages.py")]
    command += [str(problem), str(result), "--linear-solver", solver]
    more_ranks_than_cores = {
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
        "OMPI_MCA_hwloc_base_binding_policy": "none",
        "OMPI_MCA_mpi_yield_when_idle": "1",
    }
    variables = {**environment(), **more_ranks_than_cores, "LD_PRELOAD": str(library)}
    subprocess.run(command, check=True, env=variables, timeout=limit)
    return json.loads(result.read_text(encoding="utf-8"))


def compare(runs: list[dict]) -> list[str]:
    """Sentences on what depends on the number of ranks, and must not: tips and iterations."""
    found = []
    for run in runs:
        first = next(r for r in runs if r["solver"] == run["solver"])
        tips, same = np.array(run["tips"]), np.array(first["tips"])
        error = float(np.max(np.abs(tips - same)) / np.max(np.abs(same)))
        who = f'"{run["solver"]}" on {run["ranks"]} ranks'
        if error > SAME:
            found.append(f"{who}: tips differ by {error:.1e} from those on {first['ranks']}")
        more = np.abs(np.subtract(run["iterations"], first["iterations"]))
        if np.max(more) > 1:
            found.append(f"{who}: iterations {run['iterations']}, not {first['iterations']}")
    return found


def tabulate(runs: list[dict]) -> str:
    """A row for each run; of messages and bytes those of the rank that sends most, in one step."""
    head = (
        "solver",
        "ranks",
        "iterations",
        "CG",
        "messages",
        "kB sent",
        "collectives",
        "kB in them",
        "unknowns where ranks meet",
        "ghosts of a rank",
        "largest rank / mean",
    )
    lines = [" | ".join(head), " | ".join(["---", *["---:"] * (len(head) - 1)])]
    for run in runs:
        most = {name: max(values) for name, values in run["of_rank"].items()}
        counted = slice(WARM_UP, None)
        cells = (
            f"`{run['solver']}`",
            run["ranks"],
            f"{np.mean(run['iterations'][counted]):.3g}",
            f"{np.mean(run['krylov'][counted]):.3g}" if run["solver"] == "iterative" else "",
            f"{most['messages']:.0f}",
            f"{most['message_bytes'] / 1e3:.1f}",
            f"{most['collectives']:.0f}",
            f"{most['collective_bytes'] / 1e3:.1f}",
            sum(run["of_rank"]["interface"]),
            most["ghosts"],
            f"{most['owned'] / np.mean(run['of_rank']['owned']):.2f}",
        )
        lines.append(" | ".join(map(str, cells)))
    return "\n".join(f"| {line} |" for line in lines)


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", default="3x3x150", help="hexahedra of a blade (3x3x150)")
    parser.add_argument("--ranks", default="1,2,4,8,16", help="numbers of ranks (1,2,4,8,16)")
    parser.add_argument("--solvers", default="frozen,iterative", help="(frozen,iterative)")
    parser.add_argument("--steps", type=int, default=4, help=f"{WARM_UP} of them not counted (4)")
    parser.add_argument("--tolerance", type=float, default=1e-12, help="of a step (1e-12)")
    parser.add_argument("--limit", type=float, default=1800.0, help="seconds a run may take")
    parser.add_argument("--out", type=Path, default=HERE / "out", help="folder for the results")
    return parser.parse_args()


def main() -> int:
    args = arguments()
    args.out.mkdir(parents=True, exist_ok=True)
    found: list[str] = []
    everything: list[dict] = []
    with tempfile.TemporaryDirectory() as folder:
        library = compile_counter(Path(folder))
        for size in args.sizes.split(","):
            more = {"steps": args.steps, "warm_up": WARM_UP, "tolerance": args.tolerance}
            problem = prepare(Path(folder), parse_size(size), **more)
            runs = []
            for solver in args.solvers.split(","):
                for ranks in map(int, args.ranks.split(",")):
                    print(f"{size} {solver} on {ranks} ranks", file=sys.stderr, flush=True)
                    run = count(problem, library, ranks, solver, args.limit)
                    runs.append({"size": size, **run})
            everything += runs
            found += compare(runs)
            print(f"\n{size}, {runs[0]['unknowns']} unknowns\n\n{tabulate(runs)}")
    text = json.dumps(everything) + "\n"
    (args.out / "ranks.json").write_text(text, encoding="utf-8")
    print("\n".join(["", *(found or ["tips and iterations are the same on all ranks"])]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
