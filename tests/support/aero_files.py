"""Files of AeroDyn and TurbSim for tests: small, with known contents."""

import numpy as np

from turbine_fenicsx.wind.turbsim import HEADER

PRIMARY = """--- AERODYN v15 ---
A rotor
  {count}   NumAFfiles  - Number of airfoil files used (-)
"round.dat"    AFNames  - Airfoil file names (NumAFfiles lines) (quoted strings)
"plate.dat"
"blade.dat"    ADBlFile(1)  - Name of file containing properties of blade 1
"""
STATIONS = 6


def write_aerodyn(folder, length=54.0, last=180.0, chord=4.0):
    """A primary file with a blade of two polars, a cylinder at the root and a plate outside.

    Args:
        folder: Where to write.
        length: Of the blade [m].
        last: Last angle of the polars; they close the circle with 180 degrees.
        chord: At the root; 1 m at the tip [m].
    """
    folder.mkdir(parents=True, exist_ok=True)
    angle = np.linspace(-180.0, last, 181)
    a = np.radians(angle)
    plate = 2.0 * np.pi * np.sin(a) * np.cos(a), 0.01 + 1.3 * np.sin(a) ** 2
    for name, (lift, drag) in {"round": (0.0 * a, 0.6 + 0.0 * a), "plate": plate}.items():
        rows = "\n".join(
            f"{x:.6f} {cl:.9f} {cd:.9f} -0.05" for x, cl, cd in zip(angle, lift, drag, strict=True)
        )
        (folder / f"{name}.dat").write_text(f"{len(a)}  NumAlf\n{rows}\n")
    s = np.linspace(0.0, 1.0, STATIONS)
    rows = "\n".join(
        f"{length * x:g} 0 0 0 {14.0 * (1.0 - x) ** 2:g} {c:g} {1 + (x > 0)}"
        for x, c in zip(s, chord + s * (1.0 - chord), strict=True)
    )
    text = f"--- blade ---\n\n\n{STATIONS} NumBlNds\nnames\nunits\n{rows}\n"
    (folder / "blade.dat").write_text(text)
    path = folder / "rotor.dat"
    path.write_text(PRIMARY.format(count=2))
    return path


def write_turbsim(path, duration=40.0, size=160.0, speed=10.0, bottom=10.0):
    """A file of turbulence, a mean wind with waves of all components.

    Args:
        path: The file.
        duration: Of the field [s].
        size: Width and height of the grid [m].
        speed: Mean wind [m/s].
        bottom: Height of the lowest points [m].
    """
    n_t, n = int(duration / 0.5) + 1, 9
    head = np.zeros(1, HEADER)
    given = {
        **{"kind": 7, "n_z": n, "n_y": n, "n_tower": 0, "n_t": n_t, "dz": size / (n - 1)},
        **{"dy": size / (n - 1), "dt": 0.5, "u_hub": speed, "z_hub": bottom + 0.5 * size},
        **{"z_bottom": bottom, "scales": [[1000.0, 0.0]] * 3, "n_text": 0},
    }
    for name, value in given.items():
        head[name] = value
    t, z, y, axis = np.ogrid[:n_t, :n, :n, :3]
    waves = np.sin(0.3 * t + z + axis) + np.cos(0.2 * t - y + 2.0 * axis)
    values = speed * (axis == 0) + waves
    path.write_bytes(head.tobytes() + np.round(1000.0 * values).astype("<i2").tobytes())
    return path


def write_box(folder, points=(128, 17, 17)):
    """Files of a turbulence box: a wave along the wind in u, 1 m/s in v, nothing in w."""
    wave = 2.0 * np.sin(2.0 * np.pi * np.arange(points[0]) / points[0])
    u = np.broadcast_to(wave[:, None, None], points).astype("<f4")
    paths = [folder / f"{name}.bin" for name in "uvw"]
    for path, values in zip(paths, (u, 0.0 * u + 1.0, 0.0 * u), strict=True):
        values.tofile(path)
    return [str(path) for path in paths]
