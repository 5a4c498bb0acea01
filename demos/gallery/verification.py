"""How the benchmarks of ``demos/verification`` are drawn, in shorter or coarser runs."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np
from published import load, references
from recording import recorded
from strobe import Look, draw

from turbine_fenicsx.records.output_folder import read_history


@dataclass(frozen=True)
class Motion:
    """A benchmark drawn at several times.

    Args:
        run: Runs the script.
        every: Time between two places of a trail [s].
        look: How it is drawn.
    """

    run: Callable[[Any], object]
    every: float
    look: Look

    def __call__(self, name: str, folder: Path, png: Path) -> None:
        """Run the benchmark of a name with its files in a folder, and draw it."""
        script, fields = load(name), folder / "fields.xdmf"
        with recorded(script, fields, self.every):
            self.run(script)
        draw(fields, png, self.look)


def whirls(name: str, folder: Path, png: Path) -> None:
    """Frequencies of a disc on a shaft over its speed: ours and the closed form."""
    script = load(name)
    speeds, marks = np.linspace(0.0, 80.0, 81), np.linspace(0.0, 80.0, 9)
    exact = np.abs([script.exact_disc(speed) for speed in speeds])
    ours = np.abs([script.disc(speed) for speed in marks])

    def paint(axes: Any) -> None:
        axes.plot(speeds, exact, color="#888888", label=["closed form", *3 * ["_"]])
        for columns, colour, way in ((2, "#D55E00", "forward"), (0, "#0072B2", "backward")):
            points = ours[:, columns : columns + 2].T.ravel()
            axes.plot(np.tile(marks, 2), points, "o", ms=6, color=colour, label=f"{way} whirl")
        axes.plot(speeds, speeds, ":", color="black", label="speed")
        axes.set_xlabel("speed of rotation [rad/s]")
        axes.set_ylabel("frequency [rad/s]")
        axes.legend(frameon=False)

    plot(png, paint)


def frequencies(name: str, folder: Path, png: Path) -> None:
    """First frequency of the turning beam over its speed: ours, the formula, what is published."""
    script, exact = load(name), load(name, "exact")
    speeds = np.linspace(0.0, 12.5, 60)
    fine = script.STEPS[0]
    ours = [script.solve(speed, fine) for speed in script.SPEEDS]
    published = [r.value for r in references(name).values()]

    def paint(axes: Any) -> None:
        axes.plot(speeds, [exact.flap(s)[0] for s in speeds], color="#888888", label="Ritz' method")
        axes.plot(
            script.SPEEDS, published, "o", ms=13, mfc="none", color="black", label="Wright et al."
        )
        axes.plot(script.SPEEDS, ours, "o", ms=6, color="#D55E00", label="solid of hexahedra")
        axes.set_xlabel(r"speed of rotation $\Omega\,/\,\sqrt{EI/\rho A L^4}$")
        axes.set_ylabel(r"first flap frequency, the same unit")
        axes.legend(frameon=False)

    plot(png, paint)


def revolutions(name: str, folder: Path, png: Path, end: float = 200.0) -> None:
    """Changes of energy and momentum of a free rotor over its revolutions up to a time [s]."""
    script = load(name, "compute")
    script.simulate(folder, end=end)
    run = read_history(folder / "history.csv").columns
    turns = np.abs(run["angle_rotor_[rad]"]) / (2.0 * np.pi)
    after = run["time_[s]"] >= script.LOADED
    H, kinetic = run["total_energy_[J]"][after], np.max(run["kinetic_energy_[J]"])
    L = run["angular_momentum_2_[Nms]"][after]
    size = max(np.max(np.abs(run[f"angular_momentum_{i}_[Nms]"])) for i in (1, 2, 3))

    def paint(axes: Any) -> None:
        axes.plot(turns[after], (H - H[0]) / kinetic, color="#0072B2", label="energy")
        axes.plot(turns[after], (L - L[0]) / size, color="#D55E00", label="vertical momentum")
        axes.set_xlabel("revolutions of the free rotor")
        axes.set_ylabel("change, relative")
        axes.legend(frameon=False)

    plot(png, paint)


def mode_shapes(name: str, folder: Path, png: Path) -> None:
    """Deflections of the slender clamped beam in its modes: the solid's nodes, and the formula."""
    script, exact = load(name), load(name, "exact")
    system = script.slender_beam(MPI.COMM_SELF)
    found = script.modes(system, count=8).modes
    X = system.flexible_models[0].positions
    length, width, _ = script.SLENDER[0]
    axis = np.flatnonzero(np.isclose(X[:, 1], 0.5 * width) & np.isclose(X[:, 2], 0.5 * width))
    axis = axis[np.argsort(X[axis, 0])]
    x = np.linspace(0.0, 1.0, 200)

    def paint(axes: Any) -> None:
        for k, root in enumerate(exact.roots(4)):
            u = found[2 * k].real.u[0].array_r.reshape(-1, 3)[axis]
            u = u @ (u[-1] / np.linalg.norm(u[-1]) ** 2)
            colour = COLOURS[k]
            axes.plot(x, exact.clamped_shape(root, x), color="#888888", lw=1.0)
            label = f"{found[2 * k].frequency:.3g} Hz"
            axes.plot(X[axis, 0] / length, u, "o", ms=3, color=colour, label=label)
        axes.set_xlabel("along the beam")
        axes.set_ylabel("deflection, one at the tip")
        axes.legend(frameon=False)

    plot(png, paint)


def hollow_blade(name: str, folder: Path, png: Path) -> None:
    """Bending stiffness and frequencies of a hollow solid, beside the file's matrices."""
    script, tools = load(name), load(name, "sections")
    shape, beam = script.blade()
    mesh = load(name, "solid").make_solid(MPI.COMM_SELF, shape, script.MIDDLE)
    line, marks = np.linspace(0.02, 0.98, 97), np.linspace(0.05, 0.95, 19)
    file = np.array([tools.published_section(beam, s) for s in line])
    ours = np.array([tools.section(mesh, beam, s) for s in marks])
    reference, found = references(name), script.solve(script.MESHES[0], True, False, MPI.COMM_SELF)

    def paint(axes: Any) -> None:
        for column, colour, label in ((2, COLOURS[0], "edgewise"), (3, COLOURS[1], "flapwise")):
            axes.semilogy(100.0 * line, file[:, column], color=colour, lw=1.0)
            axes.semilogy(100.0 * marks, ours[:, column], "o", ms=4, color=colour, label=label)
        axes.set_xlabel("along the span [%]")
        axes.set_ylabel(r"bending stiffness [N m$^2$]")
        axes.legend(frameon=False, title="dots: solid\nlines: file")
        inner = axes.inset_axes((0.16, 0.12, 0.36, 0.4))
        places = range(1, len(script.MODES) + 1)
        values = [reference[mode].value for mode in script.MODES]
        inner.plot(places, values, "o", ms=9, mfc="none", color="black", label="beam")
        solid = [found[mode] for mode in script.MODES]
        inner.plot(places, solid, "o", ms=4, color=COLOURS[2], label="solid")
        inner.set(xlabel="mode", ylabel="frequency [Hz]", xticks=[1, 4, 8], ylim=(0.0, 4.5))
        inner.legend(frameon=False, fontsize="small", loc="upper left", borderpad=0.0)
        inner.grid(color="#dddddd", lw=0.6)

    plot(png, paint)


def beam_and_solid(name: str, folder: Path, png: Path) -> None:
    """Frequencies of a rotor of hollow blades over its speed, kept in a table, and of a beam."""
    script = load(name)
    table, beam = script.read_result(), script.turning_beam(40)
    speeds = np.linspace(0.0, 8.0, 9)
    curves = [beam.frequencies(speed * script.RPM, len(script.MODES)) for speed in speeds]

    def paint(axes: Any) -> None:
        for multiple in (1, 3, 6):
            axes.plot(speeds, multiple * speeds / 60.0, ":", color="#999999", lw=1.0)
            axes.annotate(f"{multiple}P", (8.0, multiple * 8.0 / 60.0), xytext=(3, -3), **NEXT_TO)
        axes.axvline(script.RATED, color="#999999", lw=1.0)
        axes.annotate("rated", (script.RATED, 0.0), xytext=(4, 4), **NEXT_TO)
        axes.plot(speeds, curves, color="#888888", label=["beam", *["_"] * (len(script.MODES) - 1)])
        for way, colour in zip(("flap", "edge"), COLOURS, strict=False):
            marks = [row for row in table if way in row[1]]
            axes.plot(
                [rpm for rpm, _, _ in marks],
                [f for _, _, f in marks],
                "o",
                ms=5,
                color=colour,
                label=f"solid, {way}wise",
            )
        axes.set(xlabel="speed of the rotor [rpm]", ylabel="frequency [Hz]", ylim=(0.0, 1.25))
        axes.legend(frameon=False, loc="center left", bbox_to_anchor=(0.0, 0.66))

    plot(png, paint)


def wall_errors(name: str, folder: Path, png: Path) -> None:
    """Errors of tubes of walls over the number of cells around them."""
    script = load(name)
    finest = script.pull_oval(script.FINEST)
    twisted = [abs(script.twist_tube(n) - 1.0) for n in script.TWISTED]
    oval = [abs(script.pull_oval(n) / finest - 1.0) for n in script.OVAL]

    def paint(axes: Any) -> None:
        axes.loglog(script.OVAL, oval, "o-", color=COLOURS[1], label="pulled oval")
        axes.loglog(script.TWISTED, twisted, "o-", color=COLOURS[0], label="twisted")
        slope = twisted[0] * (script.TWISTED[0] / np.array(script.TWISTED, dtype=float)) ** 4
        axes.loglog(script.TWISTED, 0.5 * slope, ":", color="black", label="order 4")
        axes.set_xlabel("cells around the tube")
        axes.set_ylabel("relative error")
        ticks = sorted({*script.TWISTED, *script.OVAL})
        axes.set_xticks(ticks, [str(n) for n in ticks])
        axes.minorticks_off()
        axes.legend(frameon=False)

    plot(png, paint)


def plot(png: Path, paint: Callable[[Any], None]) -> None:
    """Draw a diagram of the size of a picture."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.0, 4.5), layout="constrained")
    paint(axes)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="#dddddd", lw=0.6)
    figure.savefig(png, dpi=150)
    pyplot.close(figure)


NEXT_TO: dict[str, Any] = {"textcoords": "offset points", "color": "#777777"}
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
TOP_UP = (0.0, 0.0, 1.0)

BENCHMARKS: dict[str, Callable[[str, Path, Path], None]] = {
    "heavy_top": Motion(
        lambda script: script.solve(2000),
        0.005,
        Look((0.0, 0.04, 0.08, 0.12, 0.16), (1.0, -0.6, 0.5), TOP_UP, ["top"]),
    ),
    "steady_top": Motion(
        lambda script: script.solve(500),
        0.005,
        Look((0.0, 0.2, 0.4, 0.6, 0.8), (0.4, -1.0, 0.45), TOP_UP, ["top"]),
    ),
    "four_bar": Motion(
        lambda script: script.solve(1000),
        0.02,
        Look((0.0, 0.012, 0.024, 0.036, 0.048, 0.06), trails=[(0.0, 1.0, 0.0)]),
    ),
    "squeezer": Motion(
        lambda script: script.solve(600), 1e-4, Look((0.0, 0.1, 0.2, 0.3, 0.37, 0.43))
    ),
    "free_bodies": Motion(
        lambda script: script.errors(script.chain(), 60),
        0.02,
        Look((0.0, 0.2, 0.4, 0.6), (0.3, 0.2, 1.0), trails=["link_3"]),
    ),
    "flexible_coupler": Motion(
        lambda script: script.solid(script.ELEMENTS, 350),
        0.004,
        Look((0.65, 0.75, 0.84, 0.92, 1.0), trails=[(0.7, 0.0, 0.0)]),
    ),
    "l_block": Motion(
        lambda script: script.simulate(90),
        0.25,
        Look((0.0, 0.25, 0.5, 0.75), (0.2, 0.3, 1.0), shift=(11.0, 0.0, 0.0)),
    ),
    "roll_up": Motion(lambda script: script.solve(40), 1.0, Look((0.0, 0.25, 0.5, 0.75, 1.0))),
    "bend_45": Motion(
        lambda script: script.solve((16, 2, 2)),
        1.0,
        Look((0.0, 0.17, 0.33, 0.5, 0.67, 0.83, 1.0), (-0.5, -1.0, 0.5), TOP_UP),
    ),
    "princeton_beam": Motion(
        lambda script: script.solve((40, 2, 1), np.radians(45)),
        1.0,
        Look((0.0, 0.25, 0.5, 0.75, 1.0), (-0.3, -0.8, 0.6), (0.0, 1.0, 0.0)),
    ),
    "rotating_cantilever": frequencies,
    "small_vibrations": mode_shapes,
    "turning_modes": whirls,
    "thousand_revolutions": revolutions,
    "iea22_blade": hollow_blade,
    "iea22_campbell": beam_and_solid,
    "spinning_rotor": partial(revolutions, end=60.0),
    "laminate_walls": wall_errors,
}
