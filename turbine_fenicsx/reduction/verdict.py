"""The verdict on a basis as numbers, a table, warnings and a picture."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.diagram_style import LINE_STYLES, PALETTE, STYLE
from turbine_fenicsx.foundation.types import Array


def draw_basis(
    path: str | os.PathLike[str],
    singular_values: Array,
    stations: Array,
    errors: Mapping[str, tuple[Array, Array]],
) -> None:
    """Draw singular values and errors.

    Args:
        singular_values: The largest first, shape (k,) [sqrt(J)].
        stations: Places along the span, shape (stations,).
        errors: Errors of displacement [% of that of the tip] and twist [deg] at the stations, of
            each state by its name.
    """
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    with matplotlib.rc_context(STYLE):
        rows = 2 + 0.11 * len(errors)
        figure = Figure(figsize=(11.0, 2.0 + rows), layout=ConstrainedLayoutEngine())
        left, middle, right = figure.subplots(1, 3)
        shown = singular_values[singular_values > 1e-6 * max(singular_values, default=0.0)]
        left.semilogy(np.arange(1, len(shown) + 1), shown, "o-", ms=3.0, color=PALETTE[0])
        left.set(title="Equilibria beyond the first functions", xlabel="number")
        left.set_ylabel("singular value [√J]")
        for k, (name, pair) in enumerate(errors.items()):
            look = {
                "color": PALETTE[k % len(PALETTE)],
                "linestyle": LINE_STYLES[k // len(PALETTE) % len(LINE_STYLES)],
            }
            for axes, values in zip((middle, right), pair, strict=True):
                axes.plot(stations, values, label=name, **look)
        middle.set(title="Error of the displacement", ylabel="error / displacement of the tip [%]")
        right.set(title="Error of the twist", ylabel="error [deg]")
        for axes in (middle, right):
            axes.set(xlabel="place along the span", xlim=(0.0, 1.0))
            axes.set_ylim(bottom=0.0)
        if errors:
            handles, labels = middle.get_legend_handles_labels()
            figure.legend(handles, labels, loc="outside lower center", ncols=2)
        figure.savefig(os.fspath(path))


LARGEST_FREQUENCY_ERROR = 1e-3
"""Maximum relative error of a frequency without a warning."""

LARGEST_TIP_ERROR = 5e-3
"""Maximum error of the displacement of the tip, relative to it."""

LARGEST_TWIST_ERRORS = {0.7: 0.1, 0.9: 0.3}
"""Maximum errors of the twist at places along the span [deg]."""

LARGEST_COMPLIANCE_ERROR = 0.02
"""Maximum error of the compliance under smooth loads, relative to the largest of their kind."""

MORE = 1.375
"""Factor of the number of functions that is advised."""


@dataclass(frozen=True, eq=False)
class StateVerdict:
    """One equilibrium of the full body beside that of the reduced one under the same forces.

    Args:
        time: Its time there [s].
        tip: Displacement of the tip [m].
        displacement_errors: Distances of the two at all stations, shape (stations,) [m].
        twists: Twist of the full body there, shape (stations,) [deg].
        twist_errors: Difference of the reduced body's, shape (stations,) [deg].
        residual: What the full body lacks at the reduced state for equilibrium, in the energy that
            it would be at rest, relative to that of the forces [-].
    """

    path: str
    time: float
    tip: float
    displacement_errors: Array
    twists: Array
    twist_errors: Array
    residual: float

    @property
    def tip_error(self) -> float:
        """Error of the tip relative to its displacement [-]; not a number if none was found."""
        return float(self.displacement_errors[-1] / self.tip)


@dataclass(frozen=True, eq=False)
class Verdict:
    """How well a basis stands for its body.

    Args:
        name: Name of the body.
        functions: Number of functions besides those of the interfaces.
        strains: Number of strain coordinates.
        frequencies: Of the full and the reduced body with all interfaces at rest, shape (2, modes)
            [Hz].
        compliances: Largest error of the compliance by kind of smooth load, relative to the largest
            compliance of that kind [-].
        stations: Places along the span, from 0 to 1.
        states: The equilibria.
        singular_values: As of `ReducedBasis`.
    """

    name: str
    functions: int
    strains: int
    frequencies: Array
    compliances: dict[str, float]
    stations: Array
    states: tuple[StateVerdict, ...]
    singular_values: Array

    def at(self, place: float) -> int:
        """Number of the station nearest to a place."""
        return int(np.argmin(np.abs(self.stations - place)))

    @property
    def tip_error(self) -> float:
        """Largest error of the tip of any state relative to its displacement.

        Or to a tenth of the largest one, if it moves less.
        """
        least = 0.1 * max((s.tip for s in self.states), default=0.0)
        errors = (s.displacement_errors[-1] / max(s.tip, least) for s in self._found)
        return float(max(errors, default=0.0))

    def twist_error(self, place: float) -> float:
        """Largest error of the twist of any state at a place [deg]."""
        k = self.at(place)
        return max((float(abs(s.twist_errors[k])) for s in self._found), default=0.0)

    @property
    def _found(self) -> list[StateVerdict]:
        """States that the reduced body has."""
        return [s for s in self.states if np.isfinite(s.residual)]

    @property
    def warnings(self) -> list[str]:
        """A sentence for each bound that is passed, with what helps."""
        more = int(6 * np.ceil(MORE * self.functions / 6.0))
        enlarge = f"take functions = {more} instead of {self.functions}"
        nearer = f"{enlarge}, or loads for training that are nearer to what the body will see"
        found = []
        errors = np.abs(self.frequencies[1] / self.frequencies[0] - 1.0)
        wrong = np.flatnonzero(errors > LARGEST_FREQUENCY_ERROR)
        if wrong.size:
            k = wrong[0]
            found.append(
                f"frequency {k + 1} is wrong by {100.0 * errors[k]:.2g} %: take modes = "
                f"{len(errors)}, or functions = {more} instead of {self.functions}"
            )
        for kind, error in self.compliances.items():
            if error > LARGEST_COMPLIANCE_ERROR:
                found.append(
                    f"the body is too stiff by {100.0 * error:.2g} % under smooth {kind}: {enlarge}"
                )
        lost = [s for s in self.states if not np.isfinite(s.residual)]
        if lost:
            found.append(
                f"the reduced body has no equilibrium near that of the full one in {len(lost)} of "
                f"{len(self.states)} states, {lost[0].path!r} at {lost[0].time:g} s for example: "
                f"{nearer}"
            )
        if self.tip_error > LARGEST_TIP_ERROR:
            found.append(
                f"the displacement of the tip is wrong by up to {100.0 * self.tip_error:.2g} %: "
                f"{nearer}"
            )
        for place, bound in LARGEST_TWIST_ERRORS.items():
            error = self.twist_error(place)
            if error > bound:
                found.append(
                    f"the twist at {place:g} of the span is wrong by up to {error:.2g} degrees: "
                    f"{nearer}"
                )
        return found

    def draw(self, path: str | os.PathLike[str]) -> None:
        """Draw singular values, and errors along the span: of each load path the worst state.

        Args:
            path: Picture to write, such as ``.png``.

        Raises:
            ImportError: if Matplotlib is missing.
        """
        worst: dict[str, StateVerdict] = {}
        for s in self._found:
            worst[s.path] = max(worst.get(s.path, s), s, key=lambda state: state.tip_error)
        errors = {
            f"{s.path}, at {s.time:g} s": (
                100.0 * s.displacement_errors / s.tip,
                np.abs(s.twist_errors),
            )
            for s in worst.values()
        }
        draw_basis(path, self.singular_values, self.stations, errors)

    def __str__(self) -> str:
        """The table and the warnings."""
        lines = [
            f"basis of {self.name!r}: {self.functions} functions, {self.strains} strain "
            "coordinates",
            "",
        ]
        lines.append("frequencies at rest [Hz]      full   reduced   error [%]")
        for k, (full, reduced) in enumerate(self.frequencies.T):
            error = 100.0 * (reduced / full - 1.0)
            lines.append(f"{k + 1:24d} {full:9.4f} {reduced:9.4f} {error:11.4f}")
        lines.append("")
        if self.compliances:
            lines.append("compliance, smooth loads        largest error [%]")
        for kind, error in self.compliances.items():
            lines.append(f"{kind:>24} {100.0 * error:24.3f}")
        places = list(LARGEST_TWIST_ERRORS)
        if self.states:
            head = "".join(f"   twist at {p:g} [deg], error" for p in places)
            path = f"{'load path and time on it':53}"
            lines += ["", f"{path} tip [m], error [%]{head}   residual [%]"]
        for s in self.states:
            line = f"{s.path[:45]:45} {s.time:5.3g} s {s.tip:9.3f} {100.0 * s.tip_error:8.3f}"
            for k in map(self.at, places):
                line += f" {s.twists[k]:15.3f} {s.twist_errors[k]:9.3f}"
            lines.append(f"{line} {100.0 * s.residual:14.2f}")
        if self.states:
            lines.append("residual: error of the strains by their energy; it has no bound")
        lines += ["", *(f"warning: {warning}" for warning in self.warnings)]
        return "\n".join(lines).rstrip()
