"""How the benchmarks of ``demos/verification`` are drawn, in shorter or coarser runs."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from published import load, references
from recording import recorded
from strobe import Look, draw

from turbine_fenicsx.postprocessing.output_folder import read_history


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


def revolutions(name: str, folder: Path, png: Path) -> None:
    """Changes of energy and momentum of the flexible rotor over its revolutions."""
    script = load(name, "compute")
    script.simulate(folder, end=200.0)
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
    "thousand_revolutions": revolutions,
}
