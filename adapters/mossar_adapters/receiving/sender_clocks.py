"""Sender clocks: whether the times that a sender gives can be used, judged frame by frame against the arrivals.

Seen in the wild: a clock that stands still; Unix seconds in a float32, which step by 128 s; whole and quarter seconds;
milliseconds and frame numbers instead of seconds. Frames whose times look right pass at once. From the first step that
does not look right on, frames are held back until it is clear whether the clock runs:

=========  =========================================================================  ================================
step       what it is                                                                 what follows
=========  =========================================================================  ================================
standing   the same time as before with another pose, or hardly a later one           many: arrivals
leaping    far more than has passed by the arrivals                                   several in a row: another unit,
                                                                                      else arrivals; one: a clock was set
backwards  less than before, step for step                                            several in a row: arrivals
running    anything else                                                              a few in a row: the clock is used
=========  =========================================================================  ================================

Over spans of half a second in which the clock was not set, its rate is compared with that of the arrivals. At less than
12 or more than 250 Hz by the sender, and another rate by arrival, the clock is not used. A rate that both replays and
clocks may have is noted, and the sender's times are used.

Times by arrival continue where the sender's times ended. A clock that was found not to run is not used again.
"""

from collections.abc import Callable
from typing import Final, Generic, TypeVar

import msgspec
import numpy as np

from mossar_adapters.receiving.steady import Steady

MOST_HELD: Final = 64  # frames
LONGEST_HELD: Final = 0.5  # s
_PATIENCE: Final = 0.1  # s without a frame after which those held back may go on,
_MISSED: Final = 3  # and as many times from frame to frame
USUAL_RATE: Final = 30.0  # Hz, of frames with meaningless arrivals
_STANDING: Final = 4  # standing steps; fewer are frames that were sent twice
_OFTEN: Final = 8  # in the long run, if they are more than one in so many
_SPAN: Final = 128  # steps, of the long run
_RUNNING: Final = 4  # running steps in a row after which the clock is used
_LEAPS: Final = 3  # leaping steps in a row
_BACKWARDS: Final = 4  # steps back in a row; frames that overtake each other have fewer
_LEAP: Final = 0.25  # s
_FASTER: Final = 4.0  # times the arrivals: replays up to this speed look right
_CREEP: Final = 0.004  # s; a step below it that is also a tenth of the arrivals' hardly moves
_NO_SECONDS: Final = 1e11  # later than any date: Unix time in ms has 12 digits or more before the point
_TOGETHER: Final = 1e-3  # s; frames that come in less were kept somewhere: their arrivals are meaningless
UNITS: Final = {"milliseconds": 1e-3, "microseconds": 1e-6, "ticks of 100 ns": 1e-7, "nanoseconds": 1e-9}
_RATES: Final = (5.0, 250.0)  # Hz of senders of poses
_SPANS: Final = 2  # in a row, of half a second, in which the rates differ
_FRAMES: Final = 6  # in a span, for a rate
_SURE: Final = (12.0, 250.0)  # Hz; replays at another speed have no other rates
_ALIKE: Final = 1.5  # ratio of rates up to which nothing is noted
_LATER: Final = 1e-4  # s from frame to frame at least

Kept = TypeVar("Kept")


class Verdict(msgspec.Struct):
    """State of a sender's clock; all its performers share it.

    Args:
        unit: Seconds per unit of its times.
        shift: Added to its times, s, so that they continue.
        ahead: Seconds to add to arrivals; None while the sender's times are used.
        unlike: Whether another rate than that of the arrivals was noted.
    """

    unit: float = 1.0
    shift: float = 0.0
    ahead: float | None = None
    unlike: bool = False


class _Held(msgspec.Struct, Generic[Kept]):
    kept: Kept
    sent: float  # s on the sender's clock, in its unit
    arrival: float  # s


class SenderClock(Generic[Kept]):
    """Times the frames of one performer.

    Args:
        verdict: Of the sender.
        differs: Whether two frames show different poses; asked only about frames with the same time.
        note: Receives one line for people when the verdict changes.
        rate: Hz at which frames are counted where the sender's clock does not run, in place of the arrivals.
        piped: Whether times of arrival may be meaningless, as those of a file that is read through a pipe.

    Example:
        >>> clock = SenderClock(Verdict(), lambda a, b: a != b, lambda text: None)
        >>> stands = [time for k in range(9) for _, time in clock.put(k, 100.0, k / 10)]
        >>> [round(time, 3) for time in stands]
        [100.0, 100.1, 100.2, 100.3, 100.4, 100.5, 100.6, 100.7, 100.8]
    """

    def __init__(
        self,
        verdict: Verdict,
        differs: Callable[[Kept, Kept], bool],
        note: Callable[[str], None],
        *,
        rate: float | None = None,
        piped: bool = False,
    ) -> None:
        self.verdict = verdict
        self.changed = 0  # frames with another time than the sender's
        self._differs, self._note = differs, note
        self._rate, self._piped = rate, piped
        self._steady: Steady | None = None  # once times follow the arrivals
        self._latest: _Held[Kept] | None = None  # frame
        self._out: _Held[Kept] | None = None  # the latest frame that was returned,
        self._time = float("-inf")  # and its time, s
        self._held: list[_Held[Kept]] = []
        self._passed = 0.0  # s between the latest two arrivals
        self._standing = self._leaping = self._running = 0  # steps: held, in a row, in a row
        self._backwards = 0  # steps back in a row
        self._turned = 0.0  # s, the time before them
        self._long = [0, 0]  # standing steps and all steps of the long run
        self._accepts_leaps = False  # whether leaps in a row turned out to be the sender's way
        self._span: _Held[Kept] | None = None  # first frame of the span whose rate is measured
        self._count = 0  # frames in it
        self._unlike = [0, 0]  # spans in a row at an impossible, and at another rate

    @property
    def holds(self) -> bool:
        """Whether frames are held back."""
        return bool(self._held)

    def put(self, kept: Kept, sent: float, arrival: float) -> list[tuple[Kept, float]]:
        """Take a frame and return those whose times are settled, with their times, s.

        Args:
            kept: The frame.
            sent: Its time on the sender's clock.
            arrival: Time of arrival, s.
        """
        frame = _Held(kept, sent, arrival)
        if self.verdict.ahead is not None:
            return [*self._by_arrival(), *self._by_arrival([frame])]
        before, self._latest = self._latest, frame
        if before is None:
            if self.verdict.unit == 1.0 and abs(sent) >= _NO_SECONDS:
                self._held.append(frame)  # no seconds; the next steps show its unit
                return []
            return self._by_sender([frame])
        step = (sent - before.sent) * self.verdict.unit
        self._judge(step, arrival - before.arrival, frame, before)
        if self._backwards == _BACKWARDS:
            self._held.append(frame)
            self._time = self._turned
            return self._distrust()
        if not self._held and self._running:
            runs = self._keeps_pace(frame)
            return self._by_sender([frame]) if runs else self._by_arrival([frame])
        self._held.append(frame)
        return self._decided()

    def settle(self, now: float = float("inf")) -> list[tuple[Kept, float]]:
        """Return the frames held back if nothing more comes.

        Args:
            now: s, on the clock of the arrivals.
        """
        if not self._held:
            return []
        wait = min(max(_PATIENCE, _MISSED * self._passed), LONGEST_HELD)
        if now - self._held[-1].arrival < wait and now - self._held[0].arrival < LONGEST_HELD:
            return []
        return self._decided(last=True)

    def _judge(self, step: float, passed: float, frame: _Held[Kept], before: _Held[Kept]) -> None:
        """Count a step of the sender's clock, s, while so much time passed by the arrivals, s."""
        self._passed = passed
        same = step == 0
        creeps = 0 < step < _CREEP < passed and step * 10 < passed
        standing = creeps or (same and self._differs(before.kept, frame.kept))
        leaping = step > max(_LEAP, _FASTER * passed) and not self._accepts_leaps
        self._long[0] += standing
        self._long[1] += 1
        if self._long[1] == _SPAN:
            self._long = [count // 2 for count in self._long]
        self._standing += standing
        if step >= 0 or self._backwards == 0:
            self._turned = self._time
        self._backwards = self._backwards + 1 if step < 0 else 0
        if leaping or step < -_LEAP:
            self._span = None  # a clock that was set has no rate over that span
        self._leaping = self._leaping + 1 if leaping else 0
        self._running = 0 if standing or leaping else self._running + 1
        self._accepts_leaps &= step > _LEAP

    def _keeps_pace(self, frame: _Held[Kept]) -> bool:
        """Compare the rates of sender and arrivals at the end of a span; return whether the sender's times are used."""
        if self._span is None or self._piped:
            self._span, self._count = frame, 0
            return True
        self._count += 1
        passed, sent = frame.arrival - self._span.arrival, (frame.sent - self._span.sent) * self.verdict.unit
        if passed < LONGEST_HELD or self._count < _FRAMES:
            return True
        count, self._span, self._count = self._count, frame, 0
        if sent <= 0:
            return True
        ratio, by_sender, by_arrival = sent / passed, count / sent, count / passed
        slow = by_sender < _SURE[0] <= by_arrival <= _SURE[1] and ratio > _FASTER
        fast = by_sender > _SURE[1] >= by_arrival and ratio * _FASTER < 1
        unlike = not 1 / _ALIKE <= ratio <= _ALIKE
        self._unlike = [
            n + 1 if apt else 0 for n, apt in zip(self._unlike, (slow or fast, unlike), strict=True)
        ]
        how = f"the sender's clock runs at {ratio:.3g} times the rate of the arrivals"
        if self._unlike[0] == _SPANS and self._out is not None:
            self.verdict.ahead = self._time - self._out.arrival
            self._note(f"{how}; frames get the times of their arrival")
            return False
        if self._unlike[1] == 2 * _SPANS and not self.verdict.unlike:
            self.verdict.unlike = True
            self._note(f"{how}, as in a replay at another speed; its times are used")
        return True

    def _decided(self, *, last: bool = False) -> list[tuple[Kept, float]]:
        """Return the frames held back if the unit of their times is clear; at last in any case."""
        count = len(self._held)
        full = last or count >= MOST_HELD or self._held[-1].arrival - self._held[0].arrival >= LONGEST_HELD
        often = self._long[0] >= _OFTEN and self._long[0] * _OFTEN >= self._long[1]
        most = self._standing >= (2 if full else _STANDING) and self._standing * 4 >= count
        if most or often:
            return self._distrust() if full or not self._piped else []
        if self._leaping >= _LEAPS:
            return self._leapt()
        if last and 1 < count <= 2 * self._standing:  # too few in a second to wait for more
            return self._distrust()
        alone = self._running and not self._standing
        if alone or self._running >= _RUNNING or (full and not self._leaping) or last:
            return self._trusted()
        return []

    def _trusted(self) -> list[tuple[Kept, float]]:
        """Return the frames held back with the sender's times."""
        held, self._held, self._standing = self._held, [], 0
        if not self._running and self.verdict.unit == 1.0 and abs(held[0].sent) >= _NO_SECONDS:
            self._read_as(_unit_of_date(held[0].sent))
        return self._by_sender(held)

    def _leapt(self) -> list[tuple[Kept, float]]:
        """Return the frames held back after leaps in a row: in another unit, by arrival, or as they are."""
        held = self._held
        step = float(np.median(np.diff([frame.sent for frame in held])))
        passed = (held[-1].arrival - held[0].arrival) / (len(held) - 1)
        name = _unit_of_steps(step, passed) if self.verdict.unit == 1.0 else None
        if name is not None:
            self._read_as(name)
        elif passed >= 2 * _TOGETHER:
            return self._distrust()
        else:
            self._accepts_leaps = True
        self._held, self._leaping, self._standing = [], 0, 0
        return self._by_sender(held)

    def _read_as(self, name: str) -> None:
        """Read the sender's times in another unit from now on; they continue where they were."""
        unit = UNITS[name]
        if self._out is not None:
            self.verdict.shift = self._time - self._out.sent * unit
        self.verdict.unit = unit
        self._note(f"the sender's times are {name}, not seconds; they are read so")

    def _distrust(self) -> list[tuple[Kept, float]]:
        """Return the frames held back with times by arrival."""
        first = self._out or self._held[0]
        time = self._time if self._out is not None else first.sent
        self.verdict.ahead = (time if abs(time) < _NO_SECONDS else 0.0) - first.arrival
        count = len(self._held)
        mean = (self._held[-1].arrival - self._held[0].arrival) / max(count - 1, 1)
        if self._piped and self._rate is None and mean < _TOGETHER:
            self._rate = USUAL_RATE
        by = "the times of their arrival" if self._rate is None else f"times at {self._rate:g} Hz (--fps)"
        self._note(f"the sender's clock {self._how()}; frames get {by}")
        return self._by_arrival()

    def _how(self) -> str:
        sent = [frame.sent * self.verdict.unit for frame in self._held]
        steps = np.diff(sent)
        if self._backwards == _BACKWARDS:
            return "runs backwards"
        if self._leaping >= _LEAPS:
            return f"runs at another rate than frames arrive (steps of {float(np.median(steps)):.3g} s)"
        late = steps[steps > 0]
        return f"steps by {float(late.max()):.3g} s" if len(late) else "stands still, or steps coarsely"

    def _by_sender(self, frames: list[_Held[Kept]]) -> list[tuple[Kept, float]]:
        verdict = self.verdict
        found = [(frame.kept, frame.sent * verdict.unit + verdict.shift) for frame in frames]
        if found:
            self.changed += len(found) if verdict.unit != 1.0 else 0
            self._out, self._time = frames[-1], found[-1][1]
        return found

    def _by_arrival(self, frames: list[_Held[Kept]] | None = None) -> list[tuple[Kept, float]]:
        """Return frames, those held back unless others are given, with times by arrival."""
        if frames is None:
            frames, self._held = self._held, []
        if not frames:
            return []
        found = []
        for frame in frames:
            self._time = self._arrived(frame)
            self._out = frame
            found.append((frame.kept, self._time))
        self.changed += len(found)
        return found

    def _arrived(self, frame: _Held[Kept]) -> float:
        """Return the time of the next frame by its arrival, s."""
        ahead = self.verdict.ahead or 0.0
        if self._rate is not None:
            return frame.arrival + ahead if self._out is None else self._time + 1 / self._rate
        if self._steady is None:
            self._steady = Steady()
            if self._out is not None:
                self._steady.time(self._out.arrival)
        return max(self._steady.time(frame.arrival) + ahead, self._time + _LATER)


def _unit_of_steps(step: float, passed: float) -> str | None:
    """Return the unit of times with such steps while so much passed from frame to frame, s; None if it is none."""
    if passed >= _TOGETHER:
        return next((name for name, unit in UNITS.items() if 1 / 3 < step * unit / passed < 3), None)
    rates = {name: 1 / (step * unit) for name, unit in UNITS.items()}
    likely = [name for name, rate in rates.items() if _RATES[0] <= rate <= _RATES[1]]
    return min(likely, key=lambda name: abs(np.log(rates[name] / USUAL_RATE)), default=None)


def _unit_of_date(sent: float) -> str:
    """Return the unit in which a time that cannot be seconds is a date."""
    digits = np.log10(abs(sent))
    limits = {"milliseconds": 14, "microseconds": 17, "ticks of 100 ns": 18}
    return next((name for name, limit in limits.items() if digits < limit), "nanoseconds")
