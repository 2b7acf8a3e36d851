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


def labelled(headers, times):
    """Return the labels of candidates at rest in the rest pose."""
    state, notes = records(RECORDS["Row"]["labels"]), records(RECORDS["Note"], NOTED_CANDIDATES)
    found = np.zeros(len(times), np.int64)
    label_candidates(state, notes, headers, np.asarray(times, np.float64), found)
    return found.tolist()


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
