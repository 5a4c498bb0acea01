"""The picture of the rooms on the page on architecture, drawn from the imports of the package."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "turbine_fenicsx"
PAGE = ROOT / "docs" / "architecture.md"
PICTURE = ROOT / "docs" / "images" / "rooms.svg"

ROW = re.compile(r"^\| ([\w ]*) ?\| (?:\{py:mod\}`~?turbine_fenicsx\.|`)([\w.]+)` \|", re.MULTILINE)
"""A row of the table of the layers: its layer, if it begins one, and its room."""

HEIGHT, STEP, GAP, LETTER, WIDTH = 26, 58, 14, 7.4, 760
"""Height of a box, distance of rows, gap between boxes, width of a letter, width of the picture."""


def list_layers() -> list[list[str]]:
    """Rooms of each layer as the page lists them, those at the top first."""
    layers: list[list[str]] = []
    for layer, room in ROW.findall(PAGE.read_text(encoding="utf-8")):
        if layer.strip():
            layers.append([])
        layers[-1].append(room)
    return layers


def find_room(module: str) -> str:
    """Room of a module by its dotted name inside of the package."""
    first, *rest = module.split(".")
    return ".".join([first, *rest[: first == "turbine"]])


def find_imports() -> dict[str, set[str]]:
    """Other rooms from which the files of each room import, in function bodies too."""
    found: dict[str, set[str]] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        name = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        mine = find_room(name.removesuffix(".__init__"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module:
                package, _, rest = node.module.partition(".")
                if package == PACKAGE.name and rest:
                    found.setdefault(mine, set()).add(find_room(rest))
                elif package == PACKAGE.name:
                    found.setdefault(mine, set()).update(a.name for a in node.names)
    return {room: others - {room} for room, others in found.items()}


def list_arrows() -> list[tuple[str, str]]:
    """Pairs of rooms, of which the first imports from the second and not also through a third."""
    rooms = [room for layer in list_layers() for room in layer]
    imports = {room: others & set(rooms) for room, others in find_imports().items()}

    def reach(room: str) -> Iterator[str]:
        for other in imports.get(room, ()):
            yield other
            yield from reach(other)

    return [
        (room, other)
        for room in rooms
        for other in rooms
        if other in imports.get(room, ())
        and not any(other in reach(third) for third in imports[room] - {other})
    ]


def draw() -> str:
    """The picture as SVG: a row for each layer, arrows towards what is imported."""
    places: dict[str, tuple[float, float, float]] = {}
    layers = list_layers()
    for row, layer in enumerate(layers):
        widths = [LETTER * len(room) + 16 for room in layer]
        x = 0.5 * (WIDTH - sum(widths) - GAP * (len(layer) - 1))
        for room, width in zip(layer, widths, strict=True):
            places[room] = (x, 12 + row * STEP, width)
            x += width + GAP
    lines = [_draw_arrow(places[first], places[second]) for first, second in list_arrows()]
    boxes = [_draw_box(room, *place) for room, place in places.items()]
    height = 24 + (len(layers) - 1) * STEP + HEIGHT
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" '
        f'font-family="sans-serif" font-size="13">'
    )
    marker = (
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" '
        'markerHeight="7" orient="auto"><path d="M0,0 L8,4 L0,8 z" fill="#777"/></marker></defs>'
    )
    paper = f'<rect width="{WIDTH}" height="{height}" fill="white"/>'
    return "\n".join([head, marker, paper, *lines, *boxes, "</svg>", ""])


def _draw_box(room: str, x: float, y: float, width: float) -> str:
    """A room; those of the turbine have a colour of their own."""
    fill = "#fde9d9" if room.startswith("turbine") else "#dceaf7"
    return (
        f'<rect x="{x:.1f}" y="{y}" width="{width:.1f}" height="{HEIGHT}" rx="4" fill="{fill}" '
        f'stroke="#555"/><text x="{x + 0.5 * width:.1f}" y="{y + 17}" text-anchor="middle">'
        f"{room}</text>"
    )


def _draw_arrow(first: tuple[float, float, float], second: tuple[float, float, float]) -> str:
    """An arrow from a room to one that it imports from."""
    (x, y, width), (u, v, other) = first, second
    a, b = x + 0.5 * width, u + 0.5 * other
    if v == y and abs(a - b) - 0.5 * (width + other) > 2 * GAP:  # below the boxes between
        path = f"M{a:.1f},{y + HEIGHT} Q{0.5 * (a + b):.1f},{y + 46} {b:.1f},{y + HEIGHT}"
    elif v == y:
        start, end = (x + width, u) if a < b else (x, u + other)
        path = f"M{start:.1f},{y + 13} L{end:.1f},{y + 13}"
    else:
        end = v + HEIGHT
        path = f"M{a:.1f},{y} C{a:.1f},{y - 22} {b:.1f},{end + 26} {b:.1f},{end}"
    return f'<path d="{path}" fill="none" stroke="#999" marker-end="url(#tip)"/>'


if __name__ == "__main__":
    PICTURE.write_text(draw(), encoding="utf-8")
    print(f"wrote {PICTURE}")
