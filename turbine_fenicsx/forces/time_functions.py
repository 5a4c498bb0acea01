"""Functions of time for forces: each is called with a time [s] and returns a number."""

from __future__ import annotations

import math
import re
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.files import open_regular


@dataclass(frozen=True)
class Hat:
    """Triangle from zero at t = 0 to ``peak`` at half the ``duration`` and back, eq. (60).

    Args:
        peak: Largest value, of any sign and unit.
        duration: Duration [s], positive.

    Raises:
        ModelError: for a duration that is not positive.
    """

    peak: float
    duration: float = 3.0

    def __post_init__(self) -> None:
        if not self.duration > 0.0:
            raise ModelError(f"duration of a hat function must be positive, got {self.duration} s")

    def __call__(self, time: float) -> float:
        """Value at a time [s]."""
        return self.peak * max(0.0, 1.0 - abs(2.0 * time / self.duration - 1.0))


@dataclass(frozen=True)
class Constant:
    """The same value at all times.

    Args:
        value: The value, of any unit.
    """

    value: float

    def __call__(self, time: float) -> float:
        """Value at a time [s]."""
        return self.value


ALWAYS = Constant(1.0)
"""One at all times."""


@dataclass(frozen=True)
class Ramp:
    """Zero until ``start``, from there to ``final`` within the ``duration``, then constant.

    A linear ramp excites vibrations by the kinks at its ends. With ``smooth`` it is
    10 x^3 - 15 x^4 + 6 x^5, x = (t - start)/duration, which has two continuous derivatives; its
    steepest slope is 15/8 of the linear one.

    Args:
        final: Value at the end and later, of any sign and unit.
        duration: Duration [s], positive.
        start: Time of the start [s].
        smooth: Whether to round off the ends.

    Raises:
        ModelError: if the duration is not positive, or an argument is not a number.
    """

    final: float
    duration: float
    start: float = 0.0
    smooth: bool = False

    def __post_init__(self) -> None:
        _check_finite("final value of a ramp", self.final)
        _check_finite("start of a ramp", self.start, "s")
        if not 0.0 < self.duration < math.inf:
            raise ModelError(f"duration of a ramp must be positive, got {self.duration} s")

    def __call__(self, time: float) -> float:
        """Value at a time [s]."""
        x = min(max((time - self.start) / self.duration, 0.0), 1.0)
        if self.smooth:
            x = x**3 * (10.0 + x * (6.0 * x - 15.0))
        return self.final * x


@dataclass(frozen=True)
class Product:
    """The product of two functions of time, for example of a load and a ramp."""

    first: Callable[[float], float]
    second: Callable[[float], float]

    def __call__(self, time: float) -> float:
        """Value at a time [s]."""
        return self.first(time) * self.second(time)


@dataclass(frozen=True)
class Sum:
    """The sum of two functions of time, for example of a ramp and a constant."""

    first: Callable[[float], float]
    second: Callable[[float], float]

    def __call__(self, time: float) -> float:
        """Value at a time [s]."""
        return self.first(time) + self.second(time)


@dataclass(frozen=True)
class Sine:
    """amplitude sin(2 pi frequency t + phase).

    Args:
        amplitude: Amplitude, of any unit.
        frequency: Frequency [Hz], positive.
        phase: Phase [rad]; pi/2 makes it a cosine.

    Raises:
        ModelError: if the frequency is not positive, or an argument is not a number.
    """

    amplitude: float
    frequency: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        _check_finite("amplitude of a sine", self.amplitude)
        _check_finite("phase of a sine", self.phase, "rad")
        if not 0.0 < self.frequency < math.inf:
            raise ModelError(f"frequency of a sine must be positive, got {self.frequency} Hz")

    def __call__(self, time: float) -> float:
        """Value at a time [s]."""
        return self.amplitude * math.sin(2.0 * math.pi * self.frequency * time + self.phase)


@dataclass(frozen=True)
class Table:
    """Straight lines between given points; constant before the first and after the last.

    Args:
        times: Times [s], strictly increasing.
        values: Values at these times, of any unit.

    Raises:
        ModelError: if there is not one value per time, none at all, the times do not increase, or
            what is given is no number.
    """

    times: Sequence[float]
    values: Sequence[float]

    def __post_init__(self) -> None:
        for name in ("times", "values"):
            object.__setattr__(self, name, tuple(float(x) for x in getattr(self, name)))
        if len(self.times) != len(self.values):
            raise ModelError(
                f"table needs one value per time, got {len(self.times)} times and "
                f"{len(self.values)} values"
            )
        if not self.times:
            raise ModelError("table needs at least one time and value, got none")
        for k, (time, value) in enumerate(zip(self.times, self.values, strict=True), start=1):
            _check_finite(f"time {k} of a table", time, "s")
            _check_finite(f"value {k} of a table", value)
        for k, (before, after) in enumerate(pairwise(self.times), start=2):
            if not before < after:
                raise ModelError(
                    f"times of a table must strictly increase, got {after} s after {before} s as "
                    f"number {k}"
                )

    def __call__(self, time: float) -> float:
        """Value at a time [s]."""
        k = bisect_right(self.times, time)
        if k == 0 or k == len(self.times):
            return self.values[max(k - 1, 0)]
        share = (time - self.times[k - 1]) / (self.times[k] - self.times[k - 1])
        return self.values[k - 1] + share * (self.values[k] - self.values[k - 1])

    @classmethod
    def read(cls, path: str | Path) -> Table:
        """Read a text file with one time [s] and one value per line.

        They stand apart by a comma, a semicolon, a tab or blanks. Empty lines and what follows a
        # do not count; the first line may name the columns. Under MPI every rank reads the file.

        Args:
            path: The file.

        Returns:
            The table.

        Raises:
            ModelError: with file and line, if a line does not hold two numbers; with the file, for
                any other mistake in the data.
            OSError: if the file cannot be read.
        """
        try:
            with open_regular(path) as file:
                lines = file.read().decode("utf-8-sig").splitlines()
        except UnicodeDecodeError as error:
            raise ModelError(f"{path}: this is no text file ({error})") from None
        rows: list[tuple[float, float]] = []
        first = True
        for number, line in enumerate(lines, start=1):
            text = line.partition("#")[0].strip()
            if not text:
                continue
            fields = re.split(r"\s*[,;]\s*|\s+", text)
            are_numbers = [_is_number(field) for field in fields]
            if are_numbers == [True, True]:
                rows.append((float(fields[0]), float(fields[1])))
            elif not first or any(are_numbers):
                raise ModelError(
                    f"{path}, line {number}: expected a time and a value, got {text!r}"
                )
            first = False
        try:
            return cls([time for time, _ in rows], [value for _, value in rows])
        except ModelError as error:
            raise ModelError(f"{path}: {error}") from None


def _check_finite(what: str, value: float, unit: str = "") -> None:
    """Raise a ModelError unless it is a number."""
    if not math.isfinite(value):
        raise ModelError(f"{what} must be a number, got {value} {unit}".rstrip())


def _is_number(text: str) -> bool:
    """Whether a text is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True
