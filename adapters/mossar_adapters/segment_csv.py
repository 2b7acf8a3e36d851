"""A table that spreadsheets and ELAN open: a row for each segment, repetition, move and performance; of streams and of whole files."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import msgspec

from mossar_adapters.address import Address
from mossar_adapters.files.output import OutputFile
from mossar_adapters.source import Meta
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
LIMBS = (
    "trunk",
    "left_arm",
    "right_arm",
    "left_leg",
    "right_leg",
)  # of skeletons whose joints are known by name
FOLLOWED = (  # and of moves that are followed, besides `count`
    "relative_tempo",
    "deviation",
    *(f"deviation_{limb}" for limb in LIMBS),
    *(f"range_{limb}" for limb in LIMBS),
)
OF_STREAMS = COLUMNS + COUNTED + NAMED + FOLLOWED  # settings may change while one runs
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
) -> Sequence[object]:
    """Return the cells of a segment, not yet guarded, in the order of `COLUMNS`; times in s on the source's clock."""
    return (
        recording,
        performer,
        take,
        f"{part.start_time:.4f}",
        f"{part.end_time:.4f}",
        f"{part.end_time - part.start_time:.4f}",
        part.start_frame,
        part.end_frame,
        part.state,
        ending.kind,
        _number(ending.strength),
        _number(part.similarity),
        " ".join(part.active_joints),
        channel,
        part.limb or "",
    )


def stretch_row(
    recording: str,
    performer: str,
    take: int,
    ends: tuple[float, float],
    state: str,
    *,
    channel: str = BODY,
    frames: tuple[int, int] | None = None,
    joints: Sequence[str] = (),
) -> dict[str, object]:
    """Return the cells, by column, of a stretch of time that is no segment.

    Args:
        recording: Its name.
        performer: The same.
        take: Number.
        ends: Begin and end, s on the source's clock.
        state: What it is.
        channel: `body` or a limb.
        frames: First and last frame, if they are known.
        joints: That move.
    """
    start, end = ends
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


def repetition_cells(event: RepetitionEvent) -> dict[str, object]:
    """Return the cells in which repetitions differ from other stretches."""
    number = {"count": event.count, "total": event.total}
    return number | {name: _number(getattr(event, name)) for name in COUNTED[2:]}


def move_cells(event: MoveEvent) -> dict[str, object]:
    """Return the cells in which moves differ from other stretches."""
    return {"limb": event.limb, "name": event.name, "score": _number(event.score)}


def pose_cells(event: PoseEvent) -> dict[str, object]:
    """Return the cells in which held poses differ from other stretches."""
    strays = {f"deviation_{limb}": _number(event.limbs.get(limb)) for limb in LIMBS}
    return {"limb": event.limb, "name": event.name, "deviation": _number(event.deviation), **strays}


def follow_cells(event: FollowEvent) -> dict[str, object]:
    """Return the cells in which performances of a followed move differ from other stretches."""
    strays = {f"deviation_{limb}": _number(event.limbs.get(limb)) for limb in LIMBS}
    ranges = {f"range_{limb}": _number((event.range or {}).get(limb)) for limb in LIMBS}
    return {
        "limb": event.limb,
        "name": event.name,
        "score": _number(event.score),
        "count": event.count,
        "relative_tempo": _number(event.tempo),
        "deviation": _number(event.deviation),
        **strays,
        **ranges,
    }


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4f}"


class SegmentCsvSink:
    """Writes what is final of segments, repetitions, moves and performances; implements `Sink`.

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
        self._endings: dict[str, Ending] = {}  # by id of the key frame
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
                    self._remember(event.id, Ending(event.kind, event.strength))
                case SegmentEvent(status="final"):
                    rows.append(dict(zip(COLUMNS, self._row(event), strict=True)))
                case RepetitionEvent():
                    rows += self._follow(event)
                case StreamEvent(event="ended"):
                    rows += self._settled_of(event.performer)
                case MoveEvent(status="final"):
                    recording, ends = self._recordings.get(event.performer, ""), (event.start, event.end)
                    row = stretch_row(recording, event.performer, event.take, ends, "move")
                    rows.append(row | move_cells(event))
                case PoseEvent(status="left"):
                    recording = self._recordings.get(event.performer, "")
                    ends = (event.start, event.start + event.seconds)
                    row = stretch_row(
                        recording, event.performer, event.take, ends, "pose", joints=(event.joint,)
                    )
                    rows.append(row | pose_cells(event))
                case FollowEvent(status="done"):
                    recording, ends = self._recordings.get(event.performer, ""), (event.start, event.time)
                    joints = (event.joint,)
                    row = stretch_row(recording, event.performer, event.take, ends, "followed", joints=joints)
                    rows.append(row | follow_cells(event))
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

    def _row(self, event: SegmentEvent) -> Sequence[object]:
        # Ids keep Algorithm 2's frame, while a final key frame may have moved.
        who, _, frames = event.id.rpartition("/")
        ending = self._endings.pop(f"{who}/{frames.rpartition('-')[2]}", Ending())
        recording = self._recordings.get(event.performer, "")
        return segment_row(recording, event.performer, event.take, event, ending, event.channel)

    def _follow(self, event: RepetitionEvent) -> list[dict[str, object]]:
        """Keep a repetition as it is now, and return the rows of those that nothing changes any more."""
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
        rows = []
        for number in sorted(set(waiting) - set(rest)):
            event = waiting[number]
            row = stretch_row(
                self._recordings.get(event.performer, ""),
                event.performer,
                event.take,
                (event.start or 0.0, event.end or 0.0),  # what is counted has both
                "repetition",
                channel=event.channel,
                joints=(event.joint,) if event.joint else (),
            )
            rows.append(row | repetition_cells(event))
        return rows

    def _remember(self, key: str, ending: Ending) -> None:
        if len(self._endings) == _KEPT and key not in self._endings:
            del self._endings[next(iter(self._endings))]
        self._endings[key] = ending

    def _write(self, rows: Sequence[dict[str, object]]) -> None:
        head = (
            [OF_STREAMS] if self._file.tell() == 0 else []
        )  # late: a file with nothing in it may be replaced
        cells = [[row.get(name, "") for name in OF_STREAMS] for row in rows]
        self._file.write(csv_text([*head, *cells]).encode())
        self._file.flush()
