"""Claims about what ``check`` says of a mesh."""

import pytest

from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run.inspection import inspect_mesh, list_damping_mistakes
from turbine_fenicsx.turbine.run.summary import count_unknowns

pytestmark = pytest.mark.parallel


@pytest.mark.parametrize(
    "tables",
    [
        {"mesh": {"elements": [2, 1, 4], "degree": 2}},
        {"mesh": {"elements": [1, 2, 3]}, "pitch": {"bearings": True}},
        {"mesh": {"cell": "tetrahedron", "size": "2.5 m", "degree": 2}},
        {"mesh": {"span": 5, "around": 8}, "blade": {"wall": ["60 mm", "40 mm", "10 mm"]}},
    ],
    ids=str,
)
def test_unknowns_are_those_of_the_turbine(comm, tables):
    case = Case.parse(tables)
    found = inspect_mesh(case, comm)
    counted = count_unknowns(build_turbine(case, comm))
    displacements, multipliers = counted["displacements"], counted["coupling_multipliers"]
    assert found.mistakes == ()
    assert (
        f"\nunknowns: {displacements} displacements, {multipliers} coupling multipliers\n"
        in found.report
    )


def test_ratios_that_stiffness_and_mass_cannot_meet_are_found_before_a_run(comm):
    tables = {"mesh": {"elements": [1, 1, 6], "degree": 2}}
    for edge, mistakes in (("2 %", 0), ("0.001 %", 1)):
        case = Case.parse(tables | {"blade": {"damping": {"flap_1": "3 %", "edge_1": edge}}})
        found = list_damping_mistakes(case, comm)
        assert len(found) == mistakes
        assert all("blade.damping.edge_1 = 1e-05: expected" in sentence for sentence in found)
