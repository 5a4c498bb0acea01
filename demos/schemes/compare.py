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
from turbine_fenicsx.records.output_folder import read_history
from turbine_fenicsx.turbine.run.run import run_case

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
    """Change of energy since the torque has ended, as it is and its size on a logarithmic axis."""
    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(2, len(TURBINES), figsize=(11, 7), sharex=True, layout="tight")
    for (above, below), (case, title) in zip(axes.T, TURBINES.items(), strict=True):
        for scheme, (label, colour, _) in SCHEMES.items():
            t, H = found[case, scheme]
            change = H / H[0] - 1.0
            above.plot(t, 100.0 * change, colour, label=label, lw=1.2)
            below.semilogy(t[1:], np.maximum(np.abs(change[1:]), 1e-16), colour, lw=0.8)
        above.set_title(title)
        above.set_ylabel("change of energy [%]")
        below.set(xlabel="time [s]", ylabel="|change| / energy", ylim=(1e-15, 0.1))
        below.set_yticks(10.0 ** np.arange(-15, 0, 2))
        for axis in (above, below):
            axis.grid(color="0.9")
            axis.spines[["top", "right"]].set_visible(False)
    axes[0, 0].legend(loc="lower left", frameon=False)
    figure.savefig(path, dpi=110)


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
