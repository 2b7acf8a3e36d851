"""Event buffer: through it compiled code hands events out.

Record 0 counts the others. `events.py` has the records that users see; `hand_out` makes them.
"""

import struct
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from mossar_stream.events import (
    BODY,
    KEY_FRAME_KINDS,
    KEY_FRAME_STATUSES,
    SCHEMA_VERSION,
    SEGMENT_STATES,
    SEGMENT_STATUSES,
    ActivityEvent,
    Event,
    KeyFrameEvent,
    SegmentEvent,
    StreamEvent,
)
from mossar_stream.jit.decorators import inline_kernel, kernel

PATH_JOINTS = 5  # joints named as active in a segment
EVENT = np.dtype(
    [
        ("row", "i8"),  # whose it is, a key of the sources; in record 0 the number of records in use
        ("code", "i8"),  # KEY_FRAME, SEGMENT, ACTIVITY_CHANGE or TAKE_START
        ("status", "i8"),  # index into KEY_FRAME_STATUSES or SEGMENT_STATUSES
        ("nature", "i8"),  # index into KEY_FRAME_KINDS, or into SEGMENT_STATES
        ("take", "i8"),
        ("rev", "i8"),
        ("id", "i8"),  # Algorithm 2's frame; of a segment the start's; of an activity its number
        ("end_id", "i8"),  # of a segment the end's
        ("frame", "i8"),
        ("until_frame", "i8"),  # decided_frame; of a segment end_frame
        ("decided", "i8"),
        ("time", "f8"),  # of an activity its start
        ("until_time", "f8"),  # decided_time; of a segment end_time
        ("velocity", "f8"),
        ("strength", "f8"),  # of a segment its similarity, of an activity `previous`; NaN for None
        ("active_start", "f8"),  # of a segment; NaN for None
        ("active_end", "f8"),
    ]
    + [(f"joint{i}", "i8") for i in range(PATH_JOINTS)],
)
EVENT_BYTES = EVENT.itemsize
_NONE = bytes(8)  # no records
NO_JOINT = np.int64(-1)  # in place of a joint; after it there is none either
_COUNT = struct.Struct("=q")
_RECORD = struct.Struct("=" + "".join("d" if EVENT[name].kind == "f" else "q" for name in EVENT.names or ()))
KEY_FRAME, SEGMENT, ACTIVITY_CHANGE, TAKE_START = np.arange(4)
# As numpy integers: a Python integer would make numba compile a version for each value.
KEY_CANDIDATE, KEY_WITHDRAWN, KEY_CONFIRMED, KEY_MERGED, KEY_RESTORED, KEY_FINAL = np.arange(6)
KIND_ONSET, KIND_OFFSET, KIND_MINIMUM = np.arange(3)
SEGMENT_CLOSED, SEGMENT_WITHDRAWN, SEGMENT_FINAL = np.arange(3)
FIRST_MESSAGE, SECOND_MESSAGE = np.int64(1), np.int64(2)  # about a key frame: revisions
UNDECIDED, DECIDED = np.int64(0), np.int64(1)
UNKNOWN_STRENGTH = np.float64(np.nan)


class Point(NamedTuple):
    """A key frame as a message tells of it."""

    kind: np.signedinteger  # KIND_ONSET, KIND_OFFSET or KIND_MINIMUM
    id: int  # Algorithm 2's frame
    frame: int  # where it is now
    time: float  # s
    velocity: float  # share of the range
    strength: float  # NaN where it is not known


class Source(NamedTuple):
    """Whose the events of a row are, and where they wait until the caller gets them."""

    performer: str
    channel: str  # the body, or a limb
    joints: tuple[str, ...]  # names
    pending: list[Event]  # of a limb the list of its body
    limbs: tuple[str | None, ...] = ()  # of each joint, with the setting `limbs`
    leading: Callable[[tuple[str, ...]], str | None] | None = None  # the limb that leads, given active joints


_Parcel = tuple[list[Event], list[Event]]  # where events wait, and those that are added


def events_size(most: int) -> int:
    """Return the bytes of a buffer for `most` events."""
    return (most + 1) * EVENT.itemsize


@kernel
def next_event(clock, events, code):
    """Return a fresh record of the buffer, of the performer and the take that a clock is of."""
    used = events[0].row + 1
    events[0].row = used
    event = events[used]
    event.row = clock.row
    event.code = code
    event.take = clock.take
    return event


@kernel
def put_key_frame(clock, events, point, status, rev, decided):
    """Put a message about a key frame into the buffer; the last used frame is what caused it."""
    event = next_event(clock, events, KEY_FRAME)
    event.status = status
    event.nature = point.kind
    event.id = point.id
    event.frame = point.frame
    event.time = point.time
    event.velocity = point.velocity
    event.strength = point.strength
    event.rev = rev
    event.decided = decided
    event.until_frame = clock.used_frame
    event.until_time = clock.time


@kernel
def put_start(clock, events):
    """Put a message that a take has begun into the buffer."""
    next_event(clock, events, TAKE_START)


def hand_out(buffer: memoryview, sources: Mapping[int, Source]) -> None:
    """Add the events in a buffer to what waits at their sources, and empty it; those of released rows are dropped.

    The buffer is emptied once all events are made, with no call in between: Ctrl-C finds them in one place or the other.

    Args:
        buffer: Its bytes.
        sources: By row.
    """
    (count,) = _COUNT.unpack_from(buffer)
    if not count:
        return
    last, of, source = -1, -1, None
    parcels: list[_Parcel] = []
    # Making events takes as long as finding them: so no call for each, and no part of a record copied.
    # fmt: off
    for (row, code, status, nature, take, rev, begin, end, frame, until, decided,
         time, until_time, velocity, strength, active_start, active_end, a, b, c, d, e) in _records(buffer, count):
        # fmt: on
        if row != last or take != of:
            last, of, source = row, take, sources.get(row)
            if source is not None:
                performer, channel, joints, _, _, leading = source
                prefix, events = _prefix(source, take), _parcel_of(source, parcels)
        if source is None:
            continue
        value = None if strength != strength else strength  # noqa: PLR0124 - NaN
        # fmt: off
        if code == 0:
            event: Event = KeyFrameEvent(
                v=SCHEMA_VERSION,  # its default is made by a call
                performer=performer, id=f"{prefix}{begin}", rev=rev, status=KEY_FRAME_STATUSES[status],
                decided=decided == 1, kind=KEY_FRAME_KINDS[nature], take=take, frame=frame, time=time,
                decided_frame=until, decided_time=until_time, velocity=velocity, strength=value, channel=channel,
            )
        elif code == 1:
            five = joints[a], joints[b], joints[c], joints[d], joints[e]
            active = five if e >= 0 else five[: (a, b, c, d, e).index(NO_JOINT)]
            event = SegmentEvent(
                v=SCHEMA_VERSION,
                performer=performer, id=f"{prefix}{begin}-{end}", rev=rev, status=SEGMENT_STATUSES[status],
                state=SEGMENT_STATES[nature], take=take, start_frame=frame, end_frame=until, start_time=time,
                end_time=until_time, active_joints=active, similarity=value,
                active_start=active_start if nature else None, active_end=active_end if nature else None,
                channel=channel, limb=None if leading is None else leading(active),
            )
        # fmt: on
        elif code == 3:
            event = StreamEvent(performer=performer, event="started", take=take)
        else:
            event = _activity(source, (take, begin, nature, a), (time, value, until_time))
        events.append(event)
    buffer[: _COUNT.size] = _NONE
    for pending, events in parcels:
        pending += events


def _prefix(source: Source, take: int) -> str:
    """Return what the ids of key frames and segments of a take begin with."""
    channel = "" if source.channel == BODY else f"{source.channel}/"
    return f"{source.performer}/{channel}{take}/"


def _parcel_of(source: Source, parcels: list[_Parcel]) -> list[Event]:
    """Return the list for the next events of a source, which comes after those for earlier events."""
    if not parcels or parcels[-1][0] is not source.pending:
        parcels.append((source.pending, []))
    return parcels[-1][1]


def _activity(
    source: Source, record: tuple[int, int, int, int], times: tuple[float, float | None, float]
) -> ActivityEvent:
    """Return the event of a change between moving and resting, which is rare.

    Args:
        source: Whose it is.
        record: Take, number, state, and which joint was fastest.
        times: `start`, `previous` and `decided_time`, s.
    """
    take, number, state, joint = record
    start, previous, decided = times
    channel = "" if source.channel == BODY else f"{source.channel}/"
    return ActivityEvent(
        performer=source.performer,
        id=f"{source.performer}/{channel}activity/{take}/{number}",
        take=take,
        state=SEGMENT_STATES[state],
        start=start,
        previous=previous,
        limb=source.limbs[joint] if source.limbs and joint >= 0 else None,
        decided_time=decided,
        channel=source.channel,
    )


def _records(buffer: memoryview, count: int) -> Iterator[tuple[Any, ...]]:
    """Return the records in a buffer, so many."""
    return _RECORD.iter_unpack(buffer[_RECORD.size : (count + 1) * _RECORD.size])


@inline_kernel
def find_active(paths, details, active):
    """Set the joints with the longest paths, -1 where no more of them moved; of equal ones the first come first.

    Args:
        paths: (J,) m.
        details: A bit for each of the first 64 joints that does not count; see `mossar_stream.moves.joints.details`.
        active: (PATH_JOINTS,) is set.
    """
    for place in range(PATH_JOINTS):
        active[place] = NO_JOINT
    least = 0.0
    for j in range(len(paths)):
        if paths[j] > least and (j >= 64 or (details >> np.uint64(j)) & np.uint64(1) == 0):
            place = PATH_JOINTS - 1
            while place > 0 and (active[place - 1] == NO_JOINT or paths[active[place - 1]] < paths[j]):
                active[place] = active[place - 1]
                place -= 1
            active[place] = j
            last = active[PATH_JOINTS - 1]
            least = paths[last] if last != NO_JOINT else 0.0
