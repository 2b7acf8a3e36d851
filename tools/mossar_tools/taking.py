"""Taking: watches a stream for movements from rest to rest, each of which becomes an example of a move."""

from collections import deque
from collections.abc import Callable, Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.held_joints import HeldJoints
from mossar_adapters.source import Meta
from mossar_stream import ActivityEvent, Event, Frames, Segmenter, Settings
from mossar_tools.rest_to_rest import LEAST_WAY, Found, Seen, extent, most, movement_over

AWAY = 3.0  # s without movement in another pose than before it, after which a movement is over
MARGIN = 0.5  # s around a movement that are kept; the example is cut more closely
LONGEST = 20.0  # s of one movement
KEPT = 3.0  # s of frames that are kept while nothing but sway happens
SWAY = 0.25  # m, that joints go: less is nothing to report
SMOOTHED = 0.2  # s, over which poses are averaged
EVERY = 0.1  # s between two looks for a movement that is over
MAX_STEP = 0.5  # s without frames, after which all begins anew


class Movement(msgspec.Struct, frozen=True):
    """A movement between two rests.

    Args:
        positions: (n, J, 3) float32, m, with up to `MARGIN` of rest at both ends.
        fps: Hz.
        begin: s on the clock of the stream, when it began.
        end: s, when it ended.
        frames: The first and the last frame in `positions` that belong to it.
    """

    positions: NDArray[np.float32]
    fps: float
    begin: float
    end: float
    frames: tuple[int, int]

    @property
    def seconds(self) -> float:
        """Duration, s."""
        return self.end - self.begin


class MovementTaker:
    """Cuts movements out of one performer's stream; implements `Sink`, and processes frames.

    The body's key frames would not do: where a move may end they already see the next one begin. The activity of the body
    and of the limbs is that of a segmenter of its own, so the settings of the run do not matter.

    Args:
        take: Gets each movement.
        complain: Gets one line if a movement cannot be taken.
        held: Where the hidden joints of the performer were so far; None if nothing is known of the time before.
        away: s of rest in another pose than before, after which a movement is over.
        from_rest: Whether a movement has to begin at rest.

    Attributes:
        since: Movements that began before this time, s, are left out.
    """

    prompt = True
    name = "teach"

    def __init__(
        self,
        take: Callable[[Movement], None],
        complain: Callable[[str], None],
        held: HeldJoints | None = None,
        away: float = AWAY,
        from_rest: bool = True,
    ) -> None:
        self.dropped = 0
        self.since = -np.inf
        self._take = take
        self._complain = complain
        self._held = held
        self._away = away
        self._from_rest = from_rest
        self._performer: str | None = None
        self._root = 0
        self._segmenter: Segmenter | None = None
        self._forget()

    def _forget(self) -> None:
        self._times: list[float] = []  # s, of the frames since the last movement
        self._frames: list[NDArray[np.float32]] = []  # (J, 3) m
        # (1 + J, 3) m: the centre, the joints relative to it; averaged.
        self._poses: list[NDArray[np.float32]] = []
        self._speeds: list[float] = []  # m/s, of the fastest joints, or of the centre
        self._resting: list[bool] = []  # whether the body and all limbs rest
        self._recent: deque[tuple[float, NDArray[np.float32]]] = deque()  # s, and poses that are averaged
        self._moving: dict[str, bool] = {}  # channel to whether it moves
        self._after_rest = False  # whether there was a rest before the first of the frames
        self._due = -np.inf  # s, when to look next

    def announce(self, meta: Meta) -> None:
        """Watch the first performer there is."""
        if self._performer not in (None, meta.performer):
            return
        self._performer = meta.performer
        self._root = meta.skeleton.root
        if self._held is None or self._held.skeleton != meta.skeleton:
            self._held = HeldJoints(meta.skeleton)
        self._segmenter = Segmenter(meta.skeleton, Settings(limbs=True), performer=meta.performer)
        self._forget()

    def send(self, events: Sequence[Event]) -> None:
        """Do nothing: the events of the run depend on its settings."""

    def send_frames(self, frames: Frames) -> None:
        """Keep the last frames; take a movement that is over."""
        if frames.performer != self._performer or self._held is None or self._segmenter is None:
            return
        whole = self._held.fill(frames.positions, frames.confidence)
        news = deque(event for event in self._segmenter.push(frames) if isinstance(event, ActivityEvent))
        for time, positions in zip(frames.times.tolist(), whole, strict=True):
            if self._times and not 0 < time - self._times[-1] <= MAX_STEP:
                self._forget()
            self._add(time, positions)
            while news and news[0].decided_time <= time:
                self._note(news.popleft())
            if time >= self._due:
                self._due = time + EVERY
                self._look()

    def close(self) -> None:
        """Take the movement that the end of the stream cut short."""
        if self._times:
            self._look(at_end=True)

    def _add(self, time: float, positions: NDArray[np.float32]) -> None:
        """Keep a frame, its pose and its speed."""
        centre = positions[self._root] if self._root >= 0 else np.nanmean(positions, axis=0)
        self._recent.append((time, np.concatenate([centre[None], positions - centre])))
        while time - self._recent[0][0] >= SMOOTHED:
            self._recent.popleft()
        pose = np.mean([pose for _, pose in self._recent], axis=0)
        speed = 0.0
        if self._times:
            steps = np.linalg.norm(pose - self._poses[-1], axis=1) / (time - self._times[-1])
            speed = max(float(np.nan_to_num(steps[0])), float(most(steps[1:])))
        self._times.append(time)
        self._frames.append(positions.copy())
        self._poses.append(pose)
        self._speeds.append(speed)
        self._resting.append(not any(self._moving.values()))

    def _note(self, event: ActivityEvent) -> None:
        """Note, from where it happened on, that the body or a limb moves or rests."""
        self._moving[event.channel] = event.state == "moving"
        rests = not any(self._moving.values())
        for i in range(len(self._times) - 1, -1, -1):
            if self._times[i] < event.start:
                break
            self._resting[i] = rests

    def _seen(self) -> Seen:
        poses = np.array(self._poses)
        return Seen(
            np.array(self._times),
            poses[:, 1:],
            np.array(self._speeds),
            np.array(self._resting),
            self._after_rest,
        )

    def _look(self, *, at_end: bool = False) -> None:
        """Take a movement that is over; forget sway."""
        seen = self._seen()
        found = movement_over(seen, self._away, at_end=at_end)
        if found is not None:
            self._finish(found)
        elif self._times[-1] - self._times[0] > KEPT and extent(seen) < SWAY:
            self._drop(next(i for i, time in enumerate(self._times) if time >= self._times[-1] - KEPT))
        elif self._times[-1] - self._times[0] > LONGEST:
            self._complain(
                f"more than {LONGEST:g} s of movement were not taken: rest before and after a move; a fixed length needs no rest"
            )
            self._drop(len(self._times))
            self._after_rest = False

    def _finish(self, found: Found) -> None:
        begin = self._times[max(found.begin, 0)]
        end = max(begin, self._times[found.end] - SMOOTHED / 2)
        kept = [i for i, time in enumerate(self._times) if begin - MARGIN <= time <= end + MARGIN]
        movement = None
        if found.way >= LEAST_WAY and end > self.since:
            if found.begin < 0 and self._from_rest:
                self._complain("not taken: it did not begin at rest; rest, do it, rest")
            elif begin >= self.since and len(kept) > 1:
                rate = (len(kept) - 1) / (self._times[kept[-1]] - self._times[kept[0]])
                inside = [place for place, i in enumerate(kept) if begin <= self._times[i] <= end]
                shown = np.array([self._frames[i] for i in kept])
                movement = Movement(shown, rate, begin, end, (inside[0], inside[-1]))
        self._drop(found.end + 1)
        if movement is not None:
            self._take(movement)

    def _drop(self, count: int) -> None:
        """Forget the first frames; the remaining ones begin at rest."""
        for kept in (self._times, self._frames, self._poses, self._speeds, self._resting):
            del kept[:count]
        self._after_rest = True


class TimedTaker:
    """Takes stretches of a fixed length of one performer's stream; implements `Sink`, and processes frames.

    For movements without a rest at their ends.

    Args:
        take: Gets each stretch.
        say: Gets a line when a stretch begins.
        seconds: Of a stretch.
        lead: s of the stream before each stretch.
        held: As of `MovementTaker`.
    """

    prompt = True
    name = "teach"

    def __init__(
        self,
        take: Callable[[Movement], None],
        say: Callable[[str], None],
        seconds: float,
        lead: float,
        held: HeldJoints | None = None,
    ) -> None:
        self.dropped = 0
        self._take = take
        self._say = say
        self._seconds = seconds
        self._lead = lead
        self._held = held
        self._performer: str | None = None
        self._forget()

    def _forget(self) -> None:
        self._times: list[float] = []  # s
        self._frames: list[NDArray[np.float32]] = []  # (J, 3) m
        self._begin = np.inf  # s, of the stretch

    def announce(self, meta: Meta) -> None:
        """Watch the first performer there is."""
        if self._performer in (None, meta.performer):
            self._performer = meta.performer
            if self._held is None or self._held.skeleton != meta.skeleton:
                self._held = HeldJoints(meta.skeleton)
            self._forget()

    def send(self, events: Sequence[Event]) -> None:
        """Do nothing: the frames are enough."""

    def send_frames(self, frames: Frames) -> None:
        """Keep the frames of a stretch; take it when it is over."""
        if frames.performer != self._performer or self._held is None:
            return
        whole = self._held.fill(frames.positions, frames.confidence)
        for time, positions in zip(frames.times.tolist(), whole, strict=True):
            if self._times and not 0 < time - self._times[-1] <= MAX_STEP:
                self._forget()
            if self._begin == np.inf:
                self._begin = time + self._lead
            self._add(time, positions)

    def close(self) -> None:
        """Do nothing: a stretch that the end of the stream cut short is none."""

    def _add(self, time: float, positions: NDArray[np.float32]) -> None:
        before = self._times[-1] if self._times else -np.inf
        self._times.append(time)
        self._frames.append(positions.copy())
        if before < self._begin <= time:
            self._say(f"now, for {self._seconds:g} s")
        if time < self._begin:
            del self._times[:-1], self._frames[:-1]
        elif time - self._begin >= self._seconds:
            rate = (len(self._times) - 1) / (time - self._times[0])
            frames = 0, len(self._frames) - 1
            movement = Movement(np.array(self._frames), rate, self._times[0], time, frames)
            self._begin = time + self._lead
            self._take(movement)
