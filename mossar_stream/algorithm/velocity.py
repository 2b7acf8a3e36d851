"""Velocity: equation 1 of the paper, over a trailing window in seconds, and its smoothing.

The paper's velocity of a joint is the path it travelled over the last `fps` frames; the velocities of the joints
are summed. Live sources run at 10 to 240 Hz with jitter, so the window is in seconds here: a displacement that
ends at t_i counts at time t while t - t_i < window (less a microsecond, so that a constant rate gives exactly
ceil(window · fps) displacements).

Displacements are kept as whole multiples of 2^-40 m: sums of integers neither drift over ten million frames nor
depend on the order of additions, and equal velocities compare equal.
"""

import numpy as np

from mossar_stream.algorithm.clock import TIME_ROUNDING
from mossar_stream.jit.decorators import inline_kernel, kernel

PATH_UNIT = 2.0**-40  # m
MOST_UNITS = 2**60  # of one displacement, in units: far beyond any body


VELOCITY = np.dtype(  # the displacements in the window: a ring of times, and of steps
    [
        ("head", "i8"),  # next place in the ring
        ("filled", "i8"),  # entries in the ring
        ("travelled", "i8"),  # 2^-40 m, sum of the ring
    ],
)
AVERAGE = np.dtype(  # the velocities under the moving average: a ring
    [
        ("head", "i8"),
        ("filled", "i8"),
        ("sum", "i8"),  # 2^-40 m
    ],
)


@kernel
def start_velocity(velocity, average):
    """Begin with an empty window."""
    velocity.head = 0
    velocity.filled = 0
    velocity.travelled = 0
    average.head = 0
    average.filled = 0
    average.sum = 0


@inline_kernel
def ring_is_full(velocity, ring_time, time, window):
    """Tell whether the window, s, holds more displacements than the ring has places."""
    if velocity.filled < len(ring_time):
        return False
    return time - ring_time[_oldest(velocity, len(ring_time))] < window - TIME_ROUNDING


@inline_kernel
def _oldest(velocity, places):
    """Return the place in the ring of the oldest displacement; without a division, which takes long."""
    place = velocity.head - velocity.filled
    return place + places if place < 0 else place


@inline_kernel
def travel(velocity, ring_time, ring_step, time, displacement, window):
    """Add one displacement, drop those that left the window, and return the velocity (equation 1).

    Args:
        velocity: VELOCITY.
        ring_time: (ring,) s.
        ring_step: (ring,) 2^-40 m.
        time: s, at which the displacement ends.
        displacement: m, summed over the joints.
        window: s.

    Returns:
        Path within the window, summed over the joints, m.
    """
    places = len(ring_time)
    units = min(np.int64(displacement / PATH_UNIT + 0.5), MOST_UNITS)
    tail = _oldest(velocity, places)
    while velocity.filled > 0 and time - ring_time[tail] >= window - TIME_ROUNDING:
        velocity.travelled -= ring_step[tail]
        velocity.filled -= 1
        tail = tail + 1 if tail + 1 < places else 0
    ring_time[velocity.head] = time
    ring_step[velocity.head] = units
    velocity.travelled += units
    velocity.filled += 1
    velocity.head = velocity.head + 1 if velocity.head + 1 < places else 0
    return velocity.travelled * PATH_UNIT


@kernel
def moving_average(average, values, velocity):
    """Return the mean of the last velocities, as many as there are places, fewer at the start (wSize).

    Args:
        average: AVERAGE.
        values: (smoothing_window,) 2^-40 m.
        velocity: m.
    """
    units = np.int64(velocity / PATH_UNIT)
    if average.filled == len(values):
        average.sum -= values[average.head]
    else:
        average.filled += 1
    values[average.head] = units
    average.sum += units
    average.head = (average.head + 1) % len(values)
    return average.sum / average.filled * PATH_UNIT
