"""Desk: what compiled calls need besides the performers: room to work in, and an outbox."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.window_step import new_scratch, update_window
from mossar_stream.engine.engine import run
from mossar_stream.engine.plan import Plan
from mossar_stream.engine.warm_up import warm_up
from mossar_stream.events import Event
from mossar_stream.memory.event_buffer import new_event_buffer, take_events

BATCH = 512  # events that there is room for besides those of one frame


class Desk:
    """Room to work in and an outbox for performers of one plan, one after the other.

    Building one compiles the kernels for the plan's similarity measure, or loads them.

    Args:
        plan: Of the performers.
    """

    def __init__(self, plan: Plan) -> None:
        self.params = plan.params
        self.joints = plan.skeleton.names
        self.room = new_scratch(plan.shape)
        self.outbox = new_event_buffer(plan.most_events + BATCH)
        self._out = memoryview(self.outbox)  # type: ignore[arg-type]
        self._most = plan.most_events
        warm_up(plan)

    def empty(self, performers: Mapping[int, str]) -> list[Event]:
        """Return what lies in the outbox; performers are named by row."""
        return take_events(self._out, performers, self.joints)

    def act(self, memory: NDArray[np.uint8], row: int, reason: int) -> None:
        """Let the compiled part do what is due for one performer."""
        update_window(memory, row, self.params, self.room, self.outbox, reason)

    def run(
        self,
        memory: NDArray[np.uint8],
        rows: NDArray[np.int64],
        begins: NDArray[np.int64],
        ends: NDArray[np.int64],
        cursor: NDArray[np.int64],
        positions: NDArray[np.float32],
        times: NDArray[np.float64],
    ) -> int:
        """Take frames of several performers in; see `run.run`."""
        return run(
            memory,
            rows,
            begins,
            ends,
            cursor,
            self.params,
            positions,
            times,
            self.room,
            self.outbox,
            self._most,
        )
