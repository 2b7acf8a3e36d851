"""Tests of the rows' layout."""

import pytest

from mossar_stream import Settings, Skeleton
from mossar_stream.core.kernels import CACHE_LINE, RECORDS, row_parts
from mossar_stream.core.plan import Plan
from mossar_stream.core.row import records, region


@pytest.mark.parametrize("level", ["motion", "posture"])
@pytest.mark.parametrize("joints", [2, 31, 64])
def test_arrays_of_a_row_begin_with_a_line_of_the_cache_and_follow_each_other(level, joints):
    skeleton = Skeleton(tuple(f"j{j}" for j in range(joints)), (-1, *range(joints - 1)))
    plan = Plan(skeleton, Settings(level=level))
    row = plan.new_row()
    at = RECORDS["Row"].fields["at"][0].names
    places = [int(records(row)["at"][name]) for name in at]
    assert row.ctypes.data % CACHE_LINE == 0
    assert len(row) == plan.row_bytes == places[-1]
    assert places == sorted(places)
    assert not any(place % CACHE_LINE for place in places)
    for name in row_parts(row):
        part = region(row, name)
        behind = places[at.index(name) + 1]
        assert (
            places[at.index(name)] + part.nbytes <= behind < places[at.index(name)] + part.nbytes + CACHE_LINE
        )


def kinds_in(record):
    """Yield the kinds of all numbers in a record."""
    if record.subdtype:
        yield from kinds_in(record.subdtype[0])
    elif record.fields:
        for field, _ in record.fields.values():
            yield from kinds_in(field)
    else:
        yield record.kind


@pytest.mark.parametrize("name", RECORDS)
def test_records_have_fields_of_whole_numbers_and_numbers(name):
    # To Cython a struct of two doubles is a complex number, without fields.
    assert RECORDS[name].names
    assert set(kinds_in(RECORDS[name])) <= {"i", "u", "f"}
