"""Performer record: all that a run knows of one performer besides its segmenter, which the pool has.

A record exists from the first time that a source names the performer until a flood of names makes the run forget it.
Nothing about a performer is kept elsewhere in the run, so forgetting a record forgets all.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.pipeline.latency import Latency
from mossar_adapters.pipeline.odd_times import OddTimes
from mossar_adapters.pipeline.reasons import Reasons
from mossar_adapters.pipeline.stream_time import StreamTime
from mossar_adapters.pipeline.tally import Tally
from mossar_adapters.pipeline.watch import Watch
from mossar_adapters.source import Meta

_ALL = np.zeros(0, np.intp)  # joints, where none is left out


class LatestFrames(NamedTuple):
    """Times of arrival (monotonic s), and the last frame's time on the source's clock."""

    at: float
    time: float


class PerformerRecord:
    """State of one performer in a run.

    Args:
        name: In events.
        source: Index of the source.
        own: The source's name for the performer.
        received: Frames that the source has delivered so far.
    """

    def __init__(self, name: str, source: int, own: str, received: int = 0) -> None:
        self.name = name
        self.source = source
        self.own = own
        self.received = received  # frames
        self.meta: Meta | None = None  # last announcement of the source
        self.followed: Meta | None = None  # announcement to sinks of events, with the segmented skeleton
        self.body: NDArray[np.intp] = _ALL  # the joints of the segmented skeleton; none if all are
        self.latest: LatestFrames | None = None
        self.max_pause: float | None = None  # s, as settings have it; None until it is looked up
        self.unusable = 0  # frames that did not fit, or came while the performer was not followed
        self.is_refused = False  # whether there is no room
        self.is_unfollowed = False  # whether the skeleton cannot be segmented
        self.latency = Latency()
        self.time = StreamTime()
        self.steps = OddTimes()
        self.reasons = Reasons()
        self.watch = Watch()
        self.tally = Tally()
