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
