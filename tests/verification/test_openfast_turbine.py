"""Claims about turbines without a windIO file: blades from files of BeamDyn, air of AeroDyn's."""

import numpy as np
import pytest
from aero_files import write_aerodyn
from beam_turbines import section_matrices
from beamdyn_files import write_beamdyn
from reduced_turbines import COMM, read, run
from rosco_blades import folder
from windio_files import find_turbine

from turbine_fenicsx import (
    BeamLine,
    BeamSections,
    Case,
    Coupling,
    MultibodySystem,
    ReducedBody,
    beam_basis,
    box_carrier,
    modes,
)
from turbine_fenicsx.beam_files.any_file import read_beam
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.case.blade_structure import find_structure

CASE = """
[time]
step = "0.05 s"
end = "0.5 s"
start = "turning"
[turbine]
rotor_speed = "25 rpm"
numerical_dissipation = 0.1
[wind]
speed = "9 m/s"
[aero]
file = "rotor.dat"
stations = 8
[blade]
model = "beam"
hub_radius = "1.5 m"
stations = [0.0, 0.3, 1.0]
chord = [1.2, 2.0, 0.6]
thickness = [1.2, 0.6, 0.1]
beam.file = "bar.dat"
[mesh]
span = 10
around = 8
[solver]
tolerance = 1e-9
[output]
sections = [0.0]
"""


def write_case(folder):
    """The case, with its files; its path."""
    p, n = section_matrices(), 2
    C, M = np.zeros((2, n, 6, 6))
    for key, values in p["stiffness_matrix"].items():
        if key != "grid":
            i, j = int(key[1]) - 1, int(key[2]) - 1
            C[:, i, j] = C[:, j, i] = values
    M[:, [0, 1, 2], [0, 1, 2]] = np.array([[200.0], [20.0]])
    M[:, [3, 4, 5], [3, 4, 5]] = np.array([[30.0, 12.0, 42.0], [3.0, 1.2, 4.2]])
    z = np.linspace(0.0, 1.0, 11)
    axis = np.column_stack([-0.5 * z**2, 0.3 * z**2, 20.0 * z, 10.0 - 11.0 * z])
    write_beamdyn(folder, axis, [(0.0, C[0], M[0]), (1.0, C[1], M[1])])
    write_aerodyn(folder, length=20.0, chord=2.0)
    path = folder / "case.toml"
    path.write_text(CASE)
    return path


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """The case."""
    return on_rank0(COMM, lambda: write_case(tmp_path_factory.mktemp("openfast")))


def test_length_and_damping_are_those_of_the_file(path):
    case = Case.load(path)
    assert case.blade.length == pytest.approx(read_beam(path.parent / "bar.dat").line.length)
    assert case.blade.damping.mu == (1e-3, 1.1e-3, 1.2e-3, 1.4e-3, 2.2e-3, 2.2e-3)
    assert case.warnings == []


def test_the_skin_has_the_widths_of_the_case_around_the_axis(path):
    blades = plan_rotor(Case.load(path)).blades
    for s, chord, thickness in ((0.0, 1.2, 1.2), (0.3, 2.0, 0.6), (1.0, 0.6, 0.1)):
        r, d = blades.line.at(np.array([s * blades.line.length]))
        trailing, suction, leading = blades.shape.surface(np.array(s), np.array([0.0, 0.25, 0.5]))
        assert trailing == pytest.approx(r[0] + 0.5 * chord * d[0, 1], abs=1e-9)
        assert leading == pytest.approx(r[0] - 0.5 * chord * d[0, 1], abs=1e-9)
        assert suction == pytest.approx(r[0] + 0.5 * thickness * d[0, 0], abs=1e-9)


def test_it_runs_in_wind_and_its_balance_of_energy_closes(path):
    seen = read(run(path, "run"))
    size = np.max(np.abs(seen["total_energy_[J]"]))
    assert np.max(np.abs(seen["energy_error_[J]"])) < 1e-8 * size  # steps to 1e-9
    assert np.max(np.abs(seen["work_of_wind_[J]"])) > 1e-3 * size
    weight = seen["section_force_1_at_0_z_[N]"]
    assert np.all(weight[1:] > 0.0)  # the rotation pulls at the root


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        (
            "blade.length=22",
            "bar.dat has a blade of 20.01 m, expected one of 22 m, as blade.length",
        ),
        ("mesh.file=mine.msh", 'blade.model = "beam": expected none beside mesh.file'),
        ("blade.beam.file=none.dat", "none.dat"),
    ],
)
def test_cases_that_cannot_be_are_refused(path, override, sentence):
    with pytest.raises(InputError) as caught:
        Case.load(path, [override])
    assert sentence in str(caught.value)


def test_beams_need_a_file():
    with pytest.raises(InputError, match=r"expected turbine\.file or blade\.beam\.file"):
        Case.parse({"blade": {"model": "beam"}})


def test_keys_of_solid_blades_have_no_effect(path):
    more = ["blade.twist=[0.1, 0.0, 0.0]", "material.density=2000", "mesh.elements=[2, 2, 8]"]
    assert Case.load(path, more).warnings == [
        f'{key} has no effect with blade.model = "beam"'
        for key in ("blade.twist", "mesh.elements", "material.density")
    ]


# --- published turbines


def find_frequencies(line: BeamLine, sections: BeamSections, count: int) -> list[float]:
    """The lowest frequencies of a clamped beam [Hz]."""
    box = box_carrier("blade", line, (1.0, 1.0), 50, COMM)
    basis = beam_basis(box.carrier, line, sections, start=box.start)
    body = ReducedBody("blade", box.carrier, basis)
    system = MultibodySystem(COMM, [body, Coupling("root", body, box.start, None)])
    return [mode.frequency for mode in modes(system, count=count).modes]


def test_the_blade_of_nrel_5_mw_has_the_frequencies_of_published_codes():
    """First flap 0.67 to 0.70 Hz, first edge 1.07 to 1.09 Hz, second flap 1.93 to 2.02 Hz."""
    blade = read_beam(folder() / "NREL-5MW" / "NRELOffshrBsline5MW_BeamDyn.dat")
    flap, edge, second = find_frequencies(blade.line, blade.sections, 3)
    assert 0.67 < flap < 0.70
    assert 1.07 < edge < 1.09
    assert 1.93 < second < 2.02


def test_files_of_beamdyn_and_windio_are_the_same_blade_of_iea_15_mw():
    place = folder() / "IEA-15-240-RWT" / "IEA-15-240-RWT"
    blade = read_beam(place / "IEA-15-240-RWT_BeamDyn.dat")
    file = str(find_turbine("IEA-15-240-RWT.yaml"))
    case = Case.parse({"turbine": {"file": file}, "blade": {"model": "beam", "damping": 0.0}})
    other = find_structure(case)
    of_beamdyn = find_frequencies(blade.line, blade.sections, 6)
    assert of_beamdyn == pytest.approx(find_frequencies(other.line, other.sections, 6), rel=2e-3)
