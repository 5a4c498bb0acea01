"""Run the benchmark: who takes how long for a step of the same three blades.

Everything runs in child processes, in turns, ``--repeat`` times; results are written after each
child to ``results.json``, and at the end to ``report.md`` and ``scaling.png``. Exit code 1 means
that the tip deflections of some code do not agree, 2 that nothing could be measured.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import re
import sys
from pathlib import Path

from competitors import COMPETITORS, HERE, PEERS, SETS, environment, run
from problem import SIZES, parse_size, prepare
from report import report

PARTS = ("compare", "growth", "soft", "large", "units", "small")
SOFT_STEPS = 140
"""2.8 s: soft blades are then deflected by half their length."""


def machine() -> dict:
    """What the numbers were measured on."""
    text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    model = re.search(r"model name\s*:\s*(.*)", text)
    return {
        "processor": model.group(1) if model else platform.processor(),
        "cores": len(os.sched_getaffinity(0)),
        "load_before": os.getloadavg()[0],
        "date": datetime.date.today().isoformat(),
    }


def child(record: dict, command: list[str], result: Path, limit: float) -> dict:
    """Run one child and add what it wrote, or its error, to the record."""
    result.unlink(missing_ok=True)
    error = run(command, limit)
    if error:
        return {**record, "error": error}
    return {**record, **json.loads(result.read_text(encoding="utf-8"))}


def jobs(args: argparse.Namespace) -> list[tuple[dict, list[str]]]:
    """All children of one turn: what is known of each beforehand, and its command."""
    chosen = [re.compile(word) for word in args.only.split(",") if word]
    found: list[tuple[dict, list[str]]] = []
    result = str(args.out / "child.json")

    def problem(size: str, **more) -> tuple[dict, str]:
        elements = parse_size(size)
        path = prepare(args.out / "meshes", elements, **more)
        return {"size": "x".join(map(str, elements))}, str(path)

    def add(part: str, names, size: str, **more) -> None:
        about, path = problem(size, **more)
        unknowns = 9 * (parse_size(size)[0] + 1) * (parse_size(size)[1] + 1)
        unknowns *= parse_size(size)[2] + 1
        for name in names:
            c = COMPETITORS[name]
            wanted = not chosen or any(word.fullmatch(name) for word in chosen)
            if wanted and c.available() and unknowns <= c.most_unknowns:
                found.append(({"part": part, "code": name, **about}, c.command(path, result)))

    if "compare" in args.parts:
        for size in args.sizes:
            add("compare", COMPETITORS, size, steps=args.steps)
    if "growth" in args.parts:
        for size in args.growth:
            if not ("compare" in args.parts and size in args.sizes):
                add("growth", SETS["growth"], size, steps=args.steps)
    if "soft" in args.parts:
        for size in args.soft:
            add("soft", SETS["soft"], size, steps=SOFT_STEPS, material="soft")
    if "large" in args.parts:
        for size in filter(None, args.large):
            add("growth", SETS["large"], size)
            add("soft", SETS["large"], size, material="soft")
    if "units" in args.parts:
        about, path = problem(args.sizes[0], steps=args.steps)
        command = [sys.executable, str(HERE / "units.py"), path, result]
        found.append(({"part": "units", "code": "units", **about}, command))
    if "small" in args.parts:
        model = str(args.out / "rigid_model.json")
        python = [sys.executable, str(HERE / "rigid.py")]
        found.append(({"part": "small", "code": "rigid"}, [*python, result, model]))
        if any(PEERS.parent.parent.glob("lib/python*/site-packages/exudyn")):
            command = [str(PEERS), str(HERE / "exudyn_turbine.py"), model, result]
            found.append(({"part": "small", "code": "exudyn"}, command))
        command = [sys.executable, str(HERE / "paper.py"), result]
        found.append(({"part": "small", "code": "paper"}, command))
    return found


def arguments(words: list[str] | None = None) -> argparse.Namespace:
    """The command line."""
    names = ", ".join(SIZES)
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])

    def several(option: str, default: str, text: str) -> None:
        parser.add_argument(option, default=default, type=lambda s: s.split(","), help=text)

    several("--parts", ",".join(PARTS), f"of {', '.join(PARTS)} (default: all)")
    several("--sizes", "70k,220k", f"for all codes; like 8x8x96, or {names} (70k,220k)")
    several("--growth", "10k,30k,70k,220k,300k", "for growth with unknowns (10k to 300k)")
    several("--soft", "10k", "for soft blades (10k)")
    several("--large", "", "for the iterative solver, stiff and soft; 1.2M takes 24 GB (none)")
    parser.add_argument("--only", default="", help="codes, comma-separated regular expressions")
    parser.add_argument("--steps", type=int, default=12, help="time steps, the first 2 not counted")
    parser.add_argument("--repeat", type=int, default=3, help="turns; the fastest counts")
    parser.add_argument("--limit", type=float, default=1800.0, help="seconds a child may take")
    parser.add_argument("--out", type=Path, default=HERE / "out", help="folder for the results")
    parser.add_argument("--add", action="store_true", help="keep the results in the folder")
    parser.add_argument("--list", action="store_true", help="say who would run, and stop")
    args = parser.parse_args(words)
    args.out = args.out.resolve()
    unknown = set(args.parts) - set(PARTS)
    if unknown or args.steps < 3:
        parser.error(f"no such part: {unknown}" if unknown else "--steps must be 3 or more")
    return args


def main() -> int:
    args = arguments()
    if args.list:
        for c in COMPETITORS.values():
            print(f"{c.name:<22}{'' if c.available() else 'not available'}")
        return 0
    args.out.mkdir(parents=True, exist_ok=True)
    os.environ.update(environment())
    found = args.out / "results.json"
    data: dict = {"machine": machine(), "records": []}
    if args.add and found.exists():
        data = json.loads(found.read_text(encoding="utf-8"))
    todo = jobs(args)
    failed = set()
    for turn in range(args.repeat):
        for k, (about, command) in enumerate(todo):
            if k in failed:
                continue
            label = " ".join(str(v) for v in about.values())
            print(f"turn {turn + 1}/{args.repeat}: {label}", file=sys.stderr, flush=True)
            record = child({**about, "turn": turn}, command, args.out / "child.json", args.limit)
            if "error" in record:
                failed.add(k)
                print(f"  failed: {record['error']}", file=sys.stderr)
            data["records"].append(record)
            text = json.dumps(data, indent=1) + "\n"
            found.write_text(text, encoding="utf-8")
    text, agree = report(data)
    (args.out / "report.md").write_text(text, encoding="utf-8")
    print(text)
    try:
        from plot import plot

        plot(data, args.out / "scaling.png")
    except ImportError:
        print("no picture: Matplotlib is missing", file=sys.stderr)
    if len(failed) == len(todo):
        return 2
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
