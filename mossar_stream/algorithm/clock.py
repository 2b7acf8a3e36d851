"""Clock: takes, frame numbers and time of one performer, and what became of the frames."""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel

CLOCK = np.dtype(
    [
        ("row", "i8"),  # number of the performer's row, that its events carry
        ("take", "i8"),
        ("open", "i8"),  # whether a take is open
        ("next_frame", "i8"),  # number of the next one
        ("time", "f8"),  # s, of the last frame that came in time
        ("used_frame", "i8"),  # its number
        ("seen_time", "f8"),  # s, of the last processed frame with a joint
        ("taken_time", "f8"),  # s, of the last processed frame; see `comes_too_soon`
    ],
)
COUNTERS = np.dtype(  # since the row was made
    [
        ("frames", "i8"),
        ("out_of_order", "i8"),
        ("outliers", "i8"),
        ("held", "i8"),
        ("gaps", "i8"),
        ("unseen", "i8"),  # without a single joint
    ],
)
TIME_ROUNDING = 1e-6  # s, for the rounding of timestamps: where the clock's origin lies must not matter
IN_TIME, IN_VAIN, BEYOND = range(3)  # where in the take a frame lies


@inline_kernel
def place_in_time(clock, time, max_pause):
    """Tell where in the take a frame lies.

    Args:
        clock: CLOCK.
        time: s, of the frame.
        max_pause: s.

    Returns:
        IN_TIME for a frame that can be processed; IN_VAIN for one without a time, or not later than the last one;
        BEYOND for one before which the take ends, since its time is so far from the last one's.
    """
    if not abs(time) < np.inf:
        return IN_VAIN
    if clock.open == 0:
        return IN_TIME
    dt = time - clock.time
    if dt > max_pause or dt < -max_pause:
        return BEYOND
    return IN_VAIN if dt <= 0.0 else IN_TIME


@inline_kernel
def is_left_alone(clock, time, max_pause):
    """Tell whether no joint was seen for longer than `max_pause`, s, before a frame without a joint: the take ends."""
    return clock.open == 1 and time - clock.seen_time > max_pause


@inline_kernel
def comes_too_soon(clock, time, spacing):
    """Tell whether a frame follows the last processed one by less than the spacing, s, and is skipped."""
    return clock.open == 1 and time - clock.taken_time < spacing


@inline_kernel
def note_time(clock, time):
    """Note a frame that came in time."""
    clock.time = time
    clock.used_frame = clock.next_frame


@inline_kernel
def count_frame(clock, counters):
    """Count a frame, used or not."""
    clock.next_frame += 1
    counters.frames += 1


@kernel
def end_take(clock):
    """End the take; the next one has the next number, and frames are numbered from 0."""
    clock.open = 0
    clock.take += 1
    clock.next_frame = 0
