"""The package's layers point in one direction, and other rules that only the source can show."""

import ast
import importlib.util
import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "turbine_fenicsx"

# what draws the rooms for the documentation
_spec = importlib.util.spec_from_file_location("rooms", ROOT / "docs/_extensions/rooms.py")
rooms = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(rooms)

# From numbers to the application; a room imports from layers above its own in this list, and from
# rooms of its own layer, without circles. Imports in function bodies count as well.
LAYERS = [
    {"foundation", "_compat", "_version"},
    {"materials", "bodies", "joints", "forces", "meshing", "windio", "case", "records"},
    {"system"},
    {"linear_solvers"},
    {"time_stepping", "analysis", "reduction", "sections"},
    {"simulation"},
    {"wind", "control", "beam_files"},
    {"turbine.tables"},
    {"turbine.case"},
    {"turbine.blades"},
    {"turbine.components"},
    {"turbine.run"},
    {"turbine.modes", "turbine.steady", "turbine.life"},
    {"postprocessing", "study", "load_sets", "cli"},
]
# Starts and names of the package itself; the latter imports lazily and is imported by nobody.
APART = {"__init__", "__main__"}
MODULES = {p: p.relative_to(PACKAGE) for p in sorted(PACKAGE.rglob("*.py"))}


def room(path):
    """Folder or module at the top of the package, or of the turbine, that a file belongs to."""
    return rooms.find_room(".".join(path.with_suffix("").parts).removesuffix(".__init__"))


def imports_of(tree):
    """Dotted names of everything a file imports, also inside functions."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "relative imports hide the layer"
            for alias in node.names:
                yield f"{node.module}.{alias.name}"


def parse(path):
    return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


def test_every_room_has_a_layer():
    names = {room(p) for p in MODULES.values()} - APART - {"turbine"}
    listed = [name for layer in LAYERS for name in layer]
    assert len(listed) == len(set(listed))
    assert names == set(listed)


def test_the_page_on_architecture_shows_the_layers_and_files_that_are_there():
    page = rooms.PAGE.read_text(encoding="utf-8")
    assert [set(layer) for layer in rooms.list_layers()] == LAYERS
    files = re.findall(r"`([a-z_]+/[a-z_/]+\.py)`", page)
    assert len(files) > 10
    missing = {f for f in files if not (PACKAGE / f).exists() and not (ROOT / f).exists()}
    assert missing == set()


def test_the_picture_of_the_rooms_is_that_of_the_imports():
    assert rooms.PICTURE.read_text(encoding="utf-8") == rooms.draw(), "make reference draws it"


def test_unit_tests_stand_in_the_rooms_of_the_package():
    tests = ROOT / "tests" / "unit"
    found = {p.parent.relative_to(tests) for p in tests.rglob("test_*.py")}
    assert [str(r) for r in sorted(found) if not (PACKAGE / r / "__init__.py").exists()] == []
    assert Path(".") not in found


def test_no_two_files_of_tests_have_one_name():
    """Pytest imports them by their names alone, and collects nothing where two are alike."""
    names = [p.name for p in (ROOT / "tests").rglob("test_*.py")]
    assert sorted(names) == sorted(set(names))


def test_modules_import_only_from_layers_above():
    depth = {name: k for k, layer in enumerate(LAYERS) for name in layer}
    for path, short in MODULES.items():
        mine = room(short)
        for name in () if mine in APART else imports_of(parse(path)):
            package, _, rest = name.partition(".")
            if package == PACKAGE.name:
                target = rooms.find_room(rest)
                assert target in depth, f"{short} imports {name}, a public name, not its place"
                assert depth[target] <= depth[mine], f"{short} imports {name} from a layer below"


def own_imports(path, names):
    """Modules of the package that a file imports when it is imported."""
    for imported in imports_of(ast.Module(parse(path).body, [])):
        inner = imported.removeprefix(f"{PACKAGE.name}.")
        while inner and inner not in names:
            inner = inner.rpartition(".")[0]
        if inner and imported.startswith(PACKAGE.name):
            yield inner


def assert_no_circle(graph):
    done: set[str] = set()

    def visit(name, trail):
        assert name not in trail, " -> ".join([*trail, name])
        if name not in done:
            for other in sorted(graph[name]):
                visit(other, (*trail, name))
            done.add(name)

    for name in graph:
        visit(name, ())


def test_neither_modules_nor_rooms_import_each_other():
    names = {
        ".".join(p.with_suffix("").parts).removesuffix(".__init__"): f for f, p in MODULES.items()
    }
    modules = {name: set(own_imports(path, names)) - {name} for name, path in names.items()}
    assert_no_circle(modules)
    arrows: dict[str, set[str]] = {}
    for name, imported in modules.items():
        mine = rooms.find_room(name)
        arrows.setdefault(mine, set()).update({rooms.find_room(i) for i in imported} - {mine})
    assert_no_circle(arrows)


def test_files_are_no_longer_than_400_lines_and_functions_than_60():
    folders = ("demos", "tests", "benchmarks")
    found = (f for folder in folders for f in ROOT.glob(f"{folder}/**/*.py"))
    peers = ROOT / "benchmarks" / ".venv-peers"  # other people's, see benchmarks/install_peers.sh
    files = [*MODULES, *(f for f in found if peers not in f.parents)]
    lengths = {str(path): len(path.read_text(encoding="utf-8").splitlines()) for path in files}
    assert {name: n for name, n in lengths.items() if n > 400} == {}
    functions = {
        f"{path.name}: {node.name}": (node.end_lineno or 0) - node.lineno + 1
        for path in files
        for node in ast.walk(parse(path))
        if isinstance(node, ast.FunctionDef)
    }
    assert {name: n for name, n in functions.items() if n > 60} == {}


def test_no_file_defines_a_name_twice():
    """The second of two constants would count for both."""
    wrong = []
    for path, short in MODULES.items():
        targets = [t for n in parse(path).body if isinstance(n, ast.Assign) for t in n.targets]
        names = [t.id for t in targets if isinstance(t, ast.Name)]
        wrong += [f"{short}: {name}" for name in set(names) if names.count(name) > 1]
    assert wrong == []


def test_only_the_command_line_takes_the_world_communicator():
    users = set()
    for path, short in MODULES.items():
        for node in ast.walk(parse(path)):
            name = getattr(node, "attr", getattr(node, "id", getattr(node, "name", None)))
            if name in ("COMM_WORLD", "Get_world"):
                users.add(str(short))
    assert users == {"cli/main.py"}


FENICS = ("dolfinx", "ufl", "basix", "ffcx", "petsc4py", "mpi4py", "gmsh")


def test_differences_between_releases_are_bridged_in_compat_only():
    wrong = [p for p in MODULES if p.name != "_compat.py" and bridges(parse(p))]
    assert wrong == []


def bridges(tree):
    """Whether a module asks for the release of a library of FEniCS, or tries one import first."""
    local = {
        alias.asname or alias.name.split(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
        if (getattr(node, "module", None) or alias.name).split(".")[0] in FENICS
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and node.attr in ("__version__", "has_petsc"):
            if isinstance(node.value, ast.Name) and node.value.id in local:
                return True
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("hasattr", "getattr"):
            root = node.args[0]
            while isinstance(root, ast.Attribute):
                root = root.value
            # gmsh is no part of DOLFINx; its one difference is handled where it is opened
            if isinstance(root, ast.Name) and root.id in local - {"gmsh"}:
                return True
        if isinstance(node, ast.Try) and "ImportError" in ast.dump(
            ast.Module(list(node.handlers), [])
        ):
            second = [imports_of(ast.Module(handler.body, [])) for handler in node.handlers]
            if any(name.split(".")[0] in FENICS for names in second for name in names):
                return True
    return False


# Pydantic turns a ValueError of its validators into a mistake of a key; readers of TOML and of
# stored grids do the same. Everywhere else wrong input has an exception of its own.
VALIDATORS = {"case", "turbine/tables", "turbine/case", "study/file.py", "records/stored_grids.py"}


def test_checks_of_ours_cannot_be_mistaken_for_errors_of_numpy():
    wrong = [
        f"{short}:{node.lineno}"
        for path, short in MODULES.items()
        if not short.as_posix().startswith(tuple(VALIDATORS))
        for node in ast.walk(parse(path))
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "ValueError"
    ]
    assert wrong == []


def test_docstrings_of_public_names_have_all_arguments():
    """Others say in a sentence what their names cannot."""
    stub, wrong = parse(PACKAGE / "__init__.pyi"), []
    names = [(x.module, a.name) for x in stub.body if hasattr(x, "module") for a in x.names]
    assert len(names) > 100
    for module, name in names:
        path = PACKAGE.joinpath(*module.split(".")[1:])
        path = path.with_suffix(".py") if not path.is_dir() else path / "__init__.py"
        for node in parse(path).body:
            if getattr(node, "name", None) == name:
                inner = node.body if isinstance(node, ast.ClassDef) else []
                found = [node, *(x for x in inner if not getattr(x, "name", "_").startswith("_"))]
                wrong += [f"{module}.{x.name}: {a}" for x in found for a in missing_arguments(x)]
    assert wrong == []


def missing_arguments(node):
    """Arguments of a function that a section Args in its docstring does not have."""
    text = isinstance(node, ast.FunctionDef) and ast.get_docstring(node)
    if not text or "Args:" not in text:
        return []
    every = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    names = {a.arg for a in every} - {"self", "cls"}
    said = re.findall(r"^    ([\w, *]+):", text.partition("Args:")[2], re.MULTILINE)
    return sorted(names - {word.strip(" *") for line in said for word in line.split(",")})
