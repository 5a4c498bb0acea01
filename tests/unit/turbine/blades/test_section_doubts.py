"""Claims about warnings from sections: coarse meshes, matrices that are not the layup's."""

import pytest
from windio_files import find_turbine, small_turbine, write_turbine

from turbine_fenicsx import Case
from turbine_fenicsx.turbine.blades.section_doubts import list_section_doubts

IEA15, IEA22 = "IEA-15-240-RWT.yaml", "IEA-22-280-RWT.yaml"


@pytest.mark.parametrize(
    ("name", "keys", "start"),
    [
        (IEA22, {"mesh": {"span": 12, "around": 16}}, "mesh.around = 16: cells are too coarse"),
        (IEA22, {"mesh": {"span": 12, "around": 24}}, None),
        (IEA15, {"blade": {"model": "beam", "damping": 0.0}}, "{file}: the matrices of beams are"),
        (IEA22, {"blade": {"model": "beam", "damping": 0.0}}, None),
    ],
)
def test_more_than_five_percent_is_a_sentence(name, keys, start):
    file = str(find_turbine(name))
    found = list_section_doubts(Case.parse({"turbine": {"file": file}, **keys}))
    assert len(found) == (start is not None)
    assert all(each.startswith(start.format(file=file)) and "GJ" in each for each in found)


def test_nothing_is_said_where_sections_do_not_count(tmp_path):
    assert list_section_doubts(Case.parse({})) == []
    file = str(write_turbine(small_turbine(), tmp_path))
    for turbine in {"model": "rigid"}, {"model": "hybrid"}:
        case = Case.parse({"turbine": {"file": file, **turbine}, "mesh": {"file": "a.msh"}})
        assert list_section_doubts(case) == []
