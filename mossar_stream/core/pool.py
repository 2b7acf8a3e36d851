"""Pool: rows of memory for performers who share skeleton, settings and rate, so that one call serves many."""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.buffers import Buffers
from mossar_stream.core.out import Source
from mossar_stream.core.plan import Plan, move_row
from mossar_stream.core.row import records, region
from mossar_stream.events import Event
from mossar_stream.repetitions.reporting import RepetitionReporter

ROWS_AT_ONCE = 64  # of a pool for many
FIRST_ROWS = 8  # of the first pool: most plans have few performers, and skeletons may come and go
MOST_BYTES = 1 << 26  # of a pool for many, unless one row is larger


KNOWN_NOISE = (
    "known",
    "silent",
    "heard",
    "estimate",
    "aside",
    "quietest",
    "loud",
    "floor",
)  # of the sensor, but for its rate


class Pool:
    """Rows of one plan.

    Args:
        plan: How the rows are laid out.
        buffers: Shared with other pools; made large enough.
        memory: (n, row) bytes.
    """

    def __init__(self, plan: Plan, buffers: Buffers, memory: NDArray[np.uint8]) -> None:
        self.plan = plan
        self.buffers = buffers
        self.memory = memory
        buffers.make_room(plan)
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
        number = self.buffers.enlist(source)
        self.plan.prepare(self.memory[index], number)
        return Row(self, index, source, number)

    def free(self, index: int, number: int) -> None:
        """Take back a row, whose events had this number; once, also if Ctrl-C cut this short before."""
        if number in self.buffers.sources:
            del self.buffers.sources[number]
            self._free += [index]  # no call since: both or none


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
        memory: Bytes.
        state: ROW, the row's records.
        clock: CLOCK, one of them.
        counted: (1,) HEADER of repetitions; empty unless they are counted here.
        counting: Bytes of it and of the poses in which they are counted; empty likewise.
        periods: (1,) PERIODS of it; empty likewise.
        adopted: (1,) PERIODS of a limb: what is counted of its body; empty if it does not matter.
        analyses: What was counted after each analysis, with the time of the frame after it, s; None if nobody asks for it.
        is_analysing: Whether the last analysis of a take is being reported.
        analysed_take: Number of the take of which that is done; -1 if of none.
        samples: How many there were before it.
        reporter: Their events; None without the setting.
        origin: (3,) m, what is taken off positions in this take; None for nothing.
        pending: Events that were caused and have not been handed to the caller, in order; of a limb its body's.
        ended: How many takes ended, as was reported; the clock counts them as they end.
        is_level_new: Whether the level moved, and what follows from that waits for the next push, too.
        is_torn: Whether an exception came while the row was worked on: `engine.mend` comes before anything else.
    """

    def __init__(self, pool: Pool, index: int, source: Source, number: int) -> None:
        self.name, self.pending, self.number = source.performer, source.pending, number
        self.is_level_new = self.is_torn = False
        self.analyses: list[tuple[float, NDArray[np.void]]] | None = None
        self.reporter: RepetitionReporter | None = None
        self.is_analysing = False
        self.analysed_take, self.samples = -1, 0
        self._successor: Row | None = None  # while the row moves
        self._enter(pool, index)
        self.note_end()

    def _enter(self, pool: Pool, index: int) -> None:
        self.pool, self.index, self.plan = pool, index, pool.plan
        self.memory = pool.memory[index]
        self.state = records(self.memory)
        self.clock = self.state["clock"]
        shape = self.plan.shape
        self.counted = region(self.memory, shape, "counted")
        self.periods = region(self.memory, shape, "periods")
        self.adopted = region(self.memory, shape, "adopted")
        begin, end = (shape.offsets()[0][name] for name in ("counted", "adopted"))
        self.counting = self.memory[begin:end]
        self._renew_reporter()
        self.find_place()

    @property
    def buffers(self) -> Buffers:
        """What compiled calls need besides."""
        return self.pool.buffers

    @property
    def is_live(self) -> bool:
        """Whether a take has begun whose end has not been reported."""
        return bool(self.clock["open"]) or int(self.clock["take"]) != self.ended

    @property
    def is_placed(self) -> bool:
        """Whether a take is open, and it is known where the performer is."""
        return bool(self.clock["open"]) and bool(self.state["joints"]["placed"])

    @property
    def is_full(self) -> bool:
        """Whether the row has no room for one more undecided key frame."""
        return int(self.state["window"]["undecided"]) > int(self.state["plan"]["room"])

    def note_end(self) -> None:
        """Note that the ends of all takes are reported."""
        self.ended = int(self.clock["take"])

    def _renew_reporter(self) -> None:
        """Report what is counted in the row, if the settings call for it; go on if it is so already."""
        if self.plan.user_settings.repetitions:
            self.reporter = self.reporter or RepetitionReporter(
                self.plan.skeleton, self.name, self.plan.channel
            )
            self.reporter.use(self.counted)
        else:
            self.reporter = None

    def adopt_periods(self, periods: NDArray[np.void]) -> None:
        """Let a limb know what is counted of its body, `periods` of the body's row."""
        if len(self.adopted):
            self.adopted[:] = periods

    def find_place(self) -> None:
        """Take note of where the performer is."""
        joints = self.state["joints"]
        origin = np.array([joints["origin_x"], joints["origin_y"], joints["origin_z"]])
        self.origin = origin if origin.any() else None

    def settle(self, origin: NDArray[np.float64], found: bool) -> None:
        """Take off this much from positions until the take ends; look for it again if nobody was found."""
        joints = self.state["joints"]
        joints["origin_x"], joints["origin_y"], joints["origin_z"] = origin
        joints["placed"] = found
        self.origin = origin if origin.any() else None

    def take_pending(self) -> list[Event]:
        """Return the events that wait, for the caller; no call in here, so that Ctrl-C finds them in one place."""
        pending = self.pending
        events = pending[:]
        del pending[:]
        return events

    def mend(self) -> None:
        """Finish a move that an exception cut short."""
        if self._successor is not None:
            self._become(self._successor)

    def forget_range(self) -> None:
        """Forget the running range and what is known of the noise, as for another person."""
        self.state["range"]["largest"] = 0.0
        for name in KNOWN_NOISE:
            self.state["noise"][name] = 0

    def replan(self, plan: Plan) -> None:
        """Go on with another plan for rows that are laid out the same."""
        self.plan = plan
        self.buffers.sources[self.number] = plan.source(self.name, self.pending)
        plan.prepare(self.memory, self.number)

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
        move_row(self.memory, self.plan, fresh.memory, plan)
        self._become(fresh)

    def _alone(self, plan: Plan) -> "Row":
        """Return a row in a pool of its own, for the same performer."""
        return Pool(plan, self.buffers, plan.new_memory(1)).allocate(self.name, self.pending)

    def _become(self, fresh: "Row") -> None:
        """Go on as another row, with its memory; `mend` finishes this if an exception comes."""
        self._successor = fresh
        old, index, number = self.pool, self.index, self.number
        self.number, self.pending = fresh.number, fresh.pending
        self._enter(fresh.pool, fresh.index)
        self._successor = None
        if old is not fresh.pool:
            old.free(index, number)

    def release(self) -> None:
        """Give the row back."""
        self.pool.free(self.index, self.number)


def new_row(plan: Plan, buffers: Buffers, name: str, pending: list[Event] | None = None) -> Row:
    """Return a row, prepared, that has a pool for itself.

    Args:
        plan: How the row is laid out.
        buffers: To work with.
        name: The performer's.
        pending: Where its events wait, if not in a list of its own.
    """
    return Pool(plan, buffers, plan.new_memory(1)).allocate(name, pending)


def restored_row(
    plan: Plan,
    buffers: Buffers,
    name: str,
    content: NDArray[np.uint8],
    pending: list[Event] | None = None,
) -> Row:
    """Return such a row with the bytes of another one."""
    row = new_row(plan, buffers, name, pending)
    row.memory[:] = content
    row.clock["row"] = row.number
    row.find_place()
    row.note_end()
    return row


class Pools:
    """Pools of one plan, as many as are needed.

    Args:
        plan: How the rows are laid out.
        buffers: To work with.
    """

    def __init__(self, plan: Plan, buffers: Buffers) -> None:
        self._plan = plan
        self._buffers = buffers
        self._pools: list[Pool] = []

    def allocate(self, name: str, pending: list[Event] | None = None) -> Row:
        """Return a free row, prepared, for a performer of this name; see `Pool.allocate`."""
        self.drop_empty()
        for pool in self._pools:
            if not pool.is_full:
                return pool.allocate(name, pending)
        most = ROWS_AT_ONCE if self._pools else FIRST_ROWS
        rows = max(1, min(most, MOST_BYTES // self._plan.row_bytes))
        self._pools.append(Pool(self._plan, self._buffers, self._plan.new_memory(rows)))
        return self._pools[-1].allocate(name, pending)

    def drop_empty(self) -> None:
        """Give the memory back in which nobody is left."""
        self._pools = [pool for pool in self._pools if not pool.is_empty]
