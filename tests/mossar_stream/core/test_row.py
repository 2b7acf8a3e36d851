"""Tests of the rows' layout."""

import pytest

from mossar_stream.core.kernels import CACHE_LINE, RECORDS
from mossar_stream.core.row import new_memory


@pytest.mark.parametrize("count", [1, 3, 64])
def test_memory_for_rows_is_zero_and_begins_with_a_line_of_the_cache(count):
    rows = new_memory(count, 5 * CACHE_LINE)
    assert rows.shape == (count, 5 * CACHE_LINE)
    assert all(row.ctypes.data % CACHE_LINE == 0 for row in rows)
    assert not rows.any()
    rows[:] = 1  # it may be written to


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
