"""Claims about the memory of the machines."""

import os
import resource

import pytest

from turbine_fenicsx.foundation import machine
from turbine_fenicsx.foundation.machine import machine_memory

pytestmark = pytest.mark.parallel


def test_memory_of_this_machine_is_that_of_the_ranks_on_it(comm):
    here = machine_memory(comm)
    assert 1e8 < here <= float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    try:
        resource.setrlimit(resource.RLIMIT_AS, (50 * 10**9, hard))
        assert machine_memory(comm) == min(here, 50e9 * comm.size)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def test_container_gives_less_than_the_machine(comm, tmp_path, monkeypatch):
    limit = tmp_path / "memory.max"
    monkeypatch.setattr(machine, "_LIMITS", (str(limit), "/no/such/file"))
    limit.write_text("123000000\n")
    assert machine_memory(comm) == 123e6
    limit.write_text("max\n")
    assert machine_memory(comm) > 123e6
