"""Labels: candidates end repetitions of even bouts; in uneven ones they are labelled by the evidence alone."""

import numpy as np
import pytest

from checks.reference import motion as reference_motion
from mossar_stream.core.kernels import (
    ENDS,
    NOTED_CANDIDATES,
    RECORDS,
    UNLABELLED,
    WITHIN,
    label_candidates,
)

ORIGIN = 5.0  # s


def records(kind, count=1):
    return np.zeros(count, kind)


def bouts(*periods):
    """Return a header of bouts of repetitions with these periods, s, 20 s of rest between, and the same as a table."""
    headers, at, rows = records(RECORDS["Periods"]), 0.0, []
    for bout in periods:
        for count, period in enumerate(bout, 1):
            rows.append((at, at + period, period, count))
            at += period
        at += 20.0
    header = headers[0]
    header["clear"], header["cycles"], header["origin"] = 1, len(rows), ORIGIN
    for place, (begin, end, period, count) in enumerate(rows):
        cycle = header["cycle"][place]
        cycle["begins"], cycle["ends"], cycle["count"] = begin, end, count
        cycle["period"] = np.nan if count == 1 else period
    return headers, np.array(rows) + np.array([ORIGIN, ORIGIN, 0.0, 0.0])


def labelled(headers, times, speeds=None, ways=None):
    """Return the labels of candidates in the rest pose, at rest or as fast as `speeds` say, V."""
    state, notes = records(RECORDS["Row"]["labels"]), records(RECORDS["Note"], NOTED_CANDIDATES)
    found = np.zeros(len(times), np.int64)
    speeds = np.full(len(times), 0.1) if speeds is None else np.array(speeds)
    label_candidates(state, notes, headers, np.asarray(times, np.float64), speeds, found, ways)
    return found.tolist()


def way(begins, ends, leaves=np.inf):
    """Return the latest way out and back, s; the next one begins when the performer leaves."""
    ways = records(RECORDS["Row"]["ways"])
    ways["begins"], ways["ends"], ways["leaves"] = begins, ends, leaves
    return ways


def test_in_an_even_bout_one_candidate_a_period_ends_a_repetition():
    headers, _ = bouts([2.0, 2.2, 1.9, 2.0])
    ends = ORIGIN + np.cumsum([2.0, 2.2, 1.9, 2.0])
    found = labelled(headers, np.sort([*ends, *(ends - 0.7)]))
    assert found == [WITHIN, ENDS] * 4


@pytest.mark.parametrize("periods", [[1.0, 2.4, 2.4], [2.0, 2.0, 0.9], [0.6, 3.3, 0.6, 3.3]])
def test_in_an_uneven_bout_no_candidate_is_judged(periods):
    headers, table = bouts(periods)
    ends = ORIGIN + np.cumsum(periods)
    assert labelled(headers, ends) == [UNLABELLED] * len(periods)
    assert [reference_motion._period_at(table, time) for time in ends] == [0.0] * len(periods)


def test_bouts_are_even_each_by_itself():
    headers, table = bouts([0.6, 0.6], [2.5, 2.5, 2.5], [1.0, 3.0])
    times = ORIGIN + np.array([1.1, 26.2, 52.6])
    assert labelled(headers, times) == [ENDS, ENDS, UNLABELLED]
    assert [reference_motion._period_at(table, time) for time in times] == [0.6, 2.5, 0.0]


NOTHING = records(RECORDS["Periods"])


def test_before_anything_is_counted_the_way_out_and_back_is_a_repetition():
    times, speeds = [0.5, 2.0, 3.0, 4.2, 4.6, 5.0, 8.0], [0.1, 0.1, 0.1, 0.3, 0.1, 0.2, 0.1]
    found = labelled(NOTHING, times, speeds, way(1.0, 4.0))
    assert found == [UNLABELLED, WITHIN, WITHIN, WITHIN, ENDS, WITHIN, UNLABELLED]
    assert labelled(NOTHING, times, speeds) == [UNLABELLED] * len(times)


def test_what_is_on_the_next_way_out_ends_nothing():
    times, speeds = [4.2, 4.6, 5.0], [0.3, 0.2, 0.1]
    assert labelled(NOTHING, times, speeds, way(1.0, 4.0, leaves=4.8)) == [WITHIN, ENDS, UNLABELLED]


def test_what_is_counted_has_the_labels_and_no_way_has():
    headers, _ = bouts([2.0, 2.2, 1.9, 2.0])
    ends = ORIGIN + np.cumsum([2.0, 2.2, 1.9, 2.0])
    assert labelled(headers, ends, ways=way(ORIGIN, ORIGIN + 8.0)) == [ENDS] * 4
