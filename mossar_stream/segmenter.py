"""Segmenter: frames of one performer in, events out."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.block import Plan, move_row
from mossar_stream.errors import FrameError
from mossar_stream.events import Event, StreamEvent
from mossar_stream.frames import Frames, constant_times, performer_name
from mossar_stream.layout import header
from mossar_stream.outbox import decode, make_outbox
from mossar_stream.settings import LEVEL_NAMES, LevelName, Settings
from mossar_stream.skeleton import Skeleton
from mossar_stream.stream import RING_FULL, TAKE_ENDS, advance, finish, relabel_row

COUNTERS = ("frames", "out_of_order", "outliers", "held", "gaps")


class Segmenter:
    """Online Mossar for one performer.

    Kernels are compiled when the first segmenter with a similarity measure is built (seconds, once per
    installation), never while frames come in. All state has a fixed size.

    Args:
        skeleton: The performer's joints.
        settings: Defaults to `Settings()`.
        performer: Name that events carry.
        fps: Nominal rate, Hz. Needed where `push` gets no times; otherwise only a hint.

    Raises:
        ValueError: If `settings.range` is `file`, which a stream does not have, or `fps` is not positive.

    Example:
        >>> import numpy as np
        >>> skeleton = Skeleton(("hip", "hand"), (-1, 0))
        >>> segmenter = Segmenter(skeleton, Settings(window=0.1), fps=30)
        >>> frames = np.zeros((90, 2, 3), np.float32)
        >>> frames[30:60, 1, 0] = np.linspace(0, 1, 30)
        >>> frames[60:, 1, 0] = 1
        >>> [e.kind for e in segmenter.push(frames) if e.type == "key_frame" and e.status == "confirmed"]
        ['onset', 'offset']
    """

    def __init__(
        self,
        skeleton: Skeleton,
        settings: Settings | None = None,
        performer: str = "p1",
        fps: float | None = None,
    ) -> None:
        if fps is not None:
            constant_times(0, fps)
        self._given = settings or Settings()
        self._plan = Plan(skeleton, self._given, fps)
        self._memory = self._plan.new_rows(1)
        self._outbox, self._records = make_outbox(2 * self._plan.most_events)
        self._header = header(self._memory[0])
        self._pending: list[Event] = []
        self._level: LevelName | float = self._given.level
        self._one_time = np.zeros(1)
        self.performer = performer_name(performer)
        self._warm_up()

    def push(
        self,
        positions: ArrayLike | Frames,
        times: ArrayLike | None = None,
        confidence: ArrayLike | None = None,
        first_frame: int | None = None,
    ) -> list[Event]:
        """Take frames in and return the events they cause, in order.

        Frames that come too late are dropped and counted; a long gap, or a long step back in time, ends the take
        and starts a new one. Frames may be cut into chunks in any way: the events are the same.

        Args:
            positions: (n, J, 3) or, for one frame, (J, 3), metres, NaN where a joint is missing; or `Frames`.
            times: (n,) or a number, seconds on the source's clock. None counts frames at the nominal rate.
            confidence: (n, J) or (J,) in 0..1; 0 marks a joint as missing.
            first_frame: Number of the first frame; None to count on.

        Raises:
            FrameError: If the shapes do not fit the skeleton.
            ValueError: If there are neither times nor a nominal rate.
        """
        if type(times) is float and confidence is None and first_frame is None:
            # The live path: one frame, with as little Python as can be.
            self._one_time[0] = times
            try:
                if advance(self._memory, 0, self._params, positions, self._one_time, self._outbox) == 1:
                    return self._collect() if self._records[0]["row"] or self._pending else []
            except TypeError:
                pass
        if isinstance(positions, Frames):
            frames = positions
            return self.push(frames.positions, frames.times, frames.confidence, frames.first_frame)
        chunk, moments = self._check(positions, times, confidence, first_frame)
        if first_frame is not None:
            self._header["next_frame"] = first_frame
        return self._run(chunk, moments)
