"""Hollow blades whose sections, walls and webs are formulas."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.meshing.hollow_shape import Web


def plain_wall(s, a):
    """5 cm everywhere."""
    return np.full(np.broadcast(s, a).shape, 0.05)


def linear(root, tip):
    """A value that changes linearly from root to tip."""
    return lambda s: root + (tip - root) * np.asarray(s)


TWO, ZERO = linear(2.0, 2.0), linear(0.0, 0.0)


def ellipse(a, ratio):
    """Ellipse of unit chord from its trailing edge over the suction side, (x forward, y up)."""
    angle = 2.0 * np.pi * a
    return np.stack([-0.5 * np.cos(angle), 0.5 * ratio * np.sin(angle)], axis=-1)


def naca(gap):
    """Symmetric airfoil whose trailing edge has a width of gap chords; an open outline."""
    x = (1.0 - np.cos(np.linspace(0.0, np.pi, 401))) / 2.0
    y = 5.0 * (0.2969 * np.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    y[-1] = 0.0
    side = np.repeat([1.0, -1.0], [len(x) - 1, len(x)])
    x, y = np.concatenate([x[:0:-1], x]), side * np.concatenate([y[:0:-1], y])

    def outline(a, ratio):
        height = ratio * y + gap / 2.0 * x * side
        length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(height)))])
        length /= length[-1]
        return np.stack([0.5 - np.interp(a, length, x), np.interp(a, length, height)], axis=-1)

    return outline


@dataclass(frozen=True)
class Shape:
    """A straight blade with one outline whose chord, thickness ratio and twist vary.

    ``web_places`` are contour fractions at the suction and the pressure side.
    """

    length: float = 20.0
    hub_radius: float = 2.0
    outline: Callable = ellipse
    chord: Callable = TWO
    ratio: float = 1.0
    twist: Callable = ZERO
    thickness: Callable = plain_wall
    breaks: tuple = (0.0, 1.0)
    bounds: tuple = (0.0, 1.0)
    webs: tuple = ()
    web_places: tuple = ()
    web_thickness: float = 0.04
    closed_tip: bool = False

    @property
    def panels(self):
        return tuple(f"panel_{i}" for i in range(len(self.bounds) - 1))

    def lines(self, s):
        return np.tile(self.bounds, (len(s), 1))

    def web_arcs(self, web, s):
        return np.tile(self.web_places[web], (len(s), 1))

    def surface(self, s, a):
        s, a = np.broadcast_arrays(s, a)
        x, y = np.moveaxis(self.chord(s)[..., None] * self.outline(a, self.ratio), -1, 0)
        c, d = np.cos(self.twist(s)), np.sin(self.twist(s))
        return np.stack([self.hub_radius + self.length * s, c * x - d * y, d * x + c * y], axis=-1)

    def wall(self, s, a):
        return self.thickness(s, a)

    def web_wall(self, web, s):
        return np.full(np.shape(s), self.web_thickness)


def tube(**changes):
    """Circular tube of 2 m diameter."""
    return Shape(**changes)


def webbed_ellipse(**changes):
    """Tapered, twisted ellipse with caps and two webs that begin and end inside the span."""
    values = {
        "chord": linear(2.0, 0.8),
        "ratio": 0.4,
        "twist": linear(0.2, -0.05),
        "bounds": (0.0, 0.15, 0.35, 0.65, 0.85, 1.0),
        "webs": (Web("rear", 0.1, 0.6), Web("front", 0.1, 0.9)),
        "web_places": ((0.18, 0.82), (0.32, 0.68)),
        "breaks": (0.0, 0.1, 0.6, 0.9, 1.0),
    } | changes
    return Shape(**values)


def airfoil(gap=0.0, **changes):
    """Airfoil of 24 % thickness with caps and two webs, twisted and tapered."""
    values = {
        "outline": naca(gap),
        "ratio": 0.24,
        "chord": linear(4.0, 1.0),
        "twist": linear(0.25, -0.02),
        "length": 40.0,
        "bounds": (0.0, 0.08, 0.25, 0.4, 0.48, 0.52, 0.6, 0.75, 0.92, 1.0),
        "webs": (Web("rear", 0.1, 0.6), Web("front", 0.1, 0.9)),
        "web_places": ((0.27, 0.73), (0.38, 0.62)),
        "breaks": (0.0, 0.1, 0.6, 0.9, 1.0),
    } | changes
    return Shape(**values)
