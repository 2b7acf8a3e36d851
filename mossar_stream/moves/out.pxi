"""Out: the events of recognised moves, and the explanations of movements that were none."""

from mossar_stream.events import MoveEvent
from mossar_stream.moves.explaining import REASONS, Explanation

cdef str WHOLE_BODY = "body"


cdef class MoveReader(Reader):
    """Makes the events of one performer's moves; `moves.recognition.Recognition` prepares it.

    Attributes:
        performer: Name that events carry.
        names: Of the moves.
        limbs: Names of the performer's limbs.
        explained: Called with an `Explanation` of each movement; may be None.
    """

    cdef public str performer
    cdef public tuple names
    cdef public tuple limbs
    cdef public object explained
    cdef list explanations  # to be reported after the events

    def __cinit__(self, *_, **__):
        self.see, self.explanations = recognise, []

    cdef RecognitionState* known(self):
        return <RecognitionState*>cnp.PyArray_DATA(self.state)

    cdef int report(self, int64_t take, double* origin, list pending) except -1:
        cdef RecognitionState* state = self.known()
        cdef int64_t happened = state.happened
        if happened & CONFIRMED:
            state.found.take = take
        if happened & (FINAL | WITHDRAWN):
            pending.append(self.event(&state.before, "final" if happened & FINAL else "withdrawn", 2))
        if happened & CONFIRMED:
            pending.append(self.event(&state.found, "confirmed", 1))
        if happened & EXPLAINED:
            self.explain(&state.nearest)
        return 0

    cdef int end(self, int64_t take, list pending) except -1:
        cdef RecognitionState* state = self.known()
        cdef int64_t number = state.found.number
        cdef MoveMemory memory = open_move_memory(<uint8_t*>state, <MoveStore*>cnp.PyArray_DATA(self.store))
        pending.extend(self.last_word())
        if state.nearest.open:
            self.explain(&state.nearest)
        begin_move_memory(&memory, len(self.names))
        state.found.number = number
        return 0

    cdef object event(self, FoundMove* found, str status, int64_t rev):
        return MoveEvent(
            performer=self.performer, id=f"{self.performer}/move/{found.take}/{found.number}", rev=rev,
            name=self.names[found.move], status=status, take=found.take, start=found.start, end=found.end,
            score=1.0 / (1.0 + found.cost), limb=self.limbs[found.limb] if found.limb >= 0 else WHOLE_BODY,
            decided_time=found.time if status == "confirmed" else self.known().time,
        )

    def last_word(self):
        """Return the event of a move that becomes final as recognition ends."""
        cdef FoundMove* found = &self.known().found
        return [self.event(found, "final", 2)] if found.move >= 0 else []

    cdef int explain(self, Nearest* near) except -1:
        """Note the nearest move in the movement that is over."""
        cdef double lead = near.second_cost / near.cost if near.second >= 0 else INFINITY
        if self.explained is not None:
            self.explanations.append(
                Explanation(
                    performer=self.performer, start=near.start, end=near.end, nearest=self.names[near.move],
                    reason=REASONS[near.kept], cost=near.cost,
                    most=exp(near.most + LEAD_WORTH * min(log(lead), LEAD_COUNTED)), lead=lead,
                    second=self.names[near.second] if near.second >= 0 else "", posture=near.posture,
                )
            )
        return 0

    cdef int afterwards(self) except -1:
        while self.explanations:
            self.explained(self.explanations.pop(0))
        return 0
