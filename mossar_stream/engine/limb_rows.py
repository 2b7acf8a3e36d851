"""Limb rows: the rows of one performer's limbs lie in one block, so that one compiled call takes a frame in for all.

A call of its own for each limb would cost more than what it does.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.frame_step import DONE, HAPPENED, STOPS
from mossar_stream.algorithm.row import new_memory
from mossar_stream.engine.buffers import IN_USE, Guard
from mossar_stream.engine.pool import Row
from mossar_stream.engine.run import advance_by_name
from mossar_stream.jit.decorators import entry_point
from mossar_stream.jit.views import part

ONE_DONE, ONE_HAPPENED = np.int64(STOPS + DONE), np.int64(STOPS + HAPPENED)
OWN_ROW = np.int64(0)
BEYOND = 32  # bit of the first limb among those whose frame was not taken in; there are fewer limbs
LINE = 64  # bytes
HEAD = np.dtype([("limbs", "i8"), ("joints", "i8"), ("table", "i8"), ("order", "i8"), ("frame", "i8")])
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
    times: NDArray[np.float64],
) -> int:
    """Take one frame of all limbs in.

    Args:
        block: Bytes: `HEAD`, rows, a `LIMB` each, the joints of all, one after the other, and their positions.
        params: (L,) records, those of the similarity measure for each limb.
        positions: (1, J, 3) float32 m, the performer's.
        times: (1,) s.

    Returns:
        A bit for each limb of which something happened; from bit `BEYOND` on one for each that did not take it in.
    """
    head = part(block, 0, HEAD, (1,))[0]
    limbs = part(block, head.table, LIMB, (head.limbs,))
    order = part(block, head.order, np.int64, (head.joints,))
    frame = part(block, head.frame, np.float32, (head.joints, 3))
    for k in range(head.joints):
        joint = order[k]
        if joint >= 0:
            frame[k, 0], frame[k, 1], frame[k, 2] = (
                positions[0, joint, 0],
                positions[0, joint, 1],
                positions[0, joint, 2],
            )
    news = 0
    for i in range(head.limbs):
        limb = limbs[i]
        row = part(block, limb.row, np.uint8, (1, limb.row_bytes))
        own = part(block, limb.frame, np.float32, (1, limb.joints, 3))
        code = advance_by_name(row, OWN_ROW, params[i : i + 1], own, times)
        if code == ONE_HAPPENED:
            news |= 1 << i
        elif code != ONE_DONE:
            news |= 1 << (i + BEYOND)
    return news


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
        sizes = [LINE, *(row.plan.row_bytes for row in rows), LIMB.itemsize * len(rows), 8 * len(order)]
        at = np.concatenate([[0], np.cumsum(sizes)]).tolist()
        table, placed, frame = at[-3:]
        self.block = new_memory(1, frame + 12 * len(order))[0]
        self.block[: HEAD.itemsize].view(HEAD)[0] = len(rows), len(order), table, placed, frame
        self.block[placed:frame].view(np.int64)[:] = order
        self.frame = self.block[frame:].view(np.float32).reshape(1, len(order), 3)
        self.params = np.concatenate([row.params for row in rows])
        ends = np.cumsum([len(own) for own in joints]).tolist()
        self.views = [self.frame[:, end - len(own) : end] for end, own in zip(ends, joints, strict=True)]
        limbs = self.block[table:placed].view(LIMB)
        for i, (row, end) in enumerate(zip(rows, ends, strict=True)):
            count, size = len(joints[i]), row.plan.row_bytes
            limbs[i] = at[i + 1], size, frame + 12 * (end - count), count
            row.move_to(self.block[at[i + 1] : at[i + 1] + size].reshape(1, size))
        self._places = [row.memory for row in rows]
        self._guard = Guard()

    def advance(self, positions: NDArray[np.float32], times: NDArray[np.float64]) -> int:
        """Take one frame of all limbs in; see `advance_limbs`.

        Raises:
            RuntimeError: If another thread is doing so.
        """
        guard = self._guard  # as `with guard:` would do it, which takes longer
        if guard.is_busy:
            raise RuntimeError(IN_USE)
        guard.is_busy = True
        try:
            return advance_limbs(self.block, self.params, positions, times)
        finally:
            guard.is_busy = False

    def holds(self, rows: Sequence[Row]) -> bool:
        """Tell whether these rows still lie here: they leave when they need more room."""
        return all(row.memory is place for row, place in zip(rows, self._places, strict=True))

    def warm_up(self, joints: int) -> None:
        """Compile the kernel, or load it, without a frame.

        Args:
            joints: Of the performer.
        """
        head = self.block[: HEAD.itemsize].view(HEAD)
        limbs, head["limbs"] = int(head["limbs"][0]), 0
        advance_limbs(self.block, self.params, np.zeros((1, joints, 3), np.float32), np.zeros(1))
        head["limbs"] = limbs
