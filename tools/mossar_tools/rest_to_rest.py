r"""Rest to rest: finds the movement that is over, among the latest frames of a stream.

Rest is relative to the movement: slow compared with its peak. People who stand on guard sway more than those who stand
at ease. A rest that `activity` reports for the body and all limbs is one, too; it knows the noise of the sensor.

    speed   ____/‾\___/‾\_/‾\___/‾\_________
            home    pause        home  over
                ├───────────────┤

A rest in the pose of the one before the movement ends it after `REST`. A rest in another pose is a pause, such as that of
a raised arm, and ends the movement only after a longer time.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

REST = 0.6  # s without movement, in the pose before it, after which a movement is over
BEFORE = 0.4  # s of rest before a movement
BEFORE_FIRST = 0.9  # s of rest where the frames begin with a stream: the time before is not known
SETTLED = 1.0  # s of rest in another pose, where a movement may begin, too
POSED = 0.3  # s of a rest, whose mean pose is that of the rest
SLOW = 0.1  # of the peak of speed: slower is rest
MOST_PEAK = 6.0  # m/s, of the peak: a sensor that loses the body for a moment must not hide later movements
STILL = 0.06  # m/s: slower is rest
LEAST_WAY = 0.1  # m, that joints go from the pose at rest: less is no movement
NEAR = 0.4  # of the way that a movement goes: poses nearer to each other are the same
LEAST_NEAR = 0.06  # m
JOINTS = 3  # that are compared, the fastest or the farthest: those of a limb


class Seen(NamedTuple):
    """Frames since the last movement.

    Args:
        times: (n,) s.
        poses: (n, J, 3) m, relative to the centre, averaged.
        speeds: (n,) m/s, of the fastest joints or of the centre.
        resting: (n,) whether `activity` reports that the body and all limbs rest.
        after_rest: Whether the frames before the first one were at rest; else they are not known.
    """

    times: NDArray[np.float64]
    poses: NDArray[np.float32]
    speeds: NDArray[np.float64]
    resting: NDArray[np.bool_]
    after_rest: bool


class Found(NamedTuple):
    """A movement that is over.

    Args:
        begin: First frame of it; -1 if it did not begin at rest.
        end: Last frame of it.
        way: m, distance that joints moved; less than `LEAST_WAY` is sway.
    """

    begin: int
    end: int
    way: float


class _Rest(NamedTuple):
    first: int  # frame
    last: int


def most(values: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the mean of the largest values along the last axis, those of a limb's joints.

    Args:
        values: (..., J); missing joints count as 0.
    """
    count = max(1, min(JOINTS, (values.shape[-1] - 1) // 4))
    known = np.nan_to_num(values)
    return np.asarray(np.sort(known, axis=-1)[..., -count:].mean(axis=-1), np.float64)


def extent(seen: Seen) -> float:
    """Return the distance of the joints from the first pose, m."""
    return _way(seen, np.asarray(seen.poses[0], np.float64), 0, len(seen.poses) - 1)


def movement_over(seen: Seen, away: float, *, at_end: bool = False) -> Found | None:
    """Return the movement that is over at the last frame; None if none is.

    Args:
        seen: Frames.
        away: s of rest in another pose than the first one, after which a movement is over.
        at_end: Whether the stream ends, and the movement with it.
    """
    peak = int(np.argmax(seen.speeds))
    quiet = seen.resting | (seen.speeds < max(STILL, SLOW * min(float(seen.speeds[peak]), MOST_PEAK)))
    moved = np.flatnonzero(~quiet)
    if not len(moved):
        return None
    end = int(moved[-1])
    still = float(seen.times[-1] - seen.times[end])
    if still < REST and not at_end:
        return None
    rests = _rests(seen, quiet[: max(peak, int(moved[0])) + 1])
    now = _pose(seen, _Rest(min(end + 1, len(quiet) - 1), len(quiet) - 1))
    if not rests:
        return Found(-1, end, 0.0 if seen.after_rest else _way(seen, now, 0, end))
    home = _pose(seen, rests[0])
    way = _way(seen, home, rests[0].last, end)
    near = max(LEAST_NEAR, NEAR * way)
    homes = [rests[0], *(rest for rest in rests[1:] if _is_home(seen, rest, home, near))]
    # Over before, but slow, so that it shows only beside the peak of now.
    for before, after in pairwise(homes):
        way = _way(seen, home, before.last, after.first)
        if way >= max(LEAST_WAY, near):
            return Found(before.last, after.first - 1, way)
    if _apart(now, home) < near or still >= away or at_end:
        begin = homes[-1].last
        return Found(begin, end, _way(seen, home, begin, end))
    for rest in reversed(rests):
        if _seconds(seen, rest) >= SETTLED and _apart(now, pose := _pose(seen, rest)) < near:
            return Found(rest.last, end, _way(seen, pose, rest.last, end))
    return None


def _is_home(seen: Seen, rest: _Rest, home: NDArray[np.float64], near: float) -> bool:
    return _seconds(seen, rest) >= REST and _apart(_pose(seen, rest), home) < near


def _rests(seen: Seen, quiet: NDArray[np.bool_]) -> list[_Rest]:
    """Return the rests before the peak from which a movement may begin."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], quiet, [False]]).astype(np.int8)))
    spans = [_Rest(int(first), int(after) - 1) for first, after in edges.reshape(-1, 2)]
    return [rest for rest in spans if _seconds(seen, rest) >= _least(seen, rest)]


def _least(seen: Seen, rest: _Rest) -> float:
    return BEFORE_FIRST if rest.first == 0 and not seen.after_rest else BEFORE


def _seconds(seen: Seen, rest: _Rest) -> float:
    return float(seen.times[rest.last] - seen.times[rest.first])


def _pose(seen: Seen, rest: _Rest) -> NDArray[np.float64]:
    """Return the pose at the end of a rest, (J, 3) m."""
    late = seen.times[rest.first : rest.last + 1] > seen.times[rest.last] - POSED
    return np.asarray(seen.poses[rest.first : rest.last + 1][late].mean(axis=0), np.float64)


def _apart(one: NDArray[np.floating], other: NDArray[np.floating]) -> float:
    return float(most(np.linalg.norm(one - other, axis=-1)))


def _way(seen: Seen, home: NDArray[np.float64], begin: int, end: int) -> float:
    """Return the distance that the joints moved from a pose, m."""
    return float(most(np.linalg.norm(seen.poses[begin : end + 1] - home, axis=-1)).max(initial=0.0))
