"""Buffers: what compiled calls need besides the performers: scratch, and the one buffer through which events leave."""

import itertools

import numpy as np

from mossar_stream.core.kernels import CACHE_LINE, RECORDS, analysis_bytes
from mossar_stream.core.out import Source, events_size, hand_out
from mossar_stream.core.plan import Plan, new_scratch
from mossar_stream.core.row import new_memory

IN_USE = "a segmenter, or the pool it belongs to, was used by two threads at once; use one for each thread, or a lock"
TOOLS_BYTES = RECORDS["Tools"].itemsize
BATCH = 512  # events that there is room for besides those of one frame


class Buffers:
    """Scratch and the event buffer of one segmenter, or of a pool of performers, who are worked on one after the other.

    They let one thread in at a time: two would write into the same rows and the same event buffer; the second one gets an
    error at once. The one that is in leaves by `is_busy = False` as the last statement under `try`, and once more under
    `except BaseException`. Neither `finally` nor a context manager would do: Ctrl-C could come just before their last step,
    and all would be locked out.

    Attributes:
        is_busy: Whether a thread is in.
        sources: Of the rows that are in use, by the numbers that their events carry.
        tools: Bytes: `TOOLS`, scratch, what analyses of repetitions need, events. Another array after `make_room`.
        scratch: A view of it.
        store: Likewise.
        events: Likewise.
    """

    def __init__(self) -> None:
        self.is_busy = False
        self.sources: dict[int, Source] = {}
        self._numbers = itertools.count()
        self._sizes = [0, 0, 0]
        self.scratch = self.store = self.events = self.tools = np.zeros(0, np.uint8)

    def make_room(self, plan: Plan) -> None:
        """Be large enough for rows of a plan, too."""
        needed = (
            len(new_scratch(plan.shape)),
            analysis_bytes(plan.shape.padded_joints) if plan.shape.repetitions else 0,
            events_size(plan.most_events + BATCH),
        )
        sizes = [max(pair) for pair in zip(needed, self._sizes, strict=True)]
        if sizes == self._sizes:
            return
        rounded = [-(-size // CACHE_LINE) * CACHE_LINE for size in (TOOLS_BYTES, *sizes)]
        at = np.cumsum(rounded).tolist()
        tools = new_memory(1, at[-1])[0]
        tools[:TOOLS_BYTES].view(np.int64)[:] = [n for pair in zip(at, sizes, strict=False) for n in pair]
        parts = [tools[begin : begin + size] for begin, size in zip(at, sizes, strict=False)]
        parts[-1][: len(self.events)] = self.events  # those that an exception left there
        view = memoryview(parts[-1])
        # No call from here on: after Ctrl-C all are of one array.
        self._sizes, self.tools, self._view = sizes, tools, view
        self.scratch, self.store, self.events = parts

    def enlist(self, source: Source) -> int:
        """Return a number for the events of a source, which no other one gets."""
        number = next(self._numbers)
        self.sources[number] = source
        return number

    def hand_out(self) -> None:
        """Add what lies in the event buffer to what waits at the performers, and empty it."""
        hand_out(self._view, self.sources)
