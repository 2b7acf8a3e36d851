"""The decoder of JSON lines: bytes in, in any pieces, metas and frames out. It never sees a stream.

Lines without a `type` may be poses in the shapes of pose estimators, as in files (`maps.poses`).
"""

import math

from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Counters
from mossar_adapters.maps.codec import from_json
from mossar_adapters.maps.intake import MapIntake
from mossar_adapters.maps.poses import PoseDecoder
from mossar_adapters.receiving.pose import Pose
from mossar_adapters.source import Departure, Meta
from mossar_stream import FrameError, Frames

MAX_LINE = 1 << 20  # bytes


class LineDecoder:
    r"""Turns JSON lines, one frame or meta map in each, into metas and frames.

    Args:
        options: The user's fps and unit.

    Example:
        >>> decoder = LineDecoder()
        >>> decoder.receive(b'{"type": "frame", "t": 0.5, "xyz": ', 0.0)
        []
        >>> meta, frames = decoder.receive(b"[[0, 1, 0]]}\n", 0.0)
        >>> meta.performer, frames.times.tolist()
        ('p1', [0.5])
    """

    def __init__(self, options: ReadOptions | None = None) -> None:
        self.counters = Counters()
        self.usable = 0  # frames
        self.problem = ""  # fault of the first malformed line
        self._intake = MapIntake(self.counters, options, piped=True)
        self._poses = PoseDecoder(options or ReadOptions())
        self._rest = b""  # of a line whose end has not come

    def receive(self, data: bytes, arrival: float) -> list[Meta | Frames | Departure]:
        """Return the messages that these bytes complete; malformed ones are counted and skipped.

        Args:
            data: Any number of lines, whole or not.
            arrival: Time of arrival, s.
        """
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            self._decode(line, arrival)
        if len(self._rest) > MAX_LINE:
            self._refuse(f"longer than {MAX_LINE} bytes")
            self._rest = b""
        return self._intake.batch.take()

    def end(self, arrival: float) -> list[Meta | Frames | Departure]:
        """Return the content of an unterminated last line, and of lines that were held back, at the end of the input."""
        found = self.receive(b"\n", arrival) if self._rest else []
        return [*found, *self._intake.batch.take(math.inf)]

    def idle(self, now: float) -> list[Meta | Frames | Departure]:
        """Return the frames held back after which nothing came until `now`, s."""
        return self._intake.batch.take(now)

    def _decode(self, line: bytes, arrival: float) -> None:
        if not line or line.isspace():
            return
        self.counters.received += 1
        try:
            found = from_json(line)
            if found is None and (poses := self._poses.receive(line, arrival)):
                for pose in poses:
                    self._intake.batch.put(pose)
                    self.usable += 1
                return
            said = self._intake.put(found, arrival)
            if isinstance(said, Meta) and self._intake.batch.fps is None:
                self._intake.batch.fps = said.fps
            self.usable += isinstance(said, Pose)
        except FrameError as error:
            self._refuse(str(error))

    def _refuse(self, why: str) -> None:
        self.counters.reject(why)
        self.problem = self.problem or f" (line {self.counters.received}: {why})"
