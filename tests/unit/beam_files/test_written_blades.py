"""Claims about blades that are written as files of other codes: read back, they are the same."""

import numpy as np
import pytest
import yaml

from turbine_fenicsx import BeamLine, BeamSections
from turbine_fenicsx.beam_files.any_file import read_beam
from turbine_fenicsx.beam_files.beam_blade import BeamBlade
from turbine_fenicsx.beam_files.write_beamdyn import write_beamdyn
from turbine_fenicsx.beam_files.write_hawc2 import write_hawc2
from turbine_fenicsx.foundation.section_matrices import find_to_point, make_inertia
from turbine_fenicsx.windio.entry import Entry
from turbine_fenicsx.windio.section_properties import read_section_properties
from turbine_fenicsx.windio.write_section_properties import write_section_properties

STATIONS = np.linspace(0.0, 1.0, 21)


@pytest.fixture
def blade():
    """Curved and twisted, with all couplings, and a mass that has a product of inertia."""
    z = 50.0 * STATIONS
    points = np.column_stack([-2.0 * STATIONS**2, 0.5 * STATIONS**3, z])
    twist = np.radians(15.0 * (1.0 - STATIONS) ** 2)
    c, s, none = np.cos(twist), np.sin(twist), np.zeros_like(z)
    directors = np.stack([np.column_stack([c, -s, none]), np.column_stack([s, c, none])], axis=1)
    line = BeamLine(STATIONS, points, directors)
    random = np.random.default_rng(3)
    A = random.normal(size=(21, 6, 6))
    scale = np.sqrt([1e9, 1e9, 1e10, 1e9, 4e9, 5e8])
    C = (np.eye(6) + 0.02 * A @ A.swapaxes(1, 2)) * np.outer(scale, scale)
    mass = np.linspace(900.0, 100.0, 21)
    centre = np.column_stack([0.05 + 0.0 * z, 0.3 - 0.2 * STATIONS])
    seconds = mass[:, None] * [0.2, 0.9, 0.05]
    M = make_inertia(mass, centre, seconds)
    s = line.arc_length(STATIONS)
    return BeamBlade(line, BeamSections(s, C, M, (1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3)))


@pytest.mark.parametrize("write", [write_beamdyn, write_hawc2])
def test_axis_twist_and_stiffness_come_back(blade, tmp_path, write):
    name = "a.dat" if write is write_beamdyn else "a.htc"
    files = write(tmp_path / name, blade, "a blade")
    assert [file.parent for file in files] == [tmp_path, tmp_path]
    again = read_beam(files[0])
    assert again.warnings == ()
    assert again.line.length == pytest.approx(blade.line.length, rel=1e-5)
    s = blade.line.length * np.array([0.05, 0.31, 0.77, 0.98])
    for one, other in zip(again.line.at(s), blade.line.at(s), strict=True):
        assert one == pytest.approx(other, abs=5e-3 if one.ndim == 2 else 1e-3)
    C, other = again.sections.stiffness, blade.sections.stiffness
    scale = np.sqrt(np.einsum("kii->ki", other))
    assert np.abs((C - other) / (scale[:, :, None] * scale[:, None, :])).max() < 1e-9
    assert again.sections.viscosity[3:] == pytest.approx(blade.sections.viscosity[3:])


def test_mass_comes_back_but_for_the_product_that_hawc2_lacks(blade, tmp_path):
    M = blade.sections.inertia
    of_beamdyn = read_beam(write_beamdyn(tmp_path / "a.dat", blade, "a blade")[0])
    assert of_beamdyn.sections.inertia == pytest.approx(M, rel=1e-9, abs=1e-9)
    found = read_beam(write_hawc2(tmp_path / "a.htc", blade, "a blade")[0]).sections.inertia
    assert found[:, :3] == pytest.approx(M[:, :3], rel=1e-9, abs=1e-9)  # mass and centre
    assert found[:, 5, 5] == pytest.approx(M[:, 5, 5], rel=1e-9)
    assert found[:, 3, 3] == pytest.approx(M[:, 3, 3], rel=0.1)


def test_a_section_along_the_axes_of_bending_comes_back_from_hawc2_whole(blade, tmp_path):
    angle, x, y = (np.full(21, value) for value in (0.3, 0.1, -0.2))
    to_point = find_to_point(x, y, angle)
    C = np.diag([1e9, 1e9, 1e10, 1e9, 4e9, 5e8])
    M = make_inertia(np.full(21, 100.0), np.zeros((21, 2)), np.full((21, 3), [20.0, 90.0, 0.0]))
    of_bending = [to_point.swapaxes(1, 2) @ matrix @ to_point for matrix in (C, M)]
    sections = BeamSections(blade.sections.stations, *of_bending)
    files = write_hawc2(tmp_path / "a.htc", BeamBlade(blade.line, sections), "a blade")
    found = read_beam(files[0]).sections
    assert found.stiffness == pytest.approx(of_bending[0], rel=1e-9, abs=1.0)
    assert found.inertia == pytest.approx(of_bending[1], rel=1e-9, abs=1e-7)


def test_windio_reads_what_is_written(blade, tmp_path):
    path, sections = tmp_path / "elastic.yaml", blade.sections
    write_section_properties(path, STATIONS, sections.stiffness, sections.inertia)
    table = yaml.safe_load(path.read_text())["elastic_properties"]
    found = read_section_properties(Entry(table, "elastic.yaml"))
    assert found.warnings == ()
    assert found.stiffness == pytest.approx(sections.stiffness, rel=1e-12)
    assert found.inertia == pytest.approx(sections.inertia, rel=1e-12, abs=1e-12)
