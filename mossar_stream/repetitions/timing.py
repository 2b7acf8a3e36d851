"""Timing: where repetitions begin and end, and how long they take, from the cycles that are counted."""

import numpy as np

from mossar_stream.jit.decorators import kernel

# Between cycles, whose median is the period: one that was missed does not count, and four, for where samples fall makes
# those of fast movements longer and shorter in turn.
INTERVALS = 4
# Cycles without a new one, after which nothing repeats any more, besides the time between looks.
LONGEST_SILENCE = 1.5
LOWER, UPPER = np.arange(
    2
)  # as numpy integers: a Python integer would make numba compile a version for each value


@kernel
def time_cycles(header, first):
    """Set where the remembered repetitions begin and end, and their periods, samples.

    Args:
        header: `HEADER` record.
        first: Place of the first of them that may have changed.
    """
    for place in range(first, header.cycles):
        row = header.cycle[place]
        row.begins, row.ends, row.period = (
            _begin_of(header, place),
            _end_of(header, place),
            _period(header, place),
        )


@kernel
def _period(header, place):
    """Return the duration of a cycle, the median of the last ones of its bout; NaN for the first.

    While there are too few before it, those after it count, too.
    """
    begin = place - min(header.cycle[place].count - 1, INTERVALS, place)
    if begin == place:
        return np.nan
    end, beyond = place, min(begin + INTERVALS, header.cycles - 1)
    while end < beyond and header.cycle[end + 1].count > 1:
        end += 1
    return max(0.25 * (_ranked(header, begin, end, LOWER) + _ranked(header, begin, end, UPPER)), 1.0)


@kernel
def _ranked(header, begin, end, upper):
    """Return the lower or upper median of what passes between cycles, twice in samples."""
    count = end - begin
    rank = (count - 1 + upper) // 2
    for i in range(count):
        passed = _passed(header, begin + i)
        below = 0
        for k in range(count):
            other = _passed(header, begin + k)
            below += other < passed or (other == passed and k < i)
        if below == rank:
            return passed
    return 0.0


@kernel
def _passed(header, place):
    """Return how much later the next cycle is half way out and back, samples, added up."""
    one, other = header.cycle[place], header.cycle[place + 1]
    return other.out + other.back - one.out - one.back


@kernel
def _begin_of(header, place):
    """Return where a repetition begins; in a bout between passing half way back and half way out again."""
    row = header.cycle[place]
    if place > 0 and row.count > 1 and header.cycle[place - 1].turned == row.turned:
        before = header.cycle[place - 1]
        return _middle(before) if row.turned else 0.5 * (before.back + row.out + 1)
    begin = 2.0 * row.start - row.far if row.turned else max(row.start, 2.0 * row.out - row.far)
    earliest = 0.0 if place == 0 else _own_end(header.cycle[place - 1])
    return max(begin, earliest) + 0.5


@kernel
def _end_of(header, place):
    """Return where a repetition ends."""
    row = header.cycle[place]
    if place + 1 < header.cycles and not row.turned:
        after = header.cycle[place + 1]
        if after.count > 1 and not after.turned:
            return _begin_of(header, place + 1)
    return _own_end(row) + 0.5


@kernel
def _own_end(row):
    """Return where a repetition ends that nothing follows, half a sample early."""
    # Where it rests the extreme is anywhere: movements end as long after half way as they began before it.
    return _middle(row) - 0.5 if row.turned else min(float(row.end), 2.0 * row.back - row.far)


@kernel
def _middle(row):
    """Return the middle between passing half way out and half way back."""
    return 0.5 * (row.out + row.back + 1.0)
