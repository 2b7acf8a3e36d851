"""Outbox: the buffer through which compiled code hands events out.

Record 0 counts the others. `events.py` has the records that users see; `decode` makes them.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.compiled import compiled
from mossar_stream.events import (
    KEY_FRAME_KINDS,
    KEY_FRAME_STATUSES,
    SEGMENT_STATES,
    SEGMENT_STATUSES,
    KeyFrameEvent,
    SegmentEvent,
)
from mossar_stream.layout import PATH_JOINTS

EVENT = np.dtype(
    [
        ("row", "i8"),  # which performer; in record 0 the number of records in use
        ("code", "i8"),  # KEY_FRAME or SEGMENT
        ("status", "i8"),  # index into KEY_FRAME_STATUSES or SEGMENT_STATUSES
        ("nature", "i8"),  # index into KEY_FRAME_KINDS or SEGMENT_STATES
        ("take", "i8"),
        ("rev", "i8"),
        ("id", "i8"),  # Algorithm 2's frame; of a segment the start's
        ("end_id", "i8"),  # of a segment the end's
        ("frame", "i8"),
        ("time", "f8"),
        ("until_frame", "i8"),  # decided_frame; of a segment end_frame
        ("until_time", "f8"),
        ("velocity", "f8"),
        ("strength", "f8"),  # of a segment its similarity; NaN for None
        ("decided", "i8"),
    ]
    + [(f"joint{i}", "i8") for i in range(PATH_JOINTS)],
)
KEY_FRAME, SEGMENT = np.arange(2)
# As numpy integers: a Python integer would make numba compile a version for each value.
CANDIDATE, WITHDRAWN, CONFIRMED, MERGED, RESTORED, FINAL = np.arange(6)
ONSET, OFFSET, MINIMUM = np.arange(3)
SEGMENT_CLOSED, SEGMENT_WITHDRAWN, SEGMENT_FINAL = np.arange(3)
FIRST, SECOND = np.int64(1), np.int64(2)  # revisions
UNDECIDED, DECIDED = np.int64(0), np.int64(1)
UNKNOWN_STRENGTH = np.float64(np.nan)


def make_outbox(most: int) -> tuple[NDArray[np.uint8], NDArray[np.void]]:
    """Return an outbox for `most` events: its bytes for compiled code, and its records."""
    raw = np.zeros((most + 1) * EVENT.itemsize, np.uint8)
    return raw, raw.view(EVENT)


@compiled
def next_event(h, events, code):
    """Return a fresh record of the outbox."""
    used = events[0].row + 1
    events[0].row = used
    event = events[used]
    event.row = h.row
    event.code = code
    event.take = h.take
    return event


@compiled
def put_key_frame(h, events, status, kind, identity, frame, time, velocity, strength, rev, decided):
    """Put a message about a key frame into the outbox; the last used frame is what caused it."""
    event = next_event(h, events, KEY_FRAME)
    event.status = status
    event.nature = kind
    event.id = identity
    event.frame = frame
    event.time = time
    event.velocity = velocity
    event.strength = strength
    event.rev = rev
    event.decided = decided
    event.until_frame = h.used_frame
    event.until_time = h.time


def decode(
    rows: list[tuple[Any, ...]],
    performer: str,
    names: tuple[str, ...],
) -> list[KeyFrameEvent | SegmentEvent]:
    """Return the events for records of the outbox.

    Args:
        rows: Records as tuples (`records.tolist()`), all of one performer.
        performer: Its name.
        names: Names of the joints.
    """
    return [decode_one(row, performer, names) for row in rows]


def decode_one(row: tuple[Any, ...], performer: str, names: tuple[str, ...]) -> KeyFrameEvent | SegmentEvent:
    """Return the event for one record of the outbox."""
    (
        _,
        code,
        status,
        nature,
        take,
        rev,
        start,
        end,
        frame,
        time,
        until,
        until_time,
        velocity,
        strength,
        decided,
        *joints,
    ) = row
    value = None if math.isnan(strength) else strength
    if code == KEY_FRAME:
        return KeyFrameEvent(
            performer=performer,
            id=f"{performer}/{take}/{start}",
            rev=rev,
            status=KEY_FRAME_STATUSES[status],
            decided=decided == 1,
            kind=KEY_FRAME_KINDS[nature],
            take=take,
            frame=frame,
            time=time,
            decided_frame=until,
            decided_time=until_time,
            velocity=velocity,
            strength=value,
        )
    return SegmentEvent(
        performer=performer,
        id=f"{performer}/{take}/{start}-{end}",
        rev=rev,
        status=SEGMENT_STATUSES[status],
        state=SEGMENT_STATES[nature],
        take=take,
        start_frame=frame,
        end_frame=until,
        start_time=time,
        end_time=until_time,
        active_joints=tuple(names[j] for j in joints if j >= 0),
        similarity=value,
    )
