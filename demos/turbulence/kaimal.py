"""Turbulence of IEC 61400-1 for the box of a case: Kaimal spectra with exponential coherence.

``python demos/turbulence/kaimal.py CASE --category B --seed 1`` writes the files that
``wind.box.files`` of the case names, beside it. Points, spacing and wind speed are those of the
case. With V, the standard deviation s_1 = I (0.75 V + 5.6 m/s), Lambda = 42 m, and r the distance
of two points in the plane across the wind, the one-sided spectra and the coherence of u are

    S_k(f) = 4 s_k^2 (L_k/V)/(1 + 6 f L_k/V)^(5/3),      s = s_1 (1, 0.8, 0.5),
    L = Lambda (8.1, 2.7, 0.66),
    Coh(r, f) = exp(-12 ((f r/V)^2 + (0.12 r/L_1)^2)^(1/2)).

v and w have no coherence, for which the standard gives none. The waves of each frequency have
random phases, and those of u are combined by the Cholesky factor of the coherence (Veers 1988).
"""

import argparse
import tomllib
from pathlib import Path

import numpy as np

from turbine_fenicsx.case.quantities import to_si

INTENSITIES = {"A+": 0.18, "A": 0.16, "B": 0.14, "C": 0.12}
LENGTH = 42.0  # Lambda at hubs above 60 m [m]
DEVIATIONS = (1.0, 0.8, 0.5)
LENGTHS = (8.1, 2.7, 0.66)
DECAY, OFFSET = 12.0, 0.12


def find_factors(f, V, distances):
    """For each frequency the Cholesky factor of the coherence of u between all points."""
    for frequency in f:
        decay = np.hypot(frequency / V, OFFSET / (LENGTHS[0] * LENGTH)) * distances
        coherence = np.exp(-DECAY * decay)
        yield np.linalg.cholesky(coherence + 1e-9 * np.eye(len(coherence)))


def find_amplitudes(f, V, s, L):
    """Amplitudes of the waves of a component, shape (n_f, 1)."""
    S = 4.0 * s**2 * (L / V) / (1.0 + 6.0 * f * L / V) ** (5.0 / 3.0)
    return np.sqrt(0.5 * S * f[0])[:, None]


def make_turbulence(V, s_1, points, spacing, seed):
    """Fluctuations u, v, w on a box, each of the shape of its points [m/s]."""
    n, *across = points
    y, z = (d * np.arange(m) for m, d in zip(across, spacing[1:], strict=True))
    places = np.stack(np.meshgrid(y, z, indexing="ij"), axis=-1).reshape(-1, 2)
    distances = np.linalg.norm(places[:, None] - places[None], axis=2)
    f = np.arange(1, n // 2 + 1) * V / (n * spacing[0])
    rng, found = np.random.default_rng(seed), []
    for k, (ratio, length) in enumerate(zip(DEVIATIONS, LENGTHS, strict=True)):
        waves = np.exp(2j * np.pi * rng.random((len(f), len(places))))
        if k == 0:
            factors = find_factors(f, V, distances)
            waves = np.array([A @ wave for A, wave in zip(factors, waves, strict=True)])
        waves *= find_amplitudes(f, V, ratio * s_1, length * LENGTH)
        spectrum = np.concatenate([np.zeros((1, len(places))), waves])
        found.append(np.fft.irfft(spectrum, n=n, axis=0).reshape(points) * n)
    return found


def main():
    """Write the box of a case."""
    parser = argparse.ArgumentParser(description="Make the turbulence box of a case.")
    parser.add_argument("case", type=Path)
    parser.add_argument("--category", choices=INTENSITIES, default="B")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    wind = tomllib.loads(given.case.read_text())["wind"]
    V, box = to_si(wind["speed"], "m/s"), wind["box"]
    spacing = [to_si(d, "m") for d in box["spacing"]]
    s_1 = INTENSITIES[given.category] * (0.75 * V + 5.6)
    for name, values in zip(
        box["files"], make_turbulence(V, s_1, box["points"], spacing, given.seed), strict=True
    ):
        values.astype("<f4").tofile(given.case.parent / name)
        print(f"{name}: {box['points']} points, standard deviation {values.std():.2f} m/s")


if __name__ == "__main__":
    main()
