"""Channel: the body or a limb of a performer, with the row that holds its state."""

from mossar_stream.events import BODY


cdef cnp.ndarray zeros(int64_t size):
    """Return bytes, zero, that begin with a line of the cache.

    The compiled loops work on 64 bytes at a time; where these lie in two lines each, they take half as long again.
    """
    cdef cnp.npy_intp whole = size + CACHE_LINE
    cdef cnp.ndarray spare = cnp.PyArray_ZEROS(1, &whole, cnp.NPY_UINT8, 0)
    cdef int64_t begin = (CACHE_LINE - <size_t>cnp.PyArray_DATA(spare) % CACHE_LINE) % CACHE_LINE
    return spare[begin : begin + size]


def new_row(cnp.ndarray plan, /):
    """Return the bytes of a row that is laid out; all else is zero.

    Args:
        plan: (1,) Plan, without the sizes that follow from others.
    """
    cdef cnp.ndarray head = zeros(sizeof(Row)), memory
    cdef Row* row = <Row*>cnp.PyArray_DATA(head)
    memcpy(&row.plan, cnp.PyArray_DATA(plan), sizeof(Plan))
    lay_out_row(row)
    memory = zeros(row.at.end)
    memcpy(cnp.PyArray_DATA(memory), row, sizeof(Row))
    return memory


def lay_out(cnp.ndarray memory, cnp.ndarray plan, /):
    """Set plan and places of a row that is as long as the plan says; see `new_row`."""
    cdef Row* row = <Row*>cnp.PyArray_DATA(memory)
    memcpy(&row.plan, cnp.PyArray_DATA(plan), sizeof(Plan))
    lay_out_row(row)


cdef int64_t FARTHEST_SIZE = <int64_t>1 << 50


def row_bytes(cnp.ndarray plan, /):
    """Return the bytes of a row; see `new_row`."""
    cdef cnp.ndarray head = zeros(sizeof(Row))
    cdef Row* row = <Row*>cnp.PyArray_DATA(head)
    memcpy(&row.plan, cnp.PyArray_DATA(plan), sizeof(Plan))
    if max(row.plan.ring, row.plan.average_size, row.plan.history_size) > FARTHEST_SIZE:
        return FARTHEST_SIZE  # more than any memory; sums of such sizes would overflow
    lay_out_row(row)
    return row.at.end


def row_parts(cnp.ndarray memory, /):
    """Return the arrays of a row, flat: offset in bytes, name of the record or number type, and shape."""
    cdef Row* row = <Row*>cnp.PyArray_DATA(memory)
    cdef Plan* plan = &row.plan
    cdef Places* at = &row.at
    cdef int64_t places = plan.capacity + 2
    return {
        "body": (at.body, "float32", (body_numbers(plan.joints),)),
        "summaries": (at.summaries, "float64", (plan.slot_count * plan.slot,)),
        "unused": (at.unused, "int64", (plan.slot_count,)),
        "order": (at.order, "int64", (places,)),
        "keys": (at.keys, "Key", (places,)),
        "memo": (at.memo, "Memo", (plan.memo_size,)),
        "marks": (at.marks, "Mark", (plan.history_size,)),
        "counted": (at.counted, "Counting", (plan.repetitions,)),
        "periods": (at.periods, "Periods", (plan.repetitions,)),
        "samples": (at.samples, "uint8", (plan.samples,)),
        "adopted": (at.adopted, "Periods", (plan.adopts,)),
    }


cdef class Channel:
    """The body or a limb of a performer: its row, and the constant fields of its events.

    Args:
        plan: A `Plan` of plan.py.
        performer: Name.
        memory: Bytes of a row of the plan; it belongs to the channel from then on.

    Attributes:
        memory: The row; another array once it has grown.
        analyses: The counts after each analysis, with the time of the frame after it, s; None if they are not collected.
    """

    cdef object known_plan
    cdef Row* row
    cdef cnp.ndarray measure  # (1,) Measure
    cdef readonly cnp.ndarray memory
    cdef readonly str performer
    cdef readonly str name  # of the limb, or BODY
    cdef tuple joints  # their names
    cdef tuple limbs  # of each joint the limb that it belongs to, or None; empty without the setting `limbs`
    cdef str prefix  # of ids of key frames and segments in the take
    cdef int64_t prefix_take  # number of that take; -1 for none
    cdef bint is_level_new  # whether the level moved since the last push, which has to apply it
    cdef int64_t ended  # takes whose end is reported; the clock counts them as they end
    cdef public list analyses
    # Reports of repetitions.
    cdef bint reports  # whether anything is
    cdef int64_t analysed_take  # take of which the last analysis is done; -1 for none
    cdef int64_t total  # repetitions of the take that were reported
    cdef dict revisions  # messages by number of the repetition, for those that may still change
    cdef double phase_time  # s, of the last reported phase,
    cdef bint had_phase  # and whether it was one

    def __init__(self, plan, str performer, cnp.ndarray memory):
        self.performer, self.name = performer, plan.channel
        self.prefix_take = self.analysed_take = -1
        self.forget_reports()
        self.enter(memory)
        self.follow_plan(plan, plan.joint_limbs)
        self.ended = self.row.clock.take

    cdef void enter(self, cnp.ndarray memory):
        self.memory = memory
        self.row = <Row*>cnp.PyArray_DATA(memory)

    cdef int follow_plan(self, plan, tuple limbs) except -1:
        self.known_plan, self.measure = plan, plan.params
        self.joints, self.limbs, self.reports = plan.joint_names, limbs, plan.reports_repetitions
        return 0

    cdef int replan(self, plan, tuple limbs) except -1:
        """Go on with another plan, for which `Plan.continues` holds; the row keeps the room that it has."""
        cdef Plan* own = &self.row.plan
        cdef int64_t ring = own.ring, room = own.room, capacity = own.capacity
        self.follow_plan(plan, limbs)
        memcpy(own, cnp.PyArray_DATA(<cnp.ndarray>plan.record), sizeof(Plan))
        own.ring, own.room, own.capacity = ring, room, capacity
        lay_out_row(self.row)
        return 0

    cdef int grow(self, bint is_ring) except -1:
        """Move into a larger row; see `enlarge`."""
        cdef cnp.ndarray head = zeros(sizeof(Row)), memory
        cdef Row* row = <Row*>cnp.PyArray_DATA(head)
        memcpy(&row.plan, &self.row.plan, sizeof(Plan))
        enlarge(&row.plan, is_ring)
        lay_out_row(row)
        memory = zeros(row.at.end)
        memcpy(cnp.PyArray_DATA(memory), row, sizeof(Row))
        move_row(self.row, <Row*>cnp.PyArray_DATA(memory))
        self.enter(memory)
        return 0

    cdef void forget_reports(self):
        self.total, self.revisions, self.phase_time, self.had_phase = 0, {}, -INFINITY, False

    cdef bint is_live(self):
        """Return whether a take has begun whose end has not been reported."""
        return self.row.clock.open == 1 or self.row.clock.take != self.ended

    cdef bint is_placed(self):
        """Return whether a take is open, and it is known where the performer is."""
        return self.row.clock.open == 1 and self.row.joints.placed == 1

    @property
    def plan(self):
        """The plan of the row, with the room that it has by now."""
        cdef Plan* own = &self.row.plan
        sizes = own.ring, own.room, own.capacity
        if sizes != self.known_plan.sizes:
            self.known_plan = self.known_plan.with_sizes(*sizes)
        return self.known_plan

    @property
    def state(self):
        """ROW, the records, as a view."""
        return self.memory[: sizeof(Row)].view(RECORDS["Row"])[0]

    @property
    def clock(self):
        """CLOCK, one of them."""
        return self.state["clock"]

    @property
    def is_open(self):
        """Whether a take is open."""
        return self.row.clock.open == 1

    @property
    def take(self):
        """Number of the take that is open, or of the next one."""
        return self.row.clock.take

    @property
    def has_begun(self):
        """Whether a take has begun whose end has not been reported."""
        return self.is_live()

    def part(self, str name, /):
        """Return one of the row's arrays; see `row_parts`."""
        offset, kind, shape = row_parts(self.memory)[name]
        return cnp_ndarray(shape, RECORDS.get(kind, kind), self.memory, offset)

    def settle(self, origin, bint found, /):
        """Take off this much from positions, (3,) m, until the take ends.

        Args:
            origin: (3,) m.
            found: Whether the performer is there; else it is looked for again.
        """
        cdef JointsState* joints = &self.row.joints
        joints.origin_x, joints.origin_y, joints.origin_z = origin
        joints.placed = found

    def carry_on(self, counts, /):
        """Number takes and count frames on from the counts of another one; see `Segmenter.counts`."""
        cdef Counters* own = &self.row.counters
        self.row.clock.take = self.ended = counts["take"]
        own.frames, own.out_of_order, own.outliers = counts["frames"], counts["out_of_order"], counts["outliers"]
        own.held, own.gaps, own.unseen = counts["held"], counts["gaps"], counts["unseen"]

    def adopt_periods(self, cnp.ndarray periods, /):
        """Copy the periods of the body, (1,) Periods, to a limb that is judged by them."""
        if self.row.plan.adopts == 1:
            copy_periods(adopted_of(self.row), <Periods*>cnp.PyArray_DATA(periods))

    @property
    def repetitions(self):
        """Repetitions counted in the open take; 0 if they are not reported."""
        return total_of(counting_of(self.row)) if self.reports and self.row.clock.open == 1 else 0

    @property
    def phase(self):
        """Position of the latest frame in the cycle of a repeated movement, 0 to 1; None outside a bout."""
        if not self.reports or self.row.clock.open == 0:
            return None
        return phase_of(counting_of(self.row), self.row.clock.time)

    @property
    def reported(self):
        """The reports of repetitions: total, revisions, and the latest phase's time with whether it was one."""
        return self.total, dict(self.revisions), (self.phase_time, self.had_phase)

    def go_on_from(self, int64_t total, revisions, phase, /):
        """Continue earlier reports; see `reported`."""
        self.total, self.revisions = total, dict(revisions)
        self.phase_time, self.had_phase = phase


cdef object cnp_ndarray = __import__("numpy").ndarray
