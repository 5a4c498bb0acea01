"""``docs/gallery.md``: a thumbnail of each demo, then its picture, what it shows, and its code."""

import ast
import tomllib
from dataclasses import dataclass
from pathlib import Path

DEMOS = Path(__file__).parents[1]
HEAD = """\
# Gallery

A picture of every demo and every benchmark, drawn from a run of it, and the code to copy from.
`make gallery` runs them and writes this page; where a run is shortened or coarsened for the
picture, the numbers of the full one are on the page that is named.

"""
COLUMNS = 3


@dataclass(frozen=True)
class Entry:
    """One picture.

    Args:
        name: Of the picture, and the heading's anchor.
        code: Files below ``demos``; the first one's title is the heading.
        words: What the picture shows.
        picture: Where it is below ``docs/images``, if it is not in the gallery's folder.
        heading: The heading, if it is another one.
    """

    name: str
    code: tuple[str, ...]
    words: str
    picture: str = ""
    heading: str = ""

    @property
    def path(self) -> str:
        """The picture, as seen from ``docs``."""
        return f"images/{self.picture or f'gallery/{self.name}.png'}"

    @property
    def title(self) -> str:
        """Title of a case, or first line of a script's docstring."""
        if self.heading:
            return self.heading
        path = DEMOS / self.code[0]
        text = path.read_text(encoding="utf-8")
        if path.suffix == ".toml":
            title = str(tomllib.loads(text)["title"])
        else:
            title = str(ast.get_docstring(ast.parse(text))).splitlines()[0].rstrip(".")
        return title[0].upper() + title[1:]


def benchmark(name: str, words: str, *more: str) -> Entry:
    """Entry of a benchmark."""
    files = (f"verification/{name}/{file}.py" for file in ("run", *more))
    return Entry(name, tuple(files), f"{words} [Reference and errors](verification.md#{name}).")


ENTRIES = (
    Entry(
        "spin_up",
        ("gallery/turbine.toml",),
        "The turbine of the README: tips bend by six metres, drawn to scale.",
        "spin_up.png",
    ),
    Entry("rigid", ("paper/rigid.toml",), "Seven rigid bodies; [the paper's figures](paper.md)."),
    Entry(
        "hybrid_stiff",
        ("paper/hybrid_stiff.toml", "paper/hybrid_stiff.py"),
        "One case as a file and as a Python script; [the paper's figures](paper.md).",
    ),
    Entry(
        "hybrid_soft",
        ("paper/hybrid_soft.toml",),
        "Deformation five times as large as it is; [the paper's figures](paper.md).",
    ),
    Entry(
        "flexible_tower",
        ("turbine/flexible_tower.toml",),
        "Deformation twenty times as large as it is; [the options](howto/turbine_options.md).",
    ),
    Entry(
        "pitch_to_feather",
        ("turbine/pitch_to_feather.toml",),
        "All blades turned by 80 degrees; [the options](howto/turbine_options.md).",
    ),
    Entry(
        "emergency_stop",
        ("emergency_stop/emergency_stop.toml",),
        "The grid is lost at 14 m/s: the blades turn to feather, the rotor slows down, the tower "
        "swings back; [control](howto/control.md).",
    ),
    Entry(
        "iea15",
        ("iea15/iea15.toml",),
        "Hollow blades of laminates from a windIO file, coloured by the failure index of their "
        "plies; [how to](howto/real_turbine.md).",
    ),
    Entry(
        "iea15_gust",
        ("iea15_gust/iea15_gust.toml",),
        "Just after the peak of the gust: hollow blades and tower bend, to scale, coloured by the "
        "failure index of the plies; [how to](howto/wind.md).",
    ),
    Entry(
        "turbulence",
        ("turbulence/turbulence.toml", "turbulence/draw.py"),
        "Reduced blades and tower, the controller of the file, and a seeded wind field; "
        "[ten minutes, step by step](howto/ten_minutes.md).",
    ),
    Entry(
        "failure",
        ("turbulence/turbulence.toml", "turbulence/draw.py"),
        "Failure of the plies in these ten minutes, in the panels that come nearest to it; "
        "[how to](howto/worst_moment.md).",
        heading="Plies over ten minutes of turbulence",
    ),
    Entry(
        "worst_moment",
        ("turbulence/turbulence.toml",),
        "The blade at its worst moment in these ten minutes, and the hot spot in a web from near "
        "by: `turbine-fenicsx recover`; [how to](howto/worst_moment.md).",
        heading="The worst moment",
    ),
    Entry(
        "modes",
        ("turbine/modes.py",),
        "Both brakes are on; red is what moves most. [Modes, step by step](howto/modes.md).",
    ),
    Entry(
        "campbell",
        ("turbine/campbell.py",),
        "Whirl splits with the speed of the rotor; dashed, 1, 3 and 6 times it. "
        "[How to](howto/modes.md).",
    ),
    benchmark("heavy_top", "A top that falls and nutates; the line is the path of its centre."),
    benchmark("steady_top", "The axis runs round a circle while the top spins fourteen times."),
    benchmark(
        "four_bar", "The line is the path of the first free hinge through two singular positions."
    ),
    benchmark("squeezer", "Seven bodies, ten hinges, nine redundant constraints."),
    benchmark("free_bodies", "Eight links; the line is the path of the fourth."),
    benchmark(
        "flexible_coupler", "The coupler is a solid, here between its two rigid ends.", "mechanism"
    ),
    benchmark("l_block", "The block tumbles in steps of a quarter of a second, here side by side."),
    benchmark("roll_up", "Four load steps to a full circle."),
    benchmark("bend_45", "Six load steps from the arc in the plane."),
    benchmark(
        "princeton_beam", "A weight across the strip at 45 degrees bends it in both directions."
    ),
    benchmark(
        "rotating_cantilever", "The frequency rises with the speed, with nothing put in.", "exact"
    ),
    benchmark(
        "small_vibrations", "Modes of the slender beam: nodes of the solid on the formula.", "exact"
    ),
    benchmark("turning_modes", "Whirl of the disc: the solid shaft on the closed form.", "exact"),
    benchmark(
        "thousand_revolutions", "The first forty of them: round-off is all that changes.", "compute"
    ),
    benchmark(
        "iea22_blade",
        "Layers of the file as a solid of hexahedra, beside the matrices of sections in that file.",
        "exact",
        "solid",
        "sections",
    ),
    benchmark(
        "laminate_walls",
        "Tubes with one hexahedron through the wall: errors over the cells around them.",
        "exact",
        "loaded_wall",
        "mesh",
    ),
    benchmark(
        "iea22_campbell",
        "Frequencies over the speed: hollow blades as solids, and the file's beam.",
        "exact",
        "compute",
    ),
    benchmark(
        "spinning_rotor",
        "The first eight revolutions: errors walk at random, within 1e-11.",
        "compute",
    ),
    Entry(
        "refinement",
        ("refinement/refinement.py", "refinement/clamped_blade.py"),
        "Errors over unknowns; [the table](howto/mesh_accuracy.md).",
        "refinement.png",
    ),
    Entry(
        "schemes",
        ("schemes/compare.py",),
        "Energy of a rotor that nothing drives; [the numbers](theory/step.md).",
        "schemes.png",
    ),
    Entry("time_step", ("studies/time_step.toml",), "Errors over the step; [how](howto/study.md)."),
    Entry("mesh", ("studies/mesh.toml",), "Linear and quadratic elements; [how](howto/study.md)."),
    Entry(
        "rotor_speed",
        ("studies/rotor_speed.toml",),
        "A horizontal blade is pulled straight as the rotor turns faster; [how](howto/start.md).",
    ),
    Entry(
        "steady",
        ("iea15/iea15_rigid.toml",),
        "The IEA 15 MW turbine with rigid blades beside its table; [how](howto/steady.md).",
        heading="Steady states over the wind speed",
    ),
)


def markdown() -> str:
    """The page."""
    cells = [f"[![{e.title}]({e.path})<br>{e.title}](#gallery-{e.name})" for e in ENTRIES]
    rows = [cells[k : k + COLUMNS] for k in range(0, len(cells), COLUMNS)]
    rows[-1] += [""] * (COLUMNS - len(rows[-1]))
    lines = ["| " + " | ".join(row) + " |" for row in ([""] * COLUMNS, ["---"] * COLUMNS, *rows)]
    return HEAD + "\n".join(lines) + "\n\n" + "\n".join(section(entry) for entry in ENTRIES)


def section(entry: Entry) -> str:
    """Picture, words and code of an entry."""
    parts = [f"(gallery-{entry.name})=", f"## {entry.title}", "", f"![{entry.title}]({entry.path})"]
    parts += ["", entry.words, ""]
    for file in entry.code:
        language = "toml" if file.endswith(".toml") else "python"
        parts += [f"<details><summary><code>demos/{file}</code></summary>", ""]
        parts += [f"```{{literalinclude}} ../demos/{file}", f":language: {language}", "```", ""]
        parts += ["</details>", ""]
    return "\n".join(parts)
