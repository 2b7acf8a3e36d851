"""Stream time: from when to when each performer was seen, and whether all have reached the end that was asked for."""

from mossar_adapters.replay.interleaving import part
from mossar_stream import Frames


class StreamTime:
    """The time of each performer, on its source's clock.

    Args:
        seconds: How much of each performer's time is wanted; None for all.

    Example:
        >>> import numpy as np
        >>> time = StreamTime(seconds=1.0)
        >>> frames = Frames(np.zeros((3, 1, 3), np.float32), np.array([5.0, 5.5, 6.0]))
        >>> len(time.within(frames)), time.over()
        (2, True)
    """

    def __init__(self, seconds: float | None = None) -> None:
        self.spans: dict[str, tuple[float, float]] = {}  # first and last time of each performer, s
        self._seconds = seconds
        self._absent: set[str] = set()  # performers who have left, or whose frames have stopped

    def within(self, frames: Frames) -> Frames:
        """Return those frames that come before the end of their performer's time."""
        name, last = frames.performer, float(frames.times[-1])
        first = self.spans.get(name, (float(frames.times[0]), 0.0))[0]
        self.spans[name] = (first, last)
        self._absent.discard(name)
        if self._seconds is None or last - first < self._seconds:
            return frames
        kept = int((frames.times - first < self._seconds).sum())
        return part(frames, 0, kept)

    def absent(self, name: str) -> None:
        """Take note that a performer has left, or that its frames have stopped: its end is not awaited."""
        self._absent.add(name)

    def over(self) -> bool:
        """Return whether every present performer has reached the end, and there is one."""
        if self._seconds is None:
            return False
        reached = {name for name, (first, last) in self.spans.items() if last - first >= self._seconds}
        return bool(reached) and reached | self._absent >= self.spans.keys()

    def forget(self, kept: set[str]) -> None:
        """Forget all others."""
        self.spans = {name: span for name, span in self.spans.items() if name in kept}
        self._absent &= kept
