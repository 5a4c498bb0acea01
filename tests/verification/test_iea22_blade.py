"""Hollow blades of ``demos/verification`` on coarse meshes, and their references anew."""

import pytest
from runs import comm
from windio_files import IEA_22, find_turbine


@pytest.fixture(scope="module")
def blade(published):
    """The benchmark of the blade of IEA-22."""
    find_turbine(IEA_22)
    return published.load("iea22_blade")


def test_references_are_those_of_a_beam_with_the_matrices_of_the_file(published, blade):
    found = blade.solve_beam(100)
    for name, reference in published.references("iea22_blade").items():
        # 100 elements in place of 200: 4e-4 for the highest mode
        assert found[name] == pytest.approx(reference.value, rel=5e-4), name


@pytest.mark.slow
def test_coarse_solid_moves_like_the_beam(published, blade):
    found = blade.solve((20, 24), moments=True, comm=comm)
    for name, reference in published.references("iea22_blade").items():
        assert found[name] == pytest.approx(reference.value, abs=reference.tolerance), name


def test_coarse_sections_and_layers_agree_with_the_file(blade):
    rows = blade.sections((40, 32))
    assert len(rows) == 6 * 4 + 1
    assert [row.quantity for row in rows if not row.holds] == []
    edgewise = [row for row in rows if row.quantity.startswith("EI edgewise")]
    # reinforcements keep their wall up to the panels beside them: 4 % without
    assert max(abs(row.error / row.reference) for row in edgewise[1:]) < 0.01


@pytest.mark.slow
def test_the_free_rotor_keeps_energy_and_momentum(blade, published, shared_tmp_path):
    compute = published.load("spinning_rotor", "compute")
    found = compute.simulate(shared_tmp_path, end=2.0, comm=comm)
    assert found["steps"] == 20 and found["halved_steps"] == found["solver_fallbacks"] == 0
    assert found["revolutions"] == pytest.approx(2.0 * 8.0 / 60.0, rel=2e-3)
    assert found["edge_swing"] > 0.01  # [m]
    # measured: 3e-13, 4e-13, 3e-13, 1e-14
    assert found["energy_drift"] < 5e-12
    assert found["energy_balance"] < 5e-12
    assert found["vertical_momentum"] < 5e-12
    assert found["constraints"] < 1e-12


def test_the_long_run_of_the_free_rotor_holds(published):
    run, compute = (published.load("spinning_rotor", name) for name in ("run", "compute"))
    found = published.read_long_run("spinning_rotor")
    assert found["steps"] == round(compute.END / found["step"])
    assert found["revolutions"] > 99.9
    assert found["edge_swing"] > 0.05 and found["flap_swing"] > 0.03  # [m]
    assert found["halved_steps"] == found["solver_fallbacks"] == 0
    assert [row.quantity for row in run.main() if not row.holds] == []
