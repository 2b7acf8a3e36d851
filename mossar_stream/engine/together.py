"""Together: frames of many performers at once, pool by pool, in one compiled call for each."""

import functools
from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.frame_step import DONE, LOOK_DUE
from mossar_stream.engine.engine import guarded, run_rows, settle_level
from mossar_stream.engine.intake import FLOAT32, less_origin
from mossar_stream.engine.pool import Pool, Row
from mossar_stream.engine.run import BUFFER_FULL


def process_together(
    rows: Sequence[Row], chosen: Sequence[int], frames: NDArray[Any], times: NDArray[np.float64]
) -> list[tuple[int, int]]:
    """Process as many frames of each of many performers.

    Args:
        rows: P rows.
        chosen: Whose frames: places in `rows`, of takes that go on with a known place.
        frames: (P, n, J, 3) m, in single or double precision.
        times: (P, n) s.

    Returns:
        Who needs to be looked after, as the take ends or the row must grow, and how many of its frames were processed;
        the others are processed by then.
    """
    own = [rows[k] for k in chosen]
    if not own:
        return []
    is_plain = frames.dtype is FLOAT32 and all(row.origin is None for row in own)
    if len(own) < len(rows) or not is_plain:
        frames = np.stack([less_origin(row, frames[k]) for k, row in zip(chosen, own, strict=True)])
        times = times[chosen]
    return [(chosen[i], used) for i, used in _process(own, frames, times)]


def _process(
    rows: Sequence[Row], positions: NDArray[np.float32], times: NDArray[np.float64]
) -> list[tuple[int, int]]:
    """Do so for all rows, in single precision."""
    count, rests = positions.shape[1], []
    frames = positions.reshape(-1, *positions.shape[2:]), times.reshape(-1)
    by_pool: dict[Pool, list[int]] = defaultdict(list)
    for k, row in enumerate(rows):
        by_pool[row.pool].append(k)
    # First those who have a pool of their own.
    for pool, members in sorted(by_pool.items(), key=lambda item: len(item[0].memory)):
        own = [rows[k] for k in members]
        work = functools.partial(_process_pool, pool, own, (np.array(members) * count, count), frames)
        try:
            rests += [(members[i], used) for i, used in guarded(pool.buffers.guard, work)]
        except BaseException:
            for row in own:
                row.tear()
            raise
    return rests


def _process_pool(
    pool: Pool,
    own: Sequence[Row],
    places: tuple[NDArray[np.int64], int],
    frames: tuple[NDArray[np.float32], NDArray[np.float64]],
) -> list[tuple[int, int]]:
    """Do so for rows of one pool; where their frames begin, and how many each has."""
    for row in [row for row in own if row.is_level_new]:
        settle_level(row)
    begins, count = places
    batch = np.array([row.index for row in own]), begins, begins + count, np.zeros(2, np.int64)
    rests, cursor = [], batch[-1]
    stop = BUFFER_FULL
    while stop != DONE:
        stop = run_rows(pool, own, batch, frames)
        if stop not in (DONE, BUFFER_FULL):
            k, used = cursor.tolist()
            if stop == LOOK_DUE:
                own[k].look_at_repetitions(frames[1][int(begins[k]) + used])
            else:
                rests.append((k, used))
                cursor[:] = k + 1, 0
    return rests
