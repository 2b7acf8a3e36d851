"""Out: the events of feet."""

from mossar_stream.events import StepEvent
from mossar_stream.settings.feet import SIDES


cdef class StepReader(Reader):
    """Makes the events of one performer's feet; `steps.stepping.Stepping` prepares it.

    Attributes:
        performer: Name that events carry.
    """

    cdef public str performer

    def __cinit__(self, *_, **__):
        self.see = follow_feet

    cdef int report(self, int64_t take, double* origin, list pending) except -1:
        """Add the events of the last frame, the earlier one first."""
        cdef Steps* steps = <Steps*>cnp.PyArray_DATA(self.state)
        cdef int64_t first = 1 if steps.feet[1].time < steps.feet[0].time else 0, k, side
        if steps.take != take:
            steps.take, steps.number = take, 0
        for k in range(2):
            side = first if k == 0 else 1 - first
            if steps.feet[side].event != NO_NEWS:
                steps.number += 1
                pending.append(self.event(steps, side, origin))
        return 0

    cdef object event(self, Steps* steps, int64_t side, double* origin):
        cdef Foot* foot = &steps.feet[side]
        cdef bint is_far = origin[0] != 0.0 or origin[1] != 0.0 or origin[2] != 0.0
        place = [foot.place[i] + origin[i] if is_far else foot.place[i] for i in range(3)]
        return StepEvent(
            performer=self.performer, id=f"{self.performer}/step/{steps.take}/{steps.number}", rev=1,
            status="strike" if foot.event == STRIKE else "off", take=steps.take, side=SIDES[side], time=foot.time,
            position=(round(place[0], 6), round(place[1], 6), round(place[2], 6)),
            confidence=round(foot.confidence, 4), decided_time=steps.time,
        )

    cdef int end(self, int64_t take, list pending) except -1:
        cdef Steps* steps = <Steps*>cnp.PyArray_DATA(self.state)
        cdef Foot* foot
        cdef int64_t side, d
        for side in range(2):
            foot = &steps.feet[side]
            foot.state, foot.first, foot.rest = 0, foot.count, NAN
            foot.judged, foot.last = foot.count, -INFINITY
        for d in range(3):
            steps.belt[d] = steps.drift[d] = 0.0
        steps.time = steps.sample = steps.looked = steps.due = -INFINITY
        return 0
