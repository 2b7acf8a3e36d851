"""Slots: the places of a row where summaries of segments lie, handed out and taken back."""

import numpy as np

from mossar_stream.jit.decorators import kernel

SLOTS = np.dtype([("unused_count", "i8")])  # of the stack of unused slots


@kernel
def start_slots(slots, unused):
    """Let all slots be unused."""
    for i in range(len(unused)):
        unused[i] = i
    slots.unused_count = len(unused)


@kernel
def allocate(slots, unused, summaries):
    """Return an unused slot, emptied.

    Args:
        slots: SLOTS.
        unused: (slots,) stack of unused slots.
        summaries: (slots, slot) summaries.
    """
    slots.unused_count -= 1
    slot = unused[slots.unused_count]
    empty(summaries[slot])
    return slot


@kernel
def free(slots, unused, slot):
    """Take back a slot that is no longer needed."""
    unused[slots.unused_count] = slot
    slots.unused_count += 1


@kernel
def empty(summary):
    """Make a summary that of no frames."""
    for d in range(len(summary)):
        summary[d] = 0.0
