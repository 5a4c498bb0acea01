"""The pages of ``docs``: every block of code in them runs, and what they list is all there is."""

import csv
import importlib.util
import os
import re
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest
from patience import patience

from turbine_fenicsx.records.openfast_names import find_row

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
README = os.path.join("..", "README.md")
PAGES = {
    os.path.relpath(path, DOCS): path.read_text(encoding="utf-8")
    for path in [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
    if "_build" not in path.parts
}
BLOCK = re.compile(
    r"^```(?:\{code-block\} )?(\w+)\n((?::\w+:[^\n]*\n)*)(.*?)^```$", re.DOTALL | re.MULTILINE
)
FENCE = re.compile(r"^\s*(?:```|~~~|:::)", re.MULTILINE)
SHORTER = re.compile(r"Run by the tests .*?with `(--set [^`]+)`")
LONG = re.compile(r"^(make demo|.*turbine-fenicsx run [^&]*?)(?= -- | &|$)", re.MULTILINE)


@dataclass
class Block:
    """A block of code: its language, its caption, what it holds."""

    language: str
    caption: str
    text: str


def blocks(text):
    """Blocks of a page in their order."""
    found = []
    for language, options, inside in BLOCK.findall(text):
        caption = re.search(r"^:caption: (.*)$", options, re.MULTILINE)
        found.append(Block(language, caption[1] if caption else "", inside))
    return found


WITH_CODE = [name for name, text in PAGES.items() if {b.language for b in blocks(text)} - {"text"}]
QUICK = {os.path.join("howto", "fatigue.md"), os.path.join("reference", "case_file.md")}
PAGES_WITH_CODE = [
    name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in WITH_CODE
]


def test_there_is_no_kind_of_block_that_is_not_run():
    assert "tutorial.md" in WITH_CODE and len(WITH_CODE) > 8
    for name, text in PAGES.items():
        found = blocks(text)
        assert {b.language for b in found} <= {"bash", "python", "toml", "text"}, name
        assert all(b.caption.endswith(".toml") for b in found if b.language == "toml"), name
        directives = re.findall(r"^```\{(?!code-block)", text, re.MULTILINE)
        assert len(FENCE.findall(text)) == 2 * (len(found) + len(directives)), name


def test_no_attribute_of_an_image_stands_as_text():
    for name, text in PAGES.items():
        assert not re.search(r"\)\{[a-z#.]", text), name  # MyST does not take it, GitHub neither


@pytest.fixture
def sandbox(tmp_path, command_line):
    """A folder like that of the project, and what runs a line of shell in it."""
    launcher, settings = command_line.__globals__["mpirun"]()
    programs = {
        "turbine-fenicsx": f'exec {sys.executable} -m turbine_fenicsx "$@"',
        "python": f'exec {sys.executable} "$@"',
        "mpirun": f'exec {launcher} "$@"',
        "make": f'exec {sys.executable} "{tmp_path}/.venv/make.py" "$@"',
        "sbatch": 'exec bash "$@"',
        "srun": 'exec "$@"',
        "scontrol": "exit 1",
        "activate": "",
    }
    (tmp_path / ".venv" / "bin").mkdir(parents=True)
    for name, text in programs.items():
        path = tmp_path / ".venv" / "bin" / name
        path.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
        path.chmod(0o755)
    (tmp_path / ".venv" / "make.py").write_text(MAKE.replace("MAKEFILE", str(ROOT / "Makefile")))
    for name in ("demos", "meshes"):
        (tmp_path / name).symlink_to(ROOT / name)

    def run(line):
        path = f"{tmp_path / '.venv' / 'bin'}{os.pathsep}{os.environ['PATH']}"
        environment = settings | dict(os.environ) | {"PATH": path, "PYTHONPATH": str(ROOT)}
        command = ["bash", "-e", "-o", "pipefail", "-c", line]
        return subprocess.run(
            command,
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            timeout=patience(300),
        )

    if launcher is None:
        pytest.skip("there is no mpirun")
    return run


MAKE = """
# the recipe of a target of the Makefile, with more arguments, but not those it depends on
import re, subprocess, sys
target, *more = sys.argv[1:]
text = open("MAKEFILE").read()
rule = re.search(rf"^{target}:.*\\n((?:\\t.*\\n)+)", text, re.MULTILINE)
values = dict(re.findall(r"^(?:export )?(\\w+) \\?= (.*)$", text, re.MULTILINE))
recipe = re.sub(r"\\$\\((\\w+)\\)", lambda variable: values[variable[1]], rule[1].strip())
sys.exit(subprocess.run(["sh", "-ec", " ".join([recipe, *more])]).returncode)
"""


@pytest.mark.parametrize("name", PAGES_WITH_CODE)
def test_blocks_of_a_page_run(name, sandbox, tmp_path):
    for block in blocks(PAGES[name]):
        is_file = re.fullmatch(r"[\w.]+\.(toml|py|sh)", block.caption)
        if is_file:
            (tmp_path / block.caption).write_text(block.text, encoding="utf-8")
        if block.language == "python":
            if not is_file:
                (tmp_path / "block.py").write_text(block.text, encoding="utf-8")
            result = sandbox(f"python {block.caption if is_file else 'block.py'}")
        elif block.language == "bash" and not is_file:
            shorter = SHORTER.search(block.caption)
            lines = LONG.sub(rf"\1 {shorter[1]}", block.text) if shorter else block.text
            assert not shorter or shorter[1] in lines, block.text
            result = sandbox(lines)
        else:
            continue
        assert result.returncode == 0, f"{block.text}\n{result.stdout}\n{result.stderr}"
    for path in tmp_path.glob("out/*/history.csv"):
        with path.open(newline="") as file:
            # columns of a component of one's own stand on its own page
            assert_documented(next(csv.reader(file)), PAGES["reference/output.md"] + PAGES[name])
    for path in tmp_path.glob("out/*/history.out"):
        channels = path.read_text().splitlines()[6].split()[1:]
        assert [c for c in channels if find_row(c) is None and f"{c}_[" not in PAGES[name]] == []


def assert_documented(columns, page):
    """All columns are listed, one for all blades, components and places."""
    listed = set(re.findall(r"`([^`\n]+)`", BLOCK.sub("", page)))
    for column in columns:
        first = re.sub(r"(?<=[a-z]_)[123](?=_)|(?<=b)[123]$|(?<=Pitch)[123]$", "1", column)
        first = re.sub(r"(?<=_)[yz](?=_\[)|(?<=[DFM])[yz](?=b1$)", "x", first)
        first = re.sub(r"(?<=_at_)[0-9.]+(?=_)", "0.5", first)
        assert first in listed, column


def loaded(path):
    """A script as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module  # where dataclasses look
    spec.loader.exec_module(module)
    return module


def generated():
    """The Sphinx extension that makes parts of pages; it needs no Sphinx for that."""
    return loaded(DOCS / "_extensions" / "generated.py")


def test_the_gallery_shows_every_demo_and_its_page_is_up_to_date():
    page = loaded(ROOT / "demos" / "gallery" / "gallery_page.py")
    assert PAGES["gallery.md"] == page.markdown(), "python demos/gallery NAME writes it anew"
    names = {entry.name for entry in page.ENTRIES}
    benchmarks = {p.parent.name for p in (ROOT / "demos" / "verification").glob("*/run.py")}
    folders = [ROOT / "demos" / name for name in ("paper", "turbine", "studies")]
    cases = {path.stem for folder in folders for path in folder.glob("*.toml")}
    assert benchmarks and cases and benchmarks | cases <= names
    for entry in page.ENTRIES:
        assert 10_000 < (DOCS / entry.path).stat().st_size < 500_000, entry.path


@pytest.mark.slow
def test_a_picture_of_the_gallery_is_drawn(sandbox, tmp_path):
    pytest.importorskip("pyvista")
    result = sandbox("python demos/gallery four_bar -o drawn")
    assert result.returncode == 0, result.stderr
    picture = tmp_path / "drawn" / "images" / "gallery" / "four_bar.png"
    assert picture.stat().st_size > 10_000
    assert (tmp_path / "drawn" / "gallery.md").read_text() == PAGES["gallery.md"]


def test_generated_parts_of_pages_are_up_to_date():
    module = generated()
    held = {kind for text in PAGES.values() for _, kind, _ in module.PART.findall(text)}
    assert held == set(module.GENERATORS)
    for name, text in PAGES.items():
        assert text == module.refresh(text), f"{name}: make reference writes it anew"


def test_reference_pages_name_all_keys_and_commands():
    tables = PAGES["reference/case_file.md"]
    assert "| `step` | s | `0.02` | > 0 | Time step Δt. |" in tables
    assert '| `cell` |  | `"hexahedron"` | `"hexahedron"`, `"tetrahedron"` |' in tables
    assert "| `elements` |  | `[2, 2, 12]` | 3 numbers, each ≥ 1, ≤ 100000 |" in tables
    assert '| `blade_arm` | m | `"printed"` | `"printed"`, > 0 |' in tables
    assert "## `[turbine.hub]`" in tables
    commands = PAGES["reference/commands.md"]
    files = (ROOT / "turbine_fenicsx" / "cli" / "commands").glob("[a-z]*.py")
    headings = {f"## `{name.stem}`" for name in files}
    assert "## `run`" in headings and headings <= set(commands.splitlines())
    assert "| `-o, --out OUT` | output folder |" in commands


def test_the_readme_is_short_and_what_it_installs_and_shows_is_there():
    text = PAGES[README]
    assert len(text.splitlines()) <= 110
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    assert {"setup", "test"} <= set(re.findall(r"\bmake ([a-z-]+)", text)) <= targets
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [name.split(",") for name in re.findall(r"pip install '\.\[([\w,]+)\]'", text)]
    assert wanted and {x for names in wanted for x in names} <= set(
        project["optional-dependencies"]
    )
    pictures = re.findall(r'<img src="([^"]+)"', text)
    assert {Path(p).suffix for p in pictures} == {".png", ".gif"}
    for picture in pictures:
        assert 10_000 < (ROOT / picture).stat().st_size < 2_000_000, picture


def test_every_room_of_the_package_has_a_page():
    package = ROOT / "turbine_fenicsx"
    rooms = {f"turbine_fenicsx.{path.parent.name}" for path in package.glob("*/__init__.py")}
    marks = [name for text in PAGES.values() for name in generated().ROOM.findall(text)]
    assert sorted(marks) == sorted(rooms)


def test_page_of_a_room_holds_all_its_modules():
    room = "turbine_fenicsx.simulation"
    held = re.findall(r"^## `(.*)`$", generated().room(room), re.MULTILINE)
    files = (ROOT / "turbine_fenicsx" / "simulation").rglob("*.py")
    there = [".".join(p.relative_to(ROOT).with_suffix("").parts) for p in files]
    assert sorted(held) == sorted(name.removesuffix(".__init__") for name in there)


def test_links_between_pages_lead_somewhere():
    for name, text in PAGES.items():
        prose = BLOCK.sub("", text)
        links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", prose)
        links += re.findall(r"^```\{(?:literal)?include\} (\S+)", text, re.MULTILINE)
        for link in links:
            assert (DOCS / name).parent.joinpath(link).exists(), f"{name}: {link}"
