"""Limb rows: the rows of one performer's limbs lie in one block, so that one compiled call takes a frame in for all.

A call of its own for each limb would cost more than what it does. Limbs take in what the body takes in, in the same call.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.frame_step import DONE, HAPPENED, LOOK_DUE, STOPS, WINDOW_FULL
from mossar_stream.algorithm.row import ROW, new_memory
from mossar_stream.engine.buffers import IN_USE, Buffers
from mossar_stream.engine.middle import put_middle
from mossar_stream.engine.plan import new_scratch
from mossar_stream.engine.pool import Row
from mossar_stream.engine.run import FOLLOWS, advance_by_name, update_window_by_name
from mossar_stream.jit.decorators import entry_point, inline_kernel
from mossar_stream.jit.views import part
from mossar_stream.memory.event_buffer import EVENT, EVENT_BYTES
from mossar_stream.repetitions.state import HEADER, adopt

ONE_DONE, ONE_HAPPENED = np.int64(STOPS + DONE), np.int64(STOPS + HAPPENED)
OWN_ROW = np.int64(0)
SILENT, ASKS_FOR_LOOK = ~DONE, ~LOOK_DUE  # what `advance_all` may return
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
def advance_all(
    block: NDArray[np.uint8],
    params: NDArray[np.void],
    positions: NDArray[np.float32],
    body: NDArray[np.uint8],
    scratch: NDArray[np.uint8],
    event_buffer: NDArray[np.uint8],
) -> int:
    """Take one frame of a take that goes on in, of the body and of all limbs, with all that follows from it.

    Args:
        block: Bytes: `HEAD`, rows, a `LIMB` each, the joints of all, one after the other, their positions and the
            time of the frame, s.
        params: (1 + L,) records, those of the similarity measure for the body and each limb.
        positions: (1, J, 3) float32 m, the performer's.
        body: (1, row) bytes of the performer.
        scratch: Of `new_scratch`, large enough for the body and each limb.
        event_buffer: Empty; gets the events.

    Returns:
        How many limbs took it in, or need not; the caller must see to the others. SILENT if these are all, and there are
        no events. If the body asks for something first, nothing is done: `~code`, with the code that `advance` returned.
    """
    head = part(block, 0, HEAD, (1,))[0]
    if head.limbs == 0:
        return SILENT
    limbs = part(block, head.table, LIMB, (head.limbs,))
    frame = part(block, head.frame, np.float32, (head.joints, 3))
    times = part(block, head.time, np.float64, (1,))
    buffers = scratch, event_buffer
    events = part(event_buffer, 0, EVENT, (len(event_buffer) // EVENT_BYTES,))
    whole = part(body[0], 0, ROW, (1,))[0]
    clock = whole.clock
    taken = clock.taken_time
    code = _take_in(body, params[:1], (positions, times), buffers)
    if code != ONE_DONE:
        return ~code  # type: ignore[no-any-return]
    if clock.taken_time != taken:
        counted = part(body[0], whole.at.counted, HEADER, (whole.plan.repetitions,))
        _gather(part(block, head.order, np.int64, (head.joints,)), positions, frame, body)
        for i in range(head.limbs):
            state = part(block, limbs[i].row, ROW, (1,))[0]
            _catch_up(state.clock, clock, state.plan.max_pause)
        for i in range(head.limbs):
            limb = limbs[i]
            row = part(block, limb.row, np.uint8, (1, limb.row_bytes))
            state = part(block, limb.row, ROW, (1,))[0]
            own = part(block, limb.frame, np.float32, (1, limb.joints, 3))
            if state.plan.adopts == 1:
                _follow(part(block, limb.row + state.at.adopted, HEADER, (1,))[0], counted[0])
            code = _take_in(row, params[i + 1 : i + 2], (own, times), buffers)
            if code != ONE_DONE:
                return i
    return head.limbs if events[0].row > 0 else SILENT


@inline_kernel
def _take_in(
    row: NDArray[np.uint8],
    params: NDArray[np.void],
    frame: tuple[NDArray[np.float32], NDArray[np.float64]],
    buffers: tuple[NDArray[np.uint8], NDArray[np.uint8]],
) -> Any:
    """Take a frame of the body or of a limb in, with all that follows.

    Returns:
        ONE_DONE, or what `advance` returned; WINDOW_FULL, too, where there is no room for its events.
    """
    positions, times = frame
    scratch, event_buffer = buffers
    events = part(event_buffer, 0, EVENT, (len(event_buffer) // EVENT_BYTES,))
    if events[0].row + part(row[0], 0, ROW, (1,))[0].plan.most_events >= len(events):
        return np.int64(WINDOW_FULL)
    code = advance_by_name(row, OWN_ROW, params, positions, times)
    if code != ONE_HAPPENED:
        return code
    update_window_by_name(row, OWN_ROW, params, scratch, event_buffer, FOLLOWS)
    return ONE_DONE


@inline_kernel
def _gather(
    order: NDArray[np.int64],
    positions: NDArray[np.float32],
    frame: NDArray[np.float32],
    body: NDArray[np.uint8],
) -> None:
    """Set the joints of all limbs, after the body processed the frame."""
    for k in range(len(order)):
        joint = order[k]
        if joint >= 0:
            for axis in range(3):
                frame[k, axis] = positions[0, joint, axis]
        else:
            put_middle(body, frame[k])


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
        body: The performer's row.
        rows: One for each limb; they lie in the block from now on.
        joints: Of the performer, of each limb; a negative one is the middle of the body.

    Attributes:
        block: Bytes.
        params: (1 + L,) records.
        frame: (1, K, 3) float32 m, the joints of all limbs in the last frame, a view of the block.
        views: The same of each limb, (1, joints, 3).
    """

    def __init__(self, body: Row, rows: Sequence[Row], joints: Sequence[Sequence[int]]) -> None:
        order = [joint for own in joints for joint in own]
        sizes = [LINE, *(row.plan.row_bytes for row in rows), LIMB.itemsize * len(rows), 8 * len(order), 8]
        at = np.concatenate([[0], np.cumsum(sizes)]).tolist()
        table, placed, time, frame = at[-4:]
        self.block = new_memory(1, frame + 12 * len(order))[0]
        self.block[: HEAD.itemsize].view(HEAD)[0] = len(rows), len(order), table, placed, frame, time
        self.block[placed:time].view(np.int64)[:] = order
        self._time = self.block[time:frame].view(np.float64)
        self.frame = self.block[frame:].view(np.float32).reshape(1, len(order), 3)
        self.params = np.concatenate([row.params for row in (body, *rows)])
        ends = np.cumsum([len(own) for own in joints]).tolist()
        self.views = [self.frame[:, end - len(own) : end] for end, own in zip(ends, joints, strict=True)]
        limbs = self.block[table:placed].view(LIMB)
        self._buffers = _buffers_for(body, rows)
        for i, (row, end) in enumerate(zip(rows, ends, strict=True)):
            count, size = len(joints[i]), row.plan.row_bytes
            limbs[i] = at[i + 1], size, frame + 12 * (end - count), count
            place = self.block[at[i + 1] : at[i + 1] + size].reshape(1, size)
            row.move_to(place, self._buffers, body.pending)
        self._places = [row.memory for row in (body, *rows)]

    def advance(self, positions: NDArray[np.float32], times: NDArray[np.float64], body: Row) -> int:
        """Take one frame of a take that goes on in, of the body and of all limbs; see `advance_all`.

        Args:
            positions: (1, J, 3) m, the performer's.
            times: (1,) s.
            body: The performer's.

        Returns:
            What `advance_all` returned; the events are pending.

        Raises:
            RuntimeError: If another thread is doing so.
        """
        buffers = self._buffers
        frame = self.block, self.params, positions, body.memory, buffers.scratch, buffers.events
        guard = body.guard
        if guard.is_busy:
            raise RuntimeError(IN_USE)
        try:
            guard.is_busy = True
            self._time[0] = times[0]
            done = advance_all(*frame)
            if done == ASKS_FOR_LOOK:
                body.look_at_repetitions(times[0])
                done = advance_all(*frame)
            if done != SILENT:
                buffers.hand_out()
            guard.is_busy = False
        except BaseException:
            guard.is_busy = False
            raise
        return done

    def holds(self, body: Row, rows: Sequence[Row]) -> bool:
        """Tell whether these rows still lie where they did: they leave when they need more room."""
        return all(row.memory is place for row, place in zip((body, *rows), self._places, strict=True))

    def warm_up(self, body: Row) -> None:
        """Compile the kernel, or load it, without a frame.

        Args:
            body: The performer's.
        """
        head = self.block[: HEAD.itemsize].view(HEAD)
        limbs, head["limbs"] = int(head["limbs"][0]), 0
        self.advance(np.zeros((1, body.plan.shape.joints, 3), np.float32), np.zeros(1), body)
        head["limbs"] = limbs


def _buffers_for(body: Row, rows: Sequence[Row]) -> Buffers:
    """Return buffers for a body and its limbs: the body's, unless a limb needs more room; one guard is for both."""
    largest = max((body, *rows), key=lambda row: len(new_scratch(row.plan.shape)))
    if len(new_scratch(largest.plan.shape)) <= len(body.pool.buffers.scratch):
        return body.pool.buffers
    return Buffers(largest.plan, body.guard)
