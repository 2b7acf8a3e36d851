"""Run: chunks of frames of one performer or of many, with all that follows from them, in one compiled call.

`advance` and `act` are linked: single frames call them on their own.
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

OUTBOX_FULL = STOPS  # what the caller must do, besides what `advance` asks for
ADVANCE, ACT = "mossar.advance", "mossar.act"
_advance = linked(ADVANCE, int64)(advance)
_act = linked(ACT, void)(update_window)
FOLLOWS = np.int64(FOLLOW)


@entry_point(makes_arrays=False)
def run(
    memory: NDArray[np.uint8],
    rows: NDArray[np.int64],
    begins: NDArray[np.int64],
    ends: NDArray[np.int64],
    cursor: NDArray[np.int64],
    params: NDArray[np.void],
    positions: NDArray[np.float32],
    times: NDArray[np.float64],
    room: NDArray[np.uint8],
    outbox: NDArray[np.uint8],
    most: int,
) -> int:
    """Take frames in until they are used up or the caller must do something.

    Args:
        memory: (P, row) bytes, the pool.
        rows: (m,) rows of the performers whose frames these are.
        begins: (m,) where each one's frames begin.
        ends: (m,) where they end.
        cursor: (2,) which performer is next, and how many of its frames were used; moved on.
        params: One-element record array of the similarity measure.
        positions: (n, J, 3) float32 m.
        times: (n,) s.
        room: Room to work in.
        outbox: Bytes of an outbox; the caller empties it.
        most: Most events that one frame can cause.

    Returns:
        DONE; TAKE_ENDS or RING_FULL before the frame that the cursor is at; OUTBOX_FULL.
    """
    events = part(outbox, 0, EVENT, (len(outbox) // EVENT_BYTES,))
    while cursor[0] < len(rows):
        row, begin, end = rows[cursor[0]], begins[cursor[0]], ends[cursor[0]]
        while begin + cursor[1] < end:
            if events[0].row + most >= len(events):
                return OUTBOX_FULL
            here = begin + cursor[1]
            code = _advance(memory, row, params, positions[here:end], times[here:end])
            cursor[1] += code // STOPS
            stop = code % STOPS
            if stop == HAPPENED:
                _act(memory, row, params, room, outbox, FOLLOWS)
            elif stop != DONE:
                return stop  # type: ignore[no-any-return]
        cursor[0] += 1
        cursor[1] = 0
    return DONE
