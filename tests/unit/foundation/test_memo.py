"""Claims about a function that remembers its last value."""

import numpy as np

from turbine_fenicsx.foundation.memo import Memo


def counted(function):
    """The function with memory, and the arguments for which it was evaluated."""
    calls = []

    def evaluate(*arguments):
        calls.append(arguments)
        return function(*arguments)

    return Memo(evaluate), calls


def test_the_same_arguments_are_evaluated_once():
    memo, calls = counted(lambda x, y: x + y)
    x, y = np.arange(3.0), np.ones(3)
    first = memo(x, y)
    assert np.array_equal(first, [1.0, 2.0, 3.0])
    assert memo(x.copy(), y.copy()) is first  # equal bit for bit
    assert len(calls) == 1


def test_other_arguments_are_evaluated_again():
    memo, calls = counted(lambda x, y: x + y)
    x, y = np.arange(3.0), np.ones(3)
    for arguments in ((x, y), (y, x), (x, np.nextafter(y, 2.0)), (x[:2], y[:2]), (x, y)):
        assert np.array_equal(memo(*arguments), arguments[0] + arguments[1])
    assert len(calls) == 5  # only the last is kept


def test_an_array_that_was_changed_in_place_is_another():
    memo, calls = counted(lambda x: 2.0 * x)
    x = np.ones(3)
    memo(x)
    x[1] = 5.0
    assert np.array_equal(memo(x), [2.0, 10.0, 2.0])
    assert len(calls) == 2


def test_zeros_of_both_signs_and_numbers_that_are_none_are_told_apart_by_their_bits():
    memo, calls = counted(np.sign)
    memo(np.array([0.0]))
    memo(np.array([-0.0]))
    assert len(calls) == 2
    nan = np.array([np.nan])
    memo(nan)
    memo(nan)
    assert len(calls) == 3


def test_objects_are_told_apart_by_identity():
    memo, calls = counted(lambda thing: thing[0])
    a, b = [1], [1]
    assert memo(a) == memo(a) == memo(b) == 1
    assert len(calls) == 2


def test_an_object_is_not_mistaken_for_one_that_is_gone():
    """A new object may get the address of the old one, unless that is kept."""
    memo = Memo(lambda thing: thing[0])
    for k in range(100):
        assert memo([k]) == k


def test_a_function_that_fails_is_asked_again_and_the_last_value_stays():
    def invert(x):
        if x[0] == 0.0:
            raise ZeroDivisionError
        return 1.0 / x[0]

    memo, calls = counted(invert)
    assert memo(np.array([2.0])) == 0.5
    for _ in range(2):
        try:
            memo(np.array([0.0]))
        except ZeroDivisionError:
            continue
        raise AssertionError
    assert memo(np.array([2.0])) == 0.5
    assert len(calls) == 3
