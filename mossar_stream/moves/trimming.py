"""Trimming: the part of an example that is followed, without rest or parts of neighbours at its ends.

The stream need not rest where the example did. Rest at an end are the frames near its first or last pose. Parts of the
repetitions before and after are there if the example begins or ends in motion and soon turns back at the same place: along
the principal component of the poses, both turns lie at the same end of the movement, and nothing of its extent is
outside them.
"""

import numpy as np
from numpy.typing import NDArray

# Chosen on five people and ten exercises; counts are the same from 0.03 to 0.06 and with 0.15 to 0.3 s kept (docs/lab-notes/following.md).
RESTS = 0.04  # share of the distance to the farthest pose, nearer to which the body is at rest
REFERENCE = 0.15  # s, over which that pose is averaged
# s of rest that are kept at an end, or a share of the whole: movements begin slowly.
KEPT, KEPT_SHARE = (
    0.2,
    0.07,
)
SOON = 0.75  # s from an end, within which a neighbour's part turns back
TURNED = 0.1  # share of the extent by which it does
MOVING = 0.06  # share of the largest speed, faster than which an example begins or ends in motion
AT_END = 0.15  # s, over which that speed is taken
MOST_WAY = 0.8  # share of the extent covered before the turn: a part, not a movement of its own
SAME = 0.25  # share of the extent by which two turns may differ
MOST_LOST = 0.1  # share of the extent that may be outside them
LEAST_LEFT = 0.4  # s of a movement


def part_to_follow(poses: NDArray[np.float64], fps: float) -> tuple[int, int]:
    """Return the first and the last frame of the followed part.

    Args:
        poses: (n, D) m, smoothed, relative to the centre.
        fps: Hz.
    """
    whole = 0, len(poses) - 1
    first, last = _between_turns(poses, fps)
    begin = first + _rest(poses[first : last + 1], fps)
    end = last - _rest(poses[first : last + 1][::-1], fps)
    return (begin, end) if end - begin >= LEAST_LEFT * fps else whole


def _rest(poses: NDArray[np.float64], fps: float) -> int:
    """Return the number of frames of rest at the beginning."""
    away = np.linalg.norm(poses - poses[: max(1, round(REFERENCE * fps))].mean(axis=0), axis=1)
    far = away > RESTS * away.max()
    kept = round(max(KEPT * fps, KEPT_SHARE * len(poses)))
    return max(0, int(np.argmax(far)) - kept) if far.any() else 0


def _between_turns(poses: NDArray[np.float64], fps: float) -> tuple[int, int]:
    """Return the frames of the turns between an example and parts of its neighbours; its ends where it has none."""
    centred = poses - poses.mean(axis=0)
    along = centred @ np.linalg.svd(centred, full_matrices=False)[2][0]
    extent = float(np.ptp(along))
    last = len(along) - 1
    begin = _turn(along, extent, fps)
    end = last - _turn(along[::-1], extent, fps)
    for first, final in ((begin, end), (begin, last), (0, end)):
        inside = along[first : final + 1]
        alike = abs(along[first] - along[final]) < SAME * extent
        if final > first and alike and np.ptp(inside) > (1 - MOST_LOST) * extent:
            return first, final
    return 0, last


def _turn(along: NDArray[np.float64], extent: float, fps: float) -> int:
    """Return the frame where a movement that goes on at the beginning turns back soon; 0 if there is none."""
    step = max(1, round(AT_END * fps))
    speeds = np.abs(along[step:] - along[:-step])
    if not len(speeds) or speeds[0] <= MOVING * speeds.max():
        return 0
    soon = along[: round(SOON * fps) + 1] * np.sign(along[step] - along[0])
    peak = int(np.argmax(soon))
    after = along[peak:] * np.sign(along[step] - along[0])
    turned = after < soon[peak] - TURNED * extent
    if not turned.any() or after[: int(np.argmax(turned))].max() > soon[peak]:
        return 0
    return peak if soon[peak] - soon[0] < MOST_WAY * extent else 0
