"""Slots: the places of a row where summaries of segments lie, handed out and taken back."""

cdef struct Slots:
    int64_t unused_count  # of the stack of unused slots


cdef void start_slots(Slots* slots, Ints unused) noexcept nogil:
    """Mark all slots as unused."""
    cdef int64_t i
    for i in range(unused.count):
        unused.at[i] = i
    slots.unused_count = unused.count


cdef int64_t take_slot(Slots* slots, Ints unused, DoubleRows summaries) noexcept nogil:
    """Return an unused slot, emptied.

    Args:
        slots: SLOTS.
        unused: (slots,) stack of unused slots.
        summaries: (slots, slot) summaries.
    """
    cdef int64_t slot
    slots.unused_count -= 1
    slot = unused.at[slots.unused_count]
    empty(row_of_doubles(summaries, slot))
    return slot


cdef void free_slot(Slots* slots, Ints unused, int64_t slot) noexcept nogil:
    """Take back a slot that is no longer needed."""
    unused.at[slots.unused_count] = slot
    slots.unused_count += 1


cdef void empty(Doubles summary) noexcept nogil:
    """Make a summary that of no frames."""
    cdef int64_t d
    for d in range(summary.count):
        summary.at[d] = 0.0
