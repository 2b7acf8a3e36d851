"""The joints of a performer, learnt from the frames.

The first frame may have been caught in the middle, and the first ones may lack joints that were lost on the way. They are
held back until one, not the first, has all joints so far, or a quarter of a second has passed, so that most performers are
announced once. Joints that turn up later are added, and the performer announced anew.
"""

from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import FrameError

MAX_NAMES = 256
HOLD = 0.25  # s; the first frames are let go after it in any case

Row = tuple[float, ...]


class ClosedFrame(msgspec.Struct):
    """A frame that is complete.

    Args:
        rows: Numbers of each joint that came.
        arrival: When its first joint came, s.
        time: The sender's time, s, or None.
        root: Position and rotation of the whole, in protocols that have one.
    """

    rows: dict[str, Row]
    arrival: float
    time: float | None = None
    root: Row | None = None


class KnownJoints:
    """The joints of one performer in the order in which they first came, and the frames held back."""

    def __init__(self) -> None:
        self.names: dict[str, int] = {}
        self._held: list[ClosedFrame] = []
        self._frames = 0
        self._complete = False  # whether the joints are taken for known

    @property
    def learnt(self) -> bool:
        """Whether a first frame has been seen whole."""
        return self._frames > 0

    @property
    def holding(self) -> bool:
        """Whether a frame is held back."""
        return bool(self._held)

    def note(self, name: str) -> None:
        """Note a joint.

        Raises:
            FrameError: If there are too many.
        """
        if name not in self.names:
            if len(self.names) == MAX_NAMES:
                raise FrameError(f"more than {MAX_NAMES} joints")
            self.names[name] = len(self.names)

    def admit(self, closed: ClosedFrame) -> Sequence[ClosedFrame]:
        """Return the frames that may go on now that this one is closed."""
        self._frames += 1
        self._held.append(closed)
        whole = self._frames > 1 and len(closed.rows) == len(self.names)
        self._complete |= whole or closed.arrival - self._held[0].arrival > HOLD
        return self.release() if self._complete else ()

    def overdue(self, now: float) -> bool:
        """Return whether the frame held back has waited long enough."""
        return bool(self._held) and now - self._held[0].arrival > HOLD

    def release(self) -> Sequence[ClosedFrame]:
        """Return the frames held back."""
        held, self._held = self._held, []
        self._complete |= bool(held)
        return held

    def table(self, rows: dict[str, Row], width: int) -> NDArray[np.float64]:
        """Return (J, width) numbers in the order of `names`, NaN where a joint did not come."""
        missing = (np.nan,) * width
        return np.array([rows.get(name, missing) for name in self.names], dtype=np.float64)
