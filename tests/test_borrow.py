"""Borrowed arrays: the same memory, alone and in nested tuples."""

from collections import namedtuple

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError

from radiosity.transport.borrow import borrowed

Pair = namedtuple("Pair", "array count")


@njit
def double_rows(value, other):
    pair, arrays = borrowed((value, (other, other[1:])))
    for k in range(pair.count):
        pair.array[k] *= 2.0
    return pair.array.sum() + arrays[1].sum()


def test_borrowed_arrays_are_the_same_memory():
    array, other = np.arange(6.0).reshape(3, 2), np.array([5.0, 7.0])
    assert double_rows(Pair(array, 2), other) == 2 * (0 + 1 + 2 + 3) + 4 + 5 + 7
    assert np.array_equal(array, [[0, 2], [4, 6], [4, 5]])


@pytest.mark.parametrize("wrong", ["text", (1, "text")])
def test_nothing_else_is_borrowed(wrong):
    @njit
    def take(value):
        borrowed(value)

    with pytest.raises(TypingError, match="only arrays and numbers can be borrowed"):
        take(wrong)
