"""Glimpse: the view of one performer at one moment."""

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import KeyFrameKind, SegmentState, Skeleton
from mossar_tools.dashboard.tally import Count


class Mark(msgspec.Struct, frozen=True):
    """A key frame as it is shown.

    Args:
        id: What tells it from others of its performer.
        time: s.
        frame: Number of the frame.
        kind: `onset`, `offset` or `minimum`.
        velocity: Share of the range.
        strength: At which it falls; None until first computed.
        kept: Whether it stands at the level shown.
        decided: Whether the segmenter has said its last word.
        tentative: Whether it is only a candidate.
        delay: From the key frame to the message that confirmed it, s; None in recordings.
    """

    id: str
    time: float
    frame: int
    kind: KeyFrameKind
    velocity: float
    strength: float | None
    kept: bool
    decided: bool = True
    tentative: bool = False
    delay: float | None = None


class Stretch(msgspec.Struct, frozen=True):
    """A segment as it is shown."""

    start: float  # s
    end: float  # s
    state: SegmentState


class NamedMove(msgspec.Struct, frozen=True):
    """A move that was recognised."""

    start: float  # s
    end: float  # s
    name: str


class Repeated(msgspec.Struct, frozen=True):
    """How often a movement was repeated.

    Args:
        total: In the take.
        tempo: Cycles a minute; None if it is not known yet.
    """

    total: int
    tempo: float | None


class FollowedMove(msgspec.Struct, frozen=True):
    """A move that is followed, as it is shown.

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


class Curve(msgspec.Struct, frozen=True):
    """The velocity curve over the seconds shown, all (n,) and shares of the range but `times` in s."""

    times: NDArray[np.float64]
    value: NDArray[np.float64]
    ceiling: NDArray[np.float64]
    floor: NDArray[np.float64]


class Body(msgspec.Struct, frozen=True):
    """A pose, upright on the ground.

    Args:
        joints: (J, 3) m; x to the right of the viewer, y away, z up, the centre above the origin.
        motion: (J,) how much each joint moves, 0..1.
    """

    joints: NDArray[np.float32]
    motion: NDArray[np.float32]


class Ghost(msgspec.Struct, frozen=True):
    """The pose at a key frame."""

    mark: Mark
    joints: NDArray[np.float32]  # (J, 3) m, as in `Body`


class Glimpse(msgspec.Struct, frozen=True):
    """One performer at one moment.

    Args:
        performer: Name.
        skeleton: J joints.
        now: Time of the last frame, s.
        start: Where the chart begins, s.
        end: Where it ends, s.
        moving: Whether the last frame is in a moving period.
        threshold: Share of the range.
        curve: Velocity within the chart.
        marks: Key frames within the chart, in order of time.
        stretches: Segments within the chart at the level shown.
        body: The last pose; None before there is one.
        ghosts: Poses of the last kept key frames, oldest first.
        statistics: Statistics to show, name and value.
        limbs: Segments of each limb within the chart.
        moves: Those recognised within the chart.
        repeated: What was counted in this take; None if nothing was.
        followed_moves: The moves that are followed, the one to be shown large first.
        overlay: The example of that move at the same place; None while it is not being made.
        count: What was counted since the page was opened.
    """

    performer: str
    skeleton: Skeleton
    now: float
    start: float
    end: float
    moving: bool
    threshold: float
    curve: Curve
    marks: list[Mark]
    stretches: list[Stretch]
    body: Body | None
    ghosts: list[Ghost]
    statistics: list[tuple[str, str]]
    limbs: dict[str, list[Stretch]] = {}  # msgspec copies it
    moves: list[NamedMove] = []  # the same
    repeated: Repeated | None = None
    followed_moves: list[FollowedMove] = []
    overlay: Overlay | None = None
    count: Count = Count()
