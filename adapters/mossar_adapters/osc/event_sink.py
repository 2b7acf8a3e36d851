"""The OSC event sink: one message per event, times in seconds since the take's first frame.

A float32 holds no clock. So these times are called `..._in_take` here; in JSON `start`, `time` and `decided_time` are of the source's clock.

`/mossar/key_frame ,sssiiffffi` performer, status, kind, take, frame, time_in_take, decided_in_take, velocity, strength (-1
until computed), rev; `/mossar/segment ,sssiiiff` performer, status, state, take, start frame, end frame, start_in_take,
end_in_take; both of a limb as `/mossar/limb/key_frame ,ssssiiffffi` and `/mossar/limb/segment ,ssssiiiff` with the
channel after the performer; `/mossar/move ,ssssiffffi` performer, status, name, limb, take, start_in_take, end_in_take, decided_in_take, score, rev;
`/mossar/follow ,sssssiiffffffffsi` performer, status, name, limb that strays most, joint, take, count, progress, tempo,
certainty, deviation, score (-1 until done), start_in_take, time_in_take, decided_in_take, id, rev, then `sff` for each limb: name,
deviation, range (-1 until done, and of limbs that stand still);
`/mossar/pose ,sssssiffffsi` performer, status, name, limb that strays most, joint, take, start_in_take, seconds, deviation, decided_in_take,
id, rev, then `sf` for each limb: name, deviation;
`/mossar/repetition ,sssiiiffsi` performer, status, channel, take, count, total, period, tempo (-1 for the first of a bout), id, rev;
`/mossar/phase ,ssif` performer, channel, take, phase from 0 to 1, -1 once when nothing repeats any more;
`/mossar/activity ,sssifff` performer, channel, state, take, start_in_take, decided_in_take, previous (-1 at first);
`/mossar/step ,sssiffffffs` performer, status, side, take, time_in_take, decided_in_take, confidence, x, y, z, id;
`/mossar/run ,ss` performer, run, before each take; `/mossar/stream ,sssi` performer, event, reason, take.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, cast, get_type_hints

from mossar_adapters.address import Address
from mossar_adapters.newest import Newest
from mossar_adapters.osc.encode import encode
from mossar_adapters.osc.sender import DatagramSender
from mossar_adapters.source import Meta
from mossar_stream import (
    BODY,
    ActivityEvent,
    Event,
    FollowEvent,
    KeyFrameEvent,
    MoveEvent,
    PhaseEvent,
    PoseEvent,
    RepetitionEvent,
    SegmentEvent,
    StepEvent,
    StreamEvent,
)

_MAX_PERFORMERS = 1024
# The fields of each message in their order; times since the take's first frame are marked with @. A number that is None is -1.
_FIELDS: dict[type, str] = {
    KeyFrameEvent: "performer status kind take frame @time @decided_time velocity strength rev",
    SegmentEvent: "performer status state take start_frame end_frame @start_time @end_time",
    ActivityEvent: "performer channel state take @start @decided_time previous",
    MoveEvent: "performer status name limb take @start @end @decided_time score rev",
    FollowEvent: "performer status name limb joint take count progress tempo certainty deviation score"
    " @start @time @decided_time id rev",
    PoseEvent: "performer status name limb joint take @start seconds deviation @decided_time id rev",
    RepetitionEvent: "performer status channel take count total period tempo id rev",
    PhaseEvent: "performer channel take phase",
    StepEvent: "performer status side take @time @decided_time confidence position id",
    StreamEvent: "performer event reason take",
}
_TAGS = {int: "i", float: "f", float | None: "f", tuple[float, float, float]: "fff"}  # all others are words

_Timed = KeyFrameEvent | SegmentEvent | ActivityEvent | MoveEvent | FollowEvent | PoseEvent | StepEvent


class _Layout(NamedTuple):
    """The messages of one kind of event: fields with whether they are times, and OSC's tags."""

    kind: str
    fields: tuple[tuple[str, bool], ...]
    tags: str


def _layout(event: Any, fields: str) -> _Layout:
    names = [field.lstrip("@") for field in fields.split()]
    hints = get_type_hints(event)
    tags = "".join(_TAGS.get(hints.get(name, str), "s") for name in names)
    times = [field.startswith("@") for field in fields.split()]
    return _Layout(event.__struct_config__.tag, tuple(zip(names, times, strict=True)), tags)


_LAYOUTS = {event: _layout(event, fields) for event, fields in _FIELDS.items()}


class OscSink:
    """Sends events over OSC; implements `Sink`.

    Args:
        address: `osc://HOST:PORT`.

    Raises:
        MossarError: If the host is unknown or an option is wrong.
    """

    prompt = True

    def __init__(self, address: Address) -> None:
        address.check({})
        self.name = address.url
        self.dropped = 0
        self._sender = DatagramSender(address)
        # performer -> take and the time of its first frame, s
        self._starts: Newest[str, tuple[int, float]] = Newest(_MAX_PERFORMERS)

    def announce(self, meta: Meta) -> None:
        """Do nothing: the messages name their performer."""

    def begin_take(self, performer: str, take: int, time: float) -> None:
        """Note when a take began.

        Without this call the beginning is reckoned from the frame number and time of the take's first event.

        Args:
            performer: Name.
            take: Its number.
            time: Source time of its first frame, s.
        """
        self._starts[performer] = (take, time)

    def send(self, events: Sequence[Event]) -> None:
        """Send events, one datagram each; stats are not sent."""
        for event in events:
            if isinstance(event, StreamEvent) and event.run is not None:
                self._put(encode("/mossar/run", "ss", event.performer, event.run))
            data = self._written(event)
            if data:
                self._put(data)

    def close(self) -> None:
        """Release the socket. May be called twice."""
        self._sender.close()

    def _put(self, data: bytes) -> None:
        if not self._sender.send(data):
            self.dropped += 1

    def _written(self, event: Event) -> bytes:
        """Return an event as a message, empty for stats."""
        layout = _LAYOUTS.get(type(event))
        if layout is None:
            return b""
        kind, tags, values = layout.kind, layout.tags, list[Any]()
        for name, is_time in layout.fields:
            value = getattr(event, name)
            if is_time:
                value -= self._start(cast("_Timed", event))
            values += value if isinstance(value, tuple) else [-1.0 if value is None else value]
        match event:
            case KeyFrameEvent() | SegmentEvent() if event.channel != BODY:
                # Patches for the body's messages must not receive those of limbs.
                kind, tags = f"limb/{kind}", f"s{tags}"
                values.insert(1, event.channel)
            case FollowEvent():
                tags += "sff" * len(event.limbs)
                ranges = event.range or {}
                for limb, angle in event.limbs.items():
                    values += (limb, angle, ranges.get(limb, -1.0))
            case PoseEvent():
                tags += "sf" * len(event.limbs)
                values += [part for limb in event.limbs.items() for part in limb]
            case _:
                pass
        return encode(f"/mossar/{kind}", tags, *values)

    def _start(self, event: _Timed) -> float:
        known = self._starts.get(event.performer)
        if known is None or known[0] != event.take:
            self.begin_take(event.performer, event.take, _reckoned(event))
        return self._starts[event.performer][1]


def _reckoned(event: _Timed) -> float:
    """Return the time of frame 0, from two frames at their mean rate; a move or activity has no frame numbers."""
    if isinstance(event, MoveEvent | FollowEvent | PoseEvent | ActivityEvent):
        return event.start
    if isinstance(event, StepEvent):
        return event.time
    if isinstance(event, SegmentEvent):
        first, last = (event.start_frame, event.start_time), (event.end_frame, event.end_time)
    else:
        first, last = (event.frame, event.time), (event.decided_frame, event.decided_time)
    frames = last[0] - first[0]
    step = (last[1] - first[1]) / frames if frames > 0 else 0.0
    return first[1] - first[0] * step
