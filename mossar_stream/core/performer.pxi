"""Performer: one performer with limbs and readers, the owner of all memory; and the workspace that several performers share.

The interpreter, which looks for signals between steps of Python, runs no code of this file. Ctrl-C therefore acts before or
after a call, never within one, and no change is half done. Ctrl-C at the end of a call may lose its result; events therefore
wait in the list `pending` until the caller has taken them. `at_once` does several things as one.
"""

cdef enum:
    BATCH = 512  # events that there is room for besides those of one frame
    UNCHANGED = -1  # the first cycle that an analysis changed, if it changed none

from numpy import number as np_number

cdef str NOBODY = "nobody seen"  # in the reason for which a take ended
cdef str IN_USE = (
    "a segmenter, or the pool it belongs to, was used by two threads at once; use one for each thread, or a lock"
)
cdef str RELEASED = "the segmenter was released"


cdef class Workspace:
    """Scratch and the event buffer of one segmenter, or of a pool of performers, which take turns.

    It lets one thread in at a time: two would write into the same memory. The second one gets an error at once.
    """

    cdef Room room
    cdef cnp.ndarray scratch
    cdef cnp.ndarray store
    cdef cnp.ndarray events
    cdef public bint is_busy  # whether a thread is in

    def __cinit__(self):
        self.scratch = self.store = self.events = zeros(0)
        self.room.scratch = self.room.store = bytes_(NULL, 0)
        self.room.events.used = &self.room.used
        self.room.events.count = self.room.used = 0

    cdef int make_room(self, Plan* plan) except -1:
        """Grow for rows of a plan, too; the buffer must be empty."""
        cdef int64_t store = store_size(plan.joints) if plan.repetitions == 1 else 0
        if scratch_size(plan) > self.room.scratch.count:
            self.scratch = zeros(scratch_size(plan))
            self.room.scratch = bytes_(<uint8_t*>cnp.PyArray_DATA(self.scratch), scratch_size(plan))
        if store > self.room.store.count:
            self.store = zeros(store)
            self.room.store = bytes_(<uint8_t*>cnp.PyArray_DATA(self.store), store)
        if plan.most_events + BATCH > self.room.events.count:
            self.events = zeros((plan.most_events + BATCH) * sizeof(Event))
            self.room.events.at = <Event*>cnp.PyArray_DATA(self.events)
            self.room.events.count = plan.most_events + BATCH
        return 0

    cdef int hand_out(self, list performers) except -1:
        """Move the events of the buffer to the pending lists of their performers."""
        cdef EventSpan* events = &self.room.events
        cdef Event* event
        cdef Performer performer
        cdef int64_t i
        for i in range(self.room.used):
            event = &events.at[i]
            performer = performers[event.performer]
            performer.pending.append(event_of(performer.channels[event.channel], event))
        self.room.used = 0
        return 0

    cdef int enter(self) except -1:
        if self.is_busy:
            raise RuntimeError(IN_USE)
        self.is_busy = True
        return 0


cdef class Performer:
    """One performer with limbs and readers of the frames.

    Args:
        workspace: To work in.
        channels: The body's `Channel`, then those of limbs.
        joints: Of each limb: which joints of the performer they are; a negative one is the middle of the body.
        readers: `Reader` of its frames, in the order in which they report.
        phase: Whether the phase of each frame is reported.

    Attributes:
        pending: Events that were caused and have not been handed to the caller, in order: of one frame those of the body, of
            limbs, of readers, of the phase.
    """

    cdef readonly Workspace workspace
    cdef readonly tuple channels
    cdef readonly list pending
    cdef tuple joints
    cdef tuple readers
    cdef Seat seat
    cdef cnp.ndarray parts  # the arrays that the seat points to
    cdef cnp.ndarray followers
    cdef cnp.ndarray order
    cdef cnp.ndarray positions
    cdef cnp.ndarray frame  # (J, 3) float32 m, for a single frame

    def __init__(self, Workspace workspace, tuple channels, tuple joints=(), tuple readers=(), bint phase=False):
        self.workspace, self.pending = workspace, []
        self.set_up(channels, joints, readers, phase)
        self.frame = zeros(12 * self.body().row.plan.joints)

    def set_up(self, tuple channels, tuple joints, tuple readers, bint phase, /):
        """Go on with other limbs, readers and phase; see the class. Frames that are processed must not wait."""
        cdef cnp.ndarray parts = zeros(len(channels) * sizeof(Part)), followers = zeros(len(readers) * sizeof(Follower))
        cdef int64_t count = sum([len(own) for own in joints]), i, k = 0
        cdef cnp.ndarray order = zeros(8 * count), positions = zeros(12 * count)
        cdef Part* part
        cdef Channel channel
        cdef Reader reader
        for i in range(len(channels)):
            part, channel = <Part*>cnp.PyArray_DATA(parts) + i, channels[i]
            part.first = k if i > 0 else -1
            channel.row.clock.channel = i
            self.workspace.make_room(&channel.row.plan)
            if i > 0:
                for joint in joints[i - 1]:
                    (<int64_t*>cnp.PyArray_DATA(order))[k] = joint
                    k += 1
        for i in range(len(readers)):
            reader = readers[i]
            follower = <Follower*>cnp.PyArray_DATA(followers) + i
            follower.see = reader.see
            follower.state, follower.store = <uint8_t*>cnp.PyArray_DATA(reader.state), <uint8_t*>cnp.PyArray_DATA(reader.store)
            follower.periods = reader.hears()
        self.channels, self.joints, self.readers = channels, joints, readers
        self.parts, self.followers, self.order, self.positions = parts, followers, order, positions
        self.seat.parts, self.seat.limbs = <Part*>cnp.PyArray_DATA(parts), len(channels) - 1
        self.seat.followers, self.seat.readers = <Follower*>cnp.PyArray_DATA(followers), len(readers)
        self.seat.joints, self.seat.order = count, <int64_t*>cnp.PyArray_DATA(order)
        self.seat.positions, self.seat.phase = <float*>cnp.PyArray_DATA(positions), phase
        self.seat.frame = self.seat.stage = 0
        self.find_rows()

    cdef int find_rows(self) except -1:
        """Set the seat to the present rows, and to the reports that are wanted."""
        cdef int64_t i
        cdef Channel channel
        for i in range(len(self.channels)):
            channel = self.channels[i]
            self.seat.parts[i].row = channel.row
            self.seat.parts[i].measure = <Measure*>cnp.PyArray_DATA(channel.measure)
            self.seat.parts[i].heed = (
                ALL_ANALYSES if channel.analyses is not None else CHANGES if channel.reports else NO_ANALYSIS
            )
        return 0

    @property
    def main(self):
        """The channel of the body.

        Raises:
            RuntimeError: If the performer was released.
        """
        if self.seat.parts == NULL:
            raise RuntimeError(RELEASED)
        return self.channels[0]

    cdef Channel body(self):
        return <Channel>self.channels[0]

    cdef int enter(self) except -1:
        """Reserve the performer for this thread until `workspace.is_busy` is cleared."""
        if self.seat.parts == NULL:
            raise RuntimeError(RELEASED)
        return self.workspace.enter()

    def release(self):
        """Free the memory; the performer cannot be used afterwards.

        Raises:
            RuntimeError: If another thread is using it.
        """
        if self.workspace.is_busy:
            raise RuntimeError(IN_USE)
        self.seat.parts = NULL
        self.parts = self.followers = self.order = self.positions = None
        self.channels, self.readers = (), ()

    # Frames.

    def process(self, cnp.ndarray positions, cnp.ndarray times, first_frame=None, /):
        """Process frames among which takes may begin, take by take; the events are pending.

        Args:
            positions: (n, J, 3) m, in single or double precision, C-contiguous.
            times: (n,) float64 s.
            first_frame: Number of the first frame; None to count on.

        Raises:
            RuntimeError: If another thread is using the performer or its pool.
        """
        self.enter()
        try:
            self.take_by_take(positions, times, first_frame)
        finally:
            self.workspace.is_busy = False
        self.call_afterwards()

    def process_one(self, positions, time, /):
        """Process one frame of a take that goes on, if it is an array of (J, 3) numbers with a time.

        The lock of the interpreter is kept: releasing it takes as long as a frame.

        Returns:
            Whether it was processed; if not, the caller checks and processes it like any frames.
        """
        cdef Channel body
        cdef double moment
        cdef int64_t used
        cdef float* frame
        self.enter()
        try:
            body = self.body()
            if not body.is_placed() or body.is_level_new or not cnp.PyArray_CheckExact(positions):
                return False
            if isinstance(time, float):
                moment = <double>time
            elif isinstance(time, (int, np_number)):
                moment = time
            else:
                return False
            frame = self.frame_of(body, positions)
            if frame == NULL:
                return False
            used = self.run(frame, &moment, 1, True)
        finally:
            self.workspace.is_busy = False
        self.call_afterwards()
        return used == 1

    cdef float* frame_of(self, Channel body, cnp.ndarray given) except? NULL:
        """Return a frame in single precision, relative to the performer's place; NULL if it is not valid."""
        cdef int64_t joints = body.row.plan.joints
        cdef int kind = cnp.PyArray_TYPE(given)
        if cnp.PyArray_NDIM(given) != 2 or cnp.PyArray_DIM(given, 0) != joints or cnp.PyArray_DIM(given, 1) != 3:
            return NULL
        if not (kind in (cnp.NPY_FLOAT32, cnp.NPY_FLOAT64) and cnp.PyArray_ISCARRAY_RO(given)):
            if given.descr.kind not in (c"f", c"i", c"u"):
                return NULL
            given = given.astype(NP_DOUBLE, "C")
        if cnp.PyArray_TYPE(given) == cnp.NPY_FLOAT32 and not is_far_off(body.row):
            return <float*>cnp.PyArray_DATA(given)
        narrow_positions(given, 0, 3 * joints, &body.row.joints.origin_x, <float*>cnp.PyArray_DATA(self.frame))
        return <float*>cnp.PyArray_DATA(self.frame)

    cdef int take_by_take(self, cnp.ndarray positions, cnp.ndarray times, first_frame) except -1:
        """Process frames as `process` does."""
        cdef Row* row
        cdef double* moments = <double*>cnp.PyArray_DATA(times)
        cdef int64_t begin = 0, end, count = cnp.PyArray_DIM(times, 0)
        cdef cnp.ndarray narrowed
        cdef float* frames
        if self.body().is_level_new:
            self.apply_level()
        while begin < count:
            row = self.body().row
            end = count
            if row.plan.offline == 0 and not self.body().is_placed():
                end = begin + settle_row(row, positions, begin, count)
            if first_frame is not None:
                row.clock.next_frame = <int64_t>first_frame + begin
            narrowed = less_origin(row, positions, begin, end)
            frames = <float*>cnp.PyArray_DATA(narrowed) + (3 * begin * row.plan.joints if narrowed is positions else 0)
            begin += self.run(frames, moments + begin, end - begin, False)
            if begin < end:
                self.end_take_as(self.why_ended(moments[begin]))
        return 0

    cdef int64_t run(self, float* positions, double* times, int64_t count, bint keeps_lock) except -1:
        """Process frames of one take, and return the number of those before the end of the take."""
        cdef Room* room = &self.workspace.room
        cdef Seat* seat = &self.seat
        cdef Frames frames
        cdef int64_t stop
        frames.positions, frames.times, frames.count = positions, times, count
        frames.joints = seat.parts[0].row.plan.joints
        room.events.performer = seat.frame = seat.stage = 0
        while True:
            if keeps_lock:
                stop = run_frames(seat, room, &frames)
            else:
                with nogil:
                    stop = run_frames(seat, room, &frames)
            if room.used > 0:
                self.workspace.hand_out([self])
            if stop == DONE or stop == TAKE_ENDS:
                return seat.frame
            self.serve(stop, times)

    cdef int serve(self, int64_t stop, double* times) except -1:
        """Handle the reason for which the loop stopped; `times` are those of the frames, s."""
        cdef Channel body = self.body(), channel
        cdef Reader reader
        if stop == READ:
            reader = self.readers[self.seat.stage - self.seat.limbs - 2]
            reader.report(body.row.clock.take, &body.row.joints.origin_x, self.pending)
        elif stop == PHASE:
            if body.reports and body.row.clock.open == 1:
                report_phase(body, self.pending)
        elif stop == ANALYSED:
            channel = self.channels[self.seat.stage]
            if channel.analyses is not None:
                channel.analyses.append((times[self.seat.frame], channel.part("periods").copy()))
            if self.seat.changed == 1:
                report_repetitions(channel, self.pending)
        elif stop == RING_FULL:  # the source is quicker than its nominal rate
            self.grow(self.channels[self.seat.stage], True)
        elif stop == BODY_FULL:  # much is undecided, or a recording is long
            for channel in self.channels:
                if is_row_full(channel.row):
                    self.grow(channel, False)
        return 0

    cdef int grow(self, Channel channel, bint is_ring) except -1:
        channel.grow(is_ring)
        self.workspace.make_room(&channel.row.plan)
        return self.find_rows()

    cdef str why_ended(self, double time):
        """Return the reason for which a take ends before a frame at this time, s."""
        cdef Row* row = self.body().row
        cdef double step = time - row.clock.time
        if 0.0 <= step <= row.plan.max_pause:
            return NOBODY
        return "gap" if step > 0.0 else "clock stepped back"

    cdef int call_afterwards(self) except -1:
        cdef Reader reader
        for reader in self.readers:
            reader.afterwards()
        return 0

    # Ends of takes, and levels.

    cdef int update(self, Channel channel, int64_t reason) except -1:
        """Update the window of the body or a limb; see `step_window`."""
        cdef Row* row = channel.row
        cdef Measure* measure = <Measure*>cnp.PyArray_DATA(channel.measure)
        cdef Room* room = &self.workspace.room
        if reason == END or reason == RANK:
            self.analyse_once_more(channel)
        room.events.performer = 0
        if reason == RANK or reason == DECIDE:  # of a recording, which takes long
            with nogil:
                step_window(row, measure, room.scratch, room.events, reason)
        else:
            step_window(row, measure, room.scratch, room.events, reason)
        return self.workspace.hand_out([self])

    cdef int analyse_once_more(self, Channel channel) except -1:
        """Analyse the repetitions once more as the take ends; each analysis adds the newest pose to the samples."""
        cdef Row* row = channel.row
        cdef Counting* counted = counting_of(row)
        cdef bint is_changed
        if row.plan.repetitions == 0 or channel.analysed_take == row.clock.take:
            return 0
        counted.changed = UNCHANGED  # an analysis of too few samples leaves it as it was
        is_changed = analyse_repetitions(<uint8_t*>counted, self.workspace.room.store.at, INFINITY)
        if channel.analyses is not None:
            channel.analyses.append((INFINITY, channel.part("periods").copy()))
        if is_changed:
            report_repetitions(channel, self.pending)
        channel.analysed_take = row.clock.take
        return 0

    cdef int apply_level(self) except -1:
        """Apply a level that moved to the undecided key frames."""
        cdef Channel channel
        for channel in self.channels:
            if channel.is_level_new:
                self.update(channel, LEVEL)
                channel.is_level_new = False
        return 0

    cpdef int catch_up(self) except -1:
        """Set the clocks of limbs to the body's, and copy its periods to them."""
        cdef Row* body = self.body().row
        cdef Row* limb
        cdef int64_t i
        for i in range(1, len(self.channels)):
            limb = (<Channel>self.channels[i]).row
            if limb.clock.open == 1:
                limb.clock.used_frame, limb.clock.time = body.clock.used_frame, body.clock.time
                if body.clock.open == 1:
                    limb.clock.next_frame = body.clock.next_frame
            adopt_periods(limb, body)
        return 0

    cdef int close(self, Channel channel) except -1:
        """Decide everything in the take of the body or a limb; the end of a limb's take is not reported."""
        if channel.is_level_new:
            self.update(channel, LEVEL)
            channel.is_level_new = False
        if channel.row.clock.open == 1:
            self.update(channel, END)
        if channel.name != BODY:
            self.note_end(channel)
        return 0

    cdef int note_end(self, Channel channel) except -1:
        if channel.is_live():
            channel.forget_reports()
            channel.ended = channel.row.clock.take
        return 0

    cdef int end_take_as(self, str reason) except -1:
        """End the take: of readers, of the body, of limbs; then report that it has ended, for this reason."""
        cdef Channel body = self.body()
        cdef Reader reader
        self.apply_level()
        self.tell_last_periods(body)
        for reader in self.readers:
            reader.end(body.row.clock.take, self.pending)
        self.close(body)
        self.end_limbs()
        if body.is_live():
            self.pending.append(
                StreamEvent(performer=body.performer, event="ended", take=body.row.clock.take - 1, reason=reason)
            )
        return self.note_end(body)

    cdef int tell_last_periods(self, Channel body) except -1:
        """Let readers know, before the take ends, what is counted of all of it."""
        cdef int64_t i
        for i in range(self.seat.readers):
            if self.seat.followers[i].periods != NULL and body.row.clock.open == 1:
                self.analyse_once_more(body)
                tell_periods(&self.seat.followers[i], body.row)
        return 0

    cdef str reason_of(self, str reason):
        """Return the reason for which a take ends, with a note if every joint was missing, or at the origin, in all frames."""
        if self.body().is_placed():
            return reason
        return f"{reason}, {NOBODY}" if reason else NOBODY

    # Steps for `at_once`.

    def end_take(self, str reason, /):
        """End the take."""
        self.end_take_as(self.reason_of(reason))

    def end_take_for(self, str reason, /):
        """End the take, for this reason and no other."""
        self.end_take_as(reason)

    def hand_over(self, list others, /):
        """Append the pending events to another list."""
        others.extend(self.pending)
        self.pending.clear()

    def set_limbs(self, tuple limbs, tuple joints, /):
        """Go on with other limbs, and their joints; see the class."""
        self.set_up((self.body(), *limbs), joints, self.readers, self.seat.phase)

    def set_readers(self, tuple readers, bint phase, /):
        """Go on with other readers, and with the phase or without."""
        self.set_up(self.channels, self.joints, readers, phase)

    def end_limbs(self):
        """End the takes of limbs; their last segments end with the last frame in which the body was seen."""
        cdef Row* body = self.body().row
        cdef Channel limb
        self.catch_up()
        for limb in self.channels[1:]:
            limb.row.clock.shown_frame, limb.row.clock.shown_time = body.clock.shown_frame, body.clock.shown_time
            self.close(limb)

    def end_readers(self):
        """End the take of the readers alone."""
        cdef Reader reader
        for reader in self.readers:
            reader.end(self.body().row.clock.take, self.pending)

    def reset(self, str reason, /):
        """End the take, and forget the running range and the estimate of the noise, as for another person."""
        cdef Channel channel
        cdef Noise* noise
        self.end_take_as(self.reason_of("reset"))
        for channel in self.channels:
            channel.row.range.largest = 0.0
            noise = &channel.row.noise
            noise.known = noise.silent = noise.loud = 0
            noise.heard = noise.estimate = noise.aside = noise.quietest = noise.floor = 0.0
        self.pending.append(
            StreamEvent(performer=self.body().performer, event="reset", take=self.body().row.clock.take, reason=reason)
        )

    def replan(self, int64_t i, plan, tuple limbs, /):
        """Go on with another plan of the body or a limb, for which `Plan.continues` holds, and its `joint_limbs`."""
        (<Channel>self.channels[i]).replan(plan, limbs)
        self.find_rows()

    def restart(self, int64_t i, Channel fresh, /):
        """Begin in another row of the body or a limb, whose take is ended; but count takes and frames on."""
        cdef Channel old = self.channels[i]
        if i > 0:
            self.catch_up()
            self.close(old)
        fresh.row.clock.take = fresh.ended = old.row.clock.take
        memcpy(&fresh.row.counters, &old.row.counters, sizeof(Counters))
        channels = list(self.channels)
        channels[i] = fresh
        self.set_up(tuple(channels), self.joints, self.readers, self.seat.phase)

    def set_level(self, tuple strengths, /):
        """Move the level of body and limbs, which acts with the next push; their strengths."""
        cdef Channel channel
        self.catch_up()
        for channel, strength in zip(self.channels, strengths):
            channel.row.plan.beta = strength
            channel.is_level_new = True

    def settle(self):
        """Apply a level that moved, and let limbs catch up."""
        self.apply_level()
        self.catch_up()

    def decide(self, int64_t reason, /):
        """Rank or decide the key frames of a recording; see `step_window`."""
        self.update(self.body(), reason)


def at_once(performers, steps, /):
    """Do several things that neither Ctrl-C nor another thread can interrupt.

    Args:
        performers: Those that the steps change.
        steps: Tuples of a compiled function and its arguments.

    Raises:
        RuntimeError: If another thread is using one of the performers; nothing is done then.
    """
    cdef Performer performer
    cdef Workspace workspace
    cdef list entered = []
    for performer in performers:
        if performer.seat.parts == NULL:
            raise RuntimeError(RELEASED)
        if performer.workspace not in entered and performer.workspace.is_busy:
            raise RuntimeError(IN_USE)
        entered.append(performer.workspace)
    try:
        for workspace in entered:
            workspace.is_busy = True
        for step in steps:
            step[0](*step[1:])
    finally:
        for workspace in entered:
            workspace.is_busy = False
    for performer in performers:
        performer.call_afterwards()


def process_together(list performers, cnp.ndarray positions, cnp.ndarray times, /):
    """Process as many frames each of many performers, in one compiled call as far as their takes go on.

    Args:
        performers: P of them, with as many joints.
        positions: (P, n, J, 3) m, in single or double precision, C-contiguous.
        times: (P, n) float64 s, C-contiguous.

    Raises:
        RuntimeError: If another thread is using one of them; nothing is processed then.
    """
    cdef int64_t count = cnp.PyArray_DIM(positions, 1), many = len(performers), k, stop
    cdef cnp.ndarray begun = zeros(many * sizeof(Begun))
    cdef Begun* runs = <Begun*>cnp.PyArray_DATA(begun)
    cdef double* moments = <double*>cnp.PyArray_DATA(times)
    cdef bint is_single = cnp.PyArray_TYPE(positions) == cnp.NPY_FLOAT32
    cdef Performer performer
    cdef Channel body
    cdef list entered = []
    for performer in performers:
        if performer.seat.parts == NULL:
            raise RuntimeError(RELEASED)
        if performer.workspace.is_busy:
            raise RuntimeError(IN_USE)
    try:
        for k in range(many):
            performer = performers[k]
            performer.workspace.is_busy = True
            entered.append(performer.workspace)
            runs[k].room = &performer.workspace.room
            body = performer.body()
            if is_single and body.is_placed() and not body.is_level_new and not is_far_off(body.row):
                runs[k].seat = &performer.seat
                performer.seat.frame = performer.seat.stage = 0
        k = 0
        while True:
            with nogil:
                stop = _run_together(
                    runs, &k, many, <float*>cnp.PyArray_DATA(positions), moments, count, cnp.PyArray_DIM(positions, 2)
                )
            for performer in performers:
                if performer.workspace.room.used > 0:
                    performer.workspace.hand_out(performers)
            if stop == DONE:
                break
            (<Performer>performers[k]).serve(stop, moments + k * count)
        for k in range(many):  # a performer that needs its owner, or whose take ends, goes on alone
            performer = performers[k]
            begin = runs[k].processed
            if begin < count:
                if runs[k].seat != NULL:
                    performer.end_take_as(performer.why_ended(moments[k * count + begin]))
                performer.take_by_take(positions[k, begin:], times[k, begin:], None)
    finally:
        for workspace in entered:
            (<Workspace>workspace).is_busy = False
    for performer in performers:
        performer.call_afterwards()


cdef struct Begun:  # of one of many performers
    Seat* seat  # NULL for one that needs its owner
    Room* room
    int64_t processed  # frames


cdef int64_t _run_together(
    Begun* runs, int64_t* at, int64_t many, float* positions, double* times, int64_t count, int64_t joints
) noexcept nogil:
    """Process frames of performers from `at` on; return DONE, or the reason for which that one stopped; see `run_frames`."""
    cdef Frames frames
    cdef int64_t stop
    frames.count, frames.joints = count, joints
    while at[0] < many:
        if runs[at[0]].seat != NULL:
            frames.positions = positions + at[0] * count * joints * 3
            frames.times = times + at[0] * count
            runs[at[0]].room.events.performer = at[0]
            stop = run_frames(runs[at[0]].seat, runs[at[0]].room, &frames)
            if stop != DONE and stop != TAKE_ENDS:
                return stop
            runs[at[0]].processed = runs[at[0]].seat.frame
        at[0] += 1
    return DONE
