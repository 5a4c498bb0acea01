"""Colour scales of fields."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

STRESS, DEFLECTION = "von_mises_stress", "deflection"

OF_FLEXIBLE_PARTS = (STRESS, "cauchy_stress_norm", DEFLECTION)
"""Fields that rigid parts do not have; each body has its own scale of them."""

DEFAULT_FIELD = "default"
"""Stands for von Mises stress, or for the deflection where there is no stress, as of beams."""

LABELS = {
    STRESS: ("von Mises stress", "MPa", 1e-6),
    "cauchy_stress_norm": ("Cauchy stress norm", "MPa", 1e-6),
    "tsai_wu": ("failure index (Tsai-Wu)", "", 1.0),
    "displacement": ("displacement", "m", 1.0),
    DEFLECTION: ("deflection", "m", 1.0),
    "velocity": ("velocity", "m/s", 1.0),
}
"""Field to its name, the unit of the legend, and the factor to that unit."""

LARGEST_SHARE = 0.99
"""Share of the values below the end of a scale: peaks at corners do not darken the rest."""

_STOPS = ("#d3dce5", "#f6d98b", "#f39a4a", "#d5402d", "#8a1230", "#3a0a1e")


def colour_map(n: int = 256) -> list[str]:
    """From light grey, which is zero, over yellow and red to nearly black, lightness falling."""
    stops = np.array([[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in _STOPS], dtype=float)
    at = np.linspace(0.0, 1.0, len(stops))
    channels = [np.interp(np.linspace(0.0, 1.0, n), at, stops[:, k]) for k in range(3)]
    return [
        "#" + "".join(f"{round(c):02x}" for c in colour) for colour in zip(*channels, strict=True)
    ]


def to_scalars(name: str, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values of a field in the unit of its legend; of vectors their lengths."""
    numbers = np.asarray(values, dtype=float)
    lengths = np.linalg.norm(numbers, axis=1) if numbers.ndim == 2 else numbers
    return LABELS[name][2] * lengths if name in LABELS else lengths


def label(name: str, body: str = "") -> str:
    """Title of a legend in two lines: field, then the body it is of, and the unit."""
    words, unit, _ = LABELS.get(name, (name.replace("_", " "), "", 1.0))
    below = " ".join(filter(None, (body.replace("_", " "), unit and f"[{unit}]")))
    return f"{words}\n{below}" if below else words


def scale_of(values: Sequence[NDArray[np.float64]]) -> tuple[float, float]:
    """Zero and the number that nearly all values are below, rounded up.

    Args:
        values: Values at all times that are drawn.
    """
    every = np.concatenate([np.zeros(1), *(v[np.isfinite(v)] for v in values)])
    upper = np.quantile(every, LARGEST_SHARE)
    return 0.0, round_up(float(upper if upper > 0.0 else every.max()))


def round_up(x: float) -> float:
    """The next number that a scale of a few marks can end at; 1 for zero."""
    if not x > 0.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(x))
    ends = (1.0, 1.2, 1.6, 2.0, 2.4, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
    return float(next(n for n in ends if n * power >= x * (1.0 - 1e-9)) * power)
