"""Glimpse: the view of one performer at one moment."""

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import Skeleton
from mossar_tools.dashboard.tally import Count
from mossar_tools.marks import Chart, Mark


class Repeated(msgspec.Struct, frozen=True):
    """Count of a repeated movement.

    Args:
        total: In the take.
        tempo: Cycles a minute; None if it is not known yet.
    """

    total: int
    tempo: float | None


class FollowedMove(msgspec.Struct, frozen=True):
    """View of a followed move.

    Args:
        name: Of the move.
        count: How often it was done in the take.
        progress: 0 to 1 along the example; None while it is not being made.
        limb: That strays most, in the present performance or the last one; empty before the first.
        angle: By which it strays, degrees.
        tempo: Relative to the example.
        score: Of the last performance; None before the first.
    """

    name: str
    count: int = 0
    progress: float | None = None
    limb: str = ""
    angle: float = 0.0
    tempo: float = 1.0
    score: float | None = None


class Overlay(msgspec.Struct, frozen=True):
    """The example's pose over the performer's.

    Args:
        skeleton: Of the example, K joints.
        joints: (K, 3) m, as in `Body`.
        strays: Angle between each bone of the performer and the example's, degrees, NaN where there is none to compare.
    """

    skeleton: Skeleton
    joints: NDArray[np.float32]
    strays: NDArray[np.float32]


class Body(msgspec.Struct, frozen=True):
    """A pose, upright on the ground.

    Args:
        joints: (J, 3) m; x to the right of the viewer, y away, z up, the centre above the origin.
        motion: (J,) share of each joint in the motion, 0..1.
    """

    joints: NDArray[np.float32]
    motion: NDArray[np.float32]


class Ghost(msgspec.Struct, frozen=True):
    """The pose at a key frame."""

    mark: Mark
    joints: NDArray[np.float32]  # (J, 3) m, as in `Body`


class Glimpse(Chart, frozen=True, kw_only=True):
    """One performer at one moment; see `Chart`, too.

    Args:
        performer: Name.
        skeleton: J joints.
        now: Time of the last frame, s.
        moving: Whether the last frame is in a moving period.
        body: The last pose; None before there is one.
        ghosts: Poses of the last kept key frames, oldest first.
        statistics: Statistics to show, name and value.
        repeated: The count in this take; None if nothing was counted.
        followed_moves: The moves that are followed, the one to be shown large first.
        overlay: The example of that move at the same place; None while it is not being made.
        count: The count since the page was opened.
    """

    performer: str
    skeleton: Skeleton
    now: float
    moving: bool
    body: Body | None
    ghosts: list[Ghost]
    statistics: list[tuple[str, str]]
    repeated: Repeated | None = None
    followed_moves: list[FollowedMove] = msgspec.field(default_factory=list)
    overlay: Overlay | None = None
    count: Count = Count()
