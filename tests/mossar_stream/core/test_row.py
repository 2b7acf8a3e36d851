"""Tests of the rows' layout."""

import pytest

from mossar_stream.core.row import CACHE_LINE, new_memory


@pytest.mark.parametrize("count", [1, 3, 64])
def test_memory_for_rows_is_zero_and_begins_with_a_line_of_the_cache(count):
    rows = new_memory(count, 5 * CACHE_LINE)
    assert rows.shape == (count, 5 * CACHE_LINE)
    assert all(row.ctypes.data % CACHE_LINE == 0 for row in rows)
    assert not rows.any()
    rows[:] = 1  # it may be written to
