"""Taking: watches a stream for movements between rests, each of which becomes an example of a move."""

from collections import deque
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.held_joints import HeldJoints
from mossar_adapters.source import Meta
from mossar_stream import Event, Frames, MossarError

REST = 0.6  # s without movement, after which a movement is over
MARGIN = 0.5  # s around it that are kept; the example is cut more closely
LONGEST = 10.0  # s of one movement
KEPT = LONGEST + 2 * MARGIN + REST  # s of frames
SMOOTHED = 0.15  # s, over which poses are averaged
MOVING = 0.2  # of the largest speed: faster is a movement
LEAST_RANGE = 0.25  # m/s, mean over the joints: what the largest speed is at least
MOST_RANGE = 2.0  # m/s, and at most: a sensor that loses the body for a moment must not hide what follows
HALF_LIFE = 20.0  # s, of the largest speed
MAX_STEP = 0.5  # s without frames, after which all begins anew

Take = Callable[[NDArray[np.float32], float], None]


class MovementTaker:
    """Cuts movements out of one performer's stream; implements `Sink`, and takes frames, too.

    A movement lasts from when the mean speed of the joints rises above a share of its range until it has been below
    for `REST`. The body's key frames would not do: where a move may end they already see the next one begin.

    Args:
        take: Gets the positions (n, J, 3), metres, and the rate, Hz, of each movement.
        complain: Gets one line if a movement cannot be taken.
        held: Where the hidden joints of the performer were so far; None if nothing is known of the time before.

    Attributes:
        since: Movements that began before this time, s, are left out.
    """

    prompt = True
    name = "teach"

    def __init__(self, take: Take, complain: Callable[[str], None], held: HeldJoints | None = None) -> None:
        self.dropped = 0
        self.since = -np.inf
        self._take = take
        self._complain = complain
        self._held = held
        self._performer: str | None = None
        self._root = 0
        self._range = LEAST_RANGE  # m/s, largest speed, decaying
        self._forget()

    def _forget(self) -> None:
        self._frames: deque[tuple[float, NDArray[np.float32]]] = deque()  # time, s, and positions
        self._recent: deque[tuple[float, NDArray[np.float32]]] = deque()  # the same, relative to the centre
        self._pose: NDArray[np.float32] | None = None  # average of the recent ones
        self._onset: float | None = None  # s, of the movement that goes on
        self._moved = 0.0  # s, when something moved last

    def announce(self, meta: Meta) -> None:
        """Watch the first performer there is."""
        if self._performer in (None, meta.performer):
            self._performer = meta.performer
            self._root = meta.skeleton.root
            if self._held is None or self._held.skeleton != meta.skeleton:
                self._held = HeldJoints(meta.skeleton)
            self._forget()

    def send(self, events: Sequence[Event]) -> None:
        """Do nothing: the frames say enough."""

    def send_frames(self, frames: Frames) -> None:
        """Keep the last frames; take a movement that is over."""
        if frames.performer != self._performer or self._held is None:
            return
        whole = self._held.fill(frames.positions, frames.confidence)
        for time, positions in zip(frames.times.tolist(), whole, strict=True):
            if self._frames and not 0 < time - self._frames[-1][0] <= MAX_STEP:
                self._forget()
            self._follow(time, positions.copy())

    def close(self) -> None:
        """Take the movement that the end of the stream cut short."""
        if self._onset is not None:
            self._finish()

    def _follow(self, time: float, positions: NDArray[np.float32]) -> None:
        step = time - self._frames[-1][0] if self._frames else 0.0
        self._frames.append((time, positions))
        while time - self._frames[0][0] > KEPT:
            self._frames.popleft()
        speed = self._speed(time, positions, step)
        self._range = max(self._range * 0.5 ** (step / HALF_LIFE), min(speed, MOST_RANGE))
        if speed > MOVING * self._range:
            self._onset = time if self._onset is None else self._onset
            self._moved = time
        if self._onset is None:
            return
        if time - self._moved >= REST:
            self._finish()
        elif time - self._onset > LONGEST:
            self._complain(
                f"more than {LONGEST:g} s of movement were not taken: rest before and after a move"
            )
            self._onset = None

    def _speed(self, time: float, positions: NDArray[np.float32], step: float) -> float:
        """Return the mean speed of the joints relative to the centre, m/s."""
        centre = positions[self._root] if self._root >= 0 else np.nanmean(positions, axis=0)
        self._recent.append((time, positions - centre))
        while time - self._recent[0][0] >= SMOOTHED:
            self._recent.popleft()
        before, self._pose = self._pose, np.mean([pose for _, pose in self._recent], axis=0)
        if before is None or step <= 0:
            return 0.0
        speeds = np.linalg.norm(self._pose - before, axis=1) / step
        return float(np.nanmean(speeds)) if np.isfinite(speeds).any() else 0.0

    def _finish(self) -> None:
        onset, self._onset = self._onset, None
        if onset is None or onset < self.since:
            return
        begin, end = onset - MARGIN, self._moved + MARGIN
        shown = [(time, positions) for time, positions in self._frames if begin <= time <= end]
        try:
            rate = (len(shown) - 1) / (shown[-1][0] - shown[0][0]) if len(shown) > 1 else 0.0
            self._take(np.array([positions for _, positions in shown]), rate)
        except MossarError as error:
            self._complain(f"not taken: {error}")
