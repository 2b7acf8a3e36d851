"""What else follows a performer's frames: moves, what was shown, limbs, steps, the phase. All are off by default, and cost nothing then."""

import functools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mossar_stream.engine import engine
from mossar_stream.engine.pool import Row
from mossar_stream.engine.snapshot import Following
from mossar_stream.events import BODY
from mossar_stream.following.alignment import Alignment, Follow
from mossar_stream.moves.recognition import Recognition
from mossar_stream.segmenter.limbs import Limbs, LimbSegmenter
from mossar_stream.settings import LevelName, Settings
from mossar_stream.steps.stepping import Stepping

Reader = Recognition | Alignment | Stepping
Push = Callable[[Row, NDArray[np.float32], NDArray[np.float64], int | None], int]


class Followers:
    """What follows the frames of one performer besides the segmentation of the body.

    Events are added to what is pending of the performer's row, in the order in which they come about.

    Args:
        row: The performer's.
        recognition: Of moves, or None.
        following: Which moves are to be followed, and what follows them, or None.
        new_limbs: Returns the limbs of a row's performer that settings call for, None if there are none.

    Attributes:
        follow: Which moves are to be followed.
        alignment: What follows them, or None.
        limbs: Key frames of limbs, or None.
        stepping: Steps, or None.
    """

    def __init__(
        self,
        row: Row,
        recognition: Recognition | None,
        following: tuple[Follow, Alignment | None],
        new_limbs: Callable[[Row, Settings], Limbs | None],
    ) -> None:
        self._recognition = recognition
        self.follow, self.alignment = following
        self._new_limbs = new_limbs
        self._given = row.plan.given
        self.stepping = _stepping_of(row)
        self.limbs: Limbs | None = self._limbs_of(row)

    @property
    def recognition(self) -> Recognition | None:
        """What recognises moves, or None."""
        return self._recognition

    @recognition.setter
    def recognition(self, recognition: Recognition | None) -> None:
        self._recognition = recognition

    def __bool__(self) -> bool:
        others = self.recognition, self.alignment, self.limbs, self.stepping
        return self._given.phase or any(other is not None for other in others)

    def _limbs_of(self, row: Row) -> Limbs | None:
        return self._new_limbs(row, row.plan.given)

    def adopt(self, row: Row, level: LevelName | float) -> None:
        """Go on with the settings of a row; what that ends of limbs is pending then.

        Args:
            row: The performer's, as it is now.
            level: The same.
        """
        given, limbs = row.plan.given, self.limbs
        if given.limbs != self._given.limbs:
            if limbs is not None:
                limbs.end_take()
            self.limbs = self._limbs_of(row)
            if limbs is not None:
                limbs.release()
        elif limbs is not None:
            limbs.follow(given, level)
        if _steps_differ(given, self._given):
            self.stepping = _stepping_of(row)
        if self.alignment is not None:
            self.alignment = self.alignment.adopt(given, int(row.clock["take"]), row.pending)
        self._given = given

    def push_one(self, row: Row, position: NDArray[np.float32], time: NDArray[np.float64]) -> bool:
        """Process one frame of a take that goes on, as `push`, more quickly.

        Args:
            row: The performer's.
            position: (1, J, 3) m.
            time: (1,) s.

        Returns:
            Whether it was processed; if not, the take ends before it.
        """
        seconds, limbs, recognition = float(time[0]), self.limbs, self._recognition
        if limbs is None or limbs.hold(seconds):
            done = engine.process_frame(row, position, time)
        else:
            done = limbs.take(position, time) or bool(self._push_limbs(limbs, row, position, time, None))
        if done and recognition is not None and not recognition.hold(position, seconds):
            self._read(recognition, row, position, time)
        alignment = self.alignment
        if done and alignment is not None and not alignment.hold(position, seconds):
            self._read(alignment, row, position, time)
        if done and self.stepping is not None and not self.stepping.hold(position, seconds):
            self._read(self.stepping, row, position, time)
        if done and self._given.phase:
            self._tell_phase(row)
        return done

    def push(
        self,
        row: Row,
        positions: NDArray[np.float32],
        times: NDArray[np.float64],
        first_frame: int | None = None,
    ) -> int:
        """Process frames, as `engine.process`, for the body, limbs and moves, and tell the phase.

        Args:
            row: The performer's.
            positions: (n, J, 3) m.
            times: (n,) s.
            first_frame: Number of the first frame; None to count on.

        Returns:
            How many were processed: all, or those before which the take ends.
        """
        if row.telling is None or not self._given.phase:
            return self._push_all(row, positions, times, first_frame)
        for i in range(len(times)):
            if not self._push_all(row, positions[i : i + 1], times[i : i + 1], _after(first_frame, i)):
                return i
            self._tell_phase(row)
        return len(times)

    def _tell_phase(self, row: Row) -> None:
        if row.telling is not None and row.clock["open"]:
            row.pending += row.telling.phase_news(int(row.clock["take"]), float(row.last_time[0]))

    def _push_all(
        self, row: Row, positions: NDArray[np.float32], times: NDArray[np.float64], first_frame: int | None
    ) -> int:
        """Process frames; events of moves, of what is followed, then of steps, come right after those of the same frame."""
        push = self._push_channels
        for reader in (self._recognition, self.alignment, self.stepping):
            if reader is not None:
                push = functools.partial(self._push_and_read, reader, push)
        return push(row, positions, times, first_frame)

    def _push_and_read(
        self,
        reader: Reader,
        push: Push,
        row: Row,
        positions: NDArray[np.float32],
        times: NDArray[np.float64],
        first_frame: int | None,
    ) -> int:
        """Process frames by `push`, and let a reader follow them, no farther than to the end of the take."""
        count, begin = len(times), 0
        if count == 1:
            done = push(row, positions, times, first_frame)
            if done:
                self._read(reader, row, positions, times)
            return done
        while begin < count:
            before = reader.to_bytes()
            stop = reader.follow(positions, times, begin)
            end = min(stop + 1, count)
            done = push(row, positions[begin:end], times[begin:end], _after(first_frame, begin))
            if begin + done < end:
                reader.go_back_to(before)
                reader.follow(positions[: begin + done], times[: begin + done], begin)
                return begin + done
            if stop < count:
                reader.news(int(row.clock["take"]), row.pending, row.origin)
            begin = end
        return count

    def _read(
        self,
        reader: Reader,
        row: Row,
        position: NDArray[np.float32],
        time: NDArray[np.float64],
    ) -> None:
        """Let a reader follow one frame that the body has processed."""
        if reader.follow(position, time, 0) == 0:
            reader.news(int(row.clock["take"]), row.pending, row.origin)

    def _push_channels(
        self, row: Row, positions: NDArray[np.float32], times: NDArray[np.float64], first_frame: int | None
    ) -> int:
        """Process frames; limbs have their say frame by frame, so that it does not matter how frames are cut."""
        if self.limbs is None:
            return engine.process_short(row, positions, times, first_frame)
        if len(times) == 1:
            return self._push_limbs(self.limbs, row, positions, times, first_frame)
        moments, begin = times.tolist(), 0
        while begin < len(moments):
            end = begin
            number = _after(first_frame, begin)
            if number is None or engine.counts_on(row, number):
                while end < len(moments) and self.limbs.hold(moments[end]):
                    end += 1
            if end > begin:  # they come too soon for limbs
                done = engine.process_short(row, positions[begin:end], times[begin:end], number)
            else:
                end += 1
                done = self._push_limbs(self.limbs, row, positions[begin:end], times[begin:end], number)
            begin += done
            if begin < end:
                break
        return begin

    def _push_limbs(
        self,
        limbs: Limbs,
        row: Row,
        position: NDArray[np.float32],
        time: NDArray[np.float64],
        first_frame: int | None,
    ) -> int:
        """Process one frame, of the body and of its limbs; return 0 if the take ends before it."""
        counted = first_frame is None or engine.counts_on(row, first_frame)
        if counted and limbs.take(position, time):
            return 1
        done = engine.process_short(row, position, time, first_frame)
        if done:
            limbs.push(position, time)
        return done

    def apply_level(self, row: Row) -> None:
        """Let a level that moved act, of the body and of limbs."""
        engine.apply_level(row)
        if self.limbs is not None:
            self.limbs.apply_level()

    def end_take(self, row: Row, reason: str) -> None:
        """End the take: of moves, of the body, of limbs; then report that it has ended."""
        self.apply_level(row)
        if self.stepping is not None:
            self.stepping.forget()
        if self.recognition is not None:
            self.recognition.end(row.pending)
        if self.alignment is not None:
            self.alignment.end(int(row.clock["take"]), row.pending)
        engine.close_take(row)
        if self.limbs is not None:
            self.limbs.end_take()
        engine.report_end(row, reason)

    def forget_ranges(self) -> None:
        """Forget the ranges of limbs, after their takes ended."""
        if self.limbs is not None:
            self.limbs.forget_ranges()

    def mend(self, row: Row) -> None:
        """Finish what an exception cut short; see `engine.mend`."""
        engine.mend(row)
        if self.limbs is not None:
            self.limbs.mend()
        if self.recognition is not None:
            self.recognition.mend(int(row.clock["take"]), row.pending)
        if self.alignment is not None:
            self.alignment.mend(int(row.clock["take"]), row.pending)

    def release(self) -> None:
        """Give back what limbs lie in."""
        if self.limbs is not None:
            self.limbs.release()

    @property
    def bytes_taken(self) -> int:
        """Bytes of what is known here, besides what is shared with others."""
        more = 0 if self._recognition is None else self._recognition.bytes_taken
        more += 0 if self.alignment is None else self.alignment.bytes_taken
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
            follow=self.follow,
            followed=None if self.alignment is None else self.alignment.to_bytes(),
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


def _after(first_frame: int | None, count: int) -> int | None:
    """Return the number of the frame so many after the first one; None to count on."""
    return None if first_frame is None else first_frame + count


def _stepping_of(row: Row) -> Stepping | None:
    given = row.plan.given
    return Stepping(row.plan.skeleton, given, row.name) if given.steps and row.plan.channel == BODY else None


def _steps_differ(given: Settings, before: Settings) -> bool:
    fields = ("steps", "feet", "step_sensitivity", "up")
    return any(getattr(given, name) != getattr(before, name) for name in fields)
