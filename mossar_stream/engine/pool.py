"""Pool: rows of memory for performers who share skeleton, settings and rate, so that one call serves many."""

import math

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.row import ROW, ROW_BYTES, records, region
from mossar_stream.engine.buffers import Buffers
from mossar_stream.engine.plan import Plan, move_row
from mossar_stream.events import Event
from mossar_stream.memory.event_buffer import Source
from mossar_stream.repetitions.counting import look
from mossar_stream.repetitions.state import adopt_counted
from mossar_stream.repetitions.telling import Telling

ROWS = 64  # of a pool for many
FIRST_ROWS = 8  # of the first pool: most plans have few performers, and skeletons may come and go
MOST_BYTES = 1 << 26  # of a pool for many, unless one row is larger


class Pool:
    """Rows of one plan.

    Args:
        plan: How the rows are laid out.
        buffers: May be shared with other pools of the plan, if they are used one after the other.
        memory: (n, row) bytes.
    """

    def __init__(self, plan: Plan, buffers: Buffers, memory: NDArray[np.uint8]) -> None:
        self.plan = plan
        self.buffers = buffers
        self.memory = memory
        self.is_open = memory[:, :ROW_BYTES].view(ROW)[:, 0]["clock"]["open"]
        self.sources: dict[int, Source] = {}  # of the rows in use
        self._free = list(range(len(memory)))[::-1]
        self._used: set[int] = set()

    @property
    def is_full(self) -> bool:
        """Whether there is no row left."""
        return not self._free

    def allocate(self, name: str) -> "Row":
        """Return a free row, prepared, for a performer of this name."""
        index = self._free.pop()
        if index in self._used:
            self.memory[index] = 0
        self._used.add(index)
        self.plan.prepare(self.memory[index], index)
        self.sources[index] = self.plan.source(name)
        return Row(self, index)

    def free(self, index: int) -> None:
        """Take back a row."""
        del self.sources[index]
        self._free.append(index)

    def take_events(self) -> list[Event]:
        """Return what lies in the event buffer, and empty it."""
        return self.buffers.take_events(self.sources)


class Row:
    """A performer's row: in a pool, until it needs one with more room.

    Args:
        pool: The pool.
        index: Which row of it.

    Attributes:
        plan: How the row is laid out and filled in.
        name: The performer's.
        memory: (1, row) bytes.
        state: ROW, the row's records.
        clock: CLOCK, one of them.
        last_time: (1,) s, `clock["time"]`: a number of an array takes a fifth of the time of a record's.
        taken_time: (1,) s, `clock["taken_time"]`.
        present: (1,) joints in the last frame, `joints["present"]`.
        counted: (1,) HEADER of repetitions; empty unless they are counted here.
        samples: float32, the poses in which they are counted; empty likewise.
        adopted: (1,) HEADER of a limb: what is counted of its body; empty if it does not matter.
        looks: What was counted after each look, with the time of the frame after it, s; None if nobody asks for it.
        telling: What is told of them; None if nobody asks for it.
        is_live: Whether the take that is open has been told of.
        origin: (3,) m, what is taken off positions in this take; None for nothing.
        is_placed: Whether that was found; it is not before somebody was seen.
        pending: Events for the next push.
        guard: Of the pool's buffers.
        is_level_new: Whether the level moved, and what follows from that waits for the next push, too.
    """

    def __init__(self, pool: Pool, index: int) -> None:
        self.name = pool.sources[index].performer
        self.pending: list[Event] = []
        self.is_level_new = False
        self.looks: list[tuple[float, NDArray[np.void]]] | None = None
        self.telling: Telling | None = None
        self._enter(pool, index)

    def _enter(self, pool: Pool, index: int) -> None:
        self.pool, self.index, self.plan = pool, index, pool.plan
        self.memory = pool.memory[index : index + 1]
        self.params, self.guard = pool.plan.params, pool.buffers.guard
        self.state = records(self.memory[0])
        self.clock = self.state["clock"]
        whole = self.memory[:, :ROW_BYTES].view(ROW)[:, 0]
        self.last_time, self.taken_time = whole["clock"]["time"], whole["clock"]["taken_time"]
        self.present = whole["joints"]["present"]
        self.counted = region(self.memory[0], self.plan.shape, "counted")
        self.samples = region(self.memory[0], self.plan.shape, "samples")
        self.adopted = region(self.memory[0], self.plan.shape, "adopted")
        self._renew_telling()
        self.look()
        self.indices = np.array([index])

    def _renew_telling(self) -> None:
        """Tell of what is counted in the row, if the settings call for it; go on if it is so already."""
        if self.plan.given.repetitions:
            self.telling = self.telling or Telling(self.plan.skeleton, self.name, self.plan.channel)
            self.telling.look_into(self.counted)
        else:
            self.telling = None

    def look_at_repetitions(self, time: float = math.inf) -> list[Event]:
        """Look at what was repeated as often as is due before a frame, s, once more if the take ends; return what to say."""
        if not len(self.counted):
            return []
        changed = look(self.counted, self.samples, *self.pool.buffers.for_looks, time)
        if self.looks is not None:
            self.looks.append((time, self.counted.copy()))
        return self.telling.news(int(self.clock["take"])) if changed and self.telling is not None else []

    def adopt_repetitions(self, counted: NDArray[np.void]) -> None:
        """Let a limb know what is counted of its body, `counted` of the body's row."""
        if len(self.adopted):
            adopt_counted(self.adopted, counted)

    def look(self) -> None:
        """Take note of what is in the row."""
        joints = self.state["joints"]
        origin = np.array([joints["origin_x"], joints["origin_y"], joints["origin_z"]])
        self.is_live = bool(self.clock["open"])
        self.is_placed = bool(joints["placed"])
        self.origin = origin if origin.any() else None

    def settle(self, origin: NDArray[np.float64], found: bool) -> None:
        """Take off this much from positions until the take ends; look for it again if nobody was found."""
        joints = self.state["joints"]
        joints["origin_x"], joints["origin_y"], joints["origin_z"] = origin
        joints["placed"] = found
        self.is_placed = found
        self.origin = origin if origin.any() else None

    def take_pending(self) -> list[Event]:
        """Return the events that wait for the next push."""
        events, self.pending = self.pending, []
        return events

    def replan(self, plan: Plan) -> None:
        """Go on with another plan for rows that are laid out the same."""
        self.plan = plan
        self.pool.sources[self.index] = plan.source(self.name)
        plan.prepare(self.memory[0], self.index)

    def restart(self, plan: Plan) -> None:
        """Begin in a row of another plan, but count takes and frames on."""
        take, counters = int(self.clock["take"]), self.state["counters"].copy()
        self._leave_for(plan)
        self.clock["take"] = take
        self.state["counters"] = counters

    def grow(self, plan: Plan) -> None:
        """Go on in a row with more room.

        Args:
            plan: The same, but larger.
        """
        old, before, is_live = self.memory[0].copy(), self.plan, self.is_live
        self._leave_for(plan)
        move_row(old, before, self.memory[0], plan)
        self.look()
        self.is_live = is_live

    def _leave_for(self, plan: Plan) -> None:
        self.release()
        other = pool_of_one(plan, self.name)
        other.pool.buffers.guard = self.guard  # the thread that is in stays in
        self._enter(other.pool, other.index)

    def move_to(self, memory: NDArray[np.uint8], buffers: Buffers) -> None:
        """Go on in other memory of the same length, (1, row) bytes, with other buffers, which are large enough."""
        content, is_live = self.memory[0].copy(), self.is_live
        self.release()
        pool = Pool(self.plan, buffers, memory)
        self._enter(pool, pool.allocate(self.name).index)
        self.memory[0] = content
        self.clock["row"] = self.index
        self.look()
        self.is_live = is_live

    def release(self) -> None:
        """Give the row back."""
        self.pool.free(self.index)


def pool_of_one(plan: Plan, name: str, content: NDArray[np.uint8] | None = None) -> Row:
    """Return the row of a performer who has a pool for itself.

    Args:
        plan: How the row is laid out.
        name: The performer's.
        content: Bytes of such a row that there is already.
    """
    row = Pool(plan, Buffers(plan), plan.new_memory(1)).allocate(name)
    if content is not None:
        row.memory[0] = content
        row.look()
    return row


class Pools:
    """Pools of one plan, as many as are needed.

    Args:
        plan: How the rows are laid out.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._buffers = Buffers(plan)
        self._pools: list[Pool] = []

    def allocate(self, name: str) -> Row:
        """Return a free row, prepared, for a performer of this name."""
        self.drop_empty()
        for pool in self._pools:
            if not pool.is_full:
                return pool.allocate(name)
        most = ROWS if self._pools else FIRST_ROWS
        rows = max(1, min(most, MOST_BYTES // self._plan.row_bytes))
        self._pools.append(Pool(self._plan, self._buffers, self._plan.new_memory(rows)))
        return self._pools[-1].allocate(name)

    def allocate_alone(self, name: str) -> Row:
        """Return a row, prepared, in memory of its own, for a performer of this name."""
        return Pool(self._plan, self._buffers, self._plan.new_memory(1)).allocate(name)

    def drop_empty(self) -> None:
        """Give the memory back in which nobody is left."""
        self._pools = [pool for pool in self._pools if pool.sources]
