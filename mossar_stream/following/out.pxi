"""Out: the events of moves that are followed."""

from mossar_stream.events import LEFT_REASONS, FollowEvent

# How likely a performance that has begun will be done. Logistic regression on 18,794 messages about right and wrong
# repetitions, other people's examples and other exercises. Scale and begin were fitted again on 38,516 messages, with own
# examples, one other's, and two each of four others; of each person left out in turn, tenths are true within 0.18.
# `python -m checks.following` prints the table.
cdef double CERTAIN_BEGIN = 1.6
cdef double CERTAIN_PROGRESS = 4.92
cdef double CERTAIN_COST = -0.44
cdef double CERTAIN_RESIDUAL = -5.42
cdef double CERTAIN_AGAIN = 1.72
cdef double MOVES_LEAST = 0.2  # extent, as a chord, from which a limb moves in an example
cdef double FAIR = 15.0  # degrees of deviation at which the score is a half


cdef class FollowReader(Reader):
    """Makes the events of moves that one performer follows; `following.alignment.Alignment` prepares it.

    Attributes:
        performer: Name that events carry.
        names: Of the moves.
        ends: Of each bone, the joint at its end.
        limbs: Of each limb, the numbers of its bones.
        extents: Of each example, the extent of each limb.
        boxes: (M, 2, B, 3), a part of the state.
        every: s, setting `follow_every`.
    """

    cdef public str performer
    cdef public tuple names
    cdef public list ends
    cdef public dict limbs
    cdef public list extents
    cdef public cnp.ndarray boxes
    cdef public double every

    def __cinit__(self, *_, **__):
        self.see = follow_frame

    cdef FollowMemory known(self):
        return open_follow_memory(<uint8_t*>cnp.PyArray_DATA(self.state), <FollowHead*>cnp.PyArray_DATA(self.store))

    cdef Periods* hears(self):
        return self.known().periods

    cdef int report(self, int64_t take, double* origin, list pending) except -1:
        cdef FollowMemory known = self.known()
        cdef int64_t m
        for m in range(len(self.names)):
            if known.happened[m] != MOVE_UNCHANGED:
                pending.append(self.event(&known, m, take))
        return 0

    cdef int end(self, int64_t take, list pending) except -1:
        self.decide(take, pending)
        self.begin()
        return 0

    def begin(self):
        """Begin anew, as for a take."""
        cdef FollowBank bank = open_follow_bank(<uint8_t*>cnp.PyArray_DATA(self.store))
        begin_follow_memory(<uint8_t*>cnp.PyArray_DATA(self.state), &bank)
        self.known().state.every = self.every

    cdef int decide(self, int64_t take, list pending) except -1:
        """Decide about the moves that are being made; `pending` gets the events."""
        cdef FollowMemory known = self.known()
        cdef int64_t m
        cdef bint more = True
        while more:
            more = finish_following(known.memory, <uint8_t*>cnp.PyArray_DATA(self.store))
            self.report(take, NULL, pending)
        for m in range(len(self.names)):
            known.happened[m] = MOVE_UNCHANGED
        return 0

    def counted(self):
        """Return the number of the latest performance, and how many are done of each name, in this take."""
        cdef FollowMemory known = self.known()
        return known.state.number, {name: known.moves[m].count for m, name in enumerate(self.names)}

    def decided(self, int64_t take):
        """Return the events of a `decide` at this moment, and `counted` after that; nothing is changed."""
        cdef cnp.ndarray before = self.state.copy()
        cdef list events = []
        self.decide(take, events)
        counted = self.counted()
        memcpy(cnp.PyArray_DATA(self.state), cnp.PyArray_DATA(before), cnp.PyArray_DIM(before, 0))
        return events, counted

    def set_every(self, double every):
        """Report progress every so many seconds."""
        self.every = self.known().state.every = every

    def now(self, int64_t m):
        """Return the fields of a `FollowState` of move m at the last frame; None if it is not being made."""
        cdef FollowMemory known = self.known()
        cdef FollowReport* report = <FollowReport*>(known.reports.at + m * known.reports.columns)
        if known.moves[m].active == 0:
            return None
        evaluate_move(known.memory, <uint8_t*>cnp.PyArray_DATA(self.store), m)
        return {
            "example": <int64_t>report.example, "count": <int64_t>report.count, "start": report.start,
            "time": report.time, "progress": report.progress, "tempo": report.tempo, "certainty": certainty(report),
            "deviation": report.deviation, "posture": report.posture, "limbs": self.judged(report), "joint": self.joint(report),
        }

    cdef dict judged(self, FollowReport* report):
        """Return the deviation of each limb that was not hidden for too long."""
        cdef double* angles = <double*>(report + 1)
        cdef int64_t i
        return {name: angles[i] for i, name in enumerate(self.limbs) if not isnan(angles[i])}

    cdef str joint(self, FollowReport* report):
        """Return the joint at the end of the bone that strays farthest."""
        return self.ends[<int64_t>report.joint] if report.joint >= 0.0 else ""

    cdef object event(self, FollowMemory* known, int64_t m, int64_t take):
        cdef FollowReport* report = <FollowReport*>(known.reports.at + m * known.reports.columns)
        cdef int64_t what = known.happened[m]
        cdef bint is_done = what == MOVE_DONE
        cdef dict limbs = self.judged(report)
        return FollowEvent(
            performer=self.performer, id=f"{self.performer}/follow/{take}/{<int64_t>report.number}",
            rev=<int64_t>report.rev, name=self.names[m],
            status="begun" if what == MOVE_BEGUN else "progress" if what == MOVE_GOES_ON else "done" if is_done else "left",
            take=take, count=<int64_t>report.count, start=report.start, time=report.time, progress=report.progress,
            tempo=report.tempo, certainty=1.0 if is_done else 0.0 if what == MOVE_LEFT else certainty(report),
            deviation=report.deviation, posture=report.posture, limbs=limbs, joint=self.joint(report),
            range=self.range(<int64_t>report.example, m, limbs) if is_done else None,
            score=round(1.0 / (1.0 + (report.deviation / FAIR) ** 2), 3) if is_done else None,
            decided_time=known.state.time,
            reason=LEFT_REASONS[<int64_t>report.refused] if what == MOVE_LEFT else "",
        )

    cdef dict range(self, int64_t example, int64_t m, dict judged):
        """Return the extent of each judged limb's path relative to the example's; of limbs that move in the example."""
        cdef dict went = self.extent(self.boxes[m, 1] - self.boxes[m, 0])
        return {
            name: round(went[name] / far, 3)
            for name, far in self.extents[example].items()
            if far >= MOVES_LEAST and name in judged
        }

    cpdef dict extent(self, box):
        """Return the extent of each limb's directions, of those of bones, (B, 3)."""
        squares = add_up(box**2, axis=1)
        return {name: sqrt(<float>(<double>add_up(squares[own]) / len(own))) for name, own in self.limbs.items()}


cdef object certainty(FollowReport* report):
    """Return how likely a performance will be done, 0..1."""
    cdef double logit = (
        CERTAIN_BEGIN + CERTAIN_PROGRESS * report.progress + CERTAIN_COST * min(report.cost, 4.0)
        + CERTAIN_RESIDUAL * min(report.residual, 3.0)
    )
    return round(1.0 / (1.0 + exp(-logit - (CERTAIN_AGAIN if report.count else 0.0))), 3)
