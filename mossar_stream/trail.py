"""Trail: poses of the last seconds, thinned to about 30 Hz.

Speeds are taken over a tenth of a second, from the trail; and a key frame that moves to a likelier place takes
the poses between with it. Poses are kept as 16-bit multiples of 1/8192 m relative to the centre.
"""

import numpy as np

from mossar_stream.compiled import compiled

RATE = 30.0  # Hz
SPACING = 0.8 / RATE  # s; poses are kept at least this far apart
SPEED_WINDOW = 0.1  # s
QUANTUM = 1.0 / 8192.0  # m
MOST = 32767.0
SPEED_OFFSET = 0.1  # m/s, added before the logarithm, so that rest is log 0.1
MARGIN = 1e-4  # s, for the rounding of timestamps


def trail_size(seconds: float) -> int:
    """Return how many poses cover `seconds`, with the speed window before them."""
    return int((seconds + SPEED_WINDOW + 2 * SPACING) / SPACING) + 4


@compiled
def times_of(h, row):
    """Return the times of the kept poses, (trail,) s."""
    return row[h.at_trail_time : h.at_trail_time + 8 * h.trail_size].view(np.float64)


@compiled
def frames_of(h, row):
    """Return the frame numbers of the kept poses, (trail,)."""
    return row[h.at_trail_frame : h.at_trail_frame + 8 * h.trail_size].view(np.int64)


@compiled
def weights_of(h, row):
    """Return how long each kept pose stands for, (trail,) s."""
    return row[h.at_trail_weight : h.at_trail_weight + 8 * h.trail_size].view(np.float64)


@compiled
def poses_of(h, row):
    """Return the kept poses, (trail, 3, lanes) 1/8192 m."""
    flat = row[h.at_trail : h.at_trail + 6 * h.trail_size * h.lanes].view(np.int16)
    return flat.reshape(h.trail_size, 3, h.lanes)


@compiled
def keep_pose(h, row, pose, weight):
    """Keep the pose of the last used frame if the trail is due for one."""
    times = times_of(h, row)
    h.trail_debt += weight
    if h.trail_filled > 0 and h.time - times[(h.trail_head - 1) % h.trail_size] < SPACING:
        return
    here = h.trail_head
    times[here] = h.time
    frames_of(h, row)[here] = h.used_frame
    weights_of(h, row)[here] = h.trail_debt
    kept = poses_of(h, row)[here]
    for axis in range(3):
        for j in range(h.lanes):
            kept[axis, j] = np.int16(min(max(np.rint(pose[axis, j] / QUANTUM), -MOST), MOST))
    h.trail_debt = 0.0
    h.trail_head = here + 1 if here + 1 < h.trail_size else 0
    h.trail_filled = min(h.trail_filled + 1, h.trail_size)


@compiled
def set_log_speeds(h, row, pose, time, newest):
    """Set pose[3] to log(speed + 0.1 m/s), the speed being the way since about a tenth of a second ago.

    Args:
        pose: (4, lanes) m and log(m/s).
        time: s, of the pose.
        newest: How many kept poses are later than this one; 0 on the live end.
    """
    past = _pose_before(h, row, time, newest)
    span = time - times_of(h, row)[past] if past >= 0 else 0.0
    speeds = pose[3]
    if span < MARGIN:
        speeds[:] = SPEED_OFFSET
    else:
        old = poses_of(h, row)[past]
        for j in range(h.lanes):
            x = pose[0, j] - old[0, j] * QUANTUM
            y = pose[1, j] - old[1, j] * QUANTUM
            z = pose[2, j] - old[2, j] * QUANTUM
            speeds[j] = np.sqrt(x * x + y * y + z * z) / span + SPEED_OFFSET
    logarithm(speeds)


@compiled
def _pose_before(h, row, time, newest):
    """Return the place of the latest kept pose at least a speed window old, else of the oldest, -1 if none."""
    times = times_of(h, row)
    place = -1
    for back in range(newest + 1, h.trail_filled + 1):
        place = (h.trail_head - back) % h.trail_size
        if times[place] <= time - SPEED_WINDOW + MARGIN:
            break
    return place


@compiled
def logarithm(values):
    """Replace positive numbers by their natural logarithms, to 1e-9; unlike np.log this vectorises."""
    bits = values.view(np.int64)
    for i in range(len(values)):
        exponent = (bits[i] >> 52) - 1023
        bits[i] = (bits[i] & 0x000FFFFFFFFFFFFF) | 0x3FF0000000000000
        z = (values[i] - 1.0) / (values[i] + 1.0)
        q = z * z
        odd = 1.0 / 11.0 + q * (1.0 / 13.0 + q * (1.0 / 15.0 + q / 17.0))
        odd = 1.0 / 5.0 + q * (1.0 / 7.0 + q * (1.0 / 9.0 + q * odd))
        values[i] = exponent * 0.6931471805599453 + 2.0 * z * (1.0 + q * (1.0 / 3.0 + q * odd))


@compiled
def load_pose(h, row, place, pose):
    """Set `pose` to a kept one, with its log speeds; `place` counts back from the newest, 0."""
    here = (h.trail_head - 1 - place) % h.trail_size
    kept = poses_of(h, row)[here]
    for axis in range(3):
        for j in range(h.lanes):
            pose[axis, j] = kept[axis, j] * QUANTUM
    set_log_speeds(h, row, pose, times_of(h, row)[here], place + 1)
