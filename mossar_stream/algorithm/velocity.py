"""Velocity: equation 1 of the paper, over a trailing window in seconds, and its smoothing.

The paper's velocity of a joint is the path it travelled over the last `fps` frames; the velocities of the joints
are summed. Live sources run at 10 to 240 Hz with jitter, so the window is in seconds here: a displacement that
ends at t_i counts at time t while t - t_i < window (less a microsecond, so that a constant rate gives exactly
ceil(window · fps) displacements).

Displacements are kept as whole multiples of 2^-40 m: sums of integers neither drift over ten million frames nor
depend on the order of additions, and equal velocities compare equal.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import inline_kernel, kernel

UNIT = 2.0**-40  # m
MARGIN = 1e-6  # s, for the rounding of timestamps
MOST = 2**60  # of one displacement, in units: far beyond any body


@inline_kernel
def ring_is_full(h, ring_time, time):
    """Tell whether the window holds more displacements than the ring has places."""
    if h.filled < h.ring:
        return False
    return time - ring_time[_oldest(h)] < h.window - MARGIN


@inline_kernel
def _oldest(h):
    """Return the place in the ring of the oldest displacement; without a division, which takes long."""
    place = h.head - h.filled
    return place + h.ring if place < 0 else place


@inline_kernel
def travel(h, ring_time, ring_step, time, displacement):
    """Add one displacement, drop those that left the window, and return the velocity (equation 1).

    Args:
        h: Header of the row.
        ring_time: (ring,) s.
        ring_step: (ring,) 2^-40 m.
        time: s, at which the displacement ends.
        displacement: m, summed over the joints.

    Returns:
        Path within the window, summed over the joints, m.
    """
    units = min(np.int64(displacement / UNIT + 0.5), MOST)
    tail = _oldest(h)
    while h.filled > 0 and time - ring_time[tail] >= h.window - MARGIN:
        h.travelled -= ring_step[tail]
        h.filled -= 1
        tail = tail + 1 if tail + 1 < h.ring else 0
    ring_time[h.head] = time
    ring_step[h.head] = units
    h.travelled += units
    h.filled += 1
    h.head = h.head + 1 if h.head + 1 < h.ring else 0
    return h.travelled * UNIT


@kernel
def moving_average(h, average, velocity):
    """Return the mean of the last `smoothing_window` velocities, of those there are at the start (wSize)."""
    units = np.int64(velocity / UNIT)
    if h.average_filled == h.smoothing_window:
        h.average_sum -= average[h.average_head]
    else:
        h.average_filled += 1
    average[h.average_head] = units
    h.average_sum += units
    h.average_head = (h.average_head + 1) % h.smoothing_window
    return h.average_sum / h.average_filled * UNIT


def velocity_curve(
    displacements: NDArray[np.float64],
    times: NDArray[np.float64],
    window: float,
    smoothing_window: int = 1,
) -> NDArray[np.float64]:
    """Return the velocity at every frame of a recording: equation 1, summed over the joints.

    This is the plain form that the streaming one is tested against.

    Args:
        displacements: (n,) m, path of all joints since the frame before; 0 for the first frame.
        times: (n,) s, increasing.
        window: Trailing window, s.
        smoothing_window: Length of the moving average, frames.

    Returns:
        (n,) m.
    """
    curve = np.empty(len(displacements))
    for t, now in enumerate(times):
        first = np.searchsorted(times, now - (window - MARGIN), side="right")
        curve[t] = displacements[first : t + 1].sum()
    return np.array([curve[max(0, t + 1 - smoothing_window) : t + 1].mean() for t in range(len(curve))])
