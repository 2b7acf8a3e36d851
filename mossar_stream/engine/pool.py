"""Pool: rows of memory for performers who share skeleton, settings and rate, so that one call serves many."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.noise import forget_noise
from mossar_stream.algorithm.row import ROW, ROW_BYTES, records, region
from mossar_stream.engine.buffers import Buffers
from mossar_stream.engine.plan import Plan, move_row
from mossar_stream.events import Event
from mossar_stream.memory.event_buffer import Source
from mossar_stream.repetitions.counting import look
from mossar_stream.repetitions.state import adopt_counted
from mossar_stream.repetitions.telling import Telling, Told

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
        self._free = list(range(len(memory)))[::-1]
        self._used: set[int] = set()  # rows that need be emptied before another performer gets them

    @property
    def is_full(self) -> bool:
        """Whether there is no row left."""
        return not self._free

    @property
    def is_empty(self) -> bool:
        """Whether no row is in use."""
        return len(self._free) == len(self.memory)

    def allocate(self, name: str, pending: list[Event] | None = None) -> "Row":
        """Return a free row, prepared, for a performer of this name.

        Args:
            name: The performer's.
            pending: Where its events wait, if not in a list of its own.
        """
        index = self._free.pop()
        if index in self._used:
            self.memory[index] = 0
        self._used.add(index)
        source = self.plan.source(name, [] if pending is None else pending)
        number = self.buffers.guard.enlist(source)
        self.plan.prepare(self.memory[index], number)
        return Row(self, index, source, number)

    def free(self, index: int, number: int) -> None:
        """Take back a row, whose events had this number."""
        self.buffers.guard.sources.pop(number, None)
        self._free.append(index)


class _Look(NamedTuple):
    """What was known before a look at repetitions."""

    looked: int  # samples at the look before
    told: Told | None


class Row:
    """A performer's row: in a pool, until it needs one with more room.

    Args:
        pool: The pool.
        index: Which row of it.
        source: Whose the row is.
        number: That its events carry.

    Attributes:
        plan: How the row is laid out and filled in.
        name: The performer's.
        memory: (1, row) bytes.
        state: ROW, the row's records.
        clock: CLOCK, one of them.
        last_time: (1,) s, `clock["time"]`: a number of an array takes a fifth of the time of a record's.
        taken_time: (1,) s, `clock["taken_time"]`.
        counted: (1,) HEADER of repetitions; empty unless they are counted here.
        samples: float32, the poses in which they are counted; empty likewise.
        adopted: (1,) HEADER of a limb: what is counted of its body; empty if it does not matter.
        looks: What was counted after each look, with the time of the frame after it, s; None if nobody asks for it.
        telling: What is told of them; None if nobody asks for it.
        is_live: Whether the take that is open has been reported.
        origin: (3,) m, what is taken off positions in this take; None for nothing.
        is_placed: Whether that was found; it is not before somebody was seen in the take that is open.
        pending: Events that were caused and have not been handed to the caller, in order; of a limb its body's.
        guard: Of the pool's buffers.
        is_level_new: Whether the level moved, and what follows from that waits for the next push, too.
        is_torn: Whether an exception came while the row was worked on: `engine.mend` comes before anything else.
    """

    def __init__(self, pool: Pool, index: int, source: Source, number: int) -> None:
        self.name, self.pending, self.number = source.performer, source.pending, number
        self.is_level_new = self.is_torn = False
        self.looks: list[tuple[float, NDArray[np.void]]] | None = None
        self.telling: Telling | None = None
        self._looking: _Look | None = None  # while repetitions are looked at
        self._successor: Row | None = None  # while the row moves
        self._enter(pool, index)

    def _enter(self, pool: Pool, index: int) -> None:
        self.pool, self.index, self.plan = pool, index, pool.plan
        self.memory = pool.memory[index : index + 1]
        self.params, self.guard = pool.plan.params, pool.buffers.guard
        self.state = records(self.memory[0])
        self.clock = self.state["clock"]
        whole = self.memory[:, :ROW_BYTES].view(ROW)[:, 0]
        self.last_time, self.taken_time = whole["clock"]["time"], whole["clock"]["taken_time"]
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

    def look_at_repetitions(self, time: float = math.inf) -> None:
        """Look at what was repeated as often as is due before a frame, s, once more if the take ends; tell of it."""
        if not len(self.counted):
            return
        telling = self.telling
        self._looking = _Look(int(self.counted["looked"][0]), None if telling is None else telling.told())
        changed = look(self.counted, self.samples, *self.pool.buffers.for_looks, time)
        if self.looks is not None:
            self.looks.append((time, self.counted.copy()))
        news = telling.news(int(self.clock["take"])) if changed and telling is not None else []
        self._looking = None
        self.pending += news

    def _finish_look(self) -> None:
        """Tell of what a look has changed, if an exception kept that from being told."""
        if self._looking is None:
            return
        news = []
        if self.telling is not None and self._looking.told is not None:
            self.telling.go_back_to(self._looking.told)
            if int(self.counted["looked"][0]) != self._looking.looked:
                news = self.telling.news(int(self.clock["take"]))
        self._looking = None
        self.pending += news

    def adopt_repetitions(self, counted: NDArray[np.void]) -> None:
        """Let a limb know what is counted of its body, `counted` of the body's row."""
        if len(self.adopted):
            adopt_counted(self.adopted, counted)

    def look(self) -> None:
        """Take note of what is in the row."""
        self.is_live = bool(self.clock["open"])
        self.look_for_place()

    def look_for_place(self) -> None:
        """Take note of where the performer is."""
        joints = self.state["joints"]
        origin = np.array([joints["origin_x"], joints["origin_y"], joints["origin_z"]])
        self.is_placed = self.is_live and bool(joints["placed"])
        self.origin = origin if origin.any() else None

    def settle(self, origin: NDArray[np.float64], found: bool) -> None:
        """Take off this much from positions until the take ends; look for it again if nobody was found."""
        joints = self.state["joints"]
        joints["origin_x"], joints["origin_y"], joints["origin_z"] = origin
        joints["placed"] = found
        self.is_placed = found and self.is_live
        self.origin = origin if origin.any() else None

    def take_pending(self) -> list[Event]:
        """Return the events that wait, for the caller; no call in here, so that Ctrl-C finds them in one place."""
        pending = self.pending
        events = pending[:]
        del pending[:]
        return events

    def tear(self) -> None:
        """Take note that an exception came while the row was worked on."""
        self.is_torn = True
        self.is_placed = False  # no frame goes the short way now

    def mend(self) -> None:
        """Finish a move and a look that an exception cut short."""
        if self._successor is not None:
            self._become(self._successor)
        self._finish_look()

    def forget_range(self) -> None:
        """Forget the running range and what is known of the noise, as for another person."""
        self.state["range"]["largest"] = 0.0
        forget_noise(self.state["noise"])

    def replan(self, plan: Plan) -> None:
        """Go on with another plan for rows that are laid out the same."""
        self.plan = plan
        self.guard.sources[self.number] = plan.source(self.name, self.pending)
        plan.prepare(self.memory[0], self.number)

    def restart(self, plan: Plan) -> None:
        """Begin in a row of another plan, but count takes and frames on."""
        fresh = self._alone(plan)
        fresh.clock["take"] = self.clock["take"]
        fresh.state["counters"] = self.state["counters"]
        self._become(fresh)

    def grow(self, plan: Plan) -> None:
        """Go on in a row with more room.

        Args:
            plan: The same, but larger.
        """
        fresh = self._alone(plan)
        move_row(self.memory[0], self.plan, fresh.memory[0], plan)
        self._become(fresh)

    def move_to(self, memory: NDArray[np.uint8], buffers: Buffers, pending: list[Event]) -> None:
        """Go on in other memory of the same length, (1, row) bytes.

        Args:
            memory: Zeros.
            buffers: Large enough for the row.
            pending: Where its events wait from now on.
        """
        fresh = Pool(self.plan, buffers, memory).allocate(self.name, pending)
        memory[0] = self.memory[0]
        fresh.clock["row"] = fresh.number
        self._become(fresh)

    def _alone(self, plan: Plan) -> "Row":
        """Return a row in a pool of its own, for the same performer; the thread that is in stays in."""
        return Pool(plan, Buffers(plan, self.guard), plan.new_memory(1)).allocate(self.name, self.pending)

    def _become(self, fresh: "Row") -> None:
        """Go on as another row, with its memory; `mend` finishes this if an exception comes."""
        self._successor = fresh
        old, index, number = self.pool, self.index, self.number
        is_live = self.is_live and bool(fresh.clock["open"])
        self.number, self.pending = fresh.number, fresh.pending
        self._enter(fresh.pool, fresh.index)
        self.is_live = is_live
        self.look_for_place()
        self._successor = None
        if old is not fresh.pool:
            old.free(index, number)

    def release(self) -> None:
        """Give the row back."""
        self.pool.free(self.index, self.number)


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
        row.clock["row"] = row.number
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
        self._pools = [pool for pool in self._pools if not pool.is_empty]
