"""Panels of the paper's diagrams, for `turbine_fenicsx.postprocessing.plots.draw`."""

import numpy as np

from turbine_fenicsx.postprocessing.plots import PALETTE, PAPER_TOLERANCE


def column(name, factor=1.0):
    """A function of the run: a column of its history times a factor."""
    return lambda run: factor * run[name]


HAMILTONIAN = ("Hamiltonian", column("total_energy_[J]", 1e-3), PALETTE[0])
STRAIN = ("strain energy", column("strain_energy_[J]", 1e-3), PALETTE[1])
MOMENTA = {
    i: (f"$L_{i}$", column(f"angular_momentum_{i}_[Nms]", 1e-3), PALETTE[i - 1]) for i in (1, 2, 3)
}
YAW = (r"$\Theta_1$", column("angle_yaw_[rad]"), PALETTE[0])
ROTOR = (r"$\Theta_2$", column("angle_rotor_[rad]"), PALETTE[1])


def curves(title, ylabel, *quantities):
    """Panel of quantities over time.

    Args:
        title: Above the panel.
        ylabel: Quantity and unit.
        quantities: Label of each, a function of the run, and its colour.
    """

    def panel(axes, run, look):
        for label, values, color in quantities:
            axes.plot(run["time_[s]"], values(run), color=color, label=label)
        axes.set(title=title, ylabel=ylabel)

    return panel


def changes(title, ylabel, *quantities):
    """Panel of what each step after the loading adds to quantities, eq. (61), and the tolerance.

    Changes are drawn as dots without their sign; those that are zero cannot be seen. The work of
    the torques tells when the loading is over.
    """

    def panel(axes, run, look):
        loaded = np.flatnonzero(np.diff(run["external_work_[J]"]))
        first = loaded[-1] + 1 if loaded.size else 0
        axes.set_yscale("log")
        for label, values, color in quantities:
            change = np.abs(np.diff(values(run)[first:]))
            shown = np.where(change > 0.0, change, np.nan)
            time = run["time_[s]"][first + 1 :]
            axes.plot(time, shown, ".", ms=3.0, mew=0.0, color=color, label=label)
        axes.axhline(PAPER_TOLERANCE, color="#333333", lw=1.0, ls="--", label="tolerance")
        axes.set(title=title, ylabel=ylabel)

    return panel


def torque(hat):
    """Panel of the torque on the rotor: as given, and as the work and the angle of each step say.

    Args:
        hat: The function of time that the run was given [Nm].
    """

    def panel(axes, run, look):
        t, angle = run["time_[s]"], np.diff(run["angle_rotor_[rad]"])
        work = np.diff(run["work_of_torque_on_rotor_[J]"])
        middle = 0.5 * (t[1:] + t[:-1])
        axes.plot(middle, work / angle / 1e3, ".", ms=6.0, color=PALETTE[1], label="work per angle")
        given = np.array([hat(time) for time in t])
        axes.plot(t, given / 1e3, color="black", lw=0.8, label="eq. (60)")
        axes.set(title="Torque on the rotor", ylabel="$F_2$ [kNm]")

    return panel
