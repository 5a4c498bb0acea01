"""Memories of several parts do not mix."""

import numpy as np

from turbine_fenicsx.foundation.restart_data import RestartData


def example():
    """Restart data with one entry of each kind."""
    return RestartData({"time": 0.1}, {"q": np.arange(3.0)}, {"u": (np.ones((2, 3)),)})


def test_a_part_comes_back_as_it_was_added():
    data = RestartData({"step": 0.02})
    data.add("state", example())
    part = data.part("state")
    assert part.numbers == {"time": 0.1}
    assert list(part.arrays) == ["q"] and list(part.nodal) == ["u"]
    assert np.array_equal(part.arrays["q"], np.arange(3.0))
    assert data.numbers == {"step": 0.02, "state.time": 0.1}


def test_parts_may_have_parts():
    inner, outer = RestartData(), RestartData()
    inner.add("factor", example())
    outer.add("solver", inner)
    assert outer.part("solver").part("factor").numbers == {"time": 0.1}


def test_a_name_that_begins_like_another_is_another():
    data = RestartData()
    data.add("state", RestartData({"a": 1}))
    data.add("states", RestartData({"a": 2}))
    data.add("state.a", RestartData({"b": 3}))
    assert data.part("state").numbers == {"a": 1, "a.b": 3}
    assert data.part("states").numbers == {"a": 2}
    assert not data.part("stat")


def test_restart_data_are_true_if_there_is_anything_in_them():
    assert not RestartData()
    assert RestartData({"x": 0})
    assert RestartData(arrays={"x": np.zeros(1)})
    assert RestartData(nodal={"x": ()})


def test_restart_data_do_not_share_their_defaults():
    first = RestartData()
    first.numbers["x"] = 1
    assert not RestartData()
