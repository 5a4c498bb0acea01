"""The demo on the refinement of a blade: its matrices, against beams, and what it writes."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest
from runs import comm

from turbine_fenicsx import BladeGeometry, Case, FlexibleBody
from turbine_fenicsx.meshing import MeshOptions
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep

pytestmark = pytest.mark.slow

pytest.importorskip("slepc4py")
FOLDER = Path(__file__).parents[2] / "demos" / "refinement"


@pytest.fixture(scope="module")
def demo():
    """Imports a module of the demo."""
    sys.path.insert(0, str(FOLDER))
    yield importlib.import_module
    sys.path.remove(str(FOLDER))


@pytest.fixture(scope="module")
def solved(demo):
    """Rows of the demo, each computed once."""
    solve, rows = demo("refinement").solve, {}

    def row(*key):
        if key not in rows:
            rows[key] = solve(comm, *key)
        return rows[key]

    return row


class Beam:
    """Slender blade with the same elliptic sections, fibre along the axis, by Ritz's method."""

    def __init__(self, direction):
        """``direction`` is "flap" or "edge"."""
        blade, material = BladeGeometry(), Case().material
        n = 4000
        s = (np.arange(n) + 0.5) / n
        self.ds, x, length = blade.length / n, s, blade.length
        width, depth = blade.chord_at(s), blade.thickness_at(s)
        if direction == "edge":
            width, depth = depth, width
        self.mass = material.density * np.pi / 4 * width * depth
        EI = material.young[0] * np.pi / 64 * width * depth**3
        powers = np.arange(2, 12)
        w = x[:, None] ** powers
        curvature = powers * (powers - 1) * x[:, None] ** (powers - 2) / length**2
        self.K = curvature.T @ (EI[:, None] * curvature) * self.ds
        self.M = w.T @ (self.mass[:, None] * w) * self.ds
        self.load = 9.81 * w.T @ self.mass * self.ds

    def deflection(self):
        """Of the tip under the weight [m]; every function is 1 there."""
        return float(np.linalg.solve(self.K, self.load).sum())

    def frequency(self):
        """First natural frequency [Hz]."""
        return float(
            np.sqrt(np.linalg.eigvals(np.linalg.solve(self.M, self.K)).real.min()) / 2 / np.pi
        )


@pytest.mark.parametrize(
    ("cell", "degree", "geometry_degree"),
    [("hexahedron", 1, 1), ("hexahedron", 2, 2), ("tetrahedron", 1, 1), ("tetrahedron", 2, 2)],
)
def test_matrices_are_those_of_the_time_step(demo, cell, degree, geometry_degree):
    blade = demo("clamped_blade").ClampedBlade(
        comm, MeshOptions(cell, geometry_degree, (1, 1, 3)), degree
    )
    K, M = blade.stiffness_and_mass()
    frame = demo("clamped_blade").FRAME
    body = FlexibleBody("blade", blade.mesh, Case().material.make(frame), 1500.0, degree)
    model = FlexibleModel(body)
    stiffness = model.new_stiffness()
    model.assemble_stiffness(model.new_vector(), 0.0, stiffness)
    # and the tangent of a step at rest, for dt^2/2 = 1: inertia, and half the stiffness
    step = FlexibleStep(model).tangent.createSubMatrix(blade.free, blade.free)
    scale = step.norm()
    step.axpy(-0.5, K)
    stiffness_alone = step.norm()
    assert stiffness_alone < 1e-3 * scale  # inertia is small beside it, so it is looked at next
    step.axpy(-1.0, M)
    # round-off of the stiffness
    assert step.norm() < 1e-13 * scale
    assert step.norm() < 1e-3 * stiffness_alone
    for ours, theirs in ((stiffness, K), (model.mass_matrix(), M)):
        part = ours.createSubMatrix(blade.free, blade.free)
        size = part.norm()
        part.axpy(-1.0, theirs)
        assert part.norm() < 1e-13 * size


def test_fine_meshes_agree_with_beams(solved):
    row = solved("tetrahedron", 2, 2, 2)
    flap, edge = Beam("flap"), Beam("edge")
    # beams have no shear, so that their frequencies are 0.2 % and, edgewise, 0.9 % too high; this
    # mesh bends 0.6 % too little
    assert row.tip == pytest.approx(flap.deflection(), rel=0.01)
    assert row.flap == pytest.approx(flap.frequency(), rel=0.01)
    assert row.edge == pytest.approx(edge.frequency(), rel=0.015)


def test_mesh_of_the_paper_locks(solved):
    linear, quadratic = (solved("hexahedron", degree, 1, 2) for degree in (1, 2))
    assert linear.volume == quadratic.volume == pytest.approx(0.9003, abs=1e-4)
    assert quadratic.tip / linear.tip == pytest.approx(2.70, abs=0.01)  # as many times too stiff
    assert linear.flap / quadratic.flap == pytest.approx(1.595, abs=0.005)
    assert linear.edge / quadratic.edge == pytest.approx(1.251, abs=0.005)
    # polygons for ellipses, on the other hand, make it too flexible
    assert quadratic.tip > 1.05 * solved("hexahedron", 2, 2, 2).tip


def test_deflection_grows_less_than_a_large_weight(demo):
    blade = demo("clamped_blade").ClampedBlade(comm, MeshOptions(elements=(1, 1, 6)), 2)
    small, large = blade.deflection(1e-3), blade.deflection(98.1)
    share = large / small * 1e-3 / 98.1
    # an elastic cantilever bent by a sixth of its length is some 5 % stiffer; a linear one is not
    assert 0.92 < share < 0.97
    # the order of the solutions does not matter
    assert blade.deflection(1e-3) == pytest.approx(small, rel=1e-8)


@pytest.mark.parallel
def test_number_of_ranks_does_not_matter(demo, solved):
    from mpi4py import MPI

    alone = demo("refinement").solve(MPI.COMM_SELF, "hexahedron", 2, 2, 2)
    together = solved("hexahedron", 2, 2, 2)
    for name in ("unknowns", "volume", "tip", "flap", "edge"):
        assert getattr(together, name) == pytest.approx(getattr(alone, name), rel=1e-9)


def test_tables_and_picture_come_from_the_rows(demo, tmp_path):
    refinement, report = demo("refinement"), demo("refinement_report")
    if comm.size > 1:
        pytest.skip("nothing is parallel here")
    levels = {"hexahedron": (1, 2), "tetrahedron": (2,)}
    rows = list(refinement.solve_all(comm, levels))
    assert len(rows) == 2 + 1 + 2 + 3
    refinement.write(rows, tmp_path / "refinement.csv")
    assert refinement.read(tmp_path / "refinement.csv") == rows
    refinement.main(["-o", str(tmp_path), "--redraw"])
    text = (tmp_path / "refinement.md").read_text(encoding="utf-8")
    assert text == report.markdown(rows)
    paper = refinement.read(tmp_path / "refinement.csv")[1]
    assert (paper.degree, paper.level, paper.unknowns) == (1, 2, 324)
    share = report.percent(paper.tip / report.limits(rows)["tip"] - 1.0)
    assert f"| linear hexahedra | 2 | 324 | -10.0 % | {share} |" in text
    assert share == "-61.0 %"
    assert (tmp_path / "refinement.png").stat().st_size > 20_000


def test_limit_is_the_finest_value_where_there_is_no_law(demo):
    report, Row = demo("refinement_report"), demo("refinement").Row
    rows = [
        Row("hexahedron", 2, 2, n, 1, 1.0, tip, 1.0 + 2.0**-n, 1.0, 0.0)
        for n, tip in ((1, 1.0), (2, 3.0), (4, 2.0))
    ]
    assert report.limits(rows)["tip"] == 2.0
