"""Kernels that are called by name behave like kernels that are not."""

import numpy as np
import pytest
from numba import float64
from numba.core.errors import TypingError

from mossar_stream.jit.decorators import entry_point
from mossar_stream.jit.linked import linked, publish


@linked("test.mean", float64(float64[::1], float64))
def mean(values, start):
    if len(values) == 0:
        raise ValueError("no values")
    for value in values:
        start += value / len(values)
    return start


@entry_point
def twice_the_mean(values):
    return 2.0 * mean(values, 0.0)


def test_a_published_kernel_is_called_by_name():
    publish("test.mean")
    publish("test.mean")
    assert twice_the_mean(np.array([1.0, 2.0, 6.0])) == 6.0


def test_its_errors_reach_the_caller():
    publish("test.mean")
    with pytest.raises(ValueError, match="no values"):
        twice_the_mean(np.empty(0))


@entry_point
def first(values):
    return values[0]


first_of_any = linked("test.first", float64)(first)


@entry_point
def twice_the_first(values):
    return 2.0 * first_of_any(values)


def test_a_kernel_that_was_not_published_for_such_arguments_is_refused_instead_of_called():
    publish("test.first", np.ones(1))
    assert twice_the_first(np.ones(3)) == 2.0
    fixed = np.ones(3)
    fixed.flags.writeable = False
    with pytest.raises(TypingError, match=r"test\.first was not published"):
        twice_the_first(fixed)
