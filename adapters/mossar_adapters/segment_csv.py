"""A table that spreadsheets and ELAN open: a row for each segment, repetition, move and performance; of streams and of whole files."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.address import Address
from mossar_adapters.files.output import OutputFile
from mossar_adapters.newest import Newest
from mossar_adapters.source import Meta
from mossar_adapters.spans import Spanning, span
from mossar_adapters.table_text import csv_text
from mossar_stream import (
    BODY,
    Event,
    FollowEvent,
    KeyFrameEvent,
    MoveEvent,
    PoseEvent,
    RepetitionEvent,
    Segment,
    SegmentEvent,
    StreamEvent,
)

COLUMNS = (
    "recording",
    "performer",
    "take",
    "start",
    "end",
    "duration",
    "start_frame",
    "end_frame",
    "state",
    "kind",
    "strength",
    "similarity",
    "active_joints",
    "channel",
    "limb",
)
COUNTED = ("count", "total", "period", "tempo", "amplitude")  # further columns of repetitions
NAMED = ("name", "score")  # and of moves
# Of skeletons whose joints are known by name.
LIMBS = (
    "trunk",
    "left_arm",
    "right_arm",
    "left_leg",
    "right_leg",
)
# Further columns of moves that are followed, besides `count`.
FOLLOWED = (
    "relative_tempo",
    "deviation",
    *(f"deviation_{limb}" for limb in LIMBS),
    *(f"range_{limb}" for limb in LIMBS),
)
OF_STREAMS = COLUMNS + COUNTED + NAMED + FOLLOWED  # settings may change while one runs
_STATES: dict[type[Spanning], str] = {
    RepetitionEvent: "repetition",
    MoveEvent: "move",
    PoseEvent: "pose",
    FollowEvent: "followed",
}
SETTLED = 32  # repetitions later one is sure: so many at most may still be withdrawn or moved
_KEPT = 10_000  # key frames kept whose segment is still open


class Ending(NamedTuple):
    """The key frame at a segment's end; empty at the end of a take.

    Args:
        kind: `onset`, `offset` or `minimum`.
        strength: None until it is known.
    """

    kind: str = ""
    strength: float | None = None


def segment_row(
    recording: str,
    performer: str,
    take: int,
    part: SegmentEvent | Segment,
    ending: Ending,
    channel: str = BODY,
) -> dict[str, object]:
    """Return the cells of a segment by column, not yet guarded; times in s on the source's clock."""
    row = stretch_row(
        recording,
        performer,
        take,
        (part.start_time, part.end_time),
        part.state,
        channel=channel,
        frames=(part.start_frame, part.end_frame),
        joints=part.active_joints,
    )
    own = {"kind": ending.kind, "strength": ending.strength, "similarity": part.similarity, "limb": part.limb}
    return row | {name: _cell(value) for name, value in own.items()}


def stretch_row(
    recording: str,
    performer: str,
    take: int,
    ends: tuple[float, float],
    state: str,
    *,
    channel: str = BODY,
    frames: tuple[int, int] | None = None,
    times: NDArray[np.float64] | None = None,
    joints: Sequence[str] = (),
) -> dict[str, object]:
    """Return the cells, by column, that all stretches of time have.

    Args:
        recording: Its name.
        performer: The same.
        take: Number.
        ends: Begin and end, s on the source's clock.
        state: Its kind.
        channel: `body` or a limb.
        frames: First and last frame, if they are known.
        times: (n,) s, of the recording's frames, from which the frames follow.
        joints: That move.
    """
    start, end = ends
    if times is not None:
        first, last = np.searchsorted(times, ends).tolist()
        frames = first, last
    return {
        "recording": recording,
        "performer": performer,
        "take": take,
        "start": f"{start:.4f}",
        "end": f"{end:.4f}",
        "duration": f"{end - start:.4f}",
        "start_frame": "" if frames is None else frames[0],
        "end_frame": "" if frames is None else frames[1],
        "state": state,
        "active_joints": " ".join(joints),
        "channel": channel,
    }


def event_row(
    recording: str,
    event: Spanning,
    performer: str | None = None,
    times: NDArray[np.float64] | None = None,
) -> dict[str, object]:
    """Return the cells, by column, of a repetition, move, held pose or performance of a followed move.

    Args:
        recording: Its name.
        event: The last one about it.
        performer: Name; None for that of the event.
        times: (n,) s, of the recording's frames; None where frame numbers are not known.
    """
    values: dict[str, object] = {}
    match event:
        case RepetitionEvent():
            values = {name: getattr(event, name) for name in COUNTED}
        case MoveEvent():
            values = {"limb": event.limb, "name": event.name, "score": event.score}
        case PoseEvent():
            values = {"limb": event.limb, "name": event.name, "deviation": event.deviation}
        case FollowEvent():
            values = {"limb": event.limb, "name": event.name, "score": event.score, "count": event.count}
            values |= {"relative_tempo": event.tempo, "deviation": event.deviation}
            values |= {f"range_{limb}": (event.range or {}).get(limb) for limb in LIMBS}
    if isinstance(event, FollowEvent | PoseEvent):
        values |= {f"deviation_{limb}": event.limbs.get(limb) for limb in LIMBS}
    joint = None if isinstance(event, MoveEvent) else event.joint
    row = stretch_row(
        recording,
        performer or event.performer,
        event.take,
        span(event),
        _STATES[type(event)],
        channel=event.channel if isinstance(event, RepetitionEvent) else BODY,
        times=times,
        joints=(joint,) if joint else (),
    )
    return row | {name: _cell(value) for name, value in values.items()}


def _cell(value: object) -> object:
    return "" if value is None else f"{value:.4f}" if isinstance(value, float) else value


class SegmentCsvSink:
    """Writes final segments, repetitions, moves and performances; implements `Sink`.

    The strength is that of the key frame at the segment's end. A repetition waits until no later look can change it: for
    `SETTLED` more, or for the end of its take. Those that wait are not part of a snapshot.

    Args:
        address: Path of the file.
        force: Whether to replace a file that is there.
        position: Go on at this byte of a file that is there.

    Raises:
        FileError: If there is a file and `force` is not given, or the path cannot be written.
    """

    def __init__(self, address: Address, *, force: bool = False, position: int | None = None) -> None:
        self.name = address.url
        self.dropped = 0
        self._file = OutputFile(address.path, replace=force, position=position)
        self._endings: Newest[str, Ending] = Newest(_KEPT)  # by id of the key frame
        self._recordings: dict[str, str] = {}  # by performer
        self._waiting: dict[tuple[str, str], dict[int, RepetitionEvent]] = {}  # by performer, channel; number
        self._closed = False

    def announce(self, meta: Meta) -> None:
        """Remember the recording of a performer."""
        if meta.recording:
            self._recordings[meta.performer] = meta.recording

    def begin_take(self, performer: str, take: int, time: float) -> None:  # noqa: ARG002 - sinks share it
        """Write the repetitions of the take before: nothing changes them any more."""
        if rows := self._settled_of(performer):
            self._write(rows)

    def send(self, events: Sequence[Event]) -> None:
        """Write the segments, repetitions, moves and performances among the events that are final."""
        rows: list[dict[str, object]] = []
        for event in events:
            match event:
                case KeyFrameEvent() if event.strength is not None:
                    self._endings[event.id] = Ending(event.kind, event.strength)
                case SegmentEvent(status="final"):
                    rows.append(self._row(event))
                case RepetitionEvent():
                    rows += self._follow(event)
                case StreamEvent(event="ended"):
                    rows += self._settled_of(event.performer)
                case MoveEvent(status="final") | PoseEvent(status="left") | FollowEvent(status="done"):
                    rows.append(event_row(self._recordings.get(event.performer, ""), event))
                case _:
                    pass
        if rows:
            self._write(rows)

    def position(self) -> int | None:
        """Return the bytes in the file."""
        return self._file.tell()

    def sync(self) -> None:
        """Have everything written to the disk, before a snapshot counts on it."""
        self._file.sync()

    def close(self) -> None:
        """Close the file. May be called twice."""
        if not self._closed:
            self._closed = True
            self._write([row for performer, _ in list(self._waiting) for row in self._settled_of(performer)])
        self._file.close()

    def _row(self, event: SegmentEvent) -> dict[str, object]:
        # Ids keep Algorithm 2's frame, while a final key frame may have moved.
        who, _, frames = event.id.rpartition("/")
        ending = self._endings.pop(f"{who}/{frames.rpartition('-')[2]}", Ending())
        recording = self._recordings.get(event.performer, "")
        return segment_row(recording, event.performer, event.take, event, ending, event.channel)

    def _follow(self, event: RepetitionEvent) -> list[dict[str, object]]:
        """Keep the present state of a repetition, and return the rows of those that can no longer change."""
        key = event.performer, event.channel
        waiting = self._waiting.setdefault(key, {})
        former = bool(waiting) and next(iter(waiting.values())).take != event.take
        rows = self._settled(key) if former else []
        waiting = self._waiting.setdefault(key, {})
        number = int(event.id.rpartition("/r")[2])
        if event.status == "withdrawn":
            waiting.pop(number, None)
            return rows
        waiting[number] = msgspec.structs.replace(event, total=number)
        return rows + self._settled(key, number - SETTLED)

    def _settled_of(self, performer: str) -> list[dict[str, object]]:
        """Return the rows of all repetitions of a performer that wait."""
        return [row for key in list(self._waiting) if key[0] == performer for row in self._settled(key)]

    def _settled(self, key: tuple[str, str], until: float = math.inf) -> list[dict[str, object]]:
        """Return the rows of the repetitions up to a number, which wait no longer."""
        waiting = self._waiting.pop(key)
        rest = {number: event for number, event in waiting.items() if number > until}
        if rest:
            self._waiting[key] = rest
        recording = self._recordings.get(key[0], "")
        return [event_row(recording, waiting[number]) for number in sorted(set(waiting) - set(rest))]

    def _write(self, rows: Sequence[dict[str, object]]) -> None:
        # Late: a file with nothing in it may be replaced.
        head = [OF_STREAMS] if self._file.tell() == 0 else []
        cells = [[row.get(name, "") for name in OF_STREAMS] for row in rows]
        self._file.write(csv_text([*head, *cells]).encode())
        self._file.flush()
