"""Claims about inclined walls: a cone in closed form, the twist of a blade against shells."""

import numpy as np
import pytest
from windio_files import constant, curve, find_turbine, small_turbine, write_turbine

from turbine_fenicsx import BeamLine, BeamSections, Case
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.blades.inclined_walls import find_inclination
from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.blades.wall_rows import WallRows
from turbine_fenicsx.windio import read_turbine

WALL = 0.01


def make_cone(folder):
    """A blade of 20 m: a circular tube of 2 m whose lines meet 40 m from the root."""
    tables = small_turbine()
    blade = tables["components"]["blade"]
    blade["reference_axis"]["x"] = constant(0.0)
    blade["outer_shape"] = {
        "chord": curve((0.0, 2.0), (1.0, 1.0)),
        "twist": constant(0.0),
        "section_offset_y": curve((0.0, 1.0), (1.0, 0.5)),
        "section_offset_x": constant(0.0),
        "rthick": constant(1.0),
        "airfoils": [{"name": "circle", "spanwise_position": s} for s in (0.0, 1.0)],
    }
    structure = blade["structure"]
    (outer,) = (layer for layer in structure["layers"] if layer["name"] == "outer")
    whole = [anchor for anchor in structure["anchors"] if anchor["name"] in ("TE", "LE")]
    structure.update(layers=[outer | {"thickness": constant(WALL)}], anchors=whole)
    del structure["webs"]
    return read_turbine(write_turbine(tables, folder)).blade


def test_lines_of_a_cone_meet_at_its_apex(tmp_path):
    """With the distance h to the apex the slopes are -x/h and -y/h."""
    blade = make_cone(tmp_path)
    r = np.array([[0.0, 0.0, 0.0], [20.0, 0.0, 0.0]])
    r[:, 0] += blade.hub_radius
    directors = np.broadcast_to([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0]], (2, 2, 3))
    s = np.array([4.0, 10.0, 16.0])
    line = BeamLine(np.array([0.0, 1.0]), r, directors)
    D = find_inclination(WallRows.of(blade, line, 40, 32), s)
    h = 40.0 * (1.0 - 0.5 * WALL) - s
    half = D[:, 0, 0]  # E A <x^2>/h^2, half of E A R^2/h^2
    assert half == pytest.approx(D[:, 1, 1], rel=1e-3)
    assert D[:, 0, 4] == pytest.approx(half * h, rel=3e-3)  # E I/h
    assert D[:, 1, 3] == pytest.approx(-half * h, rel=3e-3)
    rest = D.copy()
    for i, j in ((0, 0), (1, 1), (0, 4), (4, 0), (1, 3), (3, 1)):
        rest[:, i, j] = 0.0
    scale = np.sqrt(half[:, None] * np.array([1.0, 1.0, 1.0, 400.0, 400.0, 400.0]))
    assert np.abs(rest / (scale[:, :, None] * scale[:, None, :])).max() < 1e-3
    assert np.allclose(D, D.swapaxes(1, 2), rtol=0.0, atol=1e-9 * np.abs(D).max())


# --- the blade of IEA 22 MW

UNITS = {
    "1 kN flapwise": ((0.0, 0.0, 1e3), (0.0, 0.0, 0.0), (1.8, 3.9, 14.6, 17.4, 1.3), 4e-6),
    "10 kN m flapwise": ((0.0, 0.0, 0.0), (0.0, -1e4, 0.0), (0.2, 1.0, 6.2, 23.7, 39.5), 2e-6),
}
"""Force and moment at the tip; rotation about the span [1e-6 rad] at 20, 40, 60, 80, 90 % of it of
CalculiX shells whose sections keep their shape in their plane; largest difference [rad]."""


@pytest.fixture(scope="module")
def iea22():
    """Its beams without and with inclined walls."""
    file = str(find_turbine("IEA-22-280-RWT.yaml"))
    case = {"turbine": {"file": file}, "blade": {"model": "beam", "damping": 0.0}}
    plain = plan_rotor(Case.parse(case)).blades
    case["blade"]["beam"] = {"taper": True}
    return plain, plan_rotor(Case.parse(case)).blades


def find_twist(blades, force, moment):
    """Rotation about the span under small loads at the tip [rad]."""
    line, sections = blades.line, blades.structure.sections
    assert isinstance(sections, BeamSections)
    s = np.linspace(0.0, line.length, 2001)
    r, d = line.at(s)
    R = np.concatenate([d, np.cross(d[:, 0], d[:, 1])[:, None]], axis=1)
    m = np.asarray(moment) + np.cross(r[-1] - r, force)
    loads = np.concatenate([R @ np.asarray(force), np.einsum("kai,ki->ka", R, m)], axis=1)
    strain = np.linalg.solve(sections.stiffness_at(s), loads[:, :, None])[:, :, 0]
    rate = np.einsum("ka,ka->k", R[:, :, 0], strain[:, 3:])
    turned = np.append(0.0, np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(s)))
    return np.interp(np.array([0.2, 0.4, 0.6, 0.8, 0.9]) * line.length, s, turned)


@pytest.mark.parametrize("load", UNITS)
def test_beams_with_inclined_walls_twist_as_shells_do(iea22, load):
    force, moment, of_shells, most = UNITS[load]
    prism, inclined = (find_twist(blades, force, moment) for blades in iea22)
    gap = np.abs(inclined - 1e-6 * np.array(of_shells))
    assert gap.max() < most
    assert np.abs(prism - 1e-6 * np.array(of_shells)).max() > 10.0 * most


def test_without_a_layup_there_are_no_walls(tmp_path):
    tables = small_turbine()
    structure = tables["components"]["blade"]["structure"]
    for key in ("layers", "webs", "anchors"):
        del structure[key]
    file = str(write_turbine(tables, tmp_path))
    case = {"turbine": {"file": file}, "blade": {"model": "beam", "beam": {"taper": True}}}
    with pytest.raises(InputError, match=r"blade\.beam\.taper: expected a file with components"):
        Case.parse(case)
