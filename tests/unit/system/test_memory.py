"""Memories of several parts do not mix."""

import numpy as np

from turbine_fenicsx.system.restart_data import Memory


def example():
    """A memory with one entry of each kind."""
    return Memory({"time": 0.1}, {"q": np.arange(3.0)}, {"u": (np.ones((2, 3)),)})


def test_a_part_comes_back_as_it_was_taken_in():
    memory = Memory({"step": 0.02})
    memory.add("state", example())
    part = memory.part("state")
    assert part.numbers == {"time": 0.1}
    assert list(part.arrays) == ["q"] and list(part.nodal) == ["u"]
    assert np.array_equal(part.arrays["q"], np.arange(3.0))
    assert memory.numbers == {"step": 0.02, "state.time": 0.1}


def test_parts_may_have_parts():
    inner, outer = Memory(), Memory()
    inner.add("factor", example())
    outer.add("solver", inner)
    assert outer.part("solver").part("factor").numbers == {"time": 0.1}


def test_a_name_that_begins_like_another_is_another():
    memory = Memory()
    memory.add("state", Memory({"a": 1}))
    memory.add("states", Memory({"a": 2}))
    memory.add("state.a", Memory({"b": 3}))
    assert memory.part("state").numbers == {"a": 1, "a.b": 3}
    assert memory.part("states").numbers == {"a": 2}
    assert not memory.part("stat")


def test_a_memory_is_true_if_there_is_anything_in_it():
    assert not Memory()
    assert Memory({"x": 0})
    assert Memory(arrays={"x": np.zeros(1)})
    assert Memory(nodal={"x": ()})


def test_memories_do_not_share_their_defaults():
    first = Memory()
    first.numbers["x"] = 1
    assert not Memory()
