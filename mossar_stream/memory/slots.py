"""Slots: the summaries of a row, handed out and taken back."""

from mossar_stream.jit.decorators import kernel


@kernel
def take_slot(h, free, slots):
    """Return an unused slot, emptied.

    Args:
        h: Header of the row.
        free: (slots,) stack of unused slots.
        slots: (slots, slot) summaries.
    """
    h.free_count -= 1
    slot = free[h.free_count]
    empty_slot(slots[slot])
    return slot


@kernel
def give_slot(h, free, slot):
    """Take back a slot that is no longer needed."""
    free[h.free_count] = slot
    h.free_count += 1


@kernel
def empty_slot(slot):
    """Make a summary that of no frames."""
    for d in range(len(slot)):
        slot[d] = 0.0
