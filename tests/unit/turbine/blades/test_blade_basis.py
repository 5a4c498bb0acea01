"""Claims about where the basis of reduced blades is kept."""

import pytest
from reduced_turbines import write_case

from turbine_fenicsx.turbine.blades.blade_basis import describe_blade, name_basis
from turbine_fenicsx.turbine.case.case import Case


@pytest.fixture
def path(tmp_path):
    return write_case(tmp_path)


@pytest.mark.parametrize(
    ("change", "same"),
    [
        ("wind.speed=11 m/s", True),
        ("blade.damping=0.02", True),
        ("time.step=0.02", True),
        ("aero.stations=9", True),
        ("turbine.tilt=-3 deg", True),
        ("pitch.bearings=false", True),
        ("blade.hub_radius=1.1 m", False),
        ("blade.layup=laminate", False),
        ("mesh.span=7", False),
        ("mesh.tip=closed", False),
        ("material.shear_viscosity=1e5", False),
        ("blade.reduction.functions=33", False),
        ("blade.reduction.strains=10", False),
    ],
)
def test_the_name_follows_what_the_basis_depends_on(path, change, same):
    drive = ["pitch.drive=free", "pitch.angle=0", "pitch.duration=2"]
    more = drive if "bearings" in change else []
    viscous = ["blade.damping.flap_1=0", "blade.damping.edge_1=0"] if "viscosity" in change else []
    plain, changed = (Case.load(path, x) for x in ([*more], [change, *more, *viscous]))
    assert (describe_blade(plain) == describe_blade(changed)) == same


def test_the_content_of_the_turbine_counts_and_not_its_name(path):
    before = describe_blade(Case.load(path))
    path.with_name("other.yaml").write_bytes(path.with_name("small.yaml").read_bytes())
    assert describe_blade(Case.load(path, ["turbine.file=other.yaml"])) == before
    with path.with_name("other.yaml").open("a") as file:
        file.write("# a remark\n")
    assert describe_blade(Case.load(path, ["turbine.file=other.yaml"])) != before


def test_bases_stand_beside_the_case_if_it_has_a_place(path):
    case = Case.load(path)
    assert case.folder == path.parent
    file = name_basis(case)
    assert file.parent == path.parent / "bases"
    assert not file.parent.exists()  # made with the first basis
    assert file.name.startswith("blade-")
    assert file.suffix == ".npz"
    assert name_basis(Case.load(path, ["wind.speed=12 m/s"])) == file
    assert name_basis(Case.load(path, ["mesh.span=7"])) != file
    tables = {"turbine": {"file": "small.yaml"}, "blade": {"model": "reduced"}}
    parsed = Case.parse(tables, path.parent)
    assert parsed.folder is None
    assert name_basis(parsed) is None


def test_a_case_may_name_the_folder_of_bases(path, tmp_path):
    beside = name_basis(Case.load(path))
    (tmp_path / "shared").mkdir()
    case = Case.load(path, [f"blade.reduction.folder={tmp_path / 'shared'}"])
    assert name_basis(case) == tmp_path / "shared" / beside.name


def test_a_folder_that_cannot_be_written_is_told(path, caplog):
    path.with_name("bases").write_text("a file")
    assert name_basis(Case.load(path)) is None
    assert "bases cannot be kept in" in caplog.text
