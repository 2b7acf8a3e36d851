"""Track: the recent past of one live performer, bounded in everything."""

from collections import deque

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.newest import Newest
from mossar_stream import (
    BODY,
    CurveState,
    Event,
    FollowEvent,
    Frames,
    KeyFrameEvent,
    MoveEvent,
    Moves,
    PoseEvent,
    RepetitionEvent,
    SegmentEvent,
    Skeleton,
    StreamEvent,
    Up,
)
from mossar_tools.dashboard.followed_moves import FollowedMoves, States
from mossar_tools.dashboard.glimpse import Body, Ghost, Glimpse, Repeated
from mossar_tools.dashboard.limb_strips import LimbStrips
from mossar_tools.dashboard.motion import Motion
from mossar_tools.dashboard.placement import Placement
from mossar_tools.dashboard.stretches import stretches_between
from mossar_tools.dashboard.tally import Tally
from mossar_tools.marks import Mark, curve_columns, curve_of

SECONDS = 20.0  # of the curve that are shown
RATE = 30.0  # samples and poses kept per second, at most
GHOSTS = 7  # poses of key frames shown
_SAMPLES = int(1.5 * SECONDS * RATE)
_POSES = 400  # poses kept until their key frames are confirmed
_MARKS = 400  # key frames kept

_KEPT = ("confirmed", "restored", "final")


class _Key(msgspec.Struct):
    """The state of a key frame."""

    event: KeyFrameEvent
    delay: float | None = None  # s
    pose: NDArray[np.float32] | None = None  # (J, 3) m, as it came


class Track:
    """Keeps frames, events and samples of the curve of one performer; not safe by itself between threads.

    Args:
        performer: Name.
        skeleton: J joints.
    """

    def __init__(self, performer: str, skeleton: Skeleton) -> None:
        self.performer = performer
        self.skeleton = skeleton
        self.tally = Tally()
        self._take = 0  # the first take whose strengths are of the features in force
        self._clear()

    def begin_with(self, take: int) -> None:
        """Note the take from which strengths are of other features; earlier key frames stay as they are."""
        self._take = take

    def _clear(self) -> None:
        self._placement = Placement(self.skeleton)
        self._motion = Motion(self.skeleton)
        self._samples: deque[CurveState] = deque(maxlen=_SAMPLES)
        self._poses: deque[tuple[float, NDArray[np.float32]]] = deque(maxlen=_POSES)
        self._keys: Newest[str, _Key] = Newest(_MARKS)
        self._limb_strips = LimbStrips()
        self._repeated: Repeated | None = None
        self._followed_moves = FollowedMoves(self.skeleton)

    def set_following(self, states: States, moves: Moves | None, up: Up) -> None:
        """Note the performer's progress in the followed moves; see `FollowedMoves.take`."""
        self._followed_moves.take(states, moves, up)

    def add_frames(self, frames: Frames) -> None:
        """Process frames; a pose is kept about every 1/30 s."""
        time, pose = float(frames.times[-1]), frames.positions[-1]
        since = time - self._poses[-1][0] if self._poses else 1.0
        if since < -1.0:  # the source began anew
            self._clear()
        elif 0 <= since < 0.8 / RATE:
            return
        self._motion.take(time, pose)
        self._placement.learn(pose)
        self._poses.append((time, pose.copy()))

    def add_event(self, event: Event) -> None:
        """Process an event: the body's key frames and repetitions, limbs' segments, moves, followed moves and poses."""
        self.tally.add(event)
        if isinstance(event, MoveEvent):
            self._limb_strips.add_move(event)
        elif isinstance(event, PoseEvent):
            self._limb_strips.add_pose(event)
        elif isinstance(event, SegmentEvent) and event.channel != BODY:
            self._limb_strips.add_segment(event)
        elif isinstance(event, KeyFrameEvent) and event.channel == BODY:
            self._add_key_frame(event)
        elif isinstance(event, RepetitionEvent) and event.channel == BODY:
            known = self._repeated.tempo if self._repeated is not None and event.count != 1 else None
            self._repeated = Repeated(event.total, known if event.tempo is None else event.tempo)
        elif isinstance(event, StreamEvent) and event.event == "started":
            self._repeated = None
            self._followed_moves.begin_take()
        elif isinstance(event, FollowEvent):
            self._followed_moves.add_event(event)

    def _add_key_frame(self, event: KeyFrameEvent) -> None:
        if event.status == "withdrawn":
            self._keys.pop(event.id, None)
            return
        key = self._keys.get(event.id)
        if key is None:
            key = self._keys[event.id] = _Key(event)
        if event.status == "confirmed":
            key.delay = event.decided_time - event.time
        if key.pose is None or event.time != key.event.time:
            key.pose = self._pose_at(event.time)
        key.event = event

    def add_sample(self, state: CurveState) -> None:
        """Add the curve at one frame."""
        if self._samples and state.time <= self._samples[-1].time:
            if state.time > self._samples[-1].time - 1.0:
                return
            self._samples.clear()
        self._samples.append(state)

    def glimpse(self, level: float, statistics: list[tuple[str, str]]) -> Glimpse | None:
        """Return the view; None before the first sample.

        Args:
            level: Strength from which key frames are shown as kept.
            statistics: Statistics to pass on.
        """
        if not self._samples:
            return None
        last = self._samples[-1]
        start = last.time - SECONDS
        seen = [state for state in self._samples if state.time >= start - 0.5]
        columns = curve_columns(seen)
        keys, marks = self._sorted(), self.marks(level)
        cuts = [mark.time for mark in marks if mark.kept]
        known = [(mark, key.pose) for mark, key in zip(marks, keys, strict=True) if mark.kept]
        body = self._body()
        return Glimpse(
            performer=self.performer,
            skeleton=self.skeleton,
            now=last.time,
            start=start,
            end=last.time,
            moving=last.moving,
            threshold=last.threshold,
            curve=curve_of(columns),
            marks=[mark for mark in marks if mark.time >= start],
            stretches=stretches_between(cuts, columns[:, 0], columns[:, 4] > 0),
            body=body,
            ghosts=[
                Ghost(mark, self._placement.place(pose)) for mark, pose in known[-GHOSTS:] if pose is not None
            ],
            statistics=statistics,
            limbs=self._limb_strips.stretches(start),
            moves=self._limb_strips.moves(start),
            repeated=self._repeated,
            count=self.tally.count,
            followed_moves=self._followed_moves.ranked(),
            overlay=self._followed_moves.overlay(body.joints, self._placement, self._poses[-1][0])
            if body
            else None,
        )

    def marks(self, level: float) -> list[Mark]:
        """Return the key frames that are remembered, in order of time, as they stand at a level."""
        return [_mark(key, level if key.event.take >= self._take else None) for key in self._sorted()]

    def key_poses(self) -> dict[str, NDArray[np.float32]]:
        """Return the poses, (J, 3) m, at the key frames where they are known, by the id of the key frame."""
        return {id_: key.pose for id_, key in self._keys.items() if key.pose is not None}

    def _sorted(self) -> list[_Key]:
        return sorted(self._keys.values(), key=lambda key: key.event.time)

    def _body(self) -> Body | None:
        if not self._poses:
            return None
        return Body(self._placement.place(self._poses[-1][1]), self._motion.shares())

    def _pose_at(self, time: float) -> NDArray[np.float32] | None:
        nearest = min(self._poses, key=lambda kept: abs(kept[0] - time), default=None)
        return nearest[1] if nearest is not None and abs(nearest[0] - time) < 0.2 else None


def _mark(key: _Key, level: float | None) -> Mark:
    """Return the mark of a key frame; without a level the segmenter decides whether it stands."""
    event = key.event
    kept = event.status in _KEPT
    if event.strength is not None and level is not None:
        kept = event.strength >= level
    return Mark(
        id=event.id,
        time=event.time,
        frame=event.frame,
        kind=event.kind,
        velocity=event.velocity,
        strength=event.strength,
        kept=kept and event.status != "candidate",
        decided=event.decided,
        tentative=event.status == "candidate",
        delay=key.delay,
    )
