"""Claims about what ``check`` says of a mesh."""

import pytest

from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run.inspection import inspect_mesh
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
