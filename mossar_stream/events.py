"""Events: the output of a segmenter.

One frozen record per kind of message, the same fields on every wire (JSON lines, msgpack, WebSocket). The life
of a key frame, by its `status`:

    candidate ──▶ withdrawn                       a lower minimum, a crossing or the end of the take came first
        │
        ▼
    confirmed ──▶ merged ◀──▶ restored            as context arrives or the user moves the level
        │            │            │
        └────────────┴────────────┴──▶ final or merged, with `decided` true: the last message about this id

Onsets and offsets start at `confirmed`. `rev` counts the messages about one id from 1. An `ActivityEvent` has no life:
it is sent once.
"""

from typing import Literal, get_args

import msgspec

SCHEMA_VERSION = 1
BODY = "body"  # the channel of the whole body; others are limbs

KeyFrameStatus = Literal["candidate", "withdrawn", "confirmed", "merged", "restored", "final"]
KeyFrameKind = Literal["onset", "offset", "minimum"]
SegmentStatus = Literal["closed", "withdrawn", "final"]
SegmentState = Literal["resting", "moving"]
MoveStatus = Literal["confirmed", "withdrawn", "final"]
RepetitionStatus = Literal["counted", "withdrawn"]
StepStatus = Literal["strike", "off"]
FollowStatus = Literal["begun", "progress", "done", "left"]
LeftReason = Literal["", "unfinished", "movement", "once", "another", "hidden", "gap"]
PoseStatus = Literal["entered", "held", "left"]
Side = Literal["left", "right"]
StreamChange = Literal["started", "stalled", "resumed", "reset", "ended"]

KEY_FRAME_STATUSES: tuple[KeyFrameStatus, ...] = get_args(KeyFrameStatus)
KEY_FRAME_KINDS: tuple[KeyFrameKind, ...] = get_args(KeyFrameKind)
STEP_STATUSES: tuple[StepStatus, ...] = get_args(StepStatus)
LEFT_REASONS: tuple[LeftReason, ...] = get_args(LeftReason)
FOLLOW_STATUSES: tuple[FollowStatus, ...] = get_args(FollowStatus)
POSE_STATUSES: tuple[PoseStatus, ...] = get_args(PoseStatus)
REPETITION_STATUSES: tuple[RepetitionStatus, ...] = get_args(RepetitionStatus)
SEGMENT_STATUSES: tuple[SegmentStatus, ...] = get_args(SegmentStatus)
MOVE_STATUSES: tuple[MoveStatus, ...] = get_args(MoveStatus)
SEGMENT_STATES: tuple[SegmentState, ...] = get_args(SegmentState)


# `omit_defaults` leaves out fields with their default, such as `channel` and `limb`; a value from a factory is always sent.
_ALWAYS_SENT: int = msgspec.field(default_factory=lambda: SCHEMA_VERSION)
SENT_AS_NONE: float | None = msgspec.field(default_factory=lambda: None)


class KeyFrameEvent(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="key_frame",
    kw_only=True,
    gc=False,
    omit_defaults=True,
):
    """A message about one key frame (the paper's Algorithms 2 and 3).

    Args:
        v: Version of this layout, 1; the same in all events.
        performer: Name of the performer; the same in all events.
        take: Counts the takes of the performer from 0; the same in all events.
        status: See the module; `confirmed` is sent once, together these are the list of Algorithm 2.
        decided: True in the last message about this id.
        kind: `onset` where the velocity crosses θ upwards, `offset` downwards, `minimum` between two moves.
        id: `performer/take/frame` with Algorithm 2's frame, of a limb `performer/channel/take/frame`; stays the same
            over all messages.
        rev: Counts the messages about this id from 1.
        frame: Frame number in the take, from 0. At level `motion` it is a few frames earlier than in the id, because smoothing
            delays the curve; a `final` message may have another one (setting `refine`).
        time: Time of that frame, s on the source's clock.
        decided_frame: The frame that caused this message.
        decided_time: Its time, s.
        velocity: Velocity at the key frame, as a share of the range at that moment.
        strength: Strength at which Algorithm 3 removes it, >= 0; None until first computed.
        channel: The limb (setting `limbs`); not sent for the body, which is `body`.
    """

    v: int = _ALWAYS_SENT
    performer: str
    id: str
    rev: int
    status: KeyFrameStatus
    decided: bool
    kind: KeyFrameKind
    take: int
    frame: int
    time: float
    decided_frame: int
    decided_time: float
    velocity: float
    strength: float | None
    channel: str = BODY


class SegmentEvent(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="segment",
    kw_only=True,
    gc=False,
    omit_defaults=True,
):
    """A message about one segment between two kept key frames, or between one and an end of the take.

    Args:
        status: `closed` when its right end is confirmed, `withdrawn` when one of its ends is merged, `final` when both ends are
            decided.
        start_time: Time of `start_frame`, s on the source's clock.
        end_time: Time of `end_frame`, s.
        id: `performer/take/start-end` in Algorithm 2's frames, of a limb `performer/channel/take/start-end`.
        rev: Counts the messages about this id from 1.
        start_frame: First frame of the segment.
        end_frame: Frame of the key frame that ends it; the take's last frame for the last one.
        state: `resting` if the performer did not move in it, else `moving`; of a `closed` segment as known then.
        active_joints: At most 5 joints with the largest path lengths relative to the centre.
        active_start: Time of the first movement in it, s; None if nothing moved.
        active_end: Time of the last movement in it, s; None if nothing moved.
        similarity: To the segment before, in 0..1; None for the first of a take.
        channel: The limb (setting `limbs`); not sent for the body, which is `body`.
        limb: The leading limb, for a segment of the body (setting `limbs`); not sent if it is not known.
    """

    v: int = _ALWAYS_SENT
    performer: str
    id: str
    rev: int
    status: SegmentStatus
    state: SegmentState
    take: int
    start_frame: int
    end_frame: int
    start_time: float
    end_time: float
    active_joints: tuple[str, ...]
    similarity: float | None
    active_start: float | None = SENT_AS_NONE
    active_end: float | None = SENT_AS_NONE
    channel: str = BODY
    limb: str | None = None


class ActivityEvent(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="activity",
    kw_only=True,
    gc=False,
    omit_defaults=True,
):
    """The performer, or a limb, began to move or came to rest; reported at once, and never withdrawn.

    `moving` comes within 0.1 s of `start`; `resting` comes once the speed has been below the line for the setting
    `rest_seconds`. A take begins at rest, so its first activity is `moving`; a take that ends in motion has no `resting`.

    Args:
        id: `performer/activity/take/number`, of a limb `performer/channel/activity/take/number`; the number counts the
            changes in the take from 1.
        state: `moving` or `resting`, from `start` on.
        start: Time of the first frame above the line, of `resting` that of the last one above it, s on the source's clock.
        previous: Duration of the state before, s; None for the first of a take.
        limb: The limb of the joint that was fastest when the performer began to move (setting `limbs`), also of the
            `resting` that ends it; None without the setting.
        decided_time: Time of the frame that caused this message, s.
        channel: The limb (setting `limbs`); not sent for the body, which is `body`.
    """

    v: int = _ALWAYS_SENT
    performer: str
    id: str
    take: int
    state: SegmentState
    start: float
    previous: float | None
    limb: str | None
    decided_time: float
    channel: str = BODY


class RepetitionEvent(
    msgspec.Struct, frozen=True, tag_field="type", tag="repetition", kw_only=True, gc=False
):
    """A message about one repetition of a movement (setting `repetitions`).

    A later analysis may withdraw a repetition or move its ends; `total` is the running count.

    Args:
        status: `counted`; again with a higher `rev` when its ends have moved; `withdrawn` when it was a false count.
        id: `performer/take/rNUMBER`, the number of the repetition in the take; of a limb
            `performer/channel/take/rNUMBER`.
        rev: Counts the messages about this id from 1.
        channel: The repeating part: `body` for the whole posture, or a limb (setting `limbs`).
        count: Number in this bout, from 1; 0 when withdrawn.
        total: Number of repetitions in the take, this message included.
        period: Median duration of the last cycles of the bout, s; None for the first of a bout.
        tempo: Cycles a minute; None for the first of a bout.
        start: Begin of the cycle, s on the source's clock; None when withdrawn.
        end: Its end, s.
        amplitude: From one extreme to the other, m, rms over joints.
        joint: The joint that moves most.
        decided_time: Time of the frame that caused this message, s.
    """

    v: int = SCHEMA_VERSION
    performer: str
    id: str
    rev: int
    status: RepetitionStatus
    take: int
    channel: str
    count: int
    total: int
    period: float | None
    tempo: float | None
    start: float | None
    end: float | None
    amplitude: float | None
    joint: str | None
    decided_time: float


class StepEvent(msgspec.Struct, frozen=True, tag_field="type", tag="step", kw_only=True, gc=False):
    """A foot came down or left the ground (setting `steps`); each is reported once.

    Args:
        id: `performer/step/take/NUMBER`, which counts the events of the take from 1.
        rev: 1.
        status: `strike` when the foot comes down, `off` when it leaves the ground.
        side: Side of the foot.
        time: Time of the step, s on the source's clock.
        position: Position of the foot, m: the mean of its known joints.
        confidence: 0 to 1: how clearly the movement exceeds a small movement and the sensor's noise.
        decided_time: Time of the frame that caused this message, s.
    """

    v: int = SCHEMA_VERSION
    performer: str
    id: str
    rev: int
    status: StepStatus
    take: int
    side: Side
    time: float
    position: tuple[float, float, float]
    confidence: float
    decided_time: float


class PhaseEvent(msgspec.Struct, frozen=True, tag_field="type", tag="phase", kw_only=True, gc=False):
    """The position of a frame in the cycle of a repeated movement (setting `phase`); every frame of a bout has one.

    Args:
        channel: The repeating part, as in `RepetitionEvent`.
        time: Of the frame, s on the source's clock.
        phase: 0 to 1 from the begin of the cycle; None once, when nothing repeats any more.
    """

    v: int = SCHEMA_VERSION
    performer: str
    take: int
    channel: str
    time: float
    phase: float | None


class StreamEvent(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="stream",
    kw_only=True,
    gc=False,
    omit_defaults=True,
):
    """A take started or ended, or frames stopped and came back.

    Args:
        event: `started` and `ended` enclose a take; `stalled`, `resumed` and `reset` come between.
        reason: Reason of an end; else empty.
        run: Of `started`: the run of the program that emits the events. The pipeline sets it; a segmenter does not, and
            then it is not sent.
    """

    v: int = _ALWAYS_SENT
    performer: str
    event: StreamChange
    take: int
    reason: str = msgspec.field(default_factory=str)
    run: str | None = None


class MoveEvent(msgspec.Struct, frozen=True, tag_field="type", tag="move", kw_only=True, gc=False):
    """A message about a recognised move, which the user has taught.

    `confirmed` comes once, as soon as the move is clear; then `withdrawn` if it turns out to be part of another one,
    else `final`.

    Args:
        id: `performer/move/take/number`; the number counts the performer's moves.
        rev: Counts the messages about this id from 1.
        name: Name of the move, as its examples have it.
        status: `confirmed`, `withdrawn` or `final`.
        start: Begin of the move, s.
        end: The latest time that was compared with the examples, s.
        score: Similarity of the movement and the nearest example, 1 / (1 + cost), in 0..1.
        limb: The leading limb: `left_arm`, `right_arm`, `left_leg`, `right_leg`, `trunk`; else a chain from the root, or `body`.
        decided_time: Time of the frame that caused this message, s.
    """

    v: int = SCHEMA_VERSION
    performer: str
    id: str
    rev: int
    name: str
    status: MoveStatus
    take: int
    start: float
    end: float
    score: float
    limb: str
    decided_time: float


def _most_deviant_limb(event: "FollowEvent | PoseEvent") -> str:
    """The limb that deviates most; `body` where no bone belongs to a limb."""
    return max(event.limbs, key=lambda name: event.limbs[name], default=BODY)


class FollowEvent(msgspec.Struct, frozen=True, tag_field="type", tag="follow", kw_only=True, gc=False):
    """A message about a performance of a followed move (parameter `follow`): progress, tempo, deviation and score.

    Args:
        id: `performer/follow/take/NUMBER`, which counts the performances of the take from 1.
        rev: Counts the messages about this id from 1.
        name: Name of the move, as its examples have it.
        status: `begun` when the performance is recognised, `progress` at most every `follow_every` seconds, then `done`, or
            `left` if it was given up or became something else.
        count: Performances of this name that are done in this take, this one included when `done`.
        start: Begin of the performance, s on the source's clock.
        time: Time that the numbers belong to, s; of `done` the end of the performance.
        progress: 0 to 1, from the begin of the example's movement to its end.
        tempo: Relative to the example, over the last second; 1.2 is a fifth faster. Of `done` that of the whole.
        certainty: 0 to 1: how likely the performance will be done.
        deviation: Root mean square angle between the directions of bones and the example's, since `start`, degrees.
        posture: The part of it that is the same from begin to end, degrees: a difference of two bodies, of two places of a
            sensor, or of a stance.
        limbs: The deviation of each limb that was not hidden for more than a third of the performance.
        joint: End of the bone that deviates most; empty if all bones were hidden.
        range: When `done`: extent of each limb's path relative to the example's, for those of `limbs` that move in the
            example; else None.
        score: When `done`: 0 to 1, the similarity of the performance and the examples; else None.
        decided_time: Time of the frame that caused this message, s.
        reason: When `left`: `unfinished` if the end of the example was not reached; `movement` if the movement differs too
            much from it; `once` if it differs less, so that it may count once it is repeated; `another` if another
            followed move fits better; `hidden` if no bone was seen; `gap` if frames were missing. Else empty.
    """

    v: int = SCHEMA_VERSION
    performer: str
    id: str
    rev: int
    name: str
    status: FollowStatus
    take: int
    count: int
    start: float
    time: float
    progress: float
    tempo: float
    certainty: float
    deviation: float
    limbs: dict[str, float]
    joint: str
    range: dict[str, float] | None
    score: float | None
    decided_time: float
    posture: float = 0.0
    reason: LeftReason = ""

    limb = property(_most_deviant_limb)


class PoseEvent(msgspec.Struct, frozen=True, tag_field="type", tag="pose", kw_only=True, gc=False):
    """A message about a pose that the performer takes; sent whenever the moves have poses.

    Args:
        id: `performer/pose/take/NUMBER`, which counts the poses of the take from 1.
        rev: Counts the messages about this id from 1.
        name: Name of the pose, as it was taught.
        status: `entered` when the performer comes to rest in the pose, `held` once, when it has been held for its `hold`
            seconds, and `left`.
        start: Time at which the performer came near to the pose, s on the source's clock.
        seconds: Time for which the pose has been held, s; of `left` in all.
        deviation: Root mean square angle between the directions of bones and those of the pose, since `entered`, degrees.
        limbs: The same for each limb.
        joint: End of the bone that deviates most.
        decided_time: Time of the frame that caused this message, s.
    """

    v: int = SCHEMA_VERSION
    performer: str
    id: str
    rev: int
    name: str
    status: PoseStatus
    take: int
    start: float
    seconds: float
    deviation: float
    limbs: dict[str, float]
    joint: str
    decided_time: float

    limb = property(_most_deviant_limb)


class StatsEvent(msgspec.Struct, frozen=True, tag_field="type", tag="stats", kw_only=True, gc=False):
    """Counters of one performer's stream since it began; made by the pipeline, not by the core.

    Args:
        frames: Processed frames.
        fps: Their rate, Hz.
        out_of_order: Frames dropped because they came late or twice.
        outliers: Joints implausibly fast, more than 100 km away, or, as a take begins, far from all others.
        held: Joints replaced by their last position, because they were missing.
        gaps: Frames after a gap.
        unseen: Frames without any tracked joint.
        malformed: Messages that could not be read.
        kernel_drops: Datagrams dropped by the operating system.
        queue_dropped: Frames dropped because a queue was full, or because they came before the program was ready.
        latency_p50_ms: Median delay from the arrival of a frame to its events, ms; None before the first event.
        latency_p99_ms: 99th percentile of that delay, ms.
        retimed: Frames of the source with another time than their sender's, because its clock does not run.
    """

    v: int = SCHEMA_VERSION
    performer: str
    frames: int
    fps: float
    out_of_order: int
    outliers: int
    held: int
    gaps: int
    unseen: int
    malformed: int
    kernel_drops: int
    queue_dropped: int
    latency_p50_ms: float | None = None
    latency_p99_ms: float | None = None
    retimed: int = 0


Event = (
    KeyFrameEvent
    | SegmentEvent
    | ActivityEvent
    | MoveEvent
    | FollowEvent
    | PoseEvent
    | RepetitionEvent
    | PhaseEvent
    | StepEvent
    | StreamEvent
    | StatsEvent
)

_encoder = msgspec.json.Encoder()


def to_json(event: Event) -> bytes:
    """Return the event as one line of JSON, without the line's end.

    Example:
        >>> to_json(StreamEvent(performer="p1", event="started", take=0))
        b'{"type":"stream","v":1,"performer":"p1","event":"started","take":0,"reason":""}'
    """
    return _encoder.encode(event)
