"""The ends of VMC frames.

A bundle is no frame, and nothing in the protocol closes one. Seen in the wild: bones, Root, OK, T; T first;
neither OK nor T. The rules:

===========  ==================================================================================================
message      effect
===========  ==================================================================================================
bone         opens a frame; if that bone is there already, closes the frame and opens the next
Root         belongs to the open frame; if that has one already, closes it; before bones, to the next frame
T            with bones before it, closes the frame and is its time; otherwise it is the time of the next frame
OK           closes the frame, which then waits for a T right after it, until senders are known to send none
idle gap     closes the frame: a short gap after the bone that ended the frame before; where OK or T end frames only
             a long one, since a busy sender may pause between the bundles of a frame
===========  ==================================================================================================
"""

import struct

from mossar_adapters.osc.assembly.known_joints import ClosedFrame, Row

_GAP_LOW, _GAP_HIGH, _INTERVAL = 0.004, 0.1, 0.04  # s
_GAP_MARKED = 0.25  # s; less than a stall, so that a sender's last frame comes before it
_RATES = (30, 60, 120, 24, 25, 50, 72, 90, 100, 144, 240)  # Hz
_float32 = struct.Struct("f")


class VmcFrames:
    """Cuts the messages of one sender into frames; each method returns the frames that it closes."""

    def __init__(self) -> None:
        self._open: ClosedFrame | None = None
        self._waiting: ClosedFrame | None = None  # closed by OK, its T may follow
        self._time_follows: bool | None = None  # whether a T comes after OK; None until seen
        self._next_time: float | None = None
        self._next_root: Row | None = None
        self._root: Row | None = None
        self._opened = 0.0  # arrival of the latest frame's first bone, s
        self._interval = _INTERVAL  # s between frames, smoothed
        self._newest = self._tail = ""  # latest bone of the open frame, last bone of the frame before
        self._marked = False  # whether OK or T ended the frame before
        self.last = 0.0  # arrival of the latest message, s

    @property
    def pending(self) -> bool:
        """Whether a frame is open or waits for its time."""
        return self._open is not None or self._waiting is not None

    def bone(self, name: str, row: Row, arrival: float) -> list[ClosedFrame]:
        """Take a bone."""
        self.last = arrival
        closed: list[ClosedFrame] = []
        if self._waiting is not None:
            self._time_follows = bool(self._time_follows)
            closed += self._let_go()
        if self._open is not None and name in self._open.rows:
            closed += self._close()
        if self._open is None:
            self._open = ClosedFrame({}, arrival, self._next_time, self._next_root)
            self._next_time = self._next_root = None
            if 0 < arrival - self._opened < 1.0:
                self._interval += (arrival - self._opened - self._interval) / 4
            self._opened = arrival
        self._open.rows[name] = row
        self._newest = name
        return closed

    def root(self, row: Row, arrival: float) -> list[ClosedFrame]:
        """Take the place of the whole."""
        self.last = arrival
        closed: list[ClosedFrame] = []
        if self._open is not None and self._open.root is not None:
            closed = self._close()
        if self._open is None:
            self._next_root = row
        else:
            self._open.root = row
        return closed

    def ok(self, arrival: float) -> list[ClosedFrame]:
        """Note that the sender has sent a frame."""
        self.last = arrival
        if self._open is None:
            return []
        if self._open.time is not None or self._time_follows is False:
            return self._close(marked=True)
        closed = self._let_go()
        self._waiting, self._open = self._open, None
        self._marked = True
        return closed

    def time(self, seconds: float, arrival: float) -> list[ClosedFrame]:
        """Take the sender's time."""
        self.last = arrival
        if self._open is not None and self._open.time is None:
            self._open.time = seconds
            return self._close(marked=True)
        if self._open is None and self._waiting is not None:
            self._waiting.time = seconds
            self._time_follows = True
            return self._let_go()
        closed = self._close()
        self._next_time = seconds
        return closed

    def idle(self, now: float) -> list[ClosedFrame]:
        """Close frames that nothing more comes for."""
        quiet = now - self.last
        closed: list[ClosedFrame] = []
        pause = min(max(self._interval / 2, _GAP_LOW), _GAP_HIGH)
        if quiet > (_GAP_MARKED if self._time_follows else pause):
            closed += self._let_go()
        unmarked = pause if self._newest == self._tail else _GAP_HIGH
        if quiet > (_GAP_MARKED if self._marked else unmarked):
            closed += self._close()
        return closed

    def _let_go(self) -> list[ClosedFrame]:
        """Close the frame that waits for its time."""
        waiting, self._waiting = self._waiting, None
        return [] if waiting is None else [self._finished(waiting)]

    def _close(self, *, marked: bool = False) -> list[ClosedFrame]:
        """Close the frame that waits for its time, and the open one."""
        closed = self._let_go()
        if self._open is not None:
            frame, self._open = self._open, None
            self._marked = marked
            closed.append(self._finished(frame))
        return closed

    def _finished(self, frame: ClosedFrame) -> ClosedFrame:
        self._root = frame.root = frame.root or self._root
        self._tail = self._newest
        return frame


def exact_time(seconds: float, fps: float | None) -> float:
    """Return the frame's time of a clock that was rounded to float32 on the way.

    A number that float32 cannot distinguish from a multiple of a usual frame time is that multiple. This keeps
    the equal spacing of the sent frames.

    Args:
        seconds: As received.
        fps: The user's rate, tried first.
    """
    for rate in (fps, *_RATES) if fps else _RATES:
        exact: float = round(seconds * rate) / rate
        if exact == seconds or _float32.unpack(_float32.pack(exact))[0] == seconds:
            return exact
    return seconds
