"""Taking: watches a stream for movements between rests, each of which becomes an example of a move."""

from collections import deque
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.source import Meta
from mossar_stream import Event, Frames, KeyFrameEvent, MossarError, StreamEvent

REST = 0.6  # s without movement, after which a movement is over
MARGIN = 0.5  # s around it that are kept; the example is cut more closely
LONGEST = 10.0  # s of one movement
KEPT = LONGEST + 2 * MARGIN + REST + 1.0  # s of frames

Take = Callable[[NDArray[np.float32], float], None]


class MovementTaker:
    """Cuts movements out of one performer's stream; implements `Sink`, and takes frames, too.

    A movement lasts from an onset until nothing has moved for `REST` after an offset.

    Args:
        take: Gets the positions (n, J, 3), metres, and the rate, Hz, of each movement.
        complain: Gets one line if a movement cannot be taken.
    """

    prompt = True
    name = "teach"

    def __init__(self, take: Take, complain: Callable[[str], None]) -> None:
        self.dropped = 0
        self._take = take
        self._complain = complain
        self._performer: str | None = None
        self._frames: deque[tuple[float, NDArray[np.float32]]] = deque()  # time, s, and positions
        self._onset: float | None = None  # s, of the movement that goes on
        self._offset: float | None = None  # s, when it last came to rest

    def announce(self, meta: Meta) -> None:
        """Watch the first performer there is."""
        if self._performer in (None, meta.performer):
            self._performer = meta.performer
            self._forget()

    def send(self, events: Sequence[Event]) -> None:
        """Take note of onsets and offsets."""
        for event in events:
            if event.performer != self._performer:
                continue
            if isinstance(event, StreamEvent) and event.event in ("started", "ended"):
                self._forget()
            elif isinstance(event, KeyFrameEvent) and event.status == "confirmed":
                self._follow(event)

    def send_frames(self, frames: Frames) -> None:
        """Keep the last frames; take a movement that is over."""
        if frames.performer != self._performer:
            return
        for time, positions in zip(frames.times.tolist(), frames.positions, strict=True):
            self._frames.append((time, positions.copy()))
            while time - self._frames[0][0] > KEPT:
                self._frames.popleft()
            self._look(time)

    def close(self) -> None:
        """Take the movement that the end of the stream cut short, if it had come to rest."""
        if self._offset is not None:
            self._finish()

    def _follow(self, event: KeyFrameEvent) -> None:
        if event.kind == "onset":
            if self._onset is None:
                self._onset = event.time
            self._offset = None
        elif event.kind == "offset" and self._onset is not None:
            self._offset = event.time

    def _look(self, now: float) -> None:
        if self._onset is None:
            return
        if self._offset is not None and now - self._offset >= REST:
            self._finish()
        elif now - self._onset > LONGEST:
            self._complain(
                f"a movement of more than {LONGEST:g} s was not taken: rest before and after a move"
            )
            self._onset = self._offset = None

    def _finish(self) -> None:
        onset, offset = self._onset, self._offset
        self._onset = self._offset = None
        if onset is None or offset is None:
            return
        shown = [(time, p) for time, p in self._frames if onset - MARGIN <= time <= offset + MARGIN]
        times = [time for time, _ in shown]
        if len(times) < 2 or times[-1] <= times[0]:
            return
        try:
            self._take(np.array([p for _, p in shown]), (len(times) - 1) / (times[-1] - times[0]))
        except MossarError as error:
            self._complain(f"not taken: {error}")

    def _forget(self) -> None:
        self._frames.clear()
        self._onset = self._offset = None
