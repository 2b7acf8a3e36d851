"""The range of a component: from whatever numbers it is computed, it ends, and is a number."""

import numpy as np
import pytest

from mossar_stream.core.kernels import BINS
from mossar_stream.core.kernels import swing_range_of as range_of

WAVE = np.sin(np.linspace(0, 12, 120)).astype(np.float32)


def with_some(value, places):
    scores = WAVE.copy()
    scores[places] = value
    return scores


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 3e38, -3e38])
@pytest.mark.parametrize("places", [slice(None), [0], [60], [-1], slice(0, 110), slice(10, None)])
def test_it_ends_whatever_the_numbers(value, places):
    counts = np.zeros(BINS, np.int32)
    found = range_of(with_some(value, places), counts)
    assert 0.0 <= found < np.inf
    assert (counts >= 0).all()


def test_what_is_no_number_is_left_out():
    counts = np.zeros(BINS, np.int32)
    whole = range_of(WAVE, counts)
    assert whole == pytest.approx(np.quantile(WAVE, 0.9) - np.quantile(WAVE, 0.1), rel=0.1)
    assert range_of(with_some(np.nan, [5, 60]), counts) == pytest.approx(whole, rel=0.1)
