"""The Campbell diagram of the IEA 22 MW rotor, with hollow blades of laminates.

The rotor of the windIO file with three shear webs and all layers in each blade, 20 cells along the
span and 24 around a section. It stands on a rigid tower, its yaw is locked and its own rotation is
free; there is no weight. At each of six speeds up to 8 rpm the rotation stretches its blades, and
frequencies are those seen from the rotor. The table has four of the speeds, 7.061 rpm being the
rated one, the [picture](gallery.md#gallery-iea22_campbell) all.

The reference is the beam of the [blade at rest](#iea22_blade), on a stiff hub that turns: stiffened
as a string by the centrifugal force, with gyroscopic forces, in its undeformed shape. It has 80
elements. Compared are motions in which two blades move against each other, so that the hub stays
where it is; edgewise motions of all blades alike turn it, and have other frequencies. The last rows
are what the rotation alone changes, K in f² = f₀² + K Ω².
"""

import csv

import numpy as np
from published import HERE, Row, load, references

from turbine_fenicsx.windio import find_turbine_file, read_turbine

FILE = "IEA-22-280-RWT.yaml"
MODES = ("flap_1", "edge_1", "flap_2")  # the lowest of the clamped beam
NAMES = ("first flap", "first edge", "second flap")
RATED = 7.061  # [rpm]
SPEEDS = (0.0, 4.0, RATED, 8.0)  # of the table [rpm]
RPM = np.pi / 30.0  # [rad/s]


def turning_beam(elements):
    """The blade of the file as a beam on a hub."""
    turbine, tools = read_turbine(find_turbine_file(FILE)), load("iea22_blade", "exact")
    beam = tools.make_beam(tools.blade_of_file(turbine), elements)
    make = load("iea22_campbell", "exact").TurningBeam
    return make(beam, turbine.blade.hub_radius, np.radians(turbine.hub.cone_angle))


def solve_beam(elements=80):
    """The references."""
    beam = turning_beam(elements)
    return collect({rpm: beam.frequencies(rpm * RPM, len(MODES)) for rpm in SPEEDS})


def read_result():
    """Speeds [rpm], names and frequencies [Hz] of ``result.csv``, which ``compute.py`` makes."""
    path = HERE / "iea22_campbell" / "result.csv"
    with path.open(encoding="utf-8") as file:
        return [
            (float(line["speed_[rpm]"]), line["name"], float(line["frequency_[Hz]"]))
            for line in csv.DictReader(file)
        ]


def result():
    """The quantities of the solid, in motions of two blades against each other."""
    table = {(round(rpm, 6), name): f for rpm, name, f in read_result()}
    return collect(
        {rpm: [table[rpm, f"{name}, blade 1 against 3"] for name in NAMES] for rpm in SPEEDS}
    )


def collect(frequencies):
    """Quantities by name, from frequencies of the modes by speed [rpm].

    K is (f^2 - f_0^2)/Omega^2 at the highest speed, both in Hz.
    """
    found = {
        f"{mode}_{rpm:g}": float(f)
        for rpm, row in frequencies.items()
        for mode, f in zip(MODES, row, strict=True)
    }
    last = SPEEDS[-1]
    for mode in MODES:
        change = found[f"{mode}_{last:g}"] ** 2 - found[f"{mode}_0"] ** 2
        found[f"{mode}_K"] = change / (last / 60.0) ** 2
    return found


def main():
    """Rows of the table; nothing is run."""
    found = result()
    return [
        Row(r.quantity, r.unit, r.value, found[name], r.tolerance, "20 by 24 elements")
        for name, r in references("iea22_campbell").items()
    ]
