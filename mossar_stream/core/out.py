"""Out: records of the event buffer (event_buffer.pxi) become events, the ones that users see."""

import struct
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from mossar_stream.core.kernels import NO_JOINT, RECORDS
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

EVENT = RECORDS["Event"]
_NONE = bytes(8)  # no records
_COUNT = struct.Struct("=q")
_RECORD = struct.Struct("=" + "".join("d" if EVENT[name].kind == "f" else "q" for name in EVENT.names or ()))


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
