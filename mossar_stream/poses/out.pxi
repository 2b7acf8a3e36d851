"""Out: the events of held poses."""

from mossar_stream.events import PoseEvent

cdef object add_up = __import__("numpy").add.reduce


cdef class PoseReader(Reader):
    """Makes the events of the poses that one performer holds; `poses.holding.Holding` prepares it.

    Attributes:
        performer: Name that events carry.
        names: Of the poses.
        ends: Of each bone, the joint at its end.
        limbs: Of each limb that has bones, their numbers.
        strays: (B,), a part of the state.
    """

    cdef public str performer
    cdef public tuple names
    cdef public list ends
    cdef public dict limbs
    cdef public cnp.ndarray strays

    def __cinit__(self, *_, **__):
        self.see = match_frame

    cdef HoldingState* known(self):
        return <HoldingState*>cnp.PyArray_DATA(self.state)

    cdef int report(self, int64_t take, double* origin, list pending) except -1:
        cdef int64_t happened = self.known().happened
        if happened != POSE_UNCHANGED:
            status = "entered" if happened == POSE_ENTERED else "held" if happened == POSE_HELD else "left"
            pending.append(self.event(status, take, 0))
        return 0

    cdef int end(self, int64_t take, list pending) except -1:
        pending.extend(self.left(take))
        self.begin()
        return 0

    def begin(self):
        """Reset the state, as for a new take."""
        memset(cnp.PyArray_DATA(self.state), 0, cnp.PyArray_DIM(self.state, 0))
        self.known().due = -INFINITY
        self.known().near = self.known().active = -1

    def left(self, int64_t take):
        """Return the event of the pose that is held, if it is left now; nothing is changed."""
        return [self.event("left", take, 1)] if self.known().active >= 0 else []

    cdef object event(self, str status, int64_t take, int64_t more):
        """Return an event of the pose that is held or was last; `more` is added to its `rev`."""
        cdef HoldingState* state = self.known()
        cdef double until = state.seen if status == "left" else state.time
        strays = self.strays / max(state.matched, 1)
        return PoseEvent(
            performer=self.performer, id=f"{self.performer}/pose/{take}/{state.number}", rev=state.rev + more,
            name=self.names[state.latest], status=status, take=take, start=round(state.start, 6),
            seconds=round(until - state.start, 6), deviation=_degrees(strays),
            limbs={name: _degrees(strays[own]) for name, own in self.limbs.items()},
            joint=self.ends[strays.argmax()], decided_time=state.time,
        )


cdef object _degrees(chords):
    """Return the angle between directions, from squares of chords: degrees, root mean square."""
    cdef double mean = <double>add_up(chords) / len(chords)
    return round(2.0 * asin(min(1.0, sqrt(mean) / 2.0)) * (180.0 / M_PI), 2)
