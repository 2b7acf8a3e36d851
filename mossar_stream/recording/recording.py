"""Recording: Mossar offline, Algorithms 1, 2 and 3, with the hierarchy of all levels.

The frames go through the same kernels as a stream, but no key frame is decided before the end.
"""

import math
import operator
import warnings
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any, cast

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.core.curve_state import CurveState, curve_state
from mossar_stream.core.intake import given_positions, has_said_size, in_seconds
from mossar_stream.core.kernels import (
    DECIDE,
    RANK,
    SPACING,
    Channel,
    Performer,
    Reader,
    Workspace,
    at_once,
    placed,
    set_middle,
)
from mossar_stream.core.plan import Plan, history_size
from mossar_stream.core.row import region
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
from mossar_stream.frames import constant_times, plain_array, refuse_text_as_rate, reshaping
from mossar_stream.moves.groups import groups_of, leading_limb, limbs_by_joint, positions_of
from mossar_stream.moves.joints import MEAN
from mossar_stream.moves.moves import Moves
from mossar_stream.moves.recognition import Recognition
from mossar_stream.poses.holding import holding_of
from mossar_stream.reading import Opened, Recorded, recorded
from mossar_stream.recording import notebook
from mossar_stream.repetitions.reporting import latest_repetitions
from mossar_stream.segmenter.limbs import settings_of_limbs
from mossar_stream.settings import LevelName, Settings, settings_or_default
from mossar_stream.skeleton import Skeleton
from mossar_stream.steps.gait import Step, step_table
from mossar_stream.steps.stepping import Stepping

MOST_APART = 4.0  # s between frames, median; longer ones are hardly seconds: 250 Hz in milliseconds
Analyses = Sequence[tuple[float, NDArray[np.void]]]  # see `Channel.analyses`
STILL_FOR = 2.0  # s without any movement; a longer recording causes a warning
CAPACITY = 64  # key frames there is room for at first
PIECE = 1 << 14  # frames that are processed at once, between which Ctrl-C acts and progress is reported


class Progress:
    """Progress of the segmentation of a recording.

    Args:
        report: Gets the share that is done, 0 to 1; may be None.
        frames: That will be processed: each once for the range, once for its key frames, and so for each limb.
    """

    def __init__(self, report: Callable[[float], None] | None, frames: int) -> None:
        self._report, self._frames, self._done = report, frames, 0

    def pieces(self, frames: int) -> Iterator[tuple[int, int]]:
        """Yield the bounds of the pieces of so many frames; each is done when the next one is asked for."""
        for begin in range(0, frames, PIECE):
            end = min(begin + PIECE, frames)
            yield begin, end
            self._done += end - begin
            if self._report is not None:
                self._report(min(1.0, self._done / self._frames))


class KeyFrame(msgspec.Struct, frozen=True):
    """A key frame of a recording.

    Args:
        frame: Number of the frame.
        time: s.
        kind: `onset`, `offset` or `minimum`.
        velocity: Share of the range.
        strength: Strength at which Algorithm 3 removes it; it is kept at every level up to this.
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
    """The result of `segment_recording`.

    Attributes:
        settings: The settings used.
        key_frames: All key frames of Algorithm 2, with the strengths of Algorithm 3; with evidence they are
            more than a stream reports.
        hierarchy: The same key frames in the order in which they are removed. Without its first k entries it is the
            k-th of the paper's nested sets.
        curves: The velocity curve, frame by frame, if `curves` was set.
        moves: The moves that were recognised, if there were any to recognise; a list with `to_dataframe`.
        followed: Performances of the moves that are followed that were done; a list with `to_dataframe`.
        poses: The poses that were held or entered, once each, when they were left; a list with `to_dataframe`.
        repetitions: Repetitions of movements, with the setting `repetitions`; a list with `to_dataframe`.
        limbs: The result of each limb, with the setting `limbs`.
        steps: Times at which feet left the ground and came down, with the setting `steps`.
        takes: First and last frame of each take; one for the whole recording unless it was divided.
    """

    def __init__(
        self, row: Channel, curves: list[CurveState], moves: list[MoveEvent], limbs: "dict[str, Result]"
    ) -> None:
        self.settings = row.plan.user_settings
        self.curves = curves
        self.moves = notebook.Table(moves, MoveEvent)
        self.repetitions = notebook.Table[RepetitionEvent]([], RepetitionEvent)
        self.steps = notebook.Table[StepEvent]([], StepEvent)
        self.followed = notebook.Table[FollowEvent]([], FollowEvent)
        self.poses = notebook.Table[PoseEvent]([], PoseEvent)
        self.limbs = limbs
        self.takes: list[tuple[int, int]] = []
        self._by_joint = limbs_by_joint(groups_of(row.plan.skeleton, row.plan.user_settings.limbs))
        self._row = row
        keys = region(row.memory, "keys")[: int(row.state["window"]["undecided"])]
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
            level: Level of the segments; that of the settings if None.
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
        row = Channel(self._row.plan, "p1", _copy_of(self._row))
        plan = row.state["plan"]
        if level is None:
            plan["beta"], plan["alpha"] = math.inf, count
        else:
            plan["beta"] = row.plan.strength(self.settings.replace(level=level).level)
            plan["alpha"] = self.settings.max_key_frames or 0
        core = Performer(Workspace(), (row,))
        at_once([core], [(core.decide, DECIDE)])
        events = core.pending
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


class TakesResult(Result):
    """The results of `segment_recording` for the takes of a recording, in order.

    Args:
        parts: Of each take, in order of time; at least one.
    """

    def __init__(self, parts: Sequence[Result]) -> None:
        self.settings, self._parts = parts[0].settings, parts
        self.curves = [state for part in parts for state in part.curves]
        self.moves = notebook.Table((e for part in parts for e in part.moves), MoveEvent)
        self.repetitions = notebook.Table((e for part in parts for e in part.repetitions), RepetitionEvent)
        self.steps = notebook.Table((e for part in parts for e in part.steps), StepEvent)
        self.followed = notebook.Table((e for part in parts for e in part.followed), FollowEvent)
        self.poses = notebook.Table((e for part in parts for e in part.poses), PoseEvent)
        self.limbs = {name: TakesResult([part.limbs[name] for part in parts]) for name in parts[0].limbs}
        self.takes = [bounds for part in parts for bounds in part.takes]
        self.key_frames = [key_frame for part in parts for key_frame in part.key_frames]
        weakest_first = (key_frame for part in parts for key_frame in part.hierarchy)
        self.hierarchy = sorted(weakest_first, key=lambda key_frame: key_frame.strength)

    def at(self, level: LevelName | float | None = None, *, count: int | None = None) -> Segmentation:
        """Return the segmentation of all takes at a level, or with a number of key frames; see `Result.at`."""
        if (level is None) == (count is None):
            raise ValueError("at() takes a level or a count")
        if level is None:
            kept = {id(one) for one in self.hierarchy[max(0, len(self.hierarchy) - max(0, count or 0)) :]}
            counts = [sum(id(one) in kept for one in part.key_frames) for part in self._parts]
            if count is not None and count < 0:
                raise ValueError(f"count must not be negative, not {count}")
            found = [part.at(count=own) for part, own in zip(self._parts, counts, strict=True)]
        else:
            found = [part.at(level) for part in self._parts]
        key_frames = [one for part in found for one in part.key_frames]
        most = self.settings.max_key_frames
        if level is not None and most is not None and len(key_frames) > most:
            return self.at(count=most)
        return Segmentation(key_frames, [segment for part in found for segment in part.segments])


def segment_recording(
    positions: ArrayLike | Recorded | Opened,
    fps: float | None = None,
    skeleton: Skeleton | None = None,
    settings: Settings | None = None,
    *,
    times: ArrayLike | None = None,
    curves: bool = False,
    moves: Moves | None = None,
    follow: Iterable[str] | bool = (),
    takes: bool = False,
    on_progress: Callable[[float], None] | None = None,
) -> Result:
    """Segment a whole recording: equation 1, Algorithms 1, 2 and 3 of Paliyawan, Choensawat and Thawonmas (2018).

    Key frames are numbered by their row in `positions`. A recording is one take: gaps and steps back in time do
    not end it; frames out of order are dropped. With `takes` it is divided into takes as a stream would be.

    Args:
        positions: (n, J, 3) metres, NaN where a joint is missing; or a whole recording, as `read` returns, which brings
            its own times, rate, skeleton and axis that points upwards.
        fps: Rate, Hz; needed without `times`.
        skeleton: The joints; unnamed ones around their centroid if None.
        settings: Defaults to `Settings()`. With `range=file` the range is that of the whole recording.
        times: (n,) seconds.
        curves: Whether to keep the velocity curve.
        moves: That are recognised.
        follow: Names of the moves that are followed, or True for all.
        takes: Whether a take ends where no joint is seen, or no frame comes, for longer than `max_pause`, and covers only
            the time in which joints are seen.
        on_progress: Gets the share that is done, 0 to 1, every 16,384 frames.

    Returns:
        The key frames and their hierarchy.

    Raises:
        FrameError: If the shapes do not fit, or joints are missing that the moves or the limbs need.
        MovesError: If `follow` has a name that the moves lack.
        TypeError: If positions are a path or a table; the message has the remedy.
        ValueError: If there are neither times nor a rate.

    Example:
        >>> take = np.zeros((90, 2, 3), np.float32)
        >>> take[30:60, 1, 0] = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 30))
        >>> take[60:, 1, 0] = 1
        >>> result = segment_recording(take, fps=30, skeleton=Skeleton(("hip", "hand"), (-1, 0)))
        >>> len(result.key_frames), len(result.at(count=1).segments)
        (2, 2)
    """
    own = recorded(positions)
    if own is None:
        frames, moments, skeleton = _checked(cast("ArrayLike", positions), fps, skeleton, times)
    else:
        fps, times = fps or own.fps, own.times if times is None else times
        frames, moments, skeleton = _checked(own.positions, fps, skeleton or own.skeleton, times)
        settings = _with_up(settings_or_default(settings), own)
    any(has_said_size("the performer", frame[np.newaxis], 4) for frame in frames)
    _warn_of_stillness(frames, moments)
    chosen = settings_or_default(settings)
    followed = checked_follow(follow, moves)
    spans = takes_of(frames, moments, chosen.max_pause) if takes else []
    progress = Progress(on_progress, _passes(skeleton, chosen) * len(frames))
    if len(spans) > 1 and chosen.range == "file":  # that of all takes
        narrow, _ = placed(frames, skeleton.root if chosen.center == "root" else -1)
        chosen = _whole_range(narrow, moments, skeleton, chosen, fps, progress)
    found = []
    for take, (begin, end) in enumerate(spans or [(0, len(frames))]):
        readers = _readers_of(skeleton, chosen, moves, followed)
        part = frames[begin:end], moments[begin:end]
        found.append(
            _segmented(*part, skeleton, chosen, fps, readers, progress, curves=curves, first=(take, begin))
        )
        found[-1].takes = [(begin, end - 1)] if end > begin else []
    return found[0] if len(found) == 1 else TakesResult(found)


def _passes(skeleton: Skeleton, settings: Settings) -> int:
    """Return the number of passes over each frame; one less for several takes with one range."""
    return (1 + len(groups_of(skeleton, settings.limbs))) * (2 if settings.range == "file" else 1)


def takes_of(positions: NDArray[Any], times: NDArray[np.float64], max_pause: float) -> list[tuple[int, int]]:
    """Return the takes into which a stream would divide a recording: first frame, and the one after the last.

    Args:
        positions: (n, J, 3).
        times: (n,) s.
        max_pause: s.
    """
    seen = np.isfinite(positions).all(axis=2).any(axis=1)
    takes = list[tuple[int, int]]()
    begin, last, seen_at, seen_time = -1, 0.0, -1, 0.0  # frame, s, frame, s
    for i, (time, is_seen) in enumerate(zip(times.tolist(), seen.tolist(), strict=True)):
        if not math.isfinite(time):
            continue
        if begin >= 0:
            step = time - last
            if abs(step) > max_pause or (step > 0 and not is_seen and time - seen_time > max_pause):
                takes.append((begin, seen_at + 1))
                begin = -1
            elif step <= 0:
                continue
        if begin < 0 and is_seen:
            begin = i
        last = time
        if is_seen:
            seen_at, seen_time = i, time
    return [*takes, (begin, seen_at + 1)] if begin >= 0 else takes


def _with_up(settings: Settings, own: Recorded) -> Settings:
    """Return the settings with the recording's vertical axis, if they leave it open."""
    return settings.replace(up=own.up) if settings.up == "auto" and own.up != "auto" else settings


def _segmented(
    frames: NDArray[Any],
    moments: NDArray[np.float64],
    skeleton: Skeleton,
    settings: Settings,
    fps: float | None,
    readers: Sequence[Reader],
    progress: Progress,
    *,
    curves: bool,
    channel: str = BODY,
    analyses: Analyses = (),
    first: tuple[int, int] = (0, 0),
) -> Result:
    """Segment a recording whose arrays fit each other: of the body, or of a limb, with the counted repetitions of the body.

    `first` are the number of the take, and of its first frame.
    """
    chosen = settings
    frames, origin = placed(frames, skeleton.root if chosen.center == "root" else -1)
    if chosen.range == "file":
        chosen = _whole_range(frames, moments, skeleton, chosen, fps, progress)
    row = _new_row(skeleton, chosen, fps, moments, channel)
    row.settle(origin, True)
    row.clock["take"], row.clock["next_frame"] = first
    row.analyses = [] if chosen.limbs else None
    groups = groups_of(skeleton, chosen.limbs)
    hang = any(limb.joints[0] == MEAN for limb in groups)
    middles = np.empty((len(frames) if hang else 0, 3), np.float32)
    states, events = _push_all(row, readers, (frames, moments), analyses, middles, progress, curves=curves)
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
            (),
            progress,
            curves=curves,
            channel=limb.name,
            analyses=row.analyses or (),
            first=first,
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
        raise FrameError(
            f"positions have shape {frames.shape}; a recording has (n, J, 3){reshaping(frames.shape)}"
        )
    if skeleton is not None and not isinstance(skeleton, Skeleton):
        raise TypeError(
            f"a recording needs a Skeleton, not {type(skeleton).__name__}; Skeleton(names, parents)"
        )
    skeleton = skeleton or Skeleton(tuple(f"joint{j}" for j in range(frames.shape[1])), root=-1)
    if len(skeleton) != frames.shape[1]:
        raise FrameError(f"positions have {frames.shape[1]} joints, the skeleton {len(skeleton)}")
    refuse_text_as_rate(fps)
    if times is None and fps is None:
        raise ValueError("segment_recording needs fps or times")
    moments = constant_times(len(frames), fps or 0.0) if times is None else plain_array(times, np.float64)
    if moments.shape != frames.shape[:1]:
        raise FrameError(f"{len(frames)} frames but times of shape {moments.shape}")
    _check_times(moments)
    return frames, moments, skeleton


def _check_times(times: NDArray[np.float64]) -> None:
    """Refuse impossible times, and warn of times that are hardly seconds.

    Raises:
        FrameError: If times are all NaN or equal, or descend.
    """
    finite = times[np.isfinite(times)]
    if len(times) and not len(finite):
        raise FrameError("all times are NaN; give the rate instead: fps=")
    steps = np.diff(finite)
    if len(steps) and not steps.any():
        raise FrameError(f"all {len(times)} times are {finite[0]:g} s; give the rate instead: fps=")
    if len(steps) and (steps <= 0).all():
        raise FrameError("times descend; they must rise: positions[::-1], times[::-1]")
    middle = float(np.median(steps)) if len(steps) else 0.0
    if middle >= MOST_APART:
        message = f"frames are {middle:,.1f} s apart; times are seconds{in_seconds(middle)}"
        warnings.warn(message, stacklevel=4)


def _warn_of_stillness(frames: NDArray[Any], times: NDArray[np.float64]) -> None:
    """Warn if a recording of `STILL_FOR` or more has nothing to segment: no joint is seen in any frame, or none moves."""
    if not len(times) or not np.nanmax(times) - np.nanmin(times) >= STILL_FOR:
        return
    known = np.full(frames.shape[1:], np.nan, frames.dtype)
    for frame in frames:
        seen = np.isfinite(frame)
        if (seen & np.isfinite(known) & (frame != known)).any():
            return
        known[seen] = frame[seen]
    what = (
        "no joint moves: all frames are alike"
        if np.isfinite(known).any()
        else "no joint is seen in any frame"
    )
    warnings.warn(f"{what}; there is nothing to segment", stacklevel=3)


def _readers_of(
    skeleton: Skeleton, settings: Settings, moves: Moves | None, followed: Follow
) -> list[Reader]:
    """Return the readers of a recording's frames."""
    readers: list[Reader | None] = [
        Recognition(moves, skeleton, "p1") if moves is not None and moves.names else None,
        alignment_of(followed, moves, skeleton, settings, "p1"),
        None if moves is None else holding_of(moves, skeleton, settings.up, "p1"),
        Stepping(skeleton, settings, "p1") if settings.steps else None,
    ]
    return [reader for reader in readers if reader is not None]


def _push_all(
    row: Channel,
    readers: Sequence[Reader],
    recorded: tuple[NDArray[np.float32], NDArray[np.float64]],
    analyses: Analyses,
    middles: NDArray[np.float32],
    progress: Progress,
    *,
    curves: bool,
) -> tuple[list[CurveState], list[Event]]:
    """Process all frames, of a limb with the counted repetitions of its body; return the curve, if it is wanted, and the events.

    `middles`, (n, 3) or (0, 3) m, are set if there are any.
    """
    frames, times = recorded
    # The first frame at or after each look; for frames out of order the latest time so far counts.
    reached = np.fmax.accumulate(np.where(np.isnan(times), -np.inf, times))
    at = reached.searchsorted([time for time, _ in analyses])
    counted = {
        int(place) % len(times): header
        for place, (time, header) in zip(at, analyses, strict=True)
        if time < np.inf
    }
    places, singly = sorted(counted), curves or len(middles) > 0
    states: list[CurveState] = []
    core = Performer(Workspace(), (row,), (), tuple(readers))
    for first, last in progress.pieces(len(times)):
        looks = (
            range(first, last) if singly else places[bisect_left(places, first) : bisect_left(places, last)]
        )
        for begin, end in pairwise(sorted({first, *looks, last})):
            if begin in counted:
                row.adopt_periods(counted[begin])
            core.process(frames[begin:end], times[begin:end])
            if curves:
                states.append(curve_state(row.memory, row.plan))
            if len(middles):
                set_middle(row.memory, middles[begin])
    if analyses:
        row.adopt_periods(analyses[-1][1])
    at_once([core], [(core.end_readers,), (core.decide, RANK)])
    return states, core.pending


def _new_row(
    skeleton: Skeleton,
    settings: Settings,
    fps: float | None,
    times: NDArray[np.float64],
    channel: str = BODY,
) -> Channel:
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
    return Channel(plan, "p1", plan.new_row())


def _copy_of(row: Channel) -> NDArray[np.uint8]:
    """Return a copy of a row's bytes."""
    memory = row.plan.new_row()
    memory[:] = row.memory
    return memory


def _whole_range(
    frames: NDArray[np.float32],
    times: NDArray[np.float64],
    skeleton: Skeleton,
    settings: Settings,
    fps: float | None,
    progress: Progress,
) -> Settings:
    """Return the settings with the range of the whole recording as bounds (paper 3.1.1, normalisation).

    The smallest velocity is 0, that of the first frame, where the window is empty. The bounds are fixed, unless
    the range must be able to rise above the noise.
    """
    row = _new_row(skeleton, settings.replace(range="running"), fps, times)
    core = Performer(Workspace(), (row,))
    for begin, end in progress.pieces(len(times)):
        core.process(frames[begin:end], times[begin:end])
    state, bounds = row.state, row.state["plan"]
    largest = max(float(state["range"]["largest"]), float(bounds["range_floor"]), np.finfo(float).tiny)
    if bounds["noise_margin"]:
        return settings.replace(range="running", range_floor=largest / float(bounds["moving_joints"]))
    return settings.replace(range="fixed", range_min=0.0, range_max=largest)
