"""Points: what readers see of a frame: joints, or middles of two, relative to the first point, the centre.

Recognised moves, followed moves and held poses place the points of their examples in a stream alike, and agree on which
frames follow each other.
"""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel
from mossar_stream.memory.joint_pages import FARTHEST
from mossar_stream.settings import Up

LATE = 1.0  # s, frames that are so late are repeated or out of order
MAX_STEP = 0.25  # s, a longer time without frames breaks the movement
EARLY = 1e-6  # s, for the rounding of times: where the clock's origin lies must not matter
Y_UP = (1, 1.0)  # axis and sign
UPWARDS: dict[Up, tuple[int, float]] = {
    "auto": Y_UP, "x": (0, 1.0), "y": Y_UP, "z": (2, 1.0), "-x": (0, -1.0), "-y": (1, -1.0), "-z": (2, -1.0),
}  # fmt: skip
FARTHEST_SUM = np.float32(FARTHEST)  # m, of the three coordinates


@inline_kernel
def is_new(frames, time, latest, spacing):
    """Tell whether a frame is to be processed; late ones are not, time that was set back begins anew.

    Args:
        frames: How many were processed so far.
        time: s, of the frame.
        latest: s, of the last frame that was processed.
        spacing: s, least time between two.
    """
    return np.isfinite(time) and (frames == 0 or not -LATE <= time - latest < spacing)


@inline_kernel
def follows(frames, time, latest):
    """Tell whether a frame follows the last one without a gap; arguments as for `is_new`."""
    return frames > 0 and 0.0 < time - latest <= MAX_STEP + EARLY


@inline_kernel
def place_points(pose, points, positions, up):
    """Set a pose to the points of a frame, y upwards; a missing point, or one beyond 100 km, stays where it was.

    Args:
        pose: (K, 3) float32 m, the pose before; the centre's own place, then the other points relative to it.
        points: (K,) records with two joints, `one` and `other`, in whose middle a point lies; -1 for the mean of all joints.
        positions: (J, 3) float32 m, NaN where a joint is missing.
        up: Axis that points upwards, and its sign.

    Returns:
        Whether all points were there.
    """
    axis, sign = up
    sign = np.float32(sign)
    whole = True
    x = y = z = np.float32(0.0)
    for k in range(points.size):
        px, py, pz = _place_of(points[k], positions)
        if k == 0:
            x, y, z = px, py, pz
        else:
            px, py, pz = px - x, py - y, pz - z
        if not _is_near(px, py, pz):
            whole = False
            continue
        if axis == 0:
            px, py, pz = pz, px, py
        elif axis == 2:
            px, py, pz = py, pz, px
        pose[k, 0], pose[k, 1], pose[k, 2] = sign * px, sign * py, pz
    return whole


@inline_kernel
def is_hidden(points, k, positions):
    """Tell whether `place_points` leaves point k where it was, because it is missing or too far; arguments as there."""
    x, y, z = _place_of(points[0], positions)
    if k == 0:
        return not _is_near(x, y, z)
    px, py, pz = _place_of(points[k], positions)
    return not _is_near(px - x, py - y, pz - z)


@inline_kernel
def _place_of(point, positions):
    """Return where a point lies in a frame, m; NaN if a joint is missing."""
    a, b = point.one, point.other
    if a < 0:
        return _mean(positions)
    half = np.float32(0.5)
    return (
        half * (positions[a, 0] + positions[b, 0]),
        half * (positions[a, 1] + positions[b, 1]),
        half * (positions[a, 2] + positions[b, 2]),
    )


@inline_kernel
def _is_near(x, y, z):
    return abs(x) + abs(y) + abs(z) < FARTHEST_SUM


@inline_kernel
def _mean(positions):
    x = y = z = np.float32(0.0)
    count = 0
    for j in range(positions.shape[0]):
        if not np.isnan(positions[j, 0] + positions[j, 1] + positions[j, 2]):
            x += positions[j, 0]
            y += positions[j, 1]
            z += positions[j, 2]
            count += 1
    share = np.float32(1.0) / np.float32(count)
    return x * share, y * share, z * share
