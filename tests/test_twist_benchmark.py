"""Parts of `benchmarks/twist` that need no CalculiX."""

import importlib
from pathlib import Path

import numpy as np
import pytest

from turbine_fenicsx.windio import find_turbine_file, read_turbine

FOLDER = Path(__file__).parent.parent / "benchmarks" / "twist"
FILE = "IEA-22-280-RWT.yaml"


@pytest.fixture
def load(monkeypatch):
    monkeypatch.syspath_prepend(str(FOLDER))
    return importlib.import_module


def test_two_readers_find_the_same_walls(load):
    """That of the benchmark shares no line with the package's."""
    blade, own = (
        load("layup").Blade(find_turbine_file(FILE)),
        read_turbine(find_turbine_file(FILE)).blade,
    )
    for s in (0.2, 0.5, 0.8):
        outline, arcs = blade.outline(s)
        picked = slice(5, -5, 10)
        found = blade.place(s, outline[picked])
        wanted = own.surface(np.full(len(found), s), arcs[picked])
        wanted = (wanted - [own.hub_radius, 0.0, 0.0])[:, [2, 1, 0]] * [1.0, -1.0, 1.0]
        assert np.max(np.abs(found - wanted)) < 0.005 * float(blade.chord(s))
        at = blade.panels(s)
        middles = 0.5 * (at[1:] + at[:-1])
        thick = [sum(t for _, t in blade.plies(s, arc)) for arc in middles]
        assert thick == pytest.approx(own.wall(np.full(len(middles), s), middles), rel=1e-6)
    mesh = load("shells").make_shells(blade, 30, 40)
    mass = own.length * own.line_mass.integral
    assert mesh.mass == pytest.approx(mass, rel=0.05)  # layers lie on the middle of the wall


def test_loads_on_nodes_work_on_the_motion_of_their_section(load):
    motion = load("section_motion")
    rng = np.random.default_rng(3)
    x, w, origin = rng.standard_normal((9, 3)), rng.random(9) + 0.1, rng.standard_normal(3)
    u, load_ = rng.standard_normal((9, 3)), rng.standard_normal(6)
    forces = motion.spread(x, w, origin, load_)
    assert forces.sum(axis=0) == pytest.approx(load_[:3])
    assert np.cross(x - origin, forces).sum(axis=0) == pytest.approx(load_[3:])
    work = np.sum(forces * u)
    assert work == pytest.approx(load_ @ motion.rigid_motion(x, w, origin, u))


def test_slices_of_a_wall_have_the_stiffness_of_its_layers(load):
    shells = load("kratos_shells")
    stiff = {"E": [40e9, 10e9, 10e9], "G": [4e9, 3e9, 2e9], "nu": [0.3, 0.3, 0.3]}
    foam = {"E": 1e8, "G": 4e7, "nu": 0.25}
    materials = {"stiff": stiff, "foam": foam}
    stack = [("stiff", 0.002), ("foam", 0.05), ("stiff", 0.003)]
    slices = np.array(list(shells._slice(stack, materials, 1.0)))
    t, _, _, E1, E2, nu, *G = slices.T
    assert t.sum() == pytest.approx(0.055)
    share = 1.0 - nu**2 * E2 / E1
    thick = [0.005, 0.05]
    for found, of_layer in (
        (E1 / share, [40e9 / (1.0 - 0.09 / 4.0), 1e8 / (1.0 - 0.0625)]),
        (nu * E2 / share, [0.3 * 10e9 / (1.0 - 0.09 / 4.0), 0.25e8 / (1.0 - 0.0625)]),
        (G[0], [4e9, 4e7]),
        (G[2], [2e9, 4e7]),
    ):
        assert t @ found == pytest.approx(np.dot(thick, of_layer))


def test_quadrilaterals_keep_the_corners_of_shells(load):
    blade = load("layup").Blade(find_turbine_file(FILE))
    mesh = load("shells").make_shells(blade, 20, 40)
    made = load("kratos_shells").Quadrilaterals.of(mesh)
    assert made.nodes[made.cells] == pytest.approx(mesh.nodes[mesh.cells[:, :4]])
    for (few, lengths), (numbers, every) in zip(made.rows, mesh.rows, strict=True):
        assert len(few) == len(numbers) // 2
        assert lengths.sum() == pytest.approx(every.sum(), rel=5e-3)


def test_fibres_lie_along_the_span_where_cells_do_not(load):
    kratos = load("kratos_shells")
    square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    span = np.array([[np.cos(0.3), np.sin(0.3), 0.2]])
    model = kratos.Quadrilaterals(square, np.array([[0, 1, 2, 3]]), [], span, [], None, None)
    assert kratos._find_angles(model) == pytest.approx([0.3])
