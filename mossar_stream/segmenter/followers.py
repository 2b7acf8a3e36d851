"""What else follows a performer's frames: moves, limbs, steps, the phase. All are off by default, and cost nothing then."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mossar_stream.engine import engine
from mossar_stream.engine.pool import Row
from mossar_stream.engine.snapshot import Following
from mossar_stream.events import BODY, Event
from mossar_stream.moves.recognition import Recognition
from mossar_stream.segmenter.limbs import Limbs, LimbSegmenter, together
from mossar_stream.settings import Settings
from mossar_stream.steps.stepping import Stepping

Hold = Callable[[NDArray[np.float32], float], bool]


class Followers:
    """What follows the frames of one performer besides the segmentation of the body.

    Args:
        row: The performer's.
        recognition: Of moves, or None.
        new_limbs: Returns the limbs of a row's performer that settings call for, None if there are none.

    Attributes:
        limbs: Key frames of limbs, or None.
        stepping: Steps, or None.
        hold: Takes one frame of a take in, (1, J, 3) m and s, and tells whether nothing comes of it but what the body has
            to say; if not, `push` must be called.
    """

    def __init__(
        self, row: Row, recognition: Recognition | None, new_limbs: Callable[[Row, Settings], Limbs | None]
    ) -> None:
        self._recognition = recognition
        self.limbs: Limbs | None = None
        self.stepping = _stepping_of(row)
        self._new_limbs = new_limbs
        self._tells_phase = row.plan.given.phase
        self._renew_limbs(row)
        self._choose()

    @property
    def recognition(self) -> Recognition | None:
        """What recognises moves, or None."""
        return self._recognition

    @recognition.setter
    def recognition(self, recognition: Recognition | None) -> None:
        self._recognition = recognition
        self._choose()

    def __bool__(self) -> bool:
        return self._tells_phase or not (
            self.recognition is None and self.limbs is None and self.stepping is None
        )

    def _renew_limbs(self, row: Row) -> None:
        given, clock = row.plan.given, row.clock
        self.limbs = self._new_limbs(row, given)
        if self.limbs is not None:
            self.limbs.join(int(clock["take"]), int(clock["next_frame"]))

    def adopt(self, row: Row, before: Settings) -> list[Event]:
        """Go on with the settings of a row, and return the events of what that ends.

        Args:
            row: The performer's, as it is now.
            before: The settings so far.
        """
        given = row.plan.given
        events: list[Event] = []
        self._tells_phase = given.phase
        if given.limbs != before.limbs:
            if self.limbs is not None:
                events += self.limbs.end_take()
                self.limbs.release()
            self._renew_limbs(row)
        elif self.limbs is not None:
            self.limbs.change(given)
        if _steps_differ(given, before):
            self.stepping = _stepping_of(row)
        self._choose()
        return events

    def _choose(self) -> None:
        """Choose what `hold` does; asking at each frame would take longer than most frames do."""
        limbs, recognition, stepping = self.limbs, self.recognition, self.stepping
        self.hold: Hold = _hold_nothing
        if self._tells_phase:
            return
        if limbs is not None:
            self.hold = limbs.hold if recognition is None else _hold_both(limbs, recognition.hold)
        elif recognition is not None:
            self.hold = recognition.hold
        if stepping is not None:
            others = None if limbs is None and recognition is None else self.hold
            self.hold = stepping.hold if others is None else _hold_both(stepping, others)

    def push_one(
        self, row: Row, position: NDArray[np.float32], time: NDArray[np.float64], seconds: float
    ) -> list[Event]:
        """Take one frame of a take that goes on in, as `push`, more quickly; `hold` has refused it.

        Args:
            row: The performer's.
            position: (1, J, 3) m.
            time: (1,) s.
            seconds: The same as a number.
        """
        recognition, limbs = self._recognition, self.limbs
        if self._tells_phase or limbs is None or self.stepping is not None:
            return self.push(row, position, time)
        if recognition is not None and (
            limbs.hold(position, seconds) or not recognition.hold(position, seconds)
        ):
            return self._push_and_recognise(recognition, row, position, time, None)
        events = limbs.take(position, time)
        return self._push_limbs(limbs, row, position, time, None) if events is None else events

    def push(
        self,
        row: Row,
        positions: NDArray[np.float32],
        times: NDArray[np.float64],
        first_frame: int | None = None,
    ) -> list[Event]:
        """Take frames in, as `engine.push`, and return what is said of the body, limbs and moves, and the phase.

        Args:
            row: The performer's.
            positions: (n, J, 3) m.
            times: (n,) s.
            first_frame: Number of the first frame; None to count on.
        """
        if row.telling is None or not self._tells_phase:
            return self._push_all(row, positions, times, first_frame)
        events: list[Event] = []
        for i in range(len(times)):
            number = None if first_frame is None else first_frame + i
            events += self._push_all(row, positions[i : i + 1], times[i : i + 1], number)
            if row.clock["open"]:
                events += row.telling.phase_news(int(row.clock["take"]), float(row.last_time[0]))
        return events

    def _push_all(
        self, row: Row, positions: NDArray[np.float32], times: NDArray[np.float64], first_frame: int | None
    ) -> list[Event]:
        stepping = self.stepping
        if stepping is None:
            return self._push_and_follow(row, positions, times, first_frame)
        events: list[Event] = []
        count, begin = len(times), 0
        while begin < count or not begin:
            stop = stepping.follow(positions, times, begin)
            end = min(stop + 1, count)
            events += self._push_and_follow(row, positions[begin:end], times[begin:end], first_frame)
            if stop < count:
                events += stepping.news(int(row.clock["take"]), row.origin)
            if first_frame is not None:
                first_frame += end - begin
            begin = max(end, 1)
        return events

    def _push_and_follow(
        self, row: Row, positions: NDArray[np.float32], times: NDArray[np.float64], first_frame: int | None
    ) -> list[Event]:
        if self.recognition is not None:
            return self._push_and_recognise(self.recognition, row, positions, times, first_frame)
        return self._push_channels(row, positions, times, first_frame)

    def _push_and_recognise(
        self,
        recognition: Recognition,
        row: Row,
        positions: NDArray[np.float32],
        times: NDArray[np.float64],
        first_frame: int | None,
    ) -> list[Event]:
        """Take frames in; what is said of moves comes right after the events of the same frame."""
        count = len(times)
        if count == 1:  # of a take that may begin with it
            stop = recognition.follow(positions, times, 0)
            events = self._push_channels(row, positions, times, first_frame)
            return events if stop else [*events, *recognition.news(int(row.clock["take"]))]
        events, begin = [], 0
        while begin < count or not begin:
            stop = recognition.follow(positions, times, begin)
            end = min(stop + 1, count)
            events += self._push_channels(row, positions[begin:end], times[begin:end], first_frame)
            if stop < count:
                events += recognition.news(int(row.clock["take"]))
            begin, first_frame = max(end, 1), None
        return events

    def _push_channels(
        self, row: Row, positions: NDArray[np.float32], times: NDArray[np.float64], first_frame: int | None
    ) -> list[Event]:
        """Take frames in; limbs have their say frame by frame, so that it does not matter how frames are cut."""
        if self.limbs is None or not len(times):
            return engine.push_short(row, positions, times, first_frame)
        if len(times) == 1:
            return self._push_limbs(self.limbs, row, positions, times, first_frame)
        events: list[Event] = []
        moments, begin = times.tolist(), 0
        while begin < len(moments):
            end = begin
            number = None if first_frame is None else first_frame + begin
            if number is None or engine.counts_on(row, number):
                while end < len(moments) and self.limbs.hold(positions, moments[end]):
                    end += 1
            if end > begin:  # they come too soon for limbs
                events += engine.push_short(row, positions[begin:end], times[begin:end], number)
            else:
                end += 1
                events += self._push_limbs(self.limbs, row, positions[begin:end], times[begin:end], number)
            begin = end
        return events

    def _push_limbs(
        self,
        limbs: Limbs,
        row: Row,
        position: NDArray[np.float32],
        time: NDArray[np.float64],
        first_frame: int | None,
    ) -> list[Event]:
        """Take one frame in, of the body and of its limbs."""
        goes_on = abs(time[0] - row.last_time[0]) <= row.plan.given.max_pause  # else a take may begin
        if goes_on and (first_frame is None or engine.counts_on(row, first_frame)):
            events = limbs.take(position, time)
            if events is not None:
                return events
        limbs.stop()
        body = engine.push_short(row, position, time, first_frame)
        found = limbs.push(position, time, first_frame)
        return together(limbs.lead(body), found) if body or found else body

    def end_take(self) -> list[Event]:
        """End the take of moves, and return the events; the body's come after them, then those of limbs."""
        if self.stepping is not None:
            self.stepping.forget()
        return [] if self.recognition is None else [*self.recognition.end()]

    def reset(self) -> None:
        """Forget the ranges of limbs, after their takes ended."""
        if self.limbs is not None:
            self.limbs.reset()

    def release(self) -> None:
        """Give back what limbs lie in."""
        if self.limbs is not None:
            self.limbs.release()

    @property
    def bytes_taken(self) -> int:
        """Bytes of what is known here, besides what is shared with others."""
        more = 0 if self._recognition is None else self._recognition.bytes_taken
        more += 0 if self.stepping is None else self.stepping.bytes_taken
        limbs = {} if self.limbs is None else self.limbs.segmenters
        return more + sum(own.state_bytes for own in limbs.values())

    def snapshot(self, row: Row, *, with_moves: bool = True) -> Following:
        """Return everything that is known here; see `Segmenter.snapshot`."""
        recognition = self.recognition
        return Following(
            moves=None if recognition is None or not with_moves else recognition.moves_text,
            digest=b"" if recognition is None else recognition.digest,
            recognition=None if recognition is None else recognition.to_bytes(),
            repetitions=None if row.telling is None else row.telling.told(),
            limbs=() if self.limbs is None else self.limbs.snapshot(),
            steps=None if self.stepping is None else self.stepping.to_bytes(),
        )

    def restore(self, row: Row, known: Following, restored: Callable[[bytes, str], LimbSegmenter]) -> None:
        """Go on where a snapshot was made; the recognition is there already.

        Args:
            row: The performer's, restored.
            known: What `snapshot` returned.
            restored: Returns the segmenter of a limb's snapshot, and its channel.

        Raises:
            SnapshotError: If it is damaged, or of other settings.
        """
        if row.telling is not None and row.clock["open"]:
            row.telling.go_on(known.repetitions)
        if self.limbs is not None:
            self.limbs.restore(known.limbs, restored)
        if self.stepping is not None:
            self.stepping.go_on_from(known.steps)


def _stepping_of(row: Row) -> Stepping | None:
    given = row.plan.given
    return Stepping(row.plan.skeleton, given, row.name) if given.steps and row.plan.channel == BODY else None


def _steps_differ(given: Settings, before: Settings) -> bool:
    fields = ("steps", "feet", "step_sensitivity", "up")
    return any(getattr(given, name) != getattr(before, name) for name in fields)


def _hold_both(first: Limbs | Stepping, second: Hold) -> Hold:
    return lambda position, time: first.hold(position, time) and second(position, time)


def _hold_nothing(_position: NDArray[np.float32], _time: float) -> bool:
    return False
