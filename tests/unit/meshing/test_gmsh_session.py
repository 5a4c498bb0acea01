"""Claims about work of rank 0 with gmsh; every rank runs every test."""

import signal

import pytest
from rotor_meshes import arrays, arrays_of, comm

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing import MeshError
from turbine_fenicsx.meshing.session import gmsh_session, is_open

pytestmark = pytest.mark.parallel


def test_rank0_alone_works_and_all_ranks_get_the_result():
    calls = []
    assert on_rank0(comm, lambda: calls.append(comm.rank) or 42) == 42
    assert calls == ([0] if comm.rank == 0 else [])


def test_an_exception_of_rank0_is_raised_on_all_ranks():
    class Unpicklable(Exception):
        pass

    def fail(error):
        raise error

    with pytest.raises(MeshError, match=r"^no$"):
        on_rank0(comm, lambda: fail(MeshError("no")))
    with pytest.raises(KeyboardInterrupt):
        on_rank0(comm, lambda: fail(KeyboardInterrupt()))
    with pytest.raises(Unpicklable if comm.rank == 0 else RuntimeError, match=r"local"):
        on_rank0(comm, lambda: fail(Unpicklable("local")))


def test_gmsh_leaves_no_trace(capfd):
    def handler(*_):
        pass

    previous = signal.signal(signal.SIGINT, handler)
    try:
        with pytest.raises(MeshError, match=r"gmsh reports: .*99"), gmsh_session() as gmsh:
            gmsh.model.mesh.getElements(3, 99)
        assert signal.getsignal(signal.SIGINT) is handler
    finally:
        signal.signal(signal.SIGINT, previous)
    assert not is_open(gmsh)
    with gmsh_session() as gmsh:
        assert gmsh.model.getEntities() == []
    assert capfd.readouterr() == ("", "")


def test_a_gmsh_in_use_keeps_its_model_and_options():
    import gmsh

    handler = signal.getsignal(signal.SIGINT)
    gmsh.initialize()
    try:
        gmsh.model.add("mine")
        gmsh.model.add("another")
        gmsh.model.setCurrent("mine")
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.Algorithm", 8)
        models = gmsh.model.list()
        arrays_of.cache_clear()
        arrays("tetrahedron", 1, size=1.5)
        assert gmsh.model.list() == models
        assert gmsh.model.getCurrent() == "mine"
        assert gmsh.option.getNumber("Mesh.Algorithm") == 8
    finally:
        gmsh.finalize()
        signal.signal(signal.SIGINT, handler)
