"""What two integrators make of energy that nothing takes away.

    python demos/schemes/compare.py -o out/schemes

runs the rigid turbine and the hybrid turbine with soft blades of the paper for 1000 s, with the
energy-momentum scheme and with the generalised-alpha method, at the same step. The torque on the
rotor ends after 3 s, there is no gravity and no damping: from then on the energy of the rotor is
constant. The picture shows what each scheme makes of it, and `result.toml` the numbers.
"""

import argparse
from pathlib import Path

from mpi4py import MPI

import matplotlib
import numpy as np

from turbine_fenicsx import Case
from turbine_fenicsx.postprocessing.output_folder import read_history
from turbine_fenicsx.turbine.run import run_case

PAPER = Path(__file__).parents[1] / "paper"
TURBINES = {"rigid": "free rigid rotor", "hybrid_soft": "spinning soft blades"}
RADIUS = "time.spectral_radius"
SCHEMES = {
    "energy_momentum": ("energy-momentum", "C0", []),
    "generalised_alpha, 0.9": (
        r"generalised-alpha, $\rho$ = 0.9",
        "C1",
        ["time.spectral_radius=0.9"],
    ),
    "generalised_alpha, 0.5": (
        r"generalised-alpha, $\rho$ = 0.5",
        "C3",
        ["time.spectral_radius=0.5"],
    ),
}


def energy(case, scheme, out, step, end):
    """Times [s] and total energies [J] after the torque has ended."""
    folder = out / f"{case}_{scheme.replace(', ', '_')}"
    changes = [
        f"time.scheme={scheme.split(',')[0]}",
        f"time.step={step}",
        f"time.end={end}",
        "output.fields_every=0",
        "loads.gravity=0",
        *SCHEMES[scheme][2],
    ]
    run_case(Case.load(PAPER / f"{case}.toml", changes), folder, MPI.COMM_WORLD)
    history = read_history(folder / "history.csv").columns
    free = history["time_[s]"] >= 3.0
    return history["time_[s]"][free], history["total_energy_[J]"][free]


def draw(found, path):
    """Energy relative to that when the torque ends: as it is, and its change on a logarithm."""
    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(2, len(TURBINES), figsize=(11, 7), sharex=True, layout="tight")
    for (above, below), (case, title) in zip(axes.T, TURBINES.items(), strict=True):
        for scheme, (label, colour, _) in SCHEMES.items():
            t, H = found[case, scheme]
            above.plot(t, H / H[0], colour, label=label, lw=1.2)
            change = np.maximum(np.abs(H / H[0] - 1.0), 1e-16)
            below.semilogy(t, change, colour, lw=0.8)
        above.set_title(title)
        below.set_xlabel("time [s]")
    axes[0, 0].set_ylabel("energy / energy at 3 s")
    axes[1, 0].set_ylabel("change of energy / energy")
    axes[0, 0].legend(loc="lower left", frameon=False)
    figure.savefig(path, dpi=130)


def main():
    """Run all and draw."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--out", type=Path, default=Path("out/schemes"))
    parser.add_argument("--step", type=float, default=0.05, help="time step in s")
    parser.add_argument("--end", type=float, default=1000.0, help="end of the runs in s")
    args = parser.parse_args()
    found = {
        (case, scheme): energy(case, scheme, args.out, args.step, args.end)
        for case in TURBINES
        for scheme in SCHEMES
    }
    draw(found, args.out / "energy.png")
    lines = [f"step = {args.step}", f"end = {args.end}", ""]
    for (case, scheme), (_, H) in found.items():
        lines.append(f'[{case}."{scheme}"]')
        lines.append(f"energy = {H[0]:.6e} # J, when the torque ends")
        lines.append(f"largest_change = {np.max(np.abs(H / H[0] - 1.0)):.3e} # of it")
        lines.append("")
    (args.out / "result.toml").write_text("\n".join(lines))


if __name__ == "__main__":
    main()
