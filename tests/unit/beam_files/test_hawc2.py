"""Claims about files of HAWC2: axes, centres, stiffness about the axis, damping, refusals."""

import numpy as np
import pytest
from hawc2_files import C2, TIMOSHENKO, write_hawc2

from turbine_fenicsx.beam_files.any_file import read_beam
from turbine_fenicsx.beam_files.hawc2 import list_parts, read_hawc2
from turbine_fenicsx.foundation.errors import FileError, InputError

T = TIMOSHENKO


@pytest.fixture
def blade(tmp_path):
    return read_hawc2(write_hawc2(tmp_path))


def energy(C, strain):
    return 0.5 * strain @ C @ strain


def test_the_axis_has_x_downwind_and_y_to_the_trailing_edge(blade):
    r, d = blade.line.at(np.array([0.0, blade.line.length]))
    x, y, z, _ = np.array(C2).T
    assert r == pytest.approx(np.column_stack([y, -x, z])[[0, -1]], abs=1e-6)
    # the twist turns about z, so that a root of -10 deg has its leading edge upwind
    trailing = d[0, 1]
    assert np.degrees(np.arctan2(trailing[0], trailing[1])) == pytest.approx(10.0, abs=0.1)


def test_a_pull_at_the_elastic_centre_does_not_bend(blade):
    """Strains by a force and moment: what a load at a centre does not cause is zero."""
    S = np.linalg.inv(blade.sections.stiffness[0])
    x_e, y_e = T["y_e"], -T["x_e"]  # in the axes of this package
    pull = np.array([0.0, 0.0, 1.0, y_e, -x_e, 0.0])
    strain = S @ pull
    assert np.abs(strain[[3, 4, 5]]).max() < 1e-12 * np.abs(strain).max()
    stretch = strain[2] + y_e * strain[3] - x_e * strain[4]
    assert stretch == pytest.approx(1.0 / (T["E"] * T["A"]))


def test_a_force_at_the_shear_centre_does_not_twist(blade):
    S = np.linalg.inv(blade.sections.stiffness[0])
    x_s, y_s = T["y_sh"], -T["x_sh"]
    for force in ((1.0, 0.0), (0.0, 1.0)):
        push = np.array([*force, 0.0, 0.0, 0.0, x_s * force[1] - y_s * force[0]])
        assert abs((S @ push)[5]) < 1e-18
    twist = S @ np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    assert twist[5] == pytest.approx(1.0 / (T["G"] * T["K"]))


def test_bending_has_the_principal_axes_of_the_structural_pitch(blade):
    S = np.linalg.inv(blade.sections.stiffness[0])
    angle = np.radians(T["pitch"])
    x_h = np.array([np.cos(angle), np.sin(angle)])  # principal axis in HAWC2's axes
    axis = np.array([x_h[1], -x_h[0]])
    moment = np.array([0.0, 0.0, 0.0, *axis, 0.0])
    curvature = (S @ moment)[3:5]
    assert curvature == pytest.approx(axis / (T["E"] * T["I_x"]))


def test_the_mass_is_about_the_axis(blade):
    M = blade.sections.inertia[0]
    x_g, y_g, m = T["y_cg"], -T["x_cg"], T["m"]
    assert [M[2, 2], M[2, 4], M[2, 3]] == pytest.approx([m, -m * x_g, m * y_g])
    # radii are about the axes of bending: through the elastic centre, and turned
    angle, away = np.radians(T["pitch"]), np.array([T["x_cg"] - T["x_e"], T["y_cg"] - T["y_e"]])
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, s], [-s, c]])
    about_e = np.diag([T["ri_y"] ** 2, T["ri_x"] ** 2])
    x, y = R @ away
    about_e[0, 1] = about_e[1, 0] = x * y
    about_g = R.T @ about_e @ R - np.outer(away, away)
    origin = m * (about_g + np.outer([T["x_cg"], T["y_cg"]], [T["x_cg"], T["y_cg"]]))
    assert M[[3, 4, 3], [3, 4, 4]] == pytest.approx([origin[0, 0], origin[1, 1], origin[0, 1]])
    assert M[5, 5] == pytest.approx(origin[0, 0] + origin[1, 1])
    # the large radius is about HAWC2's y, the axis x here
    assert M[3, 3] > M[4, 4]


@pytest.mark.parametrize("name", ["posdef", "aniso"])
def test_damping_of_the_strains_is_that_of_the_body(tmp_path, name):
    damping = f"damping_{name} 0.0 0.0 0.0 1e-3 2e-3 3e-3"
    blade = read_hawc2(write_hawc2(tmp_path, damping=damping))
    assert tuple(blade.sections.viscosity) == (0.0, 0.0, 0.0, 2e-3, 1e-3, 3e-3)
    assert blade.warnings == ()


def test_files_are_found_as_hawc2_finds_them(blade, tmp_path):
    """From a folder above, in upper or lower case, with bodies in a file that continues."""
    path = write_hawc2(tmp_path)
    bodies = tmp_path / "Bodies.htc"
    bodies.write_text(
        path.read_text().replace("./data/blade", r".\DATA\Blade") + "exit ;\nbegin main_body;"
    )
    deep = tmp_path / "htc" / "dlc12"
    deep.mkdir()
    deep = deep / "wsp10.htc"
    deep.write_text("begin new_htc_structure;\n  continue_in_file ./bodies.HTC ;\nend;\n")
    found = read_hawc2(deep)
    assert np.array_equal(found.sections.stiffness, blade.sections.stiffness)
    assert list_parts(deep) == [str(bodies), str(tmp_path / "data" / "blade_st.dat")]


def test_full_matrices_are_those_of_the_same_beam(blade, tmp_path):
    """A table with the Timoshenko beam's own matrix about its elastic centre, in turned axes."""
    angle, E, G, A = np.radians(T["pitch"]), T["E"], T["G"], T["A"]
    c, s = np.cos(angle), np.sin(angle)
    away = np.array([[c, s], [-s, c]]) @ [T["x_sh"] - T["x_e"], T["y_sh"] - T["y_e"]]
    K = np.diag([0.0, 0.0, E * A, E * T["I_x"], E * T["I_y"], 0.0])
    shear = np.diag([T["k_x"] * G * A, T["k_y"] * G * A, G * T["K"]])
    to = np.array([[1.0, 0.0, -away[1]], [0.0, 1.0, away[0]], [0.0, 0.0, 1.0]])
    K[np.ix_([0, 1, 5], [0, 1, 5])] += to.T @ shear @ to
    front = [T[key] for key in ("m", "x_cg", "y_cg", "ri_x", "ri_y", "pitch", "x_e", "y_e")]
    rows = [[r, *front, *K[np.triu_indices(6)]] for r in (0.0, blade.line.length)]
    (tmp_path / "full").mkdir()
    full = read_hawc2(write_hawc2(tmp_path / "full", rows, full=True))
    wanted = blade.sections.stiffness
    assert np.allclose(full.sections.stiffness, wanted, rtol=0.0, atol=1e-9 * np.abs(wanted).max())
    assert np.allclose(full.sections.inertia, blade.sections.inertia)


def test_what_is_not_followed_is_said(tmp_path):
    path = write_hawc2(tmp_path, damping="damping_file modes.dat")
    assert read_beam(path).warnings == (
        "turbine.htc: damping_file is left out; give blade.damping",
    )
    path = write_hawc2(tmp_path, damping="damping_posdef 0.1 0 0 1e-3 1e-3 1e-3")
    assert read_beam(path).warnings == (
        "turbine.htc: damping_posdef in proportion to the mass is left out",
    )
    short = [[r, *T.values()] for r in (0.0, 18.0)]
    (doubt,) = read_beam(write_hawc2(tmp_path, short)).warnings
    assert "its stations end at 18 m, and the axis of blade1 at 20.0" in doubt
    assert list_parts(path) == [str(tmp_path / "data" / "blade_st.dat")]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda t: t.replace("sec 2", "sec 2 0 0 -1 0 ;"), "z of sections must rise, it does not"),
        (lambda t: t.replace("blade1", "wing"), "has no main_body 'blade1'; it has tower, wing"),
        (lambda t: t.replace("set 1 2", "set 1 3"), "has no set 1 with subset 3"),
        (lambda t: t.replace("set 1 2", "set 1 x"), "line 14: expected a whole number, got 'x'"),
        (lambda t: t.replace("nsec 3", "nsec 4"), "line 17: nsec must be the number of sections"),
        (lambda t: t.replace("20.0 1.0", "20.0 no"), "line 20: expected 4 numbers, got 'sec 3"),
        (lambda t: t.replace("filename ./data/blade", "file ./data/blade"), "body has no filename"),
        (
            lambda t: "continue_in_file htc/turbine.htc ;\n" + t,
            "turbine.htc, line 1: more than 50 files continue each other",
        ),
        (lambda t: "continue_in_file ./none.htc ;\n" + t, "cannot read"),
        (
            lambda t: t.replace("      set 1 2", "      FPM 1 ;\n      set 1 2"),
            "line 7: expected 30 numbers, got",
        ),
    ],
)
def test_wrong_files_are_refused_with_their_line(tmp_path, change, sentence):
    path = write_hawc2(tmp_path)
    path.write_text(change(path.read_text()))
    with pytest.raises((InputError, FileError)) as caught:
        read_hawc2(path)
    assert sentence in str(caught.value)
