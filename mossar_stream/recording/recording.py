"""Recording: the whole of Mossar offline, Algorithms 1, 2 and 3, and the hierarchy that people choose from.

The frames go through the same kernels as a stream, but no key frame is decided before the end.
"""

import math
import operator
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.core import engine
from mossar_stream.core.buffers import Buffers
from mossar_stream.core.curve_state import CurveState, curve_state
from mossar_stream.core.intake import FLOAT32, given_positions, has_said_size, place_of, subtract
from mossar_stream.core.kernels import DECIDE, RANK, SPACING, set_middle
from mossar_stream.core.plan import Plan, history_size
from mossar_stream.core.pool import Row, new_row, restored_row
from mossar_stream.core.row import region
from mossar_stream.core.station import desk_of
from mossar_stream.errors import FrameError
from mossar_stream.events import (
    BODY,
    KEY_FRAME_KINDS,
    SENT_AS_NONE,
    Event,
    FollowEvent,
    KeyFrameEvent,
    KeyFrameKind,
    MoveEvent,
    PoseEvent,
    RepetitionEvent,
    SegmentEvent,
    SegmentState,
    StepEvent,
)
from mossar_stream.following.alignment import Follow, alignment_of, checked_follow
from mossar_stream.frames import constant_times, plain_array
from mossar_stream.moves.groups import groups_of, leading_limb, limbs_by_joint, positions_of
from mossar_stream.moves.joints import MEAN
from mossar_stream.moves.moves import Moves
from mossar_stream.moves.recognition import Recognition
from mossar_stream.poses.holding import holding_of
from mossar_stream.readers import Reader
from mossar_stream.recording import notebook
from mossar_stream.repetitions.reporting import latest_repetitions
from mossar_stream.segmenter.limbs import settings_of_limbs
from mossar_stream.settings import LevelName, Settings, settings_or_default
from mossar_stream.skeleton import Skeleton
from mossar_stream.steps.gait import Step, step_table
from mossar_stream.steps.stepping import Stepping

Analyses = Sequence[tuple[float, NDArray[np.void]]]  # see `Row.analyses`
CAPACITY = 64  # key frames there is room for at first


class KeyFrame(msgspec.Struct, frozen=True):
    """A key frame of a recording.

    Args:
        frame: Number of the frame.
        time: s.
        kind: `onset`, `offset` or `minimum`.
        velocity: Share of the range.
        strength: At which Algorithm 3 removes it; it is kept at every level up to this.
    """

    frame: int
    time: float
    kind: KeyFrameKind
    velocity: float
    strength: float


class Segment(msgspec.Struct, frozen=True, omit_defaults=True):
    """A segment of a recording.

    Args:
        start_frame: First frame.
        end_frame: Frame of the key frame that ends it; the last frame of the recording for the last segment.
        start_time: Time of `start_frame`, s.
        end_time: Time of `end_frame`, s.
        state: `resting` if nothing moved in it, else `moving`.
        active_joints: At most 5 joints with the largest paths relative to the centre.
        similarity: To the segment before, in 0..1; None for the first.
        active_start: Time of the first movement in it, s; None if nothing moved.
        active_end: Time of the last movement in it, s; None if nothing moved.
        limb: The leading limb (setting `limbs`); None if it is not known.
    """

    start_frame: int
    end_frame: int
    start_time: float
    end_time: float
    state: SegmentState
    active_joints: tuple[str, ...]
    similarity: float | None
    active_start: float | None = SENT_AS_NONE
    active_end: float | None = SENT_AS_NONE
    limb: str | None = None


class Segmentation(msgspec.Struct, frozen=True):
    """One level of the hierarchy (Algorithm 3).

    Args:
        key_frames: The kept key frames, in order of time.
        segments: The segments between them, from the first frame of the recording to the last.
    """

    key_frames: list[KeyFrame]
    segments: list[Segment]

    def to_dataframe(self) -> Any:
        """Return the segments as a pandas DataFrame.

        Raises:
            ImportError: If pandas is not installed.
        """
        return notebook.dataframe(self.segments, Segment.__struct_fields__)

    def __repr__(self) -> str:
        return notebook.segments_summary(self)

    def _repr_html_(self) -> str:
        return notebook.segments_html(self)


class Result:
    """What `segment_recording` found.

    Attributes:
        settings: The settings used.
        key_frames: All key frames of Algorithm 2, with the strengths of Algorithm 3; with evidence they are
            more than a stream tells of.
        hierarchy: The same key frames in the order in which they are removed. Without its first k entries it is the
            k-th of the paper's nested sets.
        curves: The velocity curve, frame by frame, if it was asked for.
        moves: The moves that were recognised, if there were any to recognise; a list with `to_dataframe`.
        followed: Performances of the moves that are followed that were done; a list with `to_dataframe`.
        poses: The poses that were held or entered, once each, when they were left; a list with `to_dataframe`.
        repetitions: Repetitions of movements, with the setting `repetitions`; a list with `to_dataframe`.
        limbs: What was found in each limb, with the setting `limbs`.
        steps: When feet left the ground and came down, with the setting `steps`.
    """

    def __init__(
        self, row: Row, curves: list[CurveState], moves: list[MoveEvent], limbs: "dict[str, Result]"
    ) -> None:
        self.settings = row.plan.user_settings
        self.curves = curves
        self.moves = notebook.Table(moves, MoveEvent)
        self.repetitions = notebook.Table[RepetitionEvent]([], RepetitionEvent)
        self.steps = notebook.Table[StepEvent]([], StepEvent)
        self.followed = notebook.Table[FollowEvent]([], FollowEvent)
        self.poses = notebook.Table[PoseEvent]([], PoseEvent)
        self.limbs = limbs
        self._by_joint = limbs_by_joint(groups_of(row.plan.skeleton, row.plan.user_settings.limbs))
        self._row = row
        keys = region(row.memory, row.plan.shape, "keys")[: int(row.state["window"]["undecided"])]
        self.key_frames = [
            KeyFrame(frame, time, KEY_FRAME_KINDS[kind], velocity, strength)
            for frame, time, kind, velocity, strength in keys[
                ["at_frame", "at_time", "kind", "velocity", "strength"]
            ].tolist()
        ]
        self.hierarchy = [self.key_frames[i] for i in np.argsort(keys["place"], kind="stable")]

    def __repr__(self) -> str:
        return notebook.summary(self)

    def _repr_html_(self) -> str:
        return notebook.html(self)

    def to_dataframe(self) -> Any:
        """Return all key frames, with their strengths, as a pandas DataFrame; `at(level).to_dataframe()` has segments.

        Raises:
            ImportError: If pandas is not installed.
        """
        return notebook.dataframe(self.key_frames, KeyFrame.__struct_fields__)

    def steps_dataframe(self) -> Any:
        """Return the steps as a pandas DataFrame: each from a strike to the next of the same foot (setting `steps`).

        Raises:
            ImportError: If pandas is not installed.
        """
        return notebook.dataframe(step_table(self.steps), Step.__struct_fields__)

    def plot(self, level: LevelName | float | None = None, *, axes: Any = None) -> Any:
        """Draw the segments and key frames, with the velocity curve if `curves=True` kept it.

        Args:
            level: Which segments; those of the settings if None.
            axes: Of matplotlib; a new figure's if None.

        Returns:
            The axes.

        Raises:
            ImportError: If matplotlib is not installed.
        """
        return notebook.plot(self, self.at(self.settings.level if level is None else level), axes)

    @property
    def segments(self) -> list[Segment]:
        """The segments at the level of the settings, or with `max_key_frames` key frames."""
        return self.at(self.settings.level).segments

    def at(self, level: LevelName | float | None = None, *, count: int | None = None) -> Segmentation:
        """Return the segmentation at a level, or with a number of key frames. Nothing is computed again.

        Args:
            level: A name or a strength: key frames at least as strong are kept, and of the others as many as
                `max_key_frames` calls for.
            count: Number of key frames that are kept (α); all of them if there are fewer.

        Raises:
            ValueError: If not exactly one of the two is given, or `count` is negative.
        """
        if (level is None) == (count is None):
            raise ValueError("at() takes a level or a count")
        if count is not None:
            count = min(operator.index(count), len(self.key_frames))
            if count < 0:
                raise ValueError(f"count must not be negative, not {count}")
        row = restored_row(self._row.plan, Buffers(), "p1", self._row.memory)
        plan = row.state["plan"]
        if level is None:
            plan["beta"], plan["alpha"] = math.inf, count
        else:
            plan["beta"] = row.plan.strength(self.settings.replace(level=level).level)
            plan["alpha"] = self.settings.max_key_frames or 0
        events = engine.update(row, DECIDE)
        kept = [
            KeyFrame(e.frame, e.time, e.kind, e.velocity, e.strength if e.strength is not None else math.inf)
            for e in events
            if isinstance(e, KeyFrameEvent) and e.status == "final"
        ]
        return Segmentation(kept, [self._segment(e) for e in events if isinstance(e, SegmentEvent)])

    def _segment(self, event: SegmentEvent) -> Segment:
        same = {name: getattr(event, name) for name in Segment.__struct_fields__ if name != "limb"}
        limb = leading_limb(event.active_joints, self._by_joint) if self._by_joint else None
        return Segment(**same, limb=limb)


def segment_recording(
    positions: ArrayLike,
    fps: float | None = None,
    skeleton: Skeleton | None = None,
    settings: Settings | None = None,
    *,
    times: ArrayLike | None = None,
    curves: bool = False,
    moves: Moves | None = None,
    follow: Iterable[str] | bool = (),
) -> Result:
    """Segment a whole recording: equation 1, Algorithms 1, 2 and 3 of Paliyawan, Choensawat and Thawonmas (2018).

    Key frames are numbered by their row in `positions`. A recording is one take: gaps and steps back in time do
    not end it; frames out of order are dropped.

    Args:
        positions: (n, J, 3) metres, NaN where a joint is missing.
        fps: Rate, Hz; needed without `times`.
        skeleton: The joints; unnamed ones around their centroid if None.
        settings: Defaults to `Settings()`. With `range=file` the range is that of the whole recording.
        times: (n,) seconds.
        curves: Whether to keep the velocity curve.
        moves: That are recognised.
        follow: Names of the moves that are followed, or True for all.

    Returns:
        The key frames and their hierarchy.

    Raises:
        FrameError: If the shapes do not fit, or joints are missing that the moves or the limbs need.
        MovesError: If `follow` has a name that the moves lack.
        ValueError: If there are neither times nor a rate.

    Example:
        >>> take = np.zeros((90, 2, 3), np.float32)
        >>> take[30:60, 1, 0] = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 30))
        >>> take[60:, 1, 0] = 1
        >>> result = segment_recording(take, fps=30, skeleton=Skeleton(("hip", "hand"), (-1, 0)))
        >>> len(result.key_frames), len(result.at(count=1).segments)
        (2, 2)
    """
    frames, moments, skeleton = _checked(positions, fps, skeleton, times)
    any(has_said_size("the performer", frame[np.newaxis], 4) for frame in frames)
    chosen = settings_or_default(settings)
    followed = checked_follow(follow, moves)
    readers = _readers_of(skeleton, chosen, moves, followed)
    return _segmented(frames, moments, skeleton, chosen, fps, readers, curves=curves)


def _segmented(
    frames: NDArray[Any],
    moments: NDArray[np.float64],
    skeleton: Skeleton,
    settings: Settings,
    fps: float | None,
    readers: Sequence[Reader] = (),
    *,
    curves: bool,
    channel: str = BODY,
    analyses: Analyses = (),
) -> Result:
    """Segment a recording whose arrays fit each other: of the body, or of a limb, with what was counted of the body."""
    chosen = settings
    frames, origin = _narrowed(frames, skeleton.root if chosen.center == "root" else -1)
    if chosen.range == "file":
        chosen = _whole_range(frames, moments, skeleton, chosen, fps)
    row = _new_row(skeleton, chosen, fps, moments, channel)
    row.settle(origin, found=True)
    row.analyses = [] if chosen.limbs else None
    groups = groups_of(skeleton, chosen.limbs)
    hang = any(limb.joints[0] == MEAN for limb in groups)
    middles = np.empty((len(frames) if hang else 0, 3), np.float32)
    states, events = _push_all(row, readers, (frames, moments), analyses, middles, curves=curves)
    events += engine.update(row, RANK)
    own = settings_of_limbs(settings)
    limbs = {}
    for limb in groups:
        seen = given_positions(positions_of(limb, frames, middles))
        limbs[limb.name] = _segmented(
            seen,
            moments,
            limb.skeleton,
            own,
            fps,
            curves=curves,
            channel=limb.name,
            analyses=row.analyses or (),
        )
    row.analyses = None
    found = [event for event in events if isinstance(event, MoveEvent) and event.status == "final"]
    done = [event for event in events if isinstance(event, FollowEvent) and event.status == "done"]
    result = Result(row, states, found, limbs)
    result.followed = notebook.Table(done, FollowEvent)
    left = [event for event in events if isinstance(event, PoseEvent) and event.status == "left"]
    result.poses = notebook.Table(left, PoseEvent)
    result.repetitions = notebook.Table(latest_repetitions(events), RepetitionEvent)
    result.steps = notebook.Table((e for e in events if isinstance(e, StepEvent)), StepEvent)
    return result


def _checked(
    positions: ArrayLike, fps: float | None, skeleton: Skeleton | None, times: ArrayLike | None
) -> tuple[NDArray[Any], NDArray[np.float64], Skeleton]:
    """Return positions, times and the skeleton of a recording, as arrays that fit each other."""
    frames = given_positions(positions)
    if frames.ndim != 3 or frames.shape[2] != 3 or not frames.shape[1]:
        raise FrameError(f"positions have shape {frames.shape}; a recording has (n, J, 3)")
    if skeleton is not None and not isinstance(skeleton, Skeleton):
        raise TypeError(
            f"a recording needs a Skeleton, not {type(skeleton).__name__}; Skeleton(names, parents)"
        )
    skeleton = skeleton or Skeleton(tuple(f"joint{j}" for j in range(frames.shape[1])), root=-1)
    if len(skeleton) != frames.shape[1]:
        raise FrameError(f"positions have {frames.shape[1]} joints, the skeleton {len(skeleton)}")
    if times is None and fps is None:
        raise ValueError("segment_recording needs fps or times")
    moments = constant_times(len(frames), fps or 0.0) if times is None else plain_array(times, np.float64)
    if moments.shape != frames.shape[:1]:
        raise FrameError(f"{len(frames)} frames but times of shape {moments.shape}")
    return frames, moments, skeleton


def _narrowed(positions: NDArray[Any], center: int) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Return positions in single precision, relative to where the performer is first seen, and that; see intake.py."""
    origin, _ = place_of(positions, center)
    if positions.dtype == FLOAT32 and not origin.any():
        return positions, origin
    return subtract(positions, origin, np.empty(positions.shape, np.float32)), origin


def _readers_of(
    skeleton: Skeleton, settings: Settings, moves: Moves | None, followed: Follow
) -> list[Reader]:
    """Return what reads the frames of a recording."""
    readers: list[Reader | None] = [
        Recognition(moves, skeleton, "p1") if moves is not None and moves.names else None,
        alignment_of(followed, moves, skeleton, settings, "p1"),
        None if moves is None else holding_of(moves, skeleton, settings.up, "p1"),
        Stepping(skeleton, settings, "p1") if settings.steps else None,
    ]
    return [reader for reader in readers if reader is not None]


def _push_all(
    row: Row,
    readers: Sequence[Reader],
    recorded: tuple[NDArray[np.float32], NDArray[np.float64]],
    analyses: Analyses,
    middles: NDArray[np.float32],
    *,
    curves: bool,
) -> tuple[list[CurveState], list[Event]]:
    """Process all frames, of a limb with what was counted of its body; return the curve, if it is wanted, and the events.

    `middles`, (n, 3) or (0, 3) m, are set if there are any.
    """
    frames, times = recorded
    bounds = {*range(0, len(times), 1 if curves or len(middles) else max(1, len(times))), len(times)}
    # The first frame that is not before each look; of frames out of order the latest time so far counts.
    reached = np.fmax.accumulate(np.where(np.isnan(times), -np.inf, times))
    places = reached.searchsorted([time for time, _ in analyses])
    counted = {
        int(place) % len(times): header
        for place, (time, header) in zip(places, analyses, strict=True)
        if time < np.inf
    }
    bounds |= set(counted)
    states: list[CurveState] = []
    desk = desk_of(row, readers)
    for begin, end in pairwise(sorted(bounds)):
        if begin in counted:
            row.adopt_periods(counted[begin])
        engine.process(desk, frames[begin:end], times[begin:end])
        if curves:
            states.append(curve_state(row.memory, row.plan))
        if len(middles):
            set_middle(row.memory, middles[begin])
    if analyses:
        row.adopt_periods(analyses[-1][1])
    for reader in readers:
        reader.end(0, row.pending)
    return states, row.take_pending()


def _new_row(
    skeleton: Skeleton,
    settings: Settings,
    fps: float | None,
    times: NDArray[np.float64],
    channel: str = BODY,
) -> Row:
    """Return a row for a recording: of the body, or of a limb."""
    finite = times[np.isfinite(times)]
    seconds = float(np.ptp(finite)) if len(finite) else 0.0
    history = min(history_size(seconds), history_size(len(times) * SPACING))
    bouts = min(int(seconds / settings.rest_seconds), len(times)) + 1
    plan = Plan(
        skeleton,
        settings,
        fps,
        window=CAPACITY,
        history=history,
        bouts=bouts,
        channel=channel,
        offline=True,
    )
    return new_row(plan, Buffers(), "p1")


def _whole_range(
    frames: NDArray[np.float32],
    times: NDArray[np.float64],
    skeleton: Skeleton,
    settings: Settings,
    fps: float | None,
) -> Settings:
    """Return the settings with the range of the whole recording as bounds (paper 3.1.1, normalisation).

    The smallest velocity is 0, that of the first frame, where the window is empty. The bounds are fixed, unless
    the range must be able to rise above the noise.
    """
    row = _new_row(skeleton, settings.replace(range="running"), fps, times)
    engine.process(desk_of(row), frames, times)
    state, bounds = row.state, row.state["plan"]
    largest = max(float(state["range"]["largest"]), float(bounds["range_floor"]), np.finfo(float).tiny)
    if bounds["noise_margin"]:
        return settings.replace(range="running", range_floor=largest / float(bounds["moving_joints"]))
    return settings.replace(range="fixed", range_min=0.0, range_max=largest)
