"""Claims about the memory of matrices and factors, which is counted before any is made."""

import re

import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.linear_solvers.factor import SparseFactor
from turbine_fenicsx.linear_solvers.memory import check_memory
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.modes.find_modes import ModesWanted, find_modes
from turbine_fenicsx.turbine.run.run import run_case

pytestmark = pytest.mark.parallel

ENOUGH_TO_COUNT = 0.2e9
"""Memory in which the graph of the small system fits, and its matrix does not [B]."""

SENTENCE = re.compile(
    r"(\d+) displacements need (\S+) GB of memory for (at least )?(\S+) entries of their matrix"
    r"( and (\S+) of its factor)?, the machine has \S+ GB"
    r'(; solver.linear_solver = "iterative" needs (\S+) GB)?; --force continues anyway'
)


@pytest.fixture
def memory(monkeypatch):
    """Sets the memory of the machines [B]."""
    name = "turbine_fenicsx.linear_solvers.memory.machine_memory"
    return lambda size: monkeypatch.setattr(name, lambda comm: size)


@pytest.fixture(scope="module")
def system():
    from mpi4py import MPI

    case = Case.parse({"mesh": {"elements": [4, 4, 24], "degree": 2}})
    return build_turbine(case, MPI.COMM_WORLD).system


def refusal(system, solver="frozen", shared=True):
    """The parts of the sentence with which a system is refused."""
    with pytest.raises(InputError) as error:
        check_memory(system, solver, shared)
    found = SENTENCE.fullmatch(str(error.value))
    assert found, str(error.value)
    return found


def test_entries_are_those_of_the_matrix_and_of_its_factor(comm, system, memory):
    memory(ENOUGH_TO_COUNT)
    found = refusal(system, shared=False)
    (model,) = system.flexible_models
    K = model.new_stiffness()
    model.assemble_stiffness(system.initial_state().u[0], 0.0, K)
    assert int(found[1]) == K.getSize()[0]
    entries = K.getInfo(K.InfoType.GLOBAL_SUM)["nz_used"]
    # of several ranks, what they add where they meet is not counted
    assert float(found[4]) == pytest.approx(entries, rel=0.005 if comm.size == 1 else 0.1)
    K.shift(1e9)
    factor = SparseFactor(K, "test_", symmetric=True)
    factor.update()
    used = factor._ksp.getPC().getFactorMatrix().getMumpsInfog(29)
    used = float(used) if used >= 0 else -1e6 * used
    if comm.size == 1:
        assert float(found[6]) == pytest.approx(used, rel=0.4)
    factor.destroy()


def test_equal_components_share_a_factor_and_lu_keeps_two(system, memory):
    memory(ENOUGH_TO_COUNT)
    own, shared, lu = (
        float(refusal(system, *how)[6])
        for how in (("frozen", False), ("frozen", True), ("lu", False))
    )
    assert own == pytest.approx(3.0 * shared, rel=0.05)
    assert lu == pytest.approx(2.0 * own, rel=0.02)


def test_a_graph_that_may_not_fit_is_not_made(system, memory, monkeypatch):
    monkeypatch.setattr("turbine_fenicsx.linear_solvers.memory._count_entries", None)
    memory(1e6)
    found = refusal(system)
    assert found[3] and found[5] is found[7] is None


def test_iterative_solver_is_named_only_where_it_fits(system, memory, monkeypatch):
    memory(ENOUGH_TO_COUNT)
    matrix = refusal(system, "iterative")
    assert matrix[7] is refusal(system)[7] is None
    monkeypatch.setattr("turbine_fenicsx.linear_solvers.memory.FACTOR_ENTRY", 1e3)
    memory(1.05e9 * float(matrix[2]))
    found = refusal(system)
    assert found[8] == matrix[2] and float(found[2]) > 2.0 * float(matrix[2])
    assert refusal(system, shared=False)[7] is None  # a start that needs a factor
    check_memory(system, "iterative", shared=True)
    memory(2e9 * float(found[2]))
    check_memory(system, "frozen", shared=True)


def test_runs_and_modes_that_do_not_fit_are_refused_unless_forced(comm, memory, shared_tmp_path):
    case = Case.parse({"mesh": {"elements": [1, 1, 2]}, "time": {"end": 0.04}})
    memory(1e5)
    with pytest.raises(InputError, match=r"need .* of memory .* --force continues anyway"):
        run_case(case, shared_tmp_path / "run", comm, "none")
    with pytest.raises(InputError, match=r"need .* of memory .* --force continues anyway"):
        find_modes(case, None, comm, ModesWanted(count=1))
    run_case(case, shared_tmp_path / "run", comm, "none", force=True)


def test_the_rigid_turbine_always_fits(comm, memory):
    memory(1.0)
    system = build_turbine(Case.parse({"turbine": {"model": "rigid"}}), comm).system
    check_memory(system, "frozen", shared=True)
