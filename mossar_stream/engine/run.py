"""Run: chunks of frames of one performer or of many, with all that follows from them, in one compiled call.

`advance` and `update_window` are linked: single frames call them on their own.
"""

import numpy as np
from numba import int64, void
from numpy.typing import NDArray

from mossar_stream.algorithm.frame_step import DONE, HAPPENED, STOPS, advance
from mossar_stream.algorithm.window_step import FOLLOW, update_window
from mossar_stream.jit.decorators import entry_point
from mossar_stream.jit.linked import linked
from mossar_stream.jit.views import part
from mossar_stream.memory.event_buffer import EVENT, EVENT_BYTES

BUFFER_FULL = STOPS  # what the caller must do, besides what `advance` asks for
ADVANCE, UPDATE = "mossar.advance", "mossar.update_window"
advance_by_name = linked(ADVANCE, int64)(advance)
update_window_by_name = linked(UPDATE, void)(update_window)
FOLLOWS = np.int64(FOLLOW)


@entry_point(makes_arrays=False)
def run(
    memory: NDArray[np.uint8],
    params: NDArray[np.void],
    buffers: tuple[NDArray[np.uint8], NDArray[np.uint8], int],
    batch: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]],
    positions: NDArray[np.float32],
    times: NDArray[np.float64],
) -> int:
    """Take frames in until they are used up or the caller must do something.

    Args:
        memory: (P, row) bytes, the pool.
        params: One-element record array of the similarity measure.
        buffers: Scratch; an event buffer, which the caller empties; most events that one frame can cause.
        batch: (m,) rows of the performers whose frames these are; (m,) where each one's frames begin; (m,) where they
            end; (2,) cursor: which performer is next, and how many of its frames were used, moved on.
        positions: (n, J, 3) float32 m.
        times: (n,) s.

    Returns:
        DONE; TAKE_ENDS, LOOK_DUE, RING_FULL or WINDOW_FULL before the frame that the cursor is at; BUFFER_FULL.
    """
    scratch, event_buffer, most = buffers
    rows, begins, ends, cursor = batch
    events = part(event_buffer, 0, EVENT, (len(event_buffer) // EVENT_BYTES,))
    while cursor[0] < len(rows):
        row, begin, end = rows[cursor[0]], begins[cursor[0]], ends[cursor[0]]
        while begin + cursor[1] < end:
            if events[0].row + most >= len(events):
                return BUFFER_FULL
            here = begin + cursor[1]
            code = advance_by_name(memory, row, params, positions[here:end], times[here:end])
            cursor[1] += code // STOPS
            stop = code % STOPS
            if stop == HAPPENED:
                update_window_by_name(memory, row, params, scratch, event_buffer, FOLLOWS)
            elif stop != DONE:
                return stop  # type: ignore[no-any-return]
        cursor[0] += 1
        cursor[1] = 0
    return DONE
