"""How the cases and studies of ``demos`` are drawn: by the commands that anybody has."""

import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

DEMOS = Path(__file__).parents[1]


@dataclass(frozen=True)
class Turbine:
    """A case, drawn by the command ``render``.

    Args:
        case: The file below ``demos``.
        time: When it is drawn [s].
        options: More options of ``render``.
    """

    case: str
    time: float
    options: tuple[str, ...] = ()

    def __call__(self, name: str, folder: Path, png: Path) -> None:
        """Run the case in a folder and draw it."""
        run(self.case, folder, f"time.end={self.time}", "output.fields_every=0.5")
        size = ("--size", "1200x900")
        command("render", folder, "--times", self.time, "-o", folder, *size, *self.options)
        (picture,) = folder.glob("turbine_t*.png")
        shrink(picture, png)


def run(case: str, folder: Path, *changes: str) -> None:
    """Run a case of ``demos`` into a folder."""
    more = ("--set", *changes) if changes else ()
    command("run", DEMOS / case, "-o", folder, "--overwrite", "--quiet", *more)


def command(*arguments: object) -> None:
    """A command of ``turbine-fenicsx``."""
    line = [sys.executable, "-m", "turbine_fenicsx", *map(str, arguments)]
    subprocess.run(line, check=True)


def shrink(picture: Path, png: Path) -> None:
    """Make a picture smaller, in size and in colours."""
    with Image.open(picture) as image:
        image.convert("RGB").resize((900, 675), Image.Resampling.LANCZOS).quantize(256).save(png)


def orders(name: str, folder: Path, png: Path) -> None:
    """Errors of a study of the same name."""
    command("study", DEMOS / "studies" / f"{name}.toml", "-o", folder, "--quiet")
    shutil.copy(folder / "convergence.png", png)


def steady(name: str, folder: Path, png: Path) -> None:
    """Steady states of the IEA 15 MW turbine beside its table."""
    table = DEMOS / "iea15" / "iea15_steady.csv"
    case, winds = DEMOS / "iea15" / "iea15_rigid.toml", ("--wind", "4:25:1")
    command("steady", case, *winds, "--schedule", table, "--beside", table, "-o", folder, "--quiet")
    with Image.open(folder / "steady.png") as image:
        small = image.convert("RGB")
        small.thumbnail((900, 900), Image.Resampling.LANCZOS)
        small.quantize(128).save(png)


def modes(name: str, folder: Path, png: Path) -> None:
    """Shapes of the modes of a parked turbine on one sheet."""
    case = DEMOS / "turbine" / "flexible_tower.toml"
    command("modes", case, "--lock", "rotor", "yaw", "-o", folder / "modes", "--quiet")
    command("render", folder / "modes", "-o", folder)
    with Image.open(folder / "modes.png") as image:
        small = image.convert("RGB")
        small.thumbnail((1200, 1200), Image.Resampling.LANCZOS)
        small.quantize(256).save(png)


def loads(name: str, folder: Path, png: Path) -> None:
    """Loads at the root of a blade over the speed, from the table of a study of the same name."""
    import numpy as np
    from matplotlib.figure import Figure

    command("study", DEMOS / "studies" / f"{name}.toml", "-o", folder, "--quiet")
    table = np.genfromtxt(folder / "study.csv", delimiter=",", names=True, deletechars="")
    speeds = table["turbine.rotor_speed"] * 30.0 / np.pi
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    for axes, column, factor, label in zip(
        figure.subplots(1, 3),
        ("tip_edge_2_[m]", "root_force_2_z_[N]", "root_moment_2_x_[Nm]"),
        (1.0, 1e-6, 1e-6),
        ("tip deflection by weight [m]", "pull at the root [MN]", "edgewise moment [MN m]"),
        strict=True,
    ):
        axes.plot(speeds, factor * np.abs(table[column]), "o-", color="#0b6e99")
        axes.set(xlabel="speed [rpm]", ylabel=label)
        axes.grid(color="#dddddd")
    figure.savefig(png, dpi=150)


def campbell(name: str, folder: Path, png: Path) -> None:
    """Frequencies of a turbine over the speed of its rotor."""
    case = DEMOS / "turbine" / "flexible_tower.toml"
    speeds = ("--speeds", "0:14:2", "rpm", "--lock", "yaw")
    command("modes", case, *speeds, "-o", folder / "modes", "--quiet")
    with Image.open(folder / "modes" / "campbell.png") as image:
        small = image.convert("RGB")
        small.thumbnail((1200, 1200), Image.Resampling.LANCZOS)
        small.quantize(64).save(png)


def turbulence(name: str, folder: Path, png: Path) -> None:
    """Power, pitch, loads and failure of a run in turbulence, which takes some minutes."""
    demo = DEMOS / name
    shutil.copy(demo / f"{name}.toml", folder)
    command("run", folder / f"{name}.toml", "-o", folder / "run", "--quiet")
    command("recover", folder / "run", "--quiet")
    subprocess.run([sys.executable, demo / "draw.py", folder / "run"], check=True)
    for drawn, target in ((name, name), ("failure", "failure"), ("worst", "worst_moment")):
        with Image.open(folder / "run" / f"{drawn}.png") as image:
            small = image.convert("RGB")
            small.thumbnail((1200, 1200), Image.Resampling.LANCZOS)
            small.quantize(128).save(png.with_name(f"{target}.png"))


def spin_up(name: str, folder: Path, png: Path) -> None:
    """Picture and animation of the README, which stand beside the folder of the gallery."""
    import imageio_ffmpeg

    run("gallery/turbine.toml", folder)
    colours, movie = ("--range", "0,30"), folder / "movie.mp4"
    command("render", folder, "--times", 1.2, "-o", folder, "--size", "1300x1200", *colours)
    command("render", folder, "--movie", movie, "--size", "780x720", *colours)
    (picture,) = folder.glob("turbine_t*.png")
    shutil.copy(picture, png.parents[1] / png.name)
    palette = "split[a][b];[a]palettegen=max_colors=128[p];[b][p]paletteuse=dither=none"
    animate = ("-vf", f"scale=520:-1:flags=lanczos,{palette}")
    gif = (png.parents[1] / png.name).with_suffix(".gif")
    ffmpeg = imageio_ffmpeg.get_ffmpeg_exe()
    subprocess.run([ffmpeg, "-y", "-loglevel", "error", "-i", movie, *animate, gif], check=True)


CASES = {
    "rigid": Turbine("paper/rigid.toml", 5.0),
    "hybrid_stiff": Turbine("paper/hybrid_stiff.toml", 9.0),
    "hybrid_soft": Turbine("paper/hybrid_soft.toml", 1.5, ("--scale", "5")),
    "flexible_tower": Turbine("turbine/flexible_tower.toml", 4.5, ("--scale", "20")),
    "pitch_to_feather": Turbine("turbine/pitch_to_feather.toml", 7.0),
    "emergency_stop": Turbine("emergency_stop/emergency_stop.toml", 13.0),
    "iea15": Turbine("iea15/iea15.toml", 2.0, ("--field", "tsai_wu", "--range", "0,0.12")),
    "iea15_gust": Turbine(
        "iea15_gust/iea15_gust.toml", 7.5, ("--field", "tsai_wu", "--range", "0,0.4")
    ),
    "turbulence": turbulence,
    "modes": modes,
    "campbell": campbell,
    "time_step": orders,
    "mesh": orders,
    "rotor_speed": loads,
    "steady": steady,
}
