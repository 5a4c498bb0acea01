"""Picture of the whole turbine, drawn from ``fields.xdmf`` alone.

Drawing needs PyVista and a graphics library. Where that library is missing, VTK ends the process
instead of raising, so `render_turbine` draws in a child process, which runs this file:

    python -m turbine_fenicsx.pictures OUT/fields.xdmf turbine.png --time 6.0

The cell field ``part`` says what is what: 0 nacelle, 1 hub, from 2 on the blades. The tower is no
part of the model; a pale one is added so that the picture shows a wind turbine.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

NACELLE, HUB, FIRST_BLADE = 0, 1, 2
"""Values of the cell field ``part``."""

TOWER_HEIGHT = 87.0
"""From the nacelle down [m]."""

_LABELS = {
    "cauchy_stress_norm": ("Cauchy stress norm in MPa", 1e-6),
    "displacement": ("displacement in m", 1.0),
    "velocity": ("velocity in m/s", 1.0),
}
_COLOUR_BAR = {
    "vertical": True,
    "position_x": 0.80,
    "position_y": 0.25,
    "width": 0.05,
    "height": 0.5,
    "font_family": "arial",
    "title_font_size": 28,
    "label_font_size": 26,
    "color": "black",
    "fmt": "%.3g",
    "n_labels": 5,
}
_MPI_VARIABLES = ("OMPI_", "PMIX_", "PMI_", "PRTE_", "MPI_", "HYDRA_")


def render_turbine(
    fields_xdmf: str | os.PathLike[str],
    png: str | os.PathLike[str],
    time: float | None = None,
    scalar: str | None = "cauchy_stress_norm",
) -> Path:
    """Draw the turbine at one time, in a child process.

    Args:
        fields_xdmf: Field output of a run.
        png: Picture to write, 1600 x 1200 pixels.
        time: Time [s], the nearest one written is drawn; the last one if None.
        scalar: Point or cell field that colours the blades; of a vector its length.
            With None they are plain, as for a rigid turbine.

    Returns:
        ``png``.

    Raises:
        RuntimeError: if the picture cannot be drawn; the message is one sentence.
    """
    command = [sys.executable, "-P", __file__, os.fspath(fields_xdmf), os.fspath(png)]
    command += ["--plain"] if scalar is None else ["--scalar", scalar]
    if time is not None:
        command += ["--time", repr(float(time))]
    env = {k: v for k, v in os.environ.items() if not k.startswith(_MPI_VARIABLES)}
    child = subprocess.run(command, env=env, capture_output=True, text=True)
    if child.returncode < 0:
        raise RuntimeError(
            f"cannot draw {png}: PyVista ended with signal {-child.returncode}, probably because "
            "there is no graphics library (on Debian: apt install libegl1) and no display either"
        )
    if child.returncode > 0:
        lines = child.stderr.strip().splitlines() or [f"exit code {child.returncode}"]
        raise RuntimeError(f"cannot draw {png}: {lines[-1]}")
    return Path(png)


def _read(path: str, time: float | None) -> tuple[Any, float]:
    """Grid at the time nearest to ``time``, or at the last one, and its time [s]."""
    import pyvista

    reader = pyvista.get_reader(path)
    times = np.asarray(reader.time_values)
    if times.size == 0:
        raise ValueError(f"{path} holds no times")
    step = times.size - 1 if time is None else int(np.abs(times - time).argmin())
    reader.set_active_time_point(step)
    grid = reader.read()
    if "part" not in grid.cell_data:
        raise ValueError(f"{path} has no cell field 'part'")
    return grid, float(times[step])


def _with_colour(blades: Any, scalar: str) -> str:
    """Add the field that colours the blades under its label, which is returned."""
    fields = {**blades.point_data, **blades.cell_data}
    if scalar not in fields:
        names = sorted(name for name in fields if not name.startswith("vtk"))
        raise ValueError(f"there is no field '{scalar}', but {', '.join(names)}")
    label, factor = _LABELS.get(scalar, (scalar.replace("_", " "), 1.0))
    values = np.asarray(fields[scalar], dtype=float)
    values = factor * (np.linalg.norm(values, axis=1) if values.ndim == 2 else values)
    (blades.point_data if scalar in blades.point_data else blades.cell_data)[label] = values
    return label


def _tower(top: Any) -> Any:
    """Tapered cylinder from ``top`` [m] down, radius 1.9 m to 3.0 m."""
    import pyvista

    angle, depth = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 65), np.linspace(0.0, 1.0, 2))
    radius = 1.9 + 1.1 * depth
    return pyvista.StructuredGrid(
        top[0] + radius * np.cos(angle),
        top[1] - TOWER_HEIGHT * depth,
        top[2] + radius * np.sin(angle),
    )


def _rotor_side(grid: Any, part: Any) -> float:
    """1 if the hub lies before the nacelle along e3, -1 if behind: the side to look from."""
    if not (part == HUB).any() or not (part == NACELLE).any():
        return 1.0
    hub, nacelle = (grid.extract_cells(part == number).center[2] for number in (HUB, NACELLE))
    return 1.0 if hub >= nacelle else -1.0


def _draw(path: str, png: str, time: float | None, scalar: str | None) -> None:
    """Draw the picture in this process."""
    import pyvista

    grid, time = _read(path, time)
    part = np.asarray(grid.cell_data["part"])
    plotter = pyvista.Plotter(off_screen=True, window_size=(1600, 1200), lighting="light kit")
    plotter.set_background("white")
    for number, colour in ((NACELLE, "#b8bdc4"), (HUB, "#8f969f")):
        if (part == number).any():
            body = grid.extract_cells(part == number)
            plotter.add_mesh(
                body, color=colour, ambient=0.25, smooth_shading=True, split_sharp_edges=True
            )
    if (part == NACELLE).any():
        x_min, x_max, y_min, _, z_min, z_max = grid.extract_cells(part == NACELLE).bounds
        top = (0.5 * (x_min + x_max), y_min, 0.5 * (z_min + z_max))
        plotter.add_mesh(_tower(top), color="#e8ecf1", ambient=0.6, diffuse=0.4, opacity=0.7)
    if (part >= FIRST_BLADE).any():
        blades = grid.extract_cells(part >= FIRST_BLADE)
        edges = {"show_edges": True, "edge_color": "#333333", "line_width": 0.6, "ambient": 0.25}
        if scalar is None:
            plotter.add_mesh(blades, color="#56B4E9", **edges)
        else:
            label = _with_colour(blades, scalar)
            limits = (0.0, float(np.nanmax(blades[label])) or 1.0)
            bar = {**_COLOUR_BAR, "title": label + "\n"}
            plotter.add_mesh(
                blades, scalars=label, cmap="viridis", clim=limits, scalar_bar_args=bar, **edges
            )
    plotter.add_text(f"t = {time:.2f} s", position=(40, 1120), font_size=16, color="black")
    side = _rotor_side(grid, part)
    plotter.camera_position = [
        (130.0 * side, 30.0, 317.0 * side),
        (14.0 * side, -15.5, 0.0),
        (0.0, 1.0, 0.0),
    ]
    plotter.camera.view_angle = 26.0
    plotter.enable_anti_aliasing("ssaa")
    plotter.screenshot(png)
    plotter.close()


def main(arguments: list[str] | None = None) -> int:
    """Draw a picture as the command line says; an error is one sentence and exit code 2."""
    parser = argparse.ArgumentParser(description="Draw the turbine from its field output.")
    parser.add_argument("fields", help="fields.xdmf of a run")
    parser.add_argument("png", help="picture to write")
    parser.add_argument("--time", type=float, help="time [s]; default: the last one")
    parser.add_argument("--scalar", default="cauchy_stress_norm", help="field on the blades")
    parser.add_argument("--plain", action="store_true", help="blades in one colour")
    options = parser.parse_args(arguments)
    scalar = None if options.plain else options.scalar
    try:
        _draw(options.fields, options.png, options.time, scalar)
    except ModuleNotFoundError as problem:
        print(f"pictures need PyVista: pip install pyvista ({problem})", file=sys.stderr)
        return 2
    except (OSError, ValueError) as problem:
        print(problem, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
