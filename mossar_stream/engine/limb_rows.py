"""Limb rows: the rows of one performer's limbs lie in one block, so that one compiled call takes a frame in for all.

A call of its own for each limb would cost more than what it does. Which frames are taken in the body has decided.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.frame_step import DONE, HAPPENED, STOPS
from mossar_stream.algorithm.row import ROW, new_memory
from mossar_stream.engine.pool import Row
from mossar_stream.engine.run import FOLLOWS, advance_by_name, update_window_by_name
from mossar_stream.events import Event
from mossar_stream.jit.decorators import entry_point, inline_kernel
from mossar_stream.jit.views import part
from mossar_stream.memory.event_buffer import EVENT, EVENT_BYTES
from mossar_stream.repetitions.state import HEADER, adopt

ONE_DONE, ONE_HAPPENED = np.int64(STOPS + DONE), np.int64(STOPS + HAPPENED)
OWN_ROW = np.int64(0)
LINE = 64  # bytes
HEAD = np.dtype([(name, "i8") for name in ("limbs", "joints", "table", "order", "frame", "time")])
LIMB = np.dtype(
    [
        ("row", "i8"),  # where in the block its row begins, bytes
        ("row_bytes", "i8"),
        ("frame", "i8"),  # where its joints begin, bytes
        ("joints", "i8"),
    ],
)


@entry_point(makes_arrays=False)
def advance_limbs(
    block: NDArray[np.uint8],
    params: NDArray[np.void],
    positions: NDArray[np.float32],
    body: NDArray[np.uint8],
    scratch: NDArray[np.uint8],
    event_buffer: NDArray[np.uint8],
) -> int:
    """Take the frame that the body took in last in for all limbs, with all that follows from it.

    Args:
        block: Bytes: `HEAD`, rows, a `LIMB` each, the joints of all, one after the other, their positions and the time.
        params: (L,) records, those of the similarity measure for each limb.
        positions: (1, J, 3) float32 m, the performer's.
        body: (1, row) bytes of the performer.
        scratch: Of `new_scratch`, large enough for each limb.
        event_buffer: Gets the events, with the limbs' places for rows.

    Returns:
        How many limbs took it in; the caller must see to the others.
    """
    head = part(block, 0, HEAD, (1,))[0]
    limbs = part(block, head.table, LIMB, (head.limbs,))
    frame = part(block, head.frame, np.float32, (head.joints, 3))
    times = part(block, head.time, np.float64, (1,))
    events = part(event_buffer, 0, EVENT, (len(event_buffer) // EVENT_BYTES,))
    whole = part(body[0], 0, ROW, (1,))[0]
    clock = whole.clock
    counted = part(body[0], whole.at.counted, HEADER, (whole.plan.repetitions,))
    times[0] = clock.taken_time
    _gather(part(block, head.order, np.int64, (head.joints,)), positions, frame)
    for i in range(head.limbs):
        state = part(block, limbs[i].row, ROW, (1,))[0]
        _catch_up(state.clock, clock, state.plan.max_pause)
    for i in range(head.limbs):
        limb = limbs[i]
        row = part(block, limb.row, np.uint8, (1, limb.row_bytes))
        state = part(block, limb.row, ROW, (1,))[0]
        if events[0].row + state.plan.most_events >= len(events):
            return i
        own = part(block, limb.frame, np.float32, (1, limb.joints, 3))
        if state.plan.adopts == 1:
            _follow(part(block, limb.row + state.at.adopted, HEADER, (1,))[0], counted[0])
        code = advance_by_name(row, OWN_ROW, params[i : i + 1], own, times)
        if code == ONE_HAPPENED:
            before = events[0].row
            update_window_by_name(row, OWN_ROW, params[i : i + 1], scratch, event_buffer, FOLLOWS)
            for k in range(before + 1, events[0].row + 1):
                events[k].row = i
        elif code != ONE_DONE:
            return i
    return head.limbs  # type: ignore[no-any-return]


@inline_kernel
def _gather(order: NDArray[np.int64], positions: NDArray[np.float32], frame: NDArray[np.float32]) -> None:
    """Set the joints of all limbs."""
    for k in range(len(order)):
        joint = order[k]
        if joint >= 0:
            for axis in range(3):
                frame[k, axis] = positions[0, joint, axis]


@inline_kernel
def _follow(header: Any, body: Any) -> None:
    """Let a limb know what is counted of its body, after each look at that."""
    if header.looked != body.looked or header.origin != body.origin:
        adopt(header, body)


@inline_kernel
def _catch_up(clock: Any, body: Any, max_pause: float) -> None:
    """Let a limb's clock know of the frames that the body passed over; the take goes on, as the body has found."""
    clock.next_frame = body.used_frame
    clock.time = max(clock.time, body.time - 0.5 * max_pause)


class LimbRows:
    """The rows of a performer's limbs, moved into one block.

    Args:
        rows: One for each limb; they lie in the block from now on.
        joints: Of the performer, of each limb; a negative one is set by the caller.

    Attributes:
        block: Bytes.
        params: (L,) records.
        frame: (1, K, 3) float32 m, the joints of all limbs in the last frame, a view of the block.
        views: The same of each limb, (1, joints, 3).
    """

    def __init__(self, rows: Sequence[Row], joints: Sequence[Sequence[int]]) -> None:
        order = [joint for own in joints for joint in own]
        sizes = [LINE, *(row.plan.row_bytes for row in rows), LIMB.itemsize * len(rows), 8 * len(order), 8]
        at = np.concatenate([[0], np.cumsum(sizes)]).tolist()
        table, placed, time, frame = at[-4:]
        self.block = new_memory(1, frame + 12 * len(order))[0]
        self.block[: HEAD.itemsize].view(HEAD)[0] = len(rows), len(order), table, placed, frame, time
        self.block[placed:time].view(np.int64)[:] = order
        self.frame = self.block[frame:].view(np.float32).reshape(1, len(order), 3)
        self.params = np.concatenate([row.params for row in rows])
        ends = np.cumsum([len(own) for own in joints]).tolist()
        self.views = [self.frame[:, end - len(own) : end] for end, own in zip(ends, joints, strict=True)]
        limbs = self.block[table:placed].view(LIMB)
        self._buffers = max((row.pool.buffers for row in rows), key=lambda own: len(own.scratch))
        for i, (row, end) in enumerate(zip(rows, ends, strict=True)):
            count, size = len(joints[i]), row.plan.row_bytes
            limbs[i] = at[i + 1], size, frame + 12 * (end - count), count
            place = self.block[at[i + 1] : at[i + 1] + size].reshape(1, size)
            row.move_to(place, self._buffers)
        self._places = [row.memory for row in rows]
        self._sources = {i: row.pool.sources[0] for i, row in enumerate(rows)}

    def advance(self, positions: NDArray[np.float32], body: Row) -> tuple[int, list[Event]]:
        """Take the frame in that the body took in last; see `advance_limbs`.

        Args:
            positions: (1, J, 3) m, the performer's.
            body: The performer's.

        Returns:
            How many limbs took it in, and their events.

        Raises:
            RuntimeError: If another thread is doing so.
        """
        buffers = self._buffers
        with buffers.guard:
            done = advance_limbs(
                self.block, self.params, positions, body.memory, buffers.scratch, buffers.events
            )
            return done, buffers.take_events(self._sources)

    def holds(self, rows: Sequence[Row]) -> bool:
        """Tell whether these rows still lie here: they leave when they need more room."""
        return all(row.memory is place for row, place in zip(rows, self._places, strict=True))

    def warm_up(self, body: Row) -> None:
        """Compile the kernel, or load it, without a frame.

        Args:
            body: The performer's.
        """
        head = self.block[: HEAD.itemsize].view(HEAD)
        limbs, head["limbs"] = int(head["limbs"][0]), 0
        self.advance(np.zeros((1, body.plan.shape.joints, 3), np.float32), body)
        head["limbs"] = limbs
