"""Function: the calls of Flink for each record and each timer of a performer.

A restart gets the state written with a record, and the records behind it. The events after a failure are therefore the
same, byte for byte, as without it, and receivers can drop repeated ones by id and rev.
"""

import logging
import math
import time
from collections.abc import Iterator

from pyflink.common import Types
from pyflink.datastream import KeyedProcessFunction, RuntimeContext, TimeDomain
from pyflink.datastream.state import ValueStateDescriptor
from pyflink.metrics import Counter

from mossar_adapters.flink.following import Following, Line
from mossar_adapters.flink.job import Takes
from mossar_stream import Event, FrameError, Moves, Settings, to_json

END_OF_TIME = (1 << 63) - 1  # ms; the watermark at the end of files, and of a job that is drained
STATE = "segmenter"  # name of the state; under another one a saved state is not found

_log = logging.getLogger("mossar.flink")


class SegmentFunction(KeyedProcessFunction):  # type: ignore[misc]  # it has no types
    """Segments the records of a performer; yields events as JSON.

    Args:
        settings: Of the segmenters.
        takes: Times after which takes end without a frame.
        moves: That are recognised.
        follow: Names of those that are followed, or True for all.
    """

    def __init__(
        self,
        settings: Settings,
        takes: Takes,
        moves: Moves | None = None,
        follow: tuple[str, ...] | bool = (),
    ) -> None:
        self._settings = settings
        self._takes = takes
        self._moves = moves
        self._follow = follow

    def open(self, runtime_context: RuntimeContext) -> None:
        """Begin with the state that the engine kept."""
        # An array of bytes as such crashes thread mode where there is no value yet.
        self._state = runtime_context.get_state(ValueStateDescriptor(STATE, Types.PICKLED_BYTE_ARRAY()))
        metrics = runtime_context.get_metrics_group()
        self._taken: Counter = metrics.counter("mossar_records")
        self._refused: Counter = metrics.counter("mossar_refused_records")
        self._following = Following(self._settings, moves=self._moves, follow=self._follow)

    def process_element(self, value: bytes | str, ctx: KeyedProcessFunction.Context) -> Iterator[str]:
        """Process a record."""
        performer, now = ctx.get_current_key(), time.time()
        try:
            line, events = self._following.take(performer, value, now, self._state.value)
        except FrameError as error:
            self._refused.inc()
            _log.warning("performer %s: a record was refused: %s", performer, error)
            return
        self._taken.inc()
        self._state.update(line.snapshot())
        if line.due == math.inf:
            ctx.timer_service().register_event_time_timer(END_OF_TIME)
        self._set_timer(line, now + (self._takes.idle or self._takes.forget), ctx)
        yield from _lines(events)

    def on_timer(self, timestamp: int, ctx: KeyedProcessFunction.OnTimerContext) -> Iterator[str]:
        """End the take of a performer whose frames have stopped; forget one that left long ago."""
        del timestamp
        performer, now = ctx.get_current_key(), time.time()
        line = self._following.line(performer, now, self._state.value)
        if line is None:
            return
        if ctx.time_domain() == TimeDomain.EVENT_TIME:
            yield from self._end_take(line, "end of stream")
            return
        line.due = math.inf
        quiet = now - line.heard
        if quiet >= self._takes.forget:
            self._following.forget(performer)
            self._state.clear()
            ctx.timer_service().delete_event_time_timer(END_OF_TIME)
        elif 0 < self._takes.idle <= quiet:
            self._set_timer(line, line.heard + self._takes.forget, ctx)
            # The reason that the core gives when the next frame's time shows the pause.
            yield from self._end_take(line, "gap")
        else:
            self._set_timer(line, line.heard + (self._takes.idle or self._takes.forget), ctx)

    def _set_timer(self, line: Line, due: float, ctx: KeyedProcessFunction.Context) -> None:
        """Set a timer unless an earlier one is set: it moves on when it fires, cheaper than one for each record."""
        if due < line.due:
            line.due = due
            ctx.timer_service().register_processing_time_timer(int(due * 1000) + 1)  # ms, not before `due`

    def _end_take(self, line: Line, reason: str) -> Iterator[str]:
        events = line.segmenter.end_take(reason)
        if events:
            self._state.update(line.snapshot())
        return _lines(events)


def _lines(events: list[Event]) -> Iterator[str]:
    return (to_json(event).decode() for event in events)
