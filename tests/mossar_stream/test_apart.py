"""Kernels that stand apart behave like kernels that do not."""

import numpy as np
import pytest
from numba import float64

from mossar_stream.apart import apart, publish
from mossar_stream.compiled import entry_point


@apart("test.mean", float64(float64[::1], float64))
def mean(values, start):
    if len(values) == 0:
        raise ValueError("no values")
    for value in values:
        start += value / len(values)
    return start


@entry_point
def twice_the_mean(values):
    return 2.0 * mean(values, 0)


def test_a_published_kernel_is_called_by_name():
    publish("test.mean")
    publish("test.mean")
    assert twice_the_mean(np.array([1.0, 2.0, 6.0])) == 6.0


def test_its_errors_reach_the_caller():
    publish("test.mean")
    with pytest.raises(ValueError, match="no values"):
        twice_the_mean(np.empty(0))
