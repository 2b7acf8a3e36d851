"""Dwells: stretches of slow frames, and the frame in the middle of the one near a key frame."""

import numpy as np
import pytest

from mossar_stream.core.kernels import (
    DWELL_GAP,
    LATE_DWELL,
    NEAR_DWELL,
    NO_DWELL,
    RECORDS,
    pause_frame,
)

FPS = 100.0


def middle(slow_spans, time, seconds=4.0):
    """Return the frame in the middle of the dwell near a time, s, where the performer is slow in these spans, s."""
    times = np.arange(round(seconds * FPS)) / FPS
    slow = np.zeros(len(times), np.uint8)
    for begin, end in slow_spans:
        slow[round(begin * FPS) : round(end * FPS) + 1] = 1
    return pause_frame(np.zeros(1, RECORDS["Row"]["dwells"]), slow, times, time)


@pytest.mark.parametrize("time", [1.0 - NEAR_DWELL + 0.02, 1.0, 1.9, 2.0 + NEAR_DWELL - 0.02])
def test_the_frame_lies_in_the_middle_of_the_dwell(time):
    assert middle([(1.0, 2.0)], time) / FPS == pytest.approx(1.5 - LATE_DWELL, abs=0.03)


@pytest.mark.parametrize("time", [1.0 - NEAR_DWELL - 0.02, 2.0 + NEAR_DWELL + 0.02])
def test_a_dwell_that_is_far_is_none(time):
    assert middle([(1.0, 2.0)], time) == NO_DWELL
    assert middle([], time) == NO_DWELL


def test_a_short_gap_does_not_end_a_dwell_and_a_longer_one_does():
    short, long = (middle([(1.0, 1.5), (1.5 + gap, 2.5)], 1.1) for gap in (DWELL_GAP, DWELL_GAP + 0.02))
    assert short / FPS == pytest.approx(1.75 - LATE_DWELL, abs=0.03)
    assert long / FPS == pytest.approx(1.25 - LATE_DWELL, abs=0.03)


@pytest.mark.parametrize("earlier", range(20))
def test_of_two_as_near_the_earlier_one_counts_whatever_came_before(earlier):
    begin = 0.5 * earlier + 1.0
    spans = [
        *((0.5 * place, 0.5 * place + 0.1) for place in range(earlier)),
        (begin, begin),
        (begin + 0.4, begin + 0.4),
    ]
    assert middle(spans, begin + 0.2, begin + 1.0) / FPS == pytest.approx(begin - LATE_DWELL, abs=0.03)
