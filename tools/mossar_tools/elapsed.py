"""Elapsed: times since the beginning of the stream, independent of its source's clock."""

from typing import Final

_JUMP: Final = 2.0  # s between two frames from which on the source has begun to count anew
_NAMES: Final = 4096  # performers that are remembered


class _Span:
    """Frames without a jump of their clock.

    Args:
        origin: Time of the source's clock that counts as the beginning of the stream, s.
        first: Time of the first frame, s.
    """

    def __init__(self, origin: float, first: float) -> None:
        self.origin = origin
        self.first = self.last = first

    def has(self, time: float) -> bool:
        return self.first - _JUMP < time < self.last + _JUMP


class Elapsed:
    """Turns times of sources' clocks into seconds since the beginning of the stream.

    A performer who comes later, or a clock that jumps, continues at the stream's present time.

    Example:
        >>> elapsed = Elapsed()
        >>> elapsed.see("p1", 2190.0, 2230.0)
        >>> elapsed.since("p1", 2195.5)
        5.5
    """

    def __init__(self) -> None:
        self.seconds = 0.0  # of the stream so far
        # Of each performer the span before, and the present one.
        self._spans: dict[str, tuple[_Span, _Span]] = {}

    def see(self, performer: str, first: float, last: float) -> None:
        """Note frames: the times of the first and the last one, s."""
        before = self._spans.get(performer)
        if before is None or not before[1].has(first):
            begun = _Span(self._origin(first), first)
            self._spans[performer] = begun if before is None else before[1], begun
            if len(self._spans) > _NAMES:
                del self._spans[next(iter(self._spans))]
        span = self._spans[performer][1]
        span.last = max(span.last, last)
        self.seconds = max(self.seconds, span.last - span.origin)

    def since(self, performer: str, time: float) -> float:
        """Return a time as seconds since the beginning of the stream."""
        spans = self._spans.get(performer)
        if spans is None:
            return time
        former, present = spans
        return time - (former if former.has(time) and not present.has(time) else present).origin

    def _origin(self, first: float) -> float:
        """Return the origin of frames that begin at a time: that of others on the same clock, if there are any."""
        for _, span in self._spans.values():
            if span.has(first):
                return span.origin
        return first - self.seconds


def clock(seconds: float, digits: int = 1) -> str:
    """Return seconds as minutes and seconds.

    Example:
        >>> clock(40.04), clock(3725.0, 0), clock(-0.5)
        ('0:40.0', '1:02:05', '-0:00.5')
    """
    ticks = round(abs(seconds) * 10**digits)
    whole, rest = divmod(ticks, 10**digits)
    minutes, second = divmod(whole, 60)
    hours, minute = divmod(minutes, 60)
    sign = "-" if seconds < 0 and ticks else ""
    text = f"{hours}:{minute:02}:{second:02}" if hours else f"{minute}:{second:02}"
    return f"{sign}{text}.{rest:0{digits}}" if digits else f"{sign}{text}"
