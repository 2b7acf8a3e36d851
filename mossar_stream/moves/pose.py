"""One held pose: the positions of the joints, averaged over the last part at rest of the frames."""

from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.errors import MovesError
from mossar_stream.moves.example import (
    LONGEST_TAKEN,
    MAX_DISTANCE,
    MAX_MOVE_NAME,
    NUMBERS,
    UNIT,
    Coordinate,
    check_name,
    numbers_of,
    units_of,
)
from mossar_stream.skeleton import Skeleton

MOST_HOLD = 3600.0  # s
LEAST_REST = 0.4  # s, of a pose in a recording
MOST_STRAY = 0.03  # m, rms over joints: largest distance of a pose's frames from their mean


class Pose(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A pose that is held.

    Args:
        name: Of the pose.
        positions: `J · 3` numbers in tenths of a millimetre, joint by joint.
        hold: s after which it counts as held.
    """

    name: Annotated[str, msgspec.Meta(min_length=1, max_length=MAX_MOVE_NAME)]
    positions: Annotated[tuple[Coordinate, ...], msgspec.Meta(max_length=3 * 1024)]
    hold: Annotated[float, msgspec.Meta(ge=0, le=MOST_HOLD)] = 1.0

    def metres(self, joints: int) -> NDArray[np.float64]:
        """Return the positions as (J, 3) float64, metres."""
        return (np.array(self.positions, np.float64) * UNIT).reshape(joints, 3)


def make_pose(name: str, positions: ArrayLike, fps: float, hold: float, skeleton: Skeleton) -> Pose:
    """Return a pose.

    Args:
        name: Of the pose.
        positions: (J, 3), metres; or (n, J, 3), of which the last part at rest is the pose.
        fps: Rate, Hz.
        hold: s after which it counts as held.
        skeleton: With J joints.

    Raises:
        MovesError: If the positions, the rate or `hold` cannot be used, or nothing is held.
    """
    check_name(name)
    shown = numbers_of(positions)
    shown = shown[None] if shown.ndim == 2 else shown
    _check(shown, fps, hold, len(skeleton))
    centre = shown[:, skeleton.root] if skeleton.root >= 0 else shown.mean(axis=1)
    placed = shown - centre[:, None]
    first, last = _last_rest(placed, max(1, round(LEAST_REST * fps)))
    pose = placed[first : last + 1].mean(axis=0) + centre[last]
    if np.abs(pose - pose.mean(axis=0)).max() < UNIT:
        raise MovesError("all joints of the pose are in one place")
    return Pose(name, units_of(pose), float(hold))


def _check(shown: NDArray[np.float64], fps: Any, hold: Any, joints: int) -> None:
    if not isinstance(fps, NUMBERS) or not 0 < fps <= 10_000:
        raise MovesError(f"the rate of a pose is a positive number of frames per second, not {fps!r}")
    if isinstance(hold, bool) or not isinstance(hold, NUMBERS) or not 0 <= hold <= MOST_HOLD:
        raise MovesError(f"hold is a number of seconds from 0 to {MOST_HOLD:g}, not {hold!r}")
    if shown.ndim != 3 or shown.shape[1:] != (joints, 3):
        raise MovesError(f"a pose has the form ({joints} joints, 3) or (frames, {joints} joints, 3)")
    if not 1 <= len(shown) <= LONGEST_TAKEN:
        raise MovesError(f"a pose is shown by 1 to {LONGEST_TAKEN} frames, not {len(shown)}")
    if not np.isfinite(shown).all():
        bad = int(np.argmin(np.isfinite(shown).all(axis=(1, 2))))
        raise MovesError(f"a pose needs all joints in all frames; frame {bad} lacks some")
    if np.abs(shown).max() > MAX_DISTANCE:
        raise MovesError(f"a pose's positions are metres, at most {MAX_DISTANCE:g} from the origin")


def _last_rest(placed: NDArray[np.float64], least: int) -> tuple[int, int]:
    """Return the first and the last frame of the last stretch of `least` frames or more whose frames are alike.

    Args:
        placed: (n, J, 3) m, relative to the centre.
        least: Frames; all that there are, if they are fewer.
    """
    least = min(least, len(placed))
    for last in range(len(placed) - 1, least - 2, -1):
        window = placed[last - least + 1 : last + 1]
        middle = window.mean(axis=0)
        if _stray(window, middle) > MOST_STRAY:
            continue
        first = last - least + 1
        while first > 0 and _stray(placed[first - 1 : first], middle) <= MOST_STRAY:
            first -= 1
        return first, last
    raise MovesError(f"nothing is held in these frames; a pose is held for at least {LEAST_REST:g} s")


def _stray(frames: NDArray[np.float64], middle: NDArray[np.float64]) -> float:
    """Return the largest distance of frames from a pose, rms over joints, m."""
    return float(np.sqrt(((frames - middle) ** 2).sum(axis=2).mean(axis=1)).max())
