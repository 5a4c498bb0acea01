"""Claims about the names of modes: words for shapes that are put in."""

import numpy as np
import pytest

from turbine_fenicsx.turbine.components.mode_names import (
    describe_pattern,
    find_order,
    name_blades,
    name_joints,
    name_tower,
    share_energies,
    word_ordinal,
)

X = np.linspace(0.0, 1.0, 13)
ROOTS = (1.8751040687, 4.6940911329, 7.8547574382, 10.9955407348)
"""Of a clamped beam."""


def bending(n, x=X):
    """The n-th mode of a clamped beam."""
    k = ROOTS[n - 1]
    sigma = (np.sinh(k) - np.sin(k)) / (np.cosh(k) + np.cos(k))
    return np.cosh(k * x) - np.cos(k * x) - sigma * (np.sinh(k * x) - np.sin(k * x))


def column(shape, way):
    """Sections that move in one way only."""
    found = np.zeros((len(shape), 4), dtype=complex)
    found[:, way] = shape
    return found


def three(shape, way, amplitudes):
    shapes = [a * column(shape, way) for a in amplitudes]
    return name_blades(shapes, shapes)[0].name


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_order_of_bending_modes_of_a_clamped_beam(n):
    assert find_order(bending(n)) == find_order(-bending(n)) == n


@pytest.mark.parametrize(("k", "n"), [(3.9266023120, 2), (7.0685827456, 3)])
def test_order_is_told_by_the_slopes_where_a_heavy_end_stays_in_place(k, n):
    sigma = (np.cosh(k) - np.cos(k)) / (np.sinh(k) - np.sin(k))
    clamped_and_pinned = np.cosh(k * X) - np.cos(k * X) - sigma * (np.sinh(k * X) - np.sin(k * X))
    assert find_order(clamped_and_pinned) == n


@pytest.mark.parametrize("n", [1, 2, 3])
def test_order_of_torsional_modes(n):
    assert find_order(np.sin((n - 0.5) * np.pi * X)) == n


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_the_free_end_of_a_blade_bends_nothing_by_itself(n):
    shape = bending(n)
    assert find_order(shape, ends_free=True) == n
    turned = np.sin((n - 0.5) * np.pi * X)
    turned[-1] *= 0.5  # the last slice of a blade is half as thick
    assert find_order(turned, ends_free=True) == n


def test_order_of_a_blade_whose_root_moves_counts_nodes_and_turns():
    """Shapes of IEA 15 MW at 1.24 and 3.61 Hz: a slope of 0.03, and a lobe that crosses nothing."""
    second = [0, 0, -0.01, -0.02, -0.03, -0.04, -0.03, 0.01, 0.12, 0.23, 0.51, 0.65, 1]
    third = [0, 0, 0.02, 0.07, 0.16, 0.24, 0.27, 0.21, 0.10, 0.06, 0.16, 0.35, 1]
    assert find_order(np.array(second)) == 1 and find_order(np.array(second), ends_free=True) == 2
    assert find_order(np.array(third), ends_free=True) == 3


def test_small_ripples_do_not_count():
    assert find_order(bending(1) + 1e-3 * np.sin(40 * X)) == 1


@pytest.mark.parametrize(
    ("amplitudes", "words"),
    [
        ((1, 1, 1), "collective"),
        ((-1, -1, -1), "collective"),
        ((0.9, 1.0, 0.9), "collective"),
        ((1, 0, 0), "blade 1 alone"),
        ((0.05, -1, 0.1), "blade 2 alone"),
        ((1, 0, -1), "blade 1 against 3"),
        ((-1, 0.1, 1), "blade 1 against 3"),
        ((-0.5, 1, -0.5), "blades 1 and 3 against 2"),
        ((1, -0.5, -0.5), "blades 2 and 3 against 1"),
        ((1, 0, 1), "blades 1 and 3 together"),
    ],
)
def test_pattern_of_blades(amplitudes, words):
    assert describe_pattern(np.array(amplitudes, dtype=complex), 1.0) == words
    assert describe_pattern(1j * np.array(amplitudes), 1.0) == words


@pytest.mark.parametrize(("sense", "words"), [(1.0, "forward whirl"), (-1.0, "backward whirl")])
def test_a_pattern_that_goes_round_whirls_with_the_rotor_or_against_it(sense, words):
    # Re[c_k exp(i w t)] has its crest at blades with rising numbers one after the other
    amplitudes = np.exp(-2j * np.pi * np.arange(3) / 3)
    assert describe_pattern(amplitudes, sense) == words
    assert describe_pattern(amplitudes.conj(), -sense) == words


def test_names_of_blades():
    assert three(bending(1), 0, (1, 1, 1)) == "first flap, collective"
    assert three(bending(2), 1, (1, -0.5, -0.5)) == "second edge, blades 2 and 3 against 1"
    assert three(np.sin(0.5 * np.pi * X), 3, (0, 1, 0)) == "first twist, blade 2 alone"


def test_the_way_of_motion_is_that_with_most_of_the_mass():
    shapes = [column(bending(1), 0) + 0.5 * column(bending(2), 1)] * 3
    first, other, *_ = name_blades(shapes, shapes)
    assert (first.name, other.name) == ("first flap, collective", "second edge, collective")
    assert first.share == pytest.approx(0.8, abs=0.01) and other.way == "edge"
    assert first.share + other.share == pytest.approx(1.0)


def test_names_of_the_tower():
    for way, words in enumerate(("fore-aft", "side-side", "stretch", "twist")):
        shape = column(bending(2), way)
        title = name_tower(shape, shape, 80.0 * X)[0]
        assert title.name == f"second {words} of the tower"
        assert title.share == pytest.approx(1.0)


@pytest.mark.parametrize(("turn", "words"), [(0.08, "side-side"), (0.12, "twist")])
def test_torsion_of_the_tower_counts_by_its_angle_not_by_its_mass(turn, words):
    metres = 2.0 * column(X**2, 1) + turn * column(np.sin(0.5 * np.pi * X), 3)
    shape = metres * (100.0, 100.0, 100.0, 1.0)
    assert name_tower(shape, metres, 80.0 * X)[0].name == f"first {words} of the tower"


def test_names_of_what_bends_nothing():
    assert name_joints({"yaw": 0.0, "rotor": 0.3}, True) == "free rotor"
    assert name_joints({"yaw": -0.3, "rotor": 0.3}, True) == "free yaw and rotor"
    assert name_joints({"pitch_1": 0.1, "pitch_2": 0.1, "yaw": 0.1}, False) == (
        "swinging pitch 1, pitch 2 and yaw"
    )
    assert name_joints({"pitch_1": 0.1, "rotor": 0.0}, False, True) == "pitch 1 on springs"
    assert name_joints({"yaw": 0.0}, True) == name_joints({}, True) == "rigid body"


def test_blades_count_as_one_family():
    energies = {"blade_1": 0.3, "blade_2": 0.3, "blade_3": 0.0, "tower": 0.4}
    assert share_energies(energies) == pytest.approx({"blades": 0.6, "tower": 0.4})
    assert list(share_energies(energies | {"tower": 0.7})) == ["tower", "blades"]
    assert next(iter(share_energies(energies | {"spring of pitch_1": 0.9}))) == "spring of pitch_1"
    assert share_energies({}) == share_energies({"spring of pitch_1": 0.0}) == {}


def test_numbers_in_words():
    assert [word_ordinal(n) for n in (1, 3, 9, 10)] == ["first", "third", "ninth", "10th"]
